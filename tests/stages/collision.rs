//! Whole steps: runs agree bit by bit, and what a slit of squirmers conserves.

use crate::bench::*;
use crate::rig;
use glam::DVec3;
use squirm::params::Value;
use squirm::state::start::start;
use squirm::state::{Species, State, System, Walls};

/// A slit with three kinds of active squirmers, one of them held, moving walls, a body force, and a fluid around them.
pub fn active_slit() -> (System, State) {
    let mut system = rig::system([20, 14, 17]);
    system.run.dt = 0.05;
    system.domain.walls =
        Some(Walls { velocity_low: [0.2, 0.0, -0.1], velocity_high: [-0.3, 0.0, 0.4], ..rig::walls() });
    system.fluid.acceleration = [0.05, 0.0, -0.02];
    system.species = [(2, 4.0, 2.0), (2, 1.5, 2.5), (1, 2.0, 2.0)]
        .map(|(count, along, across)| Species { count, rotlet: 0.1, ..rig::species(along, across, 0.3, -2.0) })
        .to_vec();
    system.species[2].held = true;
    let state = start(&system).expect("there is room");
    (system, state)
}

/// Wall ghosts that continue the flow, with patches of 4 x 4 cells.
pub fn continued() -> [Change; 2] {
    let word = Value::Text("continued".into());
    [("wall-ghosts", "velocity", word), ("wall-ghosts", "patch", Value::Integer(4))]
}

#[test]
fn two_sessions_with_one_seed_agree_in_every_bit() {
    let (mut system, start) = active_slit();
    let run = |system: &System, steps, changes: &[Change]| {
        let mut bench = Bench::new(system, &start, rig::EVERYTHING, changes);
        bench.session.advance(steps, false);
        let digest = bench.session.raw().expect("readable").digest();
        assert_eq!(bench.faults(), 0);
        digest
    };
    let digest = |system: &System| run(system, 50, &[]);
    let first = digest(&system);
    assert_eq!(first, digest(&system));
    let other = run(&system, 20, &continued());
    assert_eq!(other, run(&system, 20, &continued()));
    assert_ne!(other, run(&system, 20, &[]));
    system.run.seed += 1;
    assert_ne!(first, digest(&system));
    system.run.seed += (1 << 32) - 1;
    assert_ne!(first, digest(&system));
}

/// Momentum of fluid, squirmers and walls together in a slit at rest; steric forces between squirmers are too far to act.
#[test]
fn fluid_squirmers_and_walls_keep_their_momentum() {
    let (mut system, mut start) = active_slit();
    system.fluid.acceleration = [0.0; 3];
    system.species[2].held = false;
    start.squirmers.remove(4);
    start.squirmers.remove(1);
    start.squirmers.remove(1);
    (system.species[0].count, system.species[1].count) = (1, 1);
    system.species.truncate(2);
    for changes in [Vec::new(), continued().to_vec()] {
        keeps_momentum(&system, &start, &changes);
    }
}

fn keeps_momentum(system: &System, start: &State, changes: &[Change]) {
    let mut bench = Bench::new(system, start, rig::EVERYTHING, changes);
    let total = |bench: &Bench| {
        let state = &bench.scene.state;
        let bodies: DVec3 = state.squirmers.iter().map(|s| mass(system, s) * s.velocity).sum();
        let walls = bench.scene.wall_impulses;
        (momentum(&state.particles) + bodies + walls[0] + walls[1], bodies)
    };
    let (before, bodies) = total(&bench);
    let steps = 20;
    bench.session.advance(steps, false);
    let steric = bench.floats("steric");
    bench.adopt();
    let (after, moved) = total(&bench);
    assert!((moved - bodies).length() > 1.0, "{bodies} {moved}");
    assert!(steric.iter().all(|f| *f == 0.0), "{steric:?}");
    // Per step and particle one unit of 2^-21 and four f32 roundings, adding up at random in the worst cells only.
    let n = start.particles.len() as f64;
    let allowed = steps as f64 * n.sqrt() * 10.0 * (2f64.powi(-21) + 4.0 * ROUNDING);
    println!("{} of {allowed}", (after - before).length());
    assert!((after - before).length() < allowed, "{before} {after}");
}
