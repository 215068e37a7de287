//! Pair correlations and order: lattices, squirmers without correlations, and such with.

use super::{chance, close, direction, make, squirmers, stamp, table, take, text};
use rand::RngExt;
use std::f64::consts::PI;

/// A simple cubic lattice of 4 x 4 x 4 with the spacing 4; alternating axes if `staggered`.
fn lattice(staggered: bool) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let site = |i: u32| [i % 4, i / 4 % 4, i / 16];
    let places = (0..64).map(|i| site(i).map(|c| 4.0 * c as f32 + 0.5)).collect();
    let sign = |i: u32| if staggered && site(i).iter().sum::<u32>() % 2 == 1 { -1.0 } else { 1.0 };
    (places, (0..64).map(|i| [0.0, 0.0, sign(i)]).collect())
}

#[test]
fn a_lattice_has_its_shells_and_perfect_order() {
    for staggered in [false, true] {
        let (places, axes) = lattice(staggered);
        let mut structure = make("structure", &[]);
        for seq in 0..4 {
            let bytes = squirmers(&places, &axes, 1.0, 0.5).encode(&stamp(seq, [16.0; 3], false));
            take(structure.as_mut(), &bytes).unwrap();
        }
        let report = structure.finish().unwrap();
        let rows = table(&report, "pairs.csv");
        assert_eq!(rows.len(), 16, "half the edge in bins of 0.5");
        // Distance, neighbours of each, and the sign of their axes relative to its own where they alternate.
        let shells = [(4.0, 6.0, -1.0), (4.0 * 2f64.sqrt(), 12.0, 1.0), (4.0 * 3f64.sqrt(), 8.0, -1.0)];
        for row in &rows {
            let (low, high) = (row["r [a]"] - 0.25, row["r [a]"] + 0.25);
            let shell = shells.iter().find(|s| low <= s.0 && s.0 < high);
            let neighbours = shell.map_or(0.0, |s| s.1);
            let ideal = 63.0 * 4.0 / 3.0 * PI * (high.powi(3) - low.powi(3)) / 4096.0;
            close(row["g(r)"], neighbours / ideal, 1e-9);
            assert_eq!((row["g(r) error"], row["pairs seen"]), (0.0, 4.0 * 32.0 * neighbours));
            if let Some((_, _, sign)) = shell {
                close(row["<e.e'>(r)"], if staggered { *sign } else { 1.0 }, 1e-12);
                close(row["<(3 (e.e')^2 - 1)/2>(r)"], 1.0, 1e-12);
            }
        }
        for row in table(&report, "order.csv") {
            close(row["polar order"], if staggered { 0.0 } else { 1.0 }, 1e-12);
            close(row["nematic order"], 1.0, 1e-12);
        }
    }
}

/// A square lattice in a narrow slit, at two heights: in the plane there are four neighbours at 4.
#[test]
fn a_slit_is_looked_at_from_above() {
    let places: Vec<[f32; 3]> =
        (0..16u16).map(|i| [4.0 * f32::from(i % 4), 1.0 + 2.0 * f32::from(i % 2), 4.0 * f32::from(i / 4)]).collect();
    let mut structure = make("structure", &[]);
    take(
        structure.as_mut(),
        &squirmers(&places, &[[1.0, 0.0, 0.0]; 16], 1.0, 0.5).encode(&stamp(0, [16.0, 4.0, 16.0], true)),
    )
    .unwrap();
    let rows = table(&structure.finish().unwrap(), "pairs.csv");
    for row in &rows {
        let (low, high) = (row["r [a]"] - 0.25, row["r [a]"] + 0.25);
        // The second shell, at 4 sqrt(2), has four, too.
        let neighbours = if [4.0, 32f64.sqrt()].iter().any(|r| low <= *r && *r < high) { 4.0 } else { 0.0 };
        close(row["g(r)"], neighbours / (15.0 * PI * (high * high - low * low) / 256.0), 1e-9);
    }
    assert!(rows[0]["g(r) error"].is_nan(), "one snapshot says nothing about the error");
}

#[test]
fn squirmers_without_correlations_have_none_within_five_errors() {
    for (distance, walls) in [("auto", false), ("plane", true), ("full", true)] {
        let mut rng = chance(11);
        let mut structure =
            make("structure", &[("distance", text(distance)), ("bin", squirm::params::Value::Float(1.0))]);
        let size = [20.0, 6.0, 24.0f32];
        for seq in 0..256 {
            let places: Vec<[f32; 3]> = (0..60).map(|_| size.map(|l| l * rng.random::<f32>())).collect();
            let axes: Vec<[f32; 3]> = (0..60).map(|_| direction(&mut rng)).collect();
            take(
                structure.as_mut(),
                &squirmers(&places, &axes, 1.0, 0.5).encode(&stamp(seq, size.map(f64::from), walls)),
            )
            .unwrap();
        }
        let report = structure.finish().unwrap();
        let rows = table(&report, "pairs.csv");
        assert_eq!(rows.len(), if walls { 10 } else { 3 });
        for row in &rows {
            close(row["g(r)"], 1.0, 5.0 * row["g(r) error"]);
            close(row["<e.e'>(r)"], 0.0, 5.0 * row["<e.e'>(r) error"]);
            close(row["<(3 (e.e')^2 - 1)/2>(r)"], 0.0, 5.0 * row["<(3 (e.e')^2 - 1)/2>(r) error"]);
            // Poisson: the number of pairs seen is known to its root, up to a factor that blocking leaves open.
            let poisson = row["g(r)"] / row["pairs seen"].sqrt();
            assert!((0.4..2.5).contains(&(row["g(r) error"] / poisson)), "{row:?}");
        }
        let polar: Vec<f64> = table(&report, "order.csv").iter().map(|r| r["polar order"].powi(2)).collect();
        let found = squirm::analyze::statistics::independent(&polar);
        close(found.mean, 1.0 / 60.0, 5.0 * found.error);
    }
}

/// Negative control: pairs that hold hands at a distance of 2 are seen, and so is their common direction.
#[test]
fn correlations_stand_out() {
    let mut rng = chance(12);
    let mut structure = make("structure", &[]);
    for seq in 0..64 {
        let (mut places, mut axes) = (Vec::new(), Vec::new());
        for _ in 0..20 {
            let (place, axis) = ([0; 3].map(|_| 20.0 * rng.random::<f32>()), direction(&mut rng));
            let towards = direction(&mut rng);
            places.extend([place, std::array::from_fn(|k| (place[k] + 2.1 * towards[k]).rem_euclid(20.0))]);
            axes.extend([axis, axis]);
        }
        take(structure.as_mut(), &squirmers(&places, &axes, 1.0, 0.5).encode(&stamp(seq, [20.0; 3], false))).unwrap();
    }
    let rows = table(&structure.finish().unwrap(), "pairs.csv");
    let row = &rows[4];
    assert!(row["r [a]"] == 2.25 && row["g(r)"] - 1.0 > 20.0 * row["g(r) error"], "{row:?}");
    assert!(row["<e.e'>(r)"] > 20.0 * row["<e.e'>(r) error"], "{row:?}");
    let far = &rows[15];
    assert!((far["<e.e'>(r)"]).abs() < 5.0 * far["<e.e'>(r) error"]);
}
