//! squirmer-collide: bounces with exact answers, and single paths against the reference.

use crate::bench::*;
use crate::rig;
use glam::{DQuat, DVec3};
use squirm::params::Value;
use squirm::state::scene::{Load, Motion};
use squirm::state::{Particle, Squirmer, System};

pub const FLIGHT: [&str; 2] = ["stream", "squirmer-collide"];

/// Places are exact up to the f32 arithmetic of distances of some cells, and to the 1e-5 of a semi-axis by which particles leave
/// a surface, up to three times in these tests.
const PLACE: f64 = 1e-4;
/// Velocities: the slip's and the spin's roundings.
const SPEED: f64 = 2e-6;

/// The motion of one step that ended at the squirmer's pose with steady drift and spin.
pub fn motion(squirmer: &Squirmer, drift: DVec3, spin: DVec3, dt: f64) -> Motion {
    Motion {
        position: squirmer.position - drift * dt,
        orientation: DQuat::from_scaled_axis(-spin * dt) * squirmer.orientation,
        drift,
        spin,
    }
}

/// A box of 16 with one species and a step of 1.
fn world(along: f64, across: f64) -> System {
    let mut system = rig::system([16, 16, 16]);
    system.run.dt = 1.0;
    system.species = vec![rig::species(along, across, 0.0, 0.0)];
    system
}

/// Flies on the adapter and by the reference, compares, and gives the adapter's particles and loads.
fn fly(
    system: &System,
    particles: &[Particle],
    bodies: &[(Squirmer, Motion)],
    max_hits: i64,
) -> (Vec<Particle>, Vec<Load>) {
    let squirmers = bodies.iter().map(|b| b.0).collect();
    let hits = [("squirmer-collide", "max_hits", Value::Integer(max_hits))];
    let mut bench = Bench::new(system, &state(particles.to_vec(), squirmers), &FLIGHT, &hits);
    bench.set_motions(&bodies.iter().map(|b| b.1).collect::<Vec<_>>());
    for kind in FLIGHT {
        bench.run(kind);
    }
    let (found, loads) = (bench.state(), bench.loads());
    for (found, wanted) in found.particles.iter().zip(&bench.scene.state.particles) {
        let off = squirm::state::start::nearest_image(&system.domain, found.position - wanted.position);
        assert!(off.length() < PLACE, "{found:?} {wanted:?}");
        assert!((found.velocity - wanted.velocity).length() < 10.0 * SPEED, "{found:?} {wanted:?}");
    }
    for (i, wanted) in bench.scene.state.squirmers.iter().enumerate() {
        let m = mass(system, wanted);
        assert!((found.squirmers[i].velocity - wanted.velocity).length() < 40.0 * SPEED / m + 1e-7);
        let turn = (found.squirmers[i].angular_momentum - wanted.angular_momentum).length();
        // Arms are as exact as places; impulses are of the order of ten.
        assert!(turn < 20.0 * PLACE, "{turn}");
        assert!((loads[i].force - bench.scene.loads[i].force).length() < 40.0 * SPEED);
    }
    for (found, wanted) in bench.wall_impulses().into_iter().zip(bench.scene.wall_impulses) {
        assert!((found - wanted).length() < 40.0 * SPEED, "{found} {wanted}");
    }
    assert_eq!(bench.faults(), 0);
    (found.particles, loads)
}

fn resting(position: DVec3) -> (Squirmer, Motion) {
    let body = squirmer(position);
    (body, motion(&body, DVec3::ZERO, DVec3::ZERO, 1.0))
}

fn near(found: DVec3, wanted: DVec3, tolerance: f64) {
    assert!((found - wanted).length() < tolerance, "{found} instead of {wanted}");
}

#[test]
fn head_on_hits_of_all_shapes() {
    for (along, across) in [(2.0, 2.0), (3.0, 1.5), (1.5, 2.5)] {
        let system = world(along, across);
        let body = resting(DVec3::splat(8.0));
        for (axis, reach) in [(DVec3::X, across), (DVec3::NEG_Y, across), (DVec3::Z, along), (DVec3::NEG_Z, along)] {
            // The gap of 0.3 takes a fifth of the step; the rest leads back.
            let start = Particle { position: DVec3::splat(8.0) + axis * (reach + 0.3), velocity: -1.5 * axis };
            let (end, loads) = fly(&system, &[start], &[body], 8);
            near(end[0].velocity, 1.5 * axis, SPEED);
            near(end[0].position, DVec3::splat(8.0) + axis * (reach + 1.2), PLACE);
            near(loads[0].force, -3.0 * axis, 2.0 * SPEED);
            near(loads[0].torque, DVec3::ZERO, 2.0 * PLACE);
        }
    }
}

