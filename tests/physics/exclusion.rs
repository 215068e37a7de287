//! Nothing is where something else is: fluid, squirmers and walls in a crowded slit.

use crate::{advance, alone, rig, scaled_radius, size, sound};
use squirm::math::steric::{Body, contact, wall_contact};
use squirm::state::start::{nearest_image, start};
use squirm::state::{Species, State, System};

/// A slit of which prolate and oblate squirmers take 29 %, pushers and pullers.
fn crowded() -> System {
    let mut system = rig::system([24, 10, size(24, 96)]);
    system.domain.walls = Some(rig::walls());
    let count = |n: u32| n * size(1, 4);
    system.species = vec![
        Species { count: count(12), ..rig::species(4.0, 2.0, 0.2, 3.0) },
        Species { count: count(8), ..rig::species(4.0, 2.0, 0.2, -3.0) },
        Species { count: count(5), ..rig::species(2.0, 3.0, 0.2, 0.0) },
    ];
    system
}

fn body(system: &System, squirmer: &squirm::state::Squirmer) -> Body {
    Body { shape: system.species[squirmer.species].spheroid(), axis: squirmer.axis() }
}

/// Particles inside a squirmer or beyond a wall. The adapter judges in f32: 1e-6 is a few units in the last place of 1.
fn misplaced(system: &System, state: &State) -> usize {
    let height = f64::from(system.domain.size[1]);
    let inside = |p: &&squirm::state::Particle| {
        !(0.0..height).contains(&p.position.y)
            || state.squirmers.iter().any(|s| {
                let arm = nearest_image(&system.domain, p.position - s.position);
                arm.length() < 4.0 && scaled_radius(system, s.species, s.orientation, arm) < 1.0 - 1e-6
            })
    };
    state.particles.iter().filter(inside).count()
}

/// The smallest gaps between two squirmers and between a squirmer and a wall, with the bare semi-axes.
fn gaps(system: &System, state: &State) -> (f64, f64) {
    let height = f64::from(system.domain.size[1]);
    let (mut pair, mut wall) = (f64::INFINITY, f64::INFINITY);
    for (i, a) in state.squirmers.iter().enumerate() {
        let body_a = body(system, a);
        for b in &state.squirmers[..i] {
            let r = nearest_image(&system.domain, b.position - a.position);
            pair = pair.min(contact(&body_a, &body(system, b), r).map_or(f64::NEG_INFINITY, |c| c.gap));
        }
        wall = wall.min(wall_contact(&body_a, a.position.y, glam::DVec3::Y).gap);
        wall = wall.min(wall_contact(&body_a, height - a.position.y, glam::DVec3::NEG_Y).gap);
    }
    (pair, wall)
}

/// Bodies that touch with their margins of 0.25 a are 0.5 a apart (0.25 a from a wall) and repel there with 24 epsilon/sigma =
/// 240 kT/a: no thermal motion brings their bare surfaces together.
#[test]
fn no_two_things_are_in_one_place() {
    let _turn = alone();
    let system = crowded();
    let share = 1.0 - system.fluid_volume() / system.domain.volume();
    assert!(share > 0.28, "{share}");
    let mut session = rig::fused(&rig::plan(&system, rig::EVERYTHING, &[]), &start(&system).expect("there is room"));
    let mut closest = (f64::INFINITY, f64::INFINITY);
    for _ in 0..size(20, 100) {
        advance(&mut session, 10);
        let state = session.state().expect("a state");
        assert_eq!(misplaced(&system, &state), 0, "step {}", state.step);
        let gaps = gaps(&system, &state);
        closest = (closest.0.min(gaps.0), closest.1.min(gaps.1));
    }
    sound(&session);
    println!("share {share:.3}, closest squirmers {:.3}, closest to a wall {:.3}", closest.0, closest.1);
    assert!(closest.0 > 0.0 && closest.1 > 0.0, "{closest:?}");
    // They did meet: some pair and some wall within the reach of the repulsion, margin + 0.12 sigma.
    assert!(closest.0 < 0.56 && closest.1 < 0.31, "{closest:?}");
}

/// The same check finds the particles that walk into squirmers when nothing stops them.
#[test]
fn without_collisions_squirmers_fill_with_fluid() {
    let _turn = alone();
    let system = crowded();
    let stages: Vec<&str> = rig::EVERYTHING.iter().copied().filter(|s| *s != "squirmer-collide").collect();
    let mut session = rig::fused(&rig::plan(&system, &stages, &[]), &start(&system).expect("there is room"));
    assert_eq!(misplaced(&system, &session.state().expect("a state")), 0);
    advance(&mut session, 1);
    assert!(misplaced(&system, &session.state().expect("a state")) > 100);
}
