//! squirmer-fill: the same ghosts as the reference's, their rigid motion, and what the squirmers receive of them.

use crate::bench::*;
use crate::rig;
use glam::{DMat3, DQuat, DVec3};
use squirm::math::rigid::Top;
use squirm::params::Value;
use squirm::state::scene::outer;
use squirm::state::{Squirmer, State, System};

const KINDS: [&str; 6] = ["shift-grid", "cell-reduce", "squirmer-fill", "rotate", "restore-thermostat", "apply"];

fn ghosts(rule: &str) -> [Change; 1] {
    [("squirmer-fill", "ghosts", Value::Text(rule.into()))]
}

/// A prolate body, an oblate one across a face of the box, and a held sphere, all of them moving and turning.
fn bodies() -> (System, Vec<Squirmer>) {
    let mut system = rig::system([16, 17, 18]);
    system.species = [(4.0, 2.0), (1.5, 2.5), (2.0, 2.0)]
        .map(|(along, across)| squirm::state::Species { rotlet: 0.2, ..rig::species(along, across, 0.3, -2.0) })
        .to_vec();
    system.species[2].held = true;
    let body = |(i, position): (u32, DVec3)| {
        let (u, n) = random(20, i);
        Squirmer {
            species: i as usize,
            orientation: DQuat::from_rotation_arc(DVec3::Z, (u - 0.5).normalize()),
            velocity: 0.2 * n,
            angular_momentum: 100.0 * (u - 0.5),
            ..squirmer(position)
        }
    };
    let places = [DVec3::new(8.3, 7.9, 8.1), DVec3::new(0.2, 16.8, 2.0), DVec3::new(13.0, 12.0, 14.5)];
    (system, (0u32..).zip(places).map(body).collect())
}

/// Fluid outside the bodies.
fn fluid(system: &System, bodies: &[Squirmer], count: u32) -> Vec<squirm::state::Particle> {
    let mut particles = gas(system, 21, count);
    particles.retain(|p| bodies.iter().all(|s| depth(system, s, p.position) > 1.0));
    particles
}

/// Ghosts have an error of the transcendental functions in place (times the longest semi-axis) and velocity (times six); one
/// within that of a cell's face, one in some ten thousand, may be counted beyond it.
#[test]
fn ghosts_are_the_references() {
    let (system, bodies) = bodies();
    for (rule, step) in [("published", 4), ("equipartition", 4), ("equipartition", (1 << 32) + 9)] {
        let start = State { step, particles: fluid(&system, &bodies, 5000), squirmers: bodies.clone() };
        let mut bench = Bench::new(&system, &start, &KINDS[..3], &ghosts(rule));
        bench.run_all(&KINDS[..2]);
        bench.run("squirmer-fill");
        for (found, wanted) in bench.ghost_motion().iter().zip(&bench.scene.ghost_motion) {
            // Means over hundreds of ghosts, resolved to 2^-19 each.
            let off = (found.0 - wanted.0).length() + (found.1 - wanted.1).length();
            assert!(off < 4.0 * TRANSCENDENTAL, "{rule}: {found:?} {wanted:?}");
        }
        let moments = bench.moments();
        let (mut strays, mut filled) = (0.0, 0);
        for (found, wanted) in moments.iter().zip(&bench.scene.moments) {
            strays += (found.count - wanted.count).abs() / 2.0;
            filled += usize::from(wanted.count > 0.0);
            if found.count == wanted.count {
                let e = excess(&system, found, wanted, 12.0 * TRANSCENDENTAL, 4.0 * TRANSCENDENTAL);
                assert!(e <= 1.0, "{rule}: {e}\n{found:?}\n{wanted:?}");
            }
        }
        assert!(strays <= 2.0 && filled > 3000, "{strays} {filled}");
        let count = |m: &[squirm::state::scene::Moments]| m.iter().map(|m| m.count).sum::<f64>();
        assert_eq!(count(&moments), count(&bench.scene.moments));
        assert_eq!(bench.faults(), 0);
    }
}

