//! Momentum and energy over whole runs: the fluid alone, with free squirmers, and between walls.

use crate::{SQUIRMERS, advance, alone, listed, momentum, rig, size, sound};
use glam::DVec3;
use squirm::gpu::Session;
use squirm::params::Value;
use squirm::state::start::start;
use squirm::state::{State, System, packed};

fn energy(state: &State) -> f64 {
    state.particles.iter().map(|p| 0.5 * p.velocity.length_squared()).sum()
}

/// What the walls received since the start.
fn received(session: &Session) -> [DVec3; 2] {
    packed::wall_impulses(session.system(), &session.read("wall_impulses").expect("words"))
}

/// 10,000 steps without a thermostat. A collision rounds the velocities of a cell's ten particles alike, by some 6e-8 each: without
/// a sign that is 6e-7 sqrt(1e4 steps 512 cells)/5120 = 2.6e-7 of momentum per particle, and less in a larger box. In the
/// energy it would be 1e-7; what builds up beyond that is a bias of the arithmetic (found: -1e-9 of the energy per step), for
/// which the bound of 1e-4 leaves room.
#[test]
fn a_fluid_without_thermostat_keeps_energy_and_momentum() {
    let _turn = alone();
    let edge = size(8, 32);
    let system = rig::system([edge; 3]);
    let state = rig::fluid(&system, 10 * (edge as usize).pow(3));
    let plan = rig::plan(&system, rig::BULK, &[("restore-thermostat", "mode", Value::Text("energy".into()))]);
    let mut session = rig::fused(&plan, &state);
    let before = session.state().expect("a state");
    advance(&mut session, 10_000);
    let after = session.state().expect("a state");
    sound(&session);
    let drift = energy(&after) / energy(&before) - 1.0;
    let lost = (momentum(&system, &after) - momentum(&system, &before)).length() / state.particles.len() as f64;
    println!("energy drift {drift:e}, momentum per particle {lost:e}");
    assert!(drift.abs() < 1e-4, "{drift:e}");
    assert!(lost < 1e-6, "{lost:e}");
    // Energy went to and fro between the particles all the while: none has the velocity that it started with.
    let kept = before.particles.iter().zip(&after.particles).filter(|(a, b)| a.velocity == b.velocity).count();
    assert_eq!(kept, 0);
}

/// Squirmers of three shapes, two of them close to a side of the box, in 24,000 particles.
fn mixture(walled: bool) -> System {
    let mut system = rig::system([14, 14, 14]);
    system.domain.walls = walled.then(rig::walls);
    system.species = vec![
        listed(rig::species(4.0, 2.0, 0.2, 3.0), vec![[3.0, 3.2, 4.0, 0.3, 0.2, 1.0]]),
        listed(rig::species(1.5, 3.0, 0.2, -3.0), vec![[10.0, 10.0, 3.5, 0.0, 1.0, 0.4]]),
        listed(rig::species(2.0, 2.0, 0.2, 0.0), vec![[3.0, 11.7, 10.0, -1.0, 0.0, 0.0]]),
    ];
    system
}

/// Momentum per particle that 300 steps lose, walls included; the walls' share of the last line tells how much they took.
fn lost(system: &System, kinds: &[&str]) -> (f64, [DVec3; 2]) {
    let state = start(system).expect("there is room");
    let mut session = rig::fused(&rig::plan(system, kinds, &[]), &state);
    let first = session.state().expect("a state");
    let before = momentum(system, &first);
    advance(&mut session, 300);
    let after = session.state().expect("a state");
    sound(&session);
    // The squirmers' momentum walks by sqrt(M kT), some 25, all the while: without that the sum would say nothing.
    for (a, b) in first.squirmers.iter().zip(&after.squirmers) {
        assert!((a.velocity - b.velocity).length() > 1e-3, "{a:?} {b:?}");
    }
    let walls = if system.domain.walls.is_some() { received(&session) } else { [DVec3::ZERO; 2] };
    let lost = momentum(system, &after) - before + walls[0] + walls[1];
    (lost.length() / state.particles.len() as f64, walls)
}

/// Free squirmers that swim and bounce: what they gain the fluid loses. A cell's velocity after a collision is rounded by some
/// 2^-24, for its ten particles alike: 6e-7 sqrt(300 steps 2744 cells)/24,000 = 2e-8 per particle, without a sign.
#[test]
fn fluid_and_free_squirmers_keep_their_momentum() {
    let _turn = alone();
    let (lost, _) = lost(&mixture(false), SQUIRMERS);
    println!("momentum per particle {lost:e}");
    assert!(lost < 1.5e-7, "{lost:e}");
}

/// The same between walls, which take momentum from collisions with their ghosts, from bounces and from steric forces. Their
/// 64 partial sums are rounded to 2^-21 per bounce: 2.4e-7 sqrt(300 steps 400 bounces) = 1e-4 altogether, 4e-9 per particle.
#[test]
fn fluid_squirmers_and_walls_keep_their_momentum() {
    let _turn = alone();
    let (lost, [low, high]) = lost(&mixture(true), rig::EVERYTHING);
    println!("momentum per particle {lost:e}, walls {low} {high}");
    // The low wall is pushed down, the high wall up: pressure 10 kT/a^3 on 196 a^2 for 30 tau is 58,800.
    assert!((low.y / -58_800.0 - 1.0).abs() < 0.1 && (high.y / 58_800.0 - 1.0).abs() < 0.1, "{low} {high}");
    assert!(lost < 1.5e-7, "{lost:e}");
}
