//! wall-ghosts: the same ghosts as the reference's, of the fluid's density, and what the walls receive of them.

use crate::bench::*;
use crate::rig;
use glam::DVec3;
use squirm::math::fixed::Scales;
use squirm::params::Value;
use squirm::state::scene::Operator;
use squirm::state::{Particle, State, System, Walls};

const KINDS: [&str; 6] = ["shift-grid", "cell-reduce", "wall-ghosts", "rotate", "restore-thermostat", "apply"];

fn slit(size: [u32; 3]) -> System {
    let mut system = rig::system(size);
    system.fluid.temperature = 0.5;
    system.domain.walls =
        Some(Walls { velocity_low: [0.2, 0.0, -0.1], velocity_high: [-0.3, 0.0, 0.4], ..rig::walls() });
    system
}

fn continued(patch: i64, memory: f64) -> [Change; 3] {
    [
        ("wall-ghosts", "velocity", Value::Text("continued".into())),
        ("wall-ghosts", "patch", Value::Integer(patch)),
        ("wall-ghosts", "memory", Value::Float(memory)),
    ]
}

fn at_wall_velocity() -> Change {
    ("wall-ghosts", "velocity", Value::Text("wall".into()))
}

/// A gas whose shear along x differs from place to place.
fn sheared(system: &System, set: u32, count: u32) -> Vec<Particle> {
    let mut particles = gas(system, set, count);
    for p in &mut particles {
        p.velocity += DVec3::new(0.4 * (0.4 * p.position.x).sin(), 0.0, 0.3) * p.position.y;
    }
    particles
}

#[test]
fn ghosts_are_the_references() {
    let system = slit([6, 5, 7]);
    for step in [0, 1, 2, (1 << 32) + 3] {
        let start = State { step, particles: gas(&system, 10, 300), squirmers: Vec::new() };
        let mut bench = Bench::new(&system, &start, &KINDS[..3], &[at_wall_velocity()]);
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
        assert!(
            [0, 1].into_iter().flat_map(|k| bench.wall_shear(k)).all(|p| p.moment == DVec3::ZERO && p.weight == 0.0)
        );
        assert_eq!(bench.faults(), 0);
    }
}

/// Errors of a patch's sums y (v - u_w) and y^2 over `n` particles in all: half a unit of each sum of the moments per particle,
/// times y <= 2 and |u_w| < 1; half a unit of their own per cell; eight f32 roundings of summands up to y^2 + v^2.
fn sum_errors(system: &System, n: f64, columns: f64) -> (f64, f64) {
    let scales = Scales::new(system.fluid.density, system.fluid.temperature);
    let roundings = 8.0 * ROUNDING * 5.0 * n;
    let moment = n * (1.0 / scales.velocity + 0.5 / scales.mixed + 0.5 / scales.position);
    let weight = n * (2.0 / scales.position + 0.5 / scales.second);
    (moment + columns * 32.0 / scales.mixed + roundings, weight + columns * 16.0 / scales.second + roundings)
}

/// Patches smaller than a workgroup's cells and larger, cut at the end or as large as the wall; three steps of memory.
#[test]
fn continued_ghosts_and_their_shear_are_the_references() {
    let system = slit([22, 5, 19]);
    let mut shears = Vec::new();
    for (patch, memory, patches) in [(4, 2.0, 2 * 6 * 5), (8, 0.0, 2 * 3 * 3), (9, 1.0, 2 * 3 * 3), (16384, 0.5, 2)] {
        let start = state(sheared(&system, 12, 20_900), Vec::new());
        let mut bench = Bench::new(&system, &start, &KINDS[..3], &continued(patch, memory));
        for _ in 0..4 {
            let step = bench.scene.state.step;
            bench.run_all(&KINDS[..2]);
            bench.run("wall-ghosts");
            // With the shear of the steps before: averages that began with the adapter's own, and a few roundings.
            for (found, wanted) in bench.wall_shear(step).iter().zip(&bench.scene.wall_shear) {
                let near = |a: f64, b: f64| (a - b).abs() <= 4.0 * ROUNDING * (b.abs() + wanted.weight);
                assert!(near(found.weight, wanted.weight), "{found:?}\n{wanted:?}");
                assert!(near(found.moment.x, wanted.moment.x) && near(found.moment.z, wanted.moment.z));
                shears.push(wanted.shear.length());
            }
            for (found, wanted) in bench.moments().iter().zip(&bench.scene.moments) {
                let e = excess(&system, found, wanted, 6.0 * TRANSCENDENTAL, 4.0 * ROUNDING);
                assert!(e <= 1.0, "{e}\n{found:?}\n{wanted:?}");
            }
            assert!(bench.wall_seen(step).iter().all(|(moment, weight)| *moment == DVec3::ZERO && *weight == 0.0));
            bench.scene.operators = vec![Operator::default(); bench.scene.moments.len()];
            bench.receive("wall-ghosts");
            assert_eq!(bench.scene.wall_seen.len(), patches);
            let found = bench.wall_seen(step);
            for (found, wanted) in found.iter().zip(&bench.scene.wall_seen) {
                // No more particles nor columns than the whole slit has.
                let cells = (patch * patch).min(22 * 19) as f64;
                let (moment, weight) = sum_errors(&system, 10.0 * 2.0 * cells + 100.0, 2.0 * cells);
                let off = [(found.0 - wanted.0).length() / moment, (found.1 - wanted.1).abs() / weight];
                assert!(off.iter().all(|e| *e <= 1.0), "{off:?}\n{found:?}\n{wanted:?}");
            }
            assert!(found[patches..].iter().all(|(moment, weight)| *moment == DVec3::ZERO && *weight == 0.0));
            bench.next_step();
        }
        assert_eq!(bench.faults(), 0);
    }
    let (median, largest) = median_and_largest(shears);
    assert!(median > 0.1 && largest > 0.3, "{median} {largest}");
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
    let start = state(sheared(&system, 11, 2100), Vec::new());
    let mut received = Vec::new();
    for changes in [vec![at_wall_velocity()], continued(4, 2.0).to_vec()] {
        let mut bench = Bench::new(&system, &start, &KINDS, &changes);
        // The second time with the shear of the first.
        for time in 1..3 {
            bench.run_all(&KINDS[..2]);
            bench.run("wall-ghosts");
            bench.run_all(&KINDS[3..]);
            let after = momentum(&bench.scene.state.particles);
            bench.receive("wall-ghosts");
            let found = bench.wall_impulses();
            for (found, wanted) in found.into_iter().zip(bench.scene.wall_impulses) {
                // About 210 ghosts per wall at most, each with its normals' error before and after.
                let allowed = 420.0 * 2.0 * 6.0 * TRANSCENDENTAL;
                assert!((found - wanted).length() < allowed && wanted.length() > 1.0, "{found} {wanted}");
            }
            // Cell by cell the fixed-point sums decide the mean velocity to N/2 units: 420 ghosts and 2100 particles at 2^-21 each,
            // and f32 velocities.
            let missing = after - momentum(&start.particles) + found[0] + found[1];
            let allowed = f64::from(time) * 2520.0 * (2f64.powi(-21) + 4.0 * ROUNDING);
            assert!(missing.length() < allowed, "{missing}");
            received.push(found[1]);
            bench.next_step();
        }
    }
    // There was no shear before the first.
    assert!((received[0] - received[2]).length() < 1e-3 && (received[1] - received[3]).length() > 1.0, "{received:?}");
}
