//! Tests of the start: no overlap, equilibrium statistics, determinism.

use super::image::lengths;
use super::*;
use crate::math::steric::{Body, SAFETY, contact, wall_contact};
use crate::params::{Params, Values};
use crate::state::{Domain, Fluid, Init, Run, SemiAxes, Species, Walls};

pub(super) fn system(size: [u32; 3], walled: bool) -> System {
    let walls = walled.then(|| Walls::from_values(&Values::defaults(&Walls::fields())));
    System {
        run: Run { seed: 5, steps: 1, dt: 0.02, live: true },
        domain: Domain { size, walls },
        fluid: Fluid { density: 10.0, temperature: 2.0, acceleration: [0.0; 3] },
        species: Vec::new(),
        init: Init { from: None },
    }
}

pub(super) fn species(count: u32, along: f64, across: f64) -> Species {
    Species {
        name: "swimmer".into(),
        count,
        semi_axes: SemiAxes { along, across },
        offset: 0.0,
        force: [0.0; 3],
        b1: 0.1,
        beta: 0.0,
        rotlet: 0.0,
        passive: false,
        held: false,
        start: "random".into(),
        poses: None,
    }
}

/// Smallest gap between steric bodies, and between them and the walls.
fn smallest_gap(system: &System, squirmers: &[Squirmer]) -> f64 {
    let body = |s: &Squirmer| Body { shape: system.species[s.species].spheroid().grown(SAFETY), axis: s.axis() };
    let mut smallest = f64::MAX;
    for (i, a) in squirmers.iter().enumerate() {
        for b in &squirmers[i + 1..] {
            let r = nearest_image(&system.domain, b.position - a.position);
            smallest = smallest.min(contact(&body(a), &body(b), r).expect("centres differ").gap);
        }
        if system.domain.walls.is_some() {
            let height = lengths(&system.domain).y - a.position.y;
            smallest = smallest.min(wall_contact(&body(a), a.position.y, DVec3::Y).gap);
            smallest = smallest.min(wall_contact(&body(a), height, DVec3::NEG_Y).gap);
        }
    }
    smallest
}

#[test]
fn eight_hundred_spheroids_fill_half_a_narrow_slit() {
    let mut system = system([300, 7, 300], true);
    system.species = vec![species(800, 6.0, 3.0)];
    system.fluid.density = 0.0;
    let squirmers = start(&system).expect("an area fraction of 0.5 is far from jamming").squirmers;
    assert_eq!(squirmers.len(), 800);
    assert!(smallest_gap(&system, &squirmers) > 0.061, "{}", smallest_gap(&system, &squirmers));
    // Directions in the plane stay isotropic: sum of cos 2 phi has the variance 800/2 for independent ones; 5 sigma, and the
    // same again for the order that crowding makes.
    for angle in [0.0, 0.785] {
        let order: f64 = squirmers.iter().map(|s| (2.0 * (s.axis().z.atan2(s.axis().x) - angle)).cos()).sum();
        assert!(order.abs() < 10.0 * 20.0, "{order}");
    }
}