/// What each body receives, and that a held one only records it.
#[test]
fn squirmers_receive_what_their_ghosts_gain() {
    let (system, bodies) = bodies();
    for rule in ["published", "equipartition"] {
        let start = state(fluid(&system, &bodies, 40_000), bodies.clone());
        let mut bench = Bench::new(&system, &start, &KINDS, &ghosts(rule));
        bench.run_all(&KINDS);
        assert_eq!(bench.scene.state.squirmers, Bench::new(&system, &start, &KINDS, &[]).scene.state.squirmers);
        bench.receive("squirmer-fill");
        let loads = bench.loads();
        for (i, (found, wanted)) in bench.state().squirmers.iter().zip(&bench.scene.state.squirmers).enumerate() {
            let n = mass(&system, wanted);
            // Every ghost's velocity before and after has its error; they add up at random, and a stray ghost counts a few units.
            let allowed = 24.0 * TRANSCENDENTAL * n.sqrt() + 10.0 * ROUNDING * n;
            let force = (loads[i].force - bench.scene.loads[i].force).length();
            let torque = (loads[i].torque - bench.scene.loads[i].torque).length();
            println!("{rule} {i}: {force:e} {torque:e} of {allowed:e}, {}", bench.scene.loads[i].force);
            assert!(force < allowed && torque < 4.0 * allowed, "{rule} {i}: {force:e} {torque:e} of {allowed:e}");
            assert!(bench.scene.loads[i].force.length() > 0.1);
            let old = &start.squirmers[i];
            if system.species[wanted.species].held {
                assert_eq!(wanted.velocity.as_vec3(), old.velocity.as_vec3());
            } else {
                assert!((found.velocity - wanted.velocity).length() < allowed / n + 4.0 * ROUNDING);
                let turn = (found.angular_momentum - wanted.angular_momentum).length();
                assert!(turn < 4.0 * allowed + 4.0 * ROUNDING * wanted.angular_momentum.length());
                assert!((wanted.velocity - old.velocity).length() > 10.0 * allowed / n);
            }
        }
    }
}

/// Momentum and angular momentum of a free body and the fluid around it, away from the faces of the box.
#[test]
fn fluid_and_squirmers_keep_momentum_and_angular_momentum() {
    let (mut system, mut bodies) = bodies();
    system.species.truncate(1);
    bodies.truncate(1);
    let mut particles = fluid(&system, &bodies, 49_000);
    particles.retain(|p| (p.position - 8.0).abs().max_element() < 6.0);
    for rule in ["published", "equipartition"] {
        let start = state(particles.clone(), bodies.clone());
        let mut bench = Bench::new(&system, &start, &KINDS, &ghosts(rule));
        let carried = |state: &State| {
            let body = &state.squirmers[0];
            let m = mass(&system, body);
            let spin: DVec3 = state.particles.iter().map(|p| (p.position - 8.0).cross(p.velocity)).sum();
            let p = momentum(&state.particles) + m * body.velocity;
            (p, spin + m * (body.position - 8.0).cross(body.velocity) + body.angular_momentum)
        };
        let before = carried(&bench.scene.state);
        bench.run_all(&KINDS);
        bench.receive("squirmer-fill");
        let after = carried(&bench.state());
        // Each cell keeps what it carries to f32, 1e-6 per particle in bad cells; signs are random.
        let n = (particles.len() as f64).sqrt();
        let (p, l) = ((after.0 - before.0).length(), (after.1 - before.1).length());
        println!("{rule} {p:e} {l:e}");
        assert!(p < 1e-5 * n && l < 6e-5 * n, "{rule}: {p:e} {l:e}");
        let moved = bench.state().squirmers[0].velocity - bodies[0].velocity;
        assert!(moved.length() * mass(&system, &bodies[0]) > 1.0);
    }
}

/// The ghosts of the only squirmer: from its centre, and their velocities.
fn drawn(bench: &Bench) -> Vec<(DVec3, DVec3)> {
    let count = mass(bench.system(), &bench.scene.state.squirmers[0]) as usize;
    let (places, others) = (bench.floats("ghosts"), bench.floats("ghosts_yz"));
    let (linear, angular) = bench.ghost_motion()[0];
    let ghost = |(p, yz): (&[f64], &[f64])| {
        let s = DVec3::from_slice(p);
        (s, linear + angular.cross(s) + DVec3::new(p[3], yz[0], yz[1]))
    };
    places.chunks_exact(4).zip(others.chunks_exact(2)).take(count).map(ghost).collect()
}