#[test]
fn moving_bodies_pass_their_motion_on() {
    let system = world(2.0, 2.0);
    // The gap of 0.3 closes at 1.5 in a fifth of the step.
    let drift = DVec3::new(-0.5, 0.0, 0.0);
    let body = squirmer(DVec3::splat(8.0) + drift);
    let start = Particle { position: DVec3::splat(8.0) - DVec3::X * 2.3, velocity: DVec3::X };
    let (end, loads) = fly(&system, &[start], &[(body, motion(&body, drift, DVec3::ZERO, 1.0))], 8);
    near(end[0].velocity, DVec3::X * -2.0, SPEED);
    near(end[0].position, start.position + DVec3::X * (0.2 - 1.6), PLACE);
    near(loads[0].force, DVec3::X * 3.0, 2.0 * SPEED);
    // A sphere turning about z drags: v' = -v + 2 spin x s.
    // The path is straight in the turning frame, so that the contact is off by spin v h^2 / 4 = 0.005.
    let spin = DVec3::Z * 0.02;
    let body = squirmer(DVec3::splat(8.0));
    let start = Particle { position: DVec3::new(5.5, 8.0, 8.0), velocity: DVec3::X };
    let (end, loads) = fly(&system, &[start], &[(body, motion(&body, DVec3::ZERO, spin, 1.0))], 8);
    near(end[0].velocity, DVec3::new(-1.0, -0.08, 0.0), 2.0 * 0.02 * 0.01);
    near(loads[0].torque, DVec3::Z * -2.0 * 0.08, 2.0 * 0.01);
}

#[test]
fn grazing_paths_hit_or_miss_and_bodies_at_faces_are_met() {
    let system = world(2.0, 2.0);
    // Also across a corner of the box, so that the path and the body wrap.
    for centre in [DVec3::splat(8.0), DVec3::new(0.1, 15.9, 0.0)] {
        let body = resting(centre);
        for (offset, hit) in [(1.999, true), (2.001, false)] {
            let velocity = DVec3::X * 4.0;
            let wrapped = (centre + DVec3::new(-2.0, offset, 0.0)).rem_euclid(DVec3::splat(16.0));
            let (end, loads) = fly(&system, &[Particle { position: wrapped, velocity }], &[body], 8);
            assert_eq!(end[0].velocity.x < 0.0, hit, "{centre} {offset}");
            assert_eq!(loads[0].force != DVec3::ZERO, hit);
        }
    }
}

/// Between two spheres with a gap of 1 a particle of speed 3.4 bounces three times in a step; walls count as hits, too.
#[test]
fn several_hits_in_one_step() {
    let mut system = world(2.0, 2.0);
    system.species[0].count = 2;
    let bodies = [resting(DVec3::new(5.5, 3.0, 8.0)), resting(DVec3::new(10.5, 3.0, 8.0))];
    let start = Particle { position: DVec3::new(8.0, 3.0, 8.0), velocity: DVec3::X * 3.4 };
    for (hits, place, velocity) in [(8, 8.4, -3.4), (3, 8.5, -3.4), (2, 7.5, 3.4), (1, 8.5, -3.4)] {
        let (end, loads) = fly(&system, &[start], &bodies, hits);
        // After 0.5, 1.5, 2.5 of the path of 3.4 it turns; with the last bounce allowed it stays where that happened.
        let place = if hits == 8 { 8.5 - 0.9 } else { place };
        near(end[0].position, DVec3::new(place, 3.0, 8.0), PLACE);
        near(end[0].velocity, DVec3::X * velocity, SPEED);
        assert_eq!(loads[0].force != DVec3::ZERO, hits != 1);
    }
    system.domain.walls = Some(rig::walls());
    // Off the wall below into the sphere, and the other way round.
    let above = resting(DVec3::new(5.5, 3.0, 8.0));
    let bodies = [above, resting(DVec3::new(10.5, 8.0, 8.0))];
    for velocity in [-1.5, 1.5] {
        let start = Particle { position: DVec3::new(5.5, 0.4, 8.0), velocity: DVec3::Y * velocity };
        let (end, loads) = fly(&system, &[start], &bodies, 8);
        // No-slip walls and spheres both reverse it: 0.4 and 0.6 to go, 1.5 in all.
        let place = if velocity < 0.0 { 1.0 - 0.1 } else { 0.1 };
        near(end[0].position, DVec3::new(5.5, if velocity < 0.0 { place } else { 0.4 - 0.5 + 0.6 - 0.4 }, 8.0), PLACE);
        assert!(loads[0].force.y > 2.9 && loads[1].force == DVec3::ZERO);
    }
}

/// Particles found inside leave through the nearest scaled point, bouncing only if they move inwards.
#[test]
fn particles_found_inside_leave() {
    let system = world(3.0, 1.5);
    let body = resting(DVec3::splat(8.0));
    for velocity in [-0.5, 0.5] {
        let start = Particle { position: DVec3::new(9.45, 8.0, 8.0), velocity: DVec3::X * velocity };
        let (end, loads) = fly(&system, &[start], &[body], 8);
        near(end[0].velocity, DVec3::X * 0.5, SPEED);
        near(end[0].position, DVec3::new(10.0, 8.0, 8.0), PLACE);
        assert_eq!(loads[0].force != DVec3::ZERO, velocity < 0.0);
    }
}