#[test]
fn random_squirmers_of_many_shapes_keep_apart() {
    for walled in [false, true] {
        let mut system = system([40, 30, 40], walled);
        system.species = vec![species(20, 6.0, 3.0), species(20, 3.0, 3.0), species(20, 2.0, 4.0)];
        system.fluid.density = 0.0;
        let squirmers = start(&system).expect("there is room").squirmers;
        assert!(smallest_gap(&system, &squirmers) > 0.061);
        for s in &squirmers {
            assert!((0..3).all(|k| (0.0..f64::from(system.domain.size[k])).contains(&s.position[k])));
            assert!((s.orientation.length() - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn dilute_directions_are_isotropic() {
    let mut system = system([200, 200, 200], false);
    system.species = vec![species(2000, 2.0, 1.0)];
    system.fluid.density = 0.0;
    let squirmers = start(&system).expect("there is room").squirmers;
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let cosines: Vec<f64> = squirmers.iter().map(|s| s.axis().dot(axis)).collect();
        let (first, second): (f64, f64) = (cosines.iter().sum(), cosines.iter().map(|c| c * c).sum());
        // 5 sigma of sums of 2000: the variance of c is 1/3, of c^2 it is 4/45.
        assert!(first.abs() < 5.0 * (2000.0f64 / 3.0).sqrt(), "{first}");
        assert!((second - 2000.0 / 3.0).abs() < 5.0 * (2000.0f64 * 4.0 / 45.0).sqrt(), "{second}");
    }
}

#[test]
fn the_start_is_a_function_of_the_seed() {
    let mut system = system([20, 20, 20], true);
    system.species = vec![species(5, 3.0, 2.0)];
    let first = start(&system).expect("there is room");
    assert_eq!(first, start(&system).expect("there is room"));
    system.run.seed += 1;
    assert_ne!(first.particles[0], start(&system).expect("there is room").particles[0]);
}

#[test]
fn the_fluid_is_uniform_outside_the_bodies_and_at_rest() {
    let mut system = system([40, 20, 40], true);
    system.species = vec![species(10, 5.0, 3.0), Species { held: true, ..species(3, 2.0, 4.0) }];
    let state = start(&system).expect("there is room");
    assert_eq!(state.particles.len() as u64, system.particle_count());
    let l = lengths(&system.domain);
    for p in &state.particles {
        assert!((0..3).all(|k| p.position[k] >= 0.0 && p.position[k] < l[k]));
        for s in &state.squirmers {
            let r = nearest_image(&system.domain, p.position - s.position);
            assert!(!system.species[s.species].spheroid().inside(s.orientation.inverse() * r));
        }
    }
    // The layer of 0.3 a around one body holds as many particles as its free volume, sampled at random, tells: neither depleted
    // nor piled up. 5 sigma of the Poisson number, and half as much again for the sampling.
    let s = &state.squirmers[0];
    let shape = system.species[s.species].spheroid();
    let bodies = fluid::Bodies::new(&system, &state.squirmers);
    let shell = shape.grown(0.3);
    let near = |p: DVec3| shell.inside(s.orientation.inverse() * nearest_image(&system.domain, p - s.position));
    let found = state.particles.iter().filter(|p| near(p.position)).count() as f64;
    let samples = 1_000_000u32;
    let free = (0..samples).filter(|i| {
        let u = Stream::new(99, Use::Pose, *i).uniforms();
        let p = l * DVec3::new(u[0], u[1], u[2]);
        near(p) && bodies.containing(p).is_none()
    });
    let wanted = 10.0 * system.domain.volume() * free.count() as f64 / f64::from(samples);
    assert!((found - wanted).abs() < 5.0 * (wanted * 1.5).sqrt(), "{found} {wanted}");
    let (total, mass) = momentum(&system, &state.particles, &state.squirmers);
    assert!(total.length() < 1e-12 * mass, "{total}");
    let n = 3.0 * state.particles.len() as f64;
    let square: f64 = state.particles.iter().map(|p| p.velocity.length_squared()).sum();
    // 5 sigma: the variance of v^2/kT is 2.
    assert!((square / 2.0 / n - 1.0).abs() < 5.0 * (2.0 / n).sqrt(), "{}", square / n);
    assert!(state.squirmers[10..].iter().all(|s| s.velocity == DVec3::ZERO && s.angular_momentum == DVec3::ZERO));
}

#[test]
fn squirmers_have_the_energy_of_equipartition() {
    let mut system = system([200, 200, 200], false);
    system.species = vec![species(3000, 2.0, 1.0)];
    system.fluid.density = 0.0;
    system.species[0].count = 3000;
    let squirmers = start(&system).expect("there is room").squirmers;
    let (along, across) = system.species[0].spheroid().inertia(1.0);
    let energies = squirmers.iter().map(|s| {
        let l = s.orientation.inverse() * s.angular_momentum;
        let spin = l.x.powi(2) / across + l.y.powi(2) / across + l.z.powi(2) / along;
        (s.velocity.length_squared(), spin)
    });
    let (linear, angular) = energies.fold((0.0, 0.0), |a, e| (a.0 + e.0, a.1 + e.1));
    // Mass 1 (an empty fluid), kT = 2; 5 sigma of 9000 squares of variance 2.
    for energy in [linear, angular] {
        assert!((energy / 2.0 / 9000.0 - 1.0).abs() < 5.0 * (2.0f64 / 9000.0).sqrt(), "{}", energy / 9000.0);
    }
}

#[test]
fn lattices_and_lists() {
    let mut system = system([60, 12, 60], true);
    system.species = vec![Species { start: "lattice".into(), ..species(12, 4.0, 2.0) }];
    let squirmers = start(&system).expect("there is room").squirmers;
    assert!(smallest_gap(&system, &squirmers) > 0.061);
    assert!(squirmers.iter().all(|s| (s.axis() - DVec3::X).length() < 1e-12));
    system.species[0].start = "listed".into();
    system.species[0].count = 2;
    system.species[0].poses = Some(vec![[1.0, 6.0, 3.0, 0.0, 0.0, -2.0], [62.0, 6.0, 40.0, 0.0, 1.0, 1.0]]);
    let squirmers = start(&system).expect("they do not overlap").squirmers;
    assert_eq!(squirmers[1].position, DVec3::new(2.0, 6.0, 40.0));
    assert!((squirmers[0].axis() + DVec3::Z).length() < 1e-12);
    assert!((squirmers[1].axis() - DVec3::new(0.0, 0.5f64.sqrt(), 0.5f64.sqrt())).length() < 1e-12);
}

#[test]
fn impossible_starts_say_why() {
    let list = |rows: Vec<[f64; 6]>| {
        let mut system = system([40, 12, 40], true);
        #[allow(clippy::cast_possible_truncation)]
        let count = rows.len() as u32;
        system.species = vec![Species { start: "listed".into(), poses: Some(rows), ..species(count, 4.0, 2.0) }];
        system
    };
    let touching = list(vec![[1.0, 6.0, 5.0, 1.0, 0.0, 0.0], [39.0, 6.0, 8.0, 1.0, 0.0, 0.0]]);
    assert_eq!(start(&touching), Err(StartError::Overlap { first: 0, second: 1 }));
    let upright = list(vec![[1.0, 3.9, 5.0, 0.0, 1.0, 0.0]]);
    assert!(matches!(start(&upright), Err(StartError::InWall { squirmer: 0, .. })));
    assert!(matches!(start(&list(vec![[1.0, 3.9, 5.0, 0.0, 0.0, 0.0]])), Err(StartError::NoDirection { row: 1, .. })));
    let mut short = list(vec![[1.0, 6.0, 5.0, 1.0, 0.0, 0.0]]);
    short.species[0].count = 2;
    assert!(matches!(start(&short), Err(StartError::Poses { found: 1, wanted: 2, .. })));
    let mut crowded = system([20, 20, 20], false);
    crowded.species = vec![species(60, 3.0, 3.0)];
    assert!(matches!(start(&crowded), Err(StartError::Crowded { count: 60, .. })));
    crowded.species[0].start = "lattice".into();
    assert!(matches!(start(&crowded), Err(StartError::Lattice { count: 60, .. })));
    let mut narrow = system([20, 5, 20], true);
    narrow.species = vec![species(1, 3.0, 3.0)];
    assert!(matches!(start(&narrow), Err(StartError::Narrow { axis: "y", .. })));
}

#[test]
fn random_places_are_found_up_to_the_crowding_that_is_sure() {
    let cases = [
        ([20, 20, 20], false, 3.0, 3.0),
        ([24, 24, 24], false, 4.0, 2.0),
        ([24, 24, 24], false, 2.0, 4.0),
        ([16, 16, 16], false, 1.0, 1.0),
        ([40, 7, 40], true, 3.0, 3.0),
        ([40, 7, 40], true, 6.0, 3.0),
        ([40, 12, 40], true, 6.0, 3.0),
    ];
    for (size, walled, along, across) in cases {
        let mut system = system(size, walled);
        system.species = vec![species(1, along, across)];
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let most = (SURE / crowding(&system)) as u32;
        system.species[0].count = most;
        assert!(most > 10 && crowding(&system) > 0.5, "{size:?}: {most}");
        assert!(poses(&system).is_ok(), "{size:?} {most}");
        system.species[0].count = 2 * most;
        assert!(matches!(poses(&system), Err(StartError::Crowded { .. })), "{size:?}");
    }
}