/// The sums over a squirmer's ghosts about its centre: number, sum v, sum s, sum s x v, sum of s.s 1 - s s^T.
fn about_centre(bench: &Bench) -> (f64, DVec3, DVec3, DVec3, DMat3) {
    let mut sums = (0.0, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, DMat3::ZERO);
    for (s, v) in drawn(bench) {
        sums.0 += 1.0;
        sums.1 += v;
        sums.2 += s;
        sums.3 += s.cross(v);
        sums.4 += s.length_squared() * DMat3::IDENTITY - outer(s, s);
    }
    sums
}

/// Ghosts are left out only where no corner of their cell is outside, and then all of the cell's; and that is worth it.
#[test]
fn cells_within_a_body_hold_nobody() {
    let (system, bodies) = bodies();
    for body in bodies {
        let species = vec![system.species[body.species].clone()];
        let hull = species[0].hull();
        let axes = DVec3::new(hull.across, hull.across, hull.along);
        let system = System { species, ..system.clone() };
        let body = Squirmer { species: 0, position: DVec3::new(8.3, 7.9, 8.1), ..body };
        let mut bench = Bench::new(&system, &state(Vec::new(), vec![body]), &KINDS[..3], &[]);
        bench.run_all(&KINDS[..3]);
        let moments = bench.moments();
        let mut expected = vec![0.0; moments.len()];
        let mut left_out = 0.0;
        for (s, _) in drawn(&bench) {
            let (cell, offset) = bench.scene.locate(&system, body.position + s);
            let within = |corner: usize| {
                let h = DVec3::from_array([0, 1, 2].map(|k| if corner >> k & 1 == 1 { 0.5 } else { -0.5 }));
                (body.orientation.inverse() * (s - offset + h) / axes).length() < 1.0
            };
            if (0..8).all(within) && moments[cell].count == 0.0 {
                left_out += 1.0;
            } else {
                expected[cell] += 1.0;
            }
        }
        // One within rounding of a face may be counted beyond it.
        let strays = moments.iter().zip(&expected).map(|(m, n)| (m.count - n).abs() / 2.0).sum::<f64>();
        assert!(strays <= 1.0, "{strays}");
        let share = left_out / mass(&system, &body);
        println!("{axes}: {share}");
        assert!(share > 0.05, "{share}");
    }
}

/// With equipartition the ghosts of a body without slip have its rigid motion exactly; as published they do not.
#[test]
fn equipartition_leaves_no_rigid_part() {
    let (mut system, mut bodies) = bodies();
    system.species.truncate(1);
    (system.species[0].b1, system.species[0].rotlet) = (0.0, 0.0);
    bodies.truncate(1);
    let (along, across) = system.species[0].spheroid().inertia(mass(&system, &bodies[0]));
    let spin = Top { along, across }.angular_velocity(bodies[0].orientation, bodies[0].angular_momentum);
    for (rule, rigid) in [("equipartition", false), ("published", true)] {
        let mut bench = Bench::new(&system, &state(Vec::new(), bodies.clone()), &KINDS[..3], &ghosts(rule));
        bench.run_all(&KINDS[..3]);
        let (n, p, s, l, inertia) = about_centre(&bench);
        assert_eq!(n, mass(&system, &bodies[0]));
        let momentum = (p - n * bodies[0].velocity - spin.cross(s)).length();
        let turning = (l - s.cross(bodies[0].velocity) - inertia * spin).length();
        println!("{rule}: {momentum:e} {turning:e}");
        if rigid {
            // sqrt(n kT) per component, n = 670, and sqrt(I kT).
            assert!(momentum > 3.0 && turning > 3.0, "{momentum} {turning}");
        } else {
            // n roundings of 2^-19 and of f32 in the mean, of either sign; arms of up to four.
            let allowed = n * (2f64.powi(-19) + 8.0 * ROUNDING);
            assert!(momentum < allowed && turning < 8.0 * allowed, "{momentum:e} {turning:e} of {allowed:e}");
        }
    }
}
