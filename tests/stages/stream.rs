//! stream: flight, body force, walls and wrap-around against the reference.

use crate::bench::*;
use crate::rig;
use glam::DVec3;
use squirm::state::start::nearest_image;
use squirm::state::{Particle, System};

fn slit(condition: &str) -> System {
    let mut system = rig::system([10, 6, 12]);
    system.domain.walls = Some(squirm::state::Walls {
        condition: condition.into(),
        velocity_low: [0.2, 0.0, -0.1],
        velocity_high: [-0.3, 0.0, 0.4],
        ..rig::walls()
    });
    system
}

/// A gas, and particles of the greatest speed along all diagonals, some at faces and corners, some at rest.
fn particles(system: &System) -> Vec<Particle> {
    let mut particles = gas(system, 1, 4000);
    let size = DVec3::from_array(system.domain.size.map(f64::from));
    let sides = [0.0, 1e-9, 0.4, 1.0 - 1e-9];
    for k in 0..64 {
        let place = DVec3::new(sides[k % 4], sides[k / 4 % 4], sides[k / 16]) * size;
        particles.push(Particle { position: place, velocity: DVec3::ZERO });
        for corner in 0..8 {
            let sign = |bit: usize| if corner & bit == 0 { 1.0 } else { -1.0 };
            let velocity = DVec3::new(sign(1), sign(2), sign(4)) * 12.0 / 3f64.sqrt();
            particles.push(Particle { position: place, velocity });
        }
    }
    particles
}

/// Compares one flight. Every displacement rounds to a unit of the coordinate, and the product v h, the share of it up to a wall
/// and the rest of the time round to f32: some 8 roundings of the path. Twice a wall's velocity less the particle's rounds once
/// per wall, as does each half of a kick, up to a whole unit in the last place since dice decide.
fn compare(system: &System) -> Bench {
    let mut bench = Bench::new(system, &state(particles(system), Vec::new()), &["stream"], &[]);
    let start = bench.scene.state.particles.clone();
    bench.run("stream");
    let unit = f64::from(system.domain.period().into_iter().max().expect("three")) / 4_294_967_296.0;
    let (mut impulse, mut worst) = (0.0, (0.0f64, 0.0f64));
    for ((found, wanted), start) in bench.state().particles.iter().zip(&bench.scene.state.particles).zip(&start) {
        let path = (start.velocity.length() + 1.0) * system.run.dt.abs();
        let off = nearest_image(&system.domain, found.position - wanted.position).length();
        worst.0 = worst.0.max(off / (4.0 * unit + 8.0 * ROUNDING * path));
        let error = (found.velocity - wanted.velocity).abs().max_element();
        worst.1 = worst.1.max(error / (6.0 * ROUNDING * (start.velocity.length() + 1.0)));
        impulse += (start.velocity - wanted.velocity).length();
    }
    println!("{worst:?}");
    assert!(worst.0 < 1.0 && worst.1 < 1.0, "{worst:?}");
    for (found, wanted) in bench.wall_impulses().into_iter().zip(bench.scene.wall_impulses) {
        // Every bounce rounds to 2^-21 and to f32.
        let met = start.len() as f64 * 2.0 / 2_097_152.0 + 4.0 * ROUNDING * impulse;
        assert!((found - wanted).length() < met, "{found} {wanted}");
    }
    bench
}

#[test]
fn flight_in_a_periodic_box() {
    let mut system = rig::system([10, 6, 12]);
    compare(&system);
    system.fluid.acceleration = [0.3, -0.5, 0.7];
    let bench = compare(&system);
    assert_eq!(bench.wall_impulses(), [DVec3::ZERO; 2]);
}

#[test]
fn flight_between_resting_and_moving_walls() {
    for condition in ["no-slip", "slip"] {
        let mut system = slit(condition);
        compare(&system);
        system.fluid.acceleration = [0.3, -0.5, 0.7];
        let bench = compare(&system);
        let [low, high] = bench.wall_impulses();
        assert!(low.y < -100.0 && high.y > 100.0, "{low} {high}");
        let walls = system.domain.walls.as_mut().expect("walls");
        (walls.velocity_low, walls.velocity_high) = ([0.0; 3], [0.0; 3]);
        compare(&system);
    }
}

