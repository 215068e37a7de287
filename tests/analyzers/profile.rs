//! Profiles of known flows, and the temperature of known and of random particles.

use super::{chance, close, fields, make, normal, stamp, table, take, text};
use rand::RngExt;
use squirm::wire::{Fields, Particles};

const SLIT: [f64; 3] = [8.0, 6.0, 8.0];

#[test]
fn a_linear_shear_is_found_exactly() {
    let mut profile = make("profile", &[]);
    for seq in 0..8 {
        let shear = fields([4, 3, 4], 2, 10.0, |r| [0.125 * (r[1] - 3.0), 0.0, 0.25]);
        take(profile.as_mut(), &shear.encode(&stamp(seq, SLIT, true))).unwrap();
    }
    let report = profile.finish().unwrap();
    let rows = table(&report, "profile.csv");
    for (row, y) in rows.iter().zip([1.0, 3.0, 5.0]) {
        assert_eq!((row["y [a]"], row["density [m/a^3]"], row["density [m/a^3] error"]), (y, 10.0, 0.0));
        assert_eq!(
            (row["v_x [sqrt(kT/m)]"], row["v_y [sqrt(kT/m)]"], row["v_z [sqrt(kT/m)]"]),
            (0.125 * (y - 3.0), 0.0, 0.25)
        );
        assert_eq!(row["v_x [sqrt(kT/m)] error"], 0.0);
    }
    assert!(report.files.iter().all(|f| !f.0.starts_with("temperature")) && report.summary.contains("no temperature"));
}

/// The mean is that of the particles, not of the blocks: a block with three times the mass counts three times.
#[test]
fn blocks_count_by_their_mass() {
    let fields =
        Fields { block: 2, blocks: [2, 1, 1], density: vec![1.0, 3.0], velocity: vec![[1.0, 0.0, 0.0], [0.0; 3]] };
    for (axis, expected) in [("y", vec![0.25]), ("x", vec![1.0, 0.0])] {
        let mut profile = make("profile", &[("axis", text(axis))]);
        take(profile.as_mut(), &fields.encode(&stamp(0, [4.0, 2.0, 2.0], false))).unwrap();
        let rows = table(&profile.finish().unwrap(), "profile.csv");
        assert_eq!(rows.iter().map(|r| r["v_x [sqrt(kT/m)]"]).collect::<Vec<_>>(), expected);
        assert!(rows[0]["v_x [sqrt(kT/m)] error"].is_nan());
    }
}

/// A box whose edge the blocks do not divide: the density of the last layer is that of its part in the box.
#[test]
fn a_layer_that_is_cut_has_the_right_density() {
    let fields = Fields { block: 2, blocks: [1, 2, 1], density: vec![5.0, 5.0], velocity: vec![[0.0; 3]; 2] };
    let mut profile = make("profile", &[]);
    take(profile.as_mut(), &fields.encode(&stamp(0, [2.0, 3.0, 2.0], true))).unwrap();
    let rows = table(&profile.finish().unwrap(), "profile.csv");
    assert_eq!(rows.iter().map(|r| (r["y [a]"], r["density [m/a^3]"])).collect::<Vec<_>>(), [(1.0, 5.0), (2.5, 5.0)]);
}

fn particles(seq: u64, list: impl Iterator<Item = ([f32; 3], [f32; 3])>) -> Vec<u8> {
    let (position, velocity): (Vec<_>, Vec<_>) = list.unzip();
    let population = position.len() as u64;
    Particles { fraction: 0.5, population: 2 * population, position, velocity, ..Particles::default() }
        .encode(&stamp(seq, SLIT, true))
}

#[test]
fn the_temperature_is_that_about_the_mean_of_a_bin() {
    let mut profile = make("profile", &[]);
    take(profile.as_mut(), &fields([4, 3, 4], 2, 10.0, |_| [0.0; 3]).encode(&stamp(0, SLIT, true))).unwrap();
    // Four in every bin, two a little faster than the bin's mean along z and two slower: 4 x 0.5^2/(3 x 3).
    let list = (0..24u8).map(|i| {
        let bin = f32::from(i / 4);
        ([1.0, bin + 0.5, 1.0], [0.75 * bin, 0.0, if i % 2 == 0 { 0.5 } else { -0.5 }])
    });
    take(profile.as_mut(), &particles(0, list)).unwrap();
    let rows = table(&profile.finish().unwrap(), "temperature.csv");
    assert_eq!(rows.len(), 6);
    rows.iter().for_each(|r| close(r["temperature [kT]"], 1.0 / 9.0, 1e-12));
}

#[test]
fn a_gas_has_its_temperature_within_five_errors() {
    let mut rng = chance(41);
    let mut profile = make("profile", &[]);
    take(profile.as_mut(), &fields([4, 3, 4], 2, 10.0, |_| [0.0; 3]).encode(&stamp(0, SLIT, true))).unwrap();
    for seq in 0..128 {
        // Hot above y = 3; a shear that a bin hardly sees.
        let list: Vec<_> = (0..200)
            .map(|_| {
                let place = SLIT.map(|l| l as f32 * rng.random::<f32>());
                let hot = if place[1] < 3.0 { 1.0 } else { 2f64.sqrt() };
                let mut velocity = [0; 3].map(|_| (hot * normal(&mut rng)) as f32);
                velocity[0] += 0.1 * place[1];
                (place, velocity)
            })
            .collect();
        take(profile.as_mut(), &particles(seq, list.into_iter())).unwrap();
    }
    for row in table(&profile.finish().unwrap(), "temperature.csv") {
        let wanted = if row["y [a]"] < 3.0 { 1.0 } else { 2.0 };
        // (G bin)^2/36 of the shear.
        close(row["temperature [kT]"] - 0.01 / 36.0, wanted, 5.0 * row["temperature [kT] error"]);
        assert!(row["temperature [kT] error"] < 0.05, "{row:?}");
    }
}
