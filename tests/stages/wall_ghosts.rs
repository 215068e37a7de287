//! wall-ghosts: the same ghosts as the reference's, of the fluid's density, and what the walls receive of them.

use crate::bench::*;
use crate::rig;
use squirm::state::{State, System, Walls};

const KINDS: [&str; 6] = ["shift-grid", "cell-reduce", "wall-ghosts", "rotate", "restore-thermostat", "apply"];

fn slit(size: [u32; 3]) -> System {
    let mut system = rig::system(size);
    system.fluid.temperature = 0.5;
    system.domain.walls =
        Some(Walls { velocity_low: [0.2, 0.0, -0.1], velocity_high: [-0.3, 0.0, 0.4], ..rig::walls() });
    system
}

#[test]
fn ghosts_are_the_references() {
    let system = slit([6, 5, 7]);
    for step in [0, 1, 2, (1 << 32) + 3] {
        let start = State { step, particles: gas(&system, 10, 300), squirmers: Vec::new() };
        let mut bench = Bench::new(&system, &start, &KINDS[..3], &[]);
        bench.run_all(&KINDS[..2]);
        let fluid = bench.scene.moments.clone();
        bench.run("wall-ghosts");
        let mut ghosts = 0.0;
        for ((found, wanted), fluid) in bench.moments().iter().zip(&bench.scene.moments).zip(&fluid) {
            // Normals have the transcendental functions' error times their length, which is below six; the wall's share of the
            // cell is known to f32.
            let e = excess(&system, found, wanted, 6.0 * TRANSCENDENTAL, 4.0 * ROUNDING);
            assert!(e <= 1.0, "{e}\n{found:?}\n{wanted:?}");
            ghosts += wanted.count - fluid.count;
        }
        assert!(ghosts > 300.0, "{ghosts}");
        assert_eq!(bench.faults(), 0);
    }
}

/// Both layers together hold one cell's worth of ghosts per column.
#[test]
fn ghosts_have_the_fluids_density() {
    let system = slit([40, 4, 40]);
    let mut sum = 0.0;
    let steps = 5;
    for step in 0..steps {
        let bench = {
            let mut bench = Bench::new(&system, &State { step, ..State::default() }, &KINDS[..3], &[]);
            bench.run_all(&KINDS[..3]);
            bench
        };
        sum += bench.scene.moments.iter().map(|m| m.count).sum::<f64>();
    }
    let expected = 10.0 * 1600.0 * steps as f64;
    assert!((sum - expected).abs() < 5.0 * expected.sqrt(), "{sum} of {expected}");
}

#[test]
fn walls_receive_what_their_ghosts_gain() {
    let system = slit([6, 5, 7]);
    let start = state(gas(&system, 11, 2100), Vec::new());
    let mut bench = Bench::new(&system, &start, &KINDS, &[]);
    bench.run_all(&KINDS);
    let after = momentum(&bench.scene.state.particles);
    bench.receive("wall-ghosts");
    let found = bench.wall_impulses();
    for (found, wanted) in found.into_iter().zip(bench.scene.wall_impulses) {
        // About 210 ghosts per wall at most, each with its normals' error before and after.
        let allowed = 420.0 * 2.0 * 6.0 * TRANSCENDENTAL;
        assert!((found - wanted).length() < allowed && wanted.length() > 1.0, "{found} {wanted}");
    }
    // Cell by cell the fixed-point sums decide the mean velocity to N/2 units: 420 ghosts and 2100 particles at 2^-21 each, and
    // f32 velocities.
    let missing = after - momentum(&start.particles) + found[0] + found[1];
    assert!(missing.length() < 2520.0 * (2f64.powi(-21) + 4.0 * ROUNDING), "{missing}");
}