/// A slit so thin that particles meet both walls, some several times, in one step.
#[test]
fn several_bounces_in_one_step() {
    for condition in ["no-slip", "slip"] {
        let mut system = slit(condition);
        system.domain.size = [10, 2, 12];
        system.run.dt = 0.15;
        let mut state = state(gas(&system, 2, 4000), Vec::new());
        for (i, particle) in state.particles.iter_mut().enumerate() {
            // Up to 12: paths of up to 1.8 of the slit's 2.
            particle.velocity.y = 12.0 * ((i as f64 / 2000.0) - 1.0);
        }
        let mut bench = Bench::new(&system, &state, &["stream"], &[]);
        bench.run("stream");
        let mut turned = 0;
        for ((found, wanted), start) in
            bench.state().particles.iter().zip(&bench.scene.state.particles).zip(&state.particles)
        {
            // As above, with paths below 2.
            let off = nearest_image(&system.domain, found.position - wanted.position).length();
            assert!(off < 24.0 * ROUNDING * 2.0, "{found:?} {wanted:?}");
            assert!((found.velocity - wanted.velocity).length() < 6.0 * ROUNDING * 14.0);
            turned += usize::from(start.velocity.y * wanted.velocity.y < 0.0);
        }
        assert!(turned > 1000, "{turned}");
    }
}

#[test]
fn a_flight_backwards_undoes_a_flight() {
    for (condition, acceleration) in [("no-slip", [0.0; 3]), ("slip", [0.1, -0.3, 0.2])] {
        let mut system = slit(condition);
        system.fluid.acceleration = acceleration;
        // None of them starts at a wall, where a flight back has not met it yet.
        let start = state(gas(&system, 6, 4000), Vec::new());
        let mut forth = Bench::new(&system, &start, &["stream"], &[]);
        forth.run_all(&["stream"]);
        system.run.dt = -system.run.dt;
        let mut back = Bench::new(&system, &forth.scene.state, &["stream"], &[]);
        back.run_all(&["stream"]);
        for (end, begin) in back.scene.state.particles.iter().zip(&start.particles) {
            let speed = begin.velocity.length() + 1.0;
            // Twice the errors of one flight; those of the velocity, four kicks and two bounces, over the whole time.
            let off = nearest_image(&system.domain, end.position - begin.position).length();
            assert!(off < 24.0 * ROUNDING * speed * 0.1 + 4e-8, "{end:?} {begin:?}");
            assert!((end.velocity - begin.velocity).length() < 12.0 * ROUNDING * speed, "{end:?} {begin:?}");
        }
        for (a, b) in forth.wall_impulses().into_iter().zip(back.wall_impulses()) {
            assert!(a.length() > 50.0 && (a + b).length() < 1e-5 * a.length() + 1e-3, "{a} {b}");
        }
    }
}

/// A force so weak that a half kick is a small part of a unit in the last place still accelerates the fluid at its rate.
#[test]
fn weak_body_forces_are_not_lost() {
    let mut system = rig::system([16, 16, 16]);
    system.fluid.acceleration = [3e-8, 0.0, -1e-7];
    let start = state(gas(&system, 3, 40_000), Vec::new());
    let mut bench = Bench::new(&system, &start, &["stream"], &[]);
    let before = bench.scene.state.particles.clone();
    let steps = 20u32;
    for _ in 0..steps {
        bench.run_all(&["stream"]);
    }
    let n = before.len() as f64;
    for axis in 0..3 {
        let gains: Vec<f64> =
            bench.scene.state.particles.iter().zip(&before).map(|(a, b)| a.velocity[axis] - b.velocity[axis]).collect();
        let mean = gains.iter().sum::<f64>() / n;
        let variance = gains.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / n;
        let wanted = system.fluid.acceleration[axis] * system.run.dt * f64::from(steps);
        println!("{axis}: {mean:e} of {wanted:e}, sigma {:e}", (variance / n).sqrt());
        assert!((mean - wanted).abs() <= 5.0 * (variance / n).sqrt(), "{axis}: {mean:e} of {wanted:e}");
        assert!(wanted == 0.0 || wanted.abs() > 5.0 * (variance / n).sqrt(), "the test would not see it");
    }
}
