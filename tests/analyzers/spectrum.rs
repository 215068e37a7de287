//! Spectra of single modes, of noise, and Parseval's theorem for whatever else.

use super::{chance, close, fields, make, normal, stamp, table, take};
use squirm::analyze::{AnalyzeError, Report};
use squirm::wire::Fields;
use std::f64::consts::TAU;

fn spectrum(snapshots: &[Fields], size: [f64; 3], walls: bool) -> Result<Report, AnalyzeError> {
    let mut spectrum = make("spectrum", &[]);
    for (seq, fields) in (0..).zip(snapshots) {
        take(spectrum.as_mut(), &fields.encode(&stamp(seq, size, walls)))?;
    }
    spectrum.finish()
}

/// The mean of |u - mean u|^2/2; layer by layer along y if `layers`.
fn energy(fields: &Fields, layers: bool) -> f64 {
    let [nx, ny, nz] = fields.blocks.map(|n| n as usize);
    let y = |i: usize| i / nx % ny;
    let groups = if layers { ny } else { 1 };
    let mut sum = 0.0;
    for group in 0..groups {
        let all: Vec<[f64; 3]> = (0..nx * ny * nz)
            .filter(|i| !layers || y(*i) == group)
            .map(|i| fields.velocity[i].map(f64::from))
            .collect();
        for k in 0..3 {
            let mean = all.iter().map(|v| v[k]).sum::<f64>() / all.len() as f64;
            sum += all.iter().map(|v| 0.5 * (v[k] - mean).powi(2)).sum::<f64>();
        }
    }
    sum / (nx * ny * nz) as f64
}

#[test]
fn a_single_mode_is_a_single_peak_with_its_energy() {
    // v_y = A sin(2 (2 pi/L) x): energy A^2/4, in the bin of k = 2 (2 pi/L).
    let amplitude = 0.3;
    let k = 2.0 * TAU / 16.0;
    let mode = fields([8; 3], 2, 10.0, |r| [0.05, amplitude * (k * r[0]).sin(), 0.0]);
    let rows = table(&spectrum(&[mode], [16.0; 3], false).unwrap(), "spectrum.csv");
    let width = TAU / 16.0;
    for row in &rows {
        let peak = (row["k [1/a]"] / width).round() == 2.0;
        let energy = row["E(k) [a kT/m]"] * width;
        // f32 in the snapshot.
        close(energy, if peak { amplitude * amplitude / 4.0 } else { 0.0 }, 1e-7);
    }
    // 8 x 8 x 8 modes without the mean.
    assert_eq!(rows.iter().map(|r| r["modes"]).sum::<f64>(), 511.0);
    // Of wave numbers n with |n| rounding to 2, 1.5 <= |n| < 2.5: |n|^2 = 3, 4, 5, 6.
    assert_eq!(rows[1]["modes"], 8.0 + 6.0 + 24.0 + 24.0);
}

#[test]
fn between_walls_only_x_and_z_have_waves() {
    let across = fields([8, 4, 4], 2, 10.0, |r| [r[1], 0.0, 0.2 * (TAU / 16.0 * r[0]).cos()]);
    let rows = table(&spectrum(std::slice::from_ref(&across), [16.0, 8.0, 8.0], true).unwrap(), "spectrum.csv");
    let width = TAU / 16.0;
    // What changes across the slit is a mean flow of layers, no wave.
    close(rows[0]["E(k) [a kT/m]"] * width, 0.2 * 0.2 / 4.0, 1e-7);
    assert!(rows[1..].iter().all(|r| r["E(k) [a kT/m]"].abs() < 1e-7));
    // Negative control: where y is periodic, the steps across it are waves.
    let periodic = table(&spectrum(&[across], [16.0, 8.0, 8.0], false).unwrap(), "spectrum.csv");
    assert!(periodic[1..].iter().any(|r| r["E(k) [a kT/m]"] > 0.1));
}

#[test]
fn the_sum_over_all_waves_is_the_energy() {
    let mut rng = chance(31);
    for (size, blocks, walls) in [([12.0, 8.0, 10.0], [6, 4, 5], false), ([12.0, 8.0, 10.0], [6, 4, 5], true)] {
        let noise = fields(blocks, 2, 10.0, |_| [0; 3].map(|_| normal(&mut rng)));
        let rows = table(&spectrum(std::slice::from_ref(&noise), size, walls).unwrap(), "spectrum.csv");
        let sum: f64 = rows.iter().map(|r| r["E(k) [a kT/m]"]).sum::<f64>() * TAU / 12.0;
        close(sum / energy(&noise, walls), 1.0, 1e-12);
    }
}

/// Blocks of n particles at kT = 1 have independent velocities of the variance 1/n: nothing but the noise floor.
#[test]
fn thermal_noise_lies_on_its_floor() {
    for walls in [false, true] {
        let mut rng = chance(32);
        let particles = 5.0 * 8.0;
        let noise: Vec<Fields> = (0..128)
            .map(|_| fields([8, 4, 6], 2, 5.0, |_| [0; 3].map(|_| normal(&mut rng) / f64::sqrt(particles))))
            .collect();
        let rows = table(&spectrum(&noise, [16.0, 8.0, 12.0], walls).unwrap(), "spectrum.csv");
        for row in &rows {
            close(row["E(k) [a kT/m]"], row["thermal noise [a kT/m]"], 5.0 * row["E(k) [a kT/m] error"]);
            assert!(row["E(k) [a kT/m] error"] < 0.2 * row["thermal noise [a kT/m]"], "{row:?}");
        }
        // Negative control: twice as hot is seen in every band.
        let hot: Vec<Fields> = noise
            .iter()
            .map(|f| Fields { velocity: f.velocity.iter().map(|v| v.map(|c| c * 2f32.sqrt())).collect(), ..f.clone() })
            .collect();
        for row in table(&spectrum(&hot, [16.0, 8.0, 12.0], walls).unwrap(), "spectrum.csv") {
            assert!(row["E(k) [a kT/m]"] - row["thermal noise [a kT/m]"] > 5.0 * row["E(k) [a kT/m] error"], "{row:?}");
        }
    }
}

#[test]
fn blocks_that_do_not_divide_the_box_are_refused() {
    let uneven = fields([3, 3, 3], 3, 5.0, |_| [0.0; 3]);
    let said = spectrum(&[uneven], [8.0, 9.0, 9.0], false).unwrap_err().to_string();
    assert!(said.contains("blocks of 3 a do not divide the edge of 8 a"), "{said}");
}
