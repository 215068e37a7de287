//! rotate: the map of each cell against the reference.

use crate::bench::*;
use crate::rig;
use glam::{DMat3, DVec3};
use squirm::params::Value;
use squirm::state::State;
use squirm::state::scene::Operator;

fn largest(m: DMat3) -> f64 {
    m.to_cols_array().into_iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}

#[test]
fn maps_of_a_gas() {
    let kinds = ["shift-grid", "cell-reduce", "rotate"];
    let system = rig::system([9, 10, 11]);
    for (step, angle) in [(0, 130.0), (5, 90.0), ((3 << 32) + 1, 180.0)] {
        let start = State { step, ..state(gas(&system, 9, 3000), Vec::new()) };
        let mut bench = Bench::new(&system, &start, &kinds, &[("rotate", "angle", Value::Float(angle))]);
        bench.run_all(&kinds[..2]);
        bench.run("rotate");
        let mut turned = 0;
        for ((found, wanted), m) in bench.operators().iter().zip(&bench.scene.operators).zip(&bench.scene.moments) {
            if m.count < 2.0 {
                assert_eq!(*found, Operator::default());
                continue;
            }
            // The axis has sines and cosines, near its poles the square root of their error; its length is corrected to f32.
            let off = largest(found.a - wanted.a);
            assert!(off < 4.0 * TRANSCENDENTAL, "{off:e}");
            assert!(largest(found.a * found.a.transpose() - DMat3::IDENTITY) < 16.0 * ROUNDING);
            assert_eq!(found.w, DVec3::ZERO);
            // The mean velocity stays: b is what A leaves of it, with some ten roundings.
            let mean = m.v / m.count;
            assert!((found.apply(DVec3::ZERO, mean) - mean).length() < 16.0 * ROUNDING * mean.length());
            turned += 1;
        }
        assert!(turned > 700, "{turned}");
        assert_eq!(bench.faults(), 0);
    }
}

/// Beside a wall cells turn further by their grip, elsewhere they do not.
#[test]
fn maps_of_cells_that_hold_ghosts() {
    let kinds = ["shift-grid", "cell-reduce", "wall-ghosts", "rotate"];
    let mut system = rig::system([9, 6, 7]);
    system.domain.walls = Some(rig::walls());
    let start = state(gas(&system, 10, 3000), Vec::new());
    for grip in [1.0, 1.1, 1.22] {
        let mut bench = Bench::new(&system, &start, &kinds, &[("rotate", "grip", Value::Float(grip))]);
        bench.run_all(&kinds);
        let mut turned = [0; 2];
        for ((found, wanted), m) in bench.operators().iter().zip(&bench.scene.operators).zip(&bench.scene.moments) {
            let trace = found.a.x_axis.x + found.a.y_axis.y + found.a.z_axis.z;
            let more = if m.ghosts > 0.0 { grip } else { 1.0 };
            let expected = 3.0 - 2.0 * (more * (1.0 - f64::to_radians(130.0).cos())).min(2.0);
            assert!(m.count < 2.0 || (trace - expected).abs() < 2.4e-4, "{trace} {expected}");
            assert!(largest(found.a - wanted.a) < 4.0 * TRANSCENDENTAL);
            turned[usize::from(m.ghosts > 0.0)] += 1;
        }
        assert!(turned[0] > 300 && turned[1] > 100, "{turned:?}");
        assert_eq!(bench.faults(), 0);
    }
}
