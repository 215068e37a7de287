//! cell-reduce: all sums of a cell to the last unit of their fixed point, and the faults that protect them.

use crate::bench::*;
use crate::rig;
use glam::DVec3;
use squirm::buffers::Fault;
use squirm::math::fixed::Scales;
use squirm::state::{Particle, System};

fn assert_moments(bench: &Bench) {
    let found = bench.moments();
    assert_eq!(found.len(), bench.scene.moments.len());
    for (cell, (found, wanted)) in found.iter().zip(&bench.scene.moments).enumerate() {
        let e = excess(bench.system(), found, wanted, 0.0, 0.0);
        assert!(e <= 1.0, "cell {cell}: {e}\n{found:?}\n{wanted:?}");
    }
    // The coarse copy of sum |v|^2.
    let Scales { energy_coarse: scale, coarse_bit, .. } =
        Scales::new(bench.system().fluid.density, bench.system().fluid.temperature);
    for (words, wanted) in bench.words("moments").chunks_exact(24).zip(&bench.scene.moments) {
        let error = (f64::from(words[0] >> coarse_bit) / scale - wanted.energy).abs();
        assert!(error <= 0.5 * wanted.count / scale + 4.0 * ROUNDING * wanted.energy, "{error}");
    }
    assert_eq!(bench.faults(), 0);
}

#[test]
fn sums_of_a_gas() {
    for (walled, density, temperature) in [(false, 10.0, 1.0), (true, 10.0, 0.3), (true, 50.0, 7.0)] {
        let mut system = rig::system([5, 6, 7]);
        system.domain.walls = walled.then(rig::walls);
        (system.fluid.density, system.fluid.temperature) = (density, temperature);
        let start = state(gas(&system, 5, system.particle_count() as u32), Vec::new());
        let mut bench = Bench::new(&system, &start, &["shift-grid", "cell-reduce"], &[]);
        bench.run_all(&["shift-grid"]);
        bench.run("cell-reduce");
        assert_moments(&bench);
        // Again: the sums start anew.
        bench.run("cell-reduce");
        assert_moments(&bench);
    }
}

#[test]
fn sums_of_one_cell_with_1_to_60_particles() {
    let system = rig::system([4, 4, 4]);
    // Cell 21 lies at (1, 1, 1) on the grid that has not been shifted; fast particles at its corners, too.
    for count in 1..=60 {
        let particle = |i| {
            let (u, n) = random(count, i);
            let (u, n) = if i % 5 == 4 { (u.round() * (1.0 - 1e-9), 2.0 * n.signum()) } else { (u, n) };
            Particle { position: DVec3::ONE + u, velocity: n }
        };
        let start = state((0..count).map(particle).collect(), Vec::new());
        let mut bench = Bench::new(&system, &start, &["cell-reduce"], &[]);
        bench.run("cell-reduce");
        assert_eq!(bench.moments()[21].count, f64::from(count));
        assert_moments(&bench);
    }
}

/// The faults after cell-reduce and rotate, and the number of particles counted.
fn faults(system: &System, particles: Vec<Particle>) -> (u32, f64) {
    let mut bench = Bench::new(system, &state(particles, Vec::new()), &["cell-reduce", "rotate"], &[]);
    bench.run_all(&["cell-reduce", "rotate"]);
    (bench.faults(), bench.moments().iter().map(|m| m.count).sum())
}

/// `count` particles in one cell, with velocities along z that alternate.
fn crowd(count: u32, speed: f64) -> Vec<Particle> {
    let particle = |i: u32| Particle {
        position: DVec3::ONE + random(7, i).0,
        velocity: DVec3::Z * if i.is_multiple_of(2) { speed } else { -speed },
    };
    (0..count).map(particle).collect()
}

#[test]
fn what_the_sums_cannot_hold_is_a_fault() {
    let system = rig::system([4, 4, 4]);
    // Speeds up to twelve, thermal speeds being one.
    assert_eq!(faults(&system, crowd(10, 11.99)), (0, 10.0));
    let mut particles = crowd(10, 1.0);
    particles[3].velocity = DVec3::new(0.0, 12.01, 0.0);
    assert_eq!(faults(&system, particles.clone()), (Fault::Speed as u32, 9.0));
    particles[3].velocity = DVec3::new(f64::INFINITY, 0.0, 0.0);
    assert_eq!(faults(&system, particles.clone()), (Fault::Speed as u32, 9.0));
    particles[3].velocity = DVec3::new(0.0, f64::NAN, 0.0);
    assert_eq!(faults(&system, particles), (Fault::Nan as u32, 9.0));
    // 10 + 12 sqrt(10) + 40 and more, up to the next power of two: 128.
    assert_eq!(faults(&system, crowd(128, 1.0)), (0, 128.0));
    assert_eq!(faults(&system, crowd(129, 1.0)), (Fault::Count as u32, 129.0));
    // Sums of squares up to 2^32 / 2^20 = 4096.
    assert_eq!(faults(&system, crowd(40, 10.0)), (0, 40.0));
    assert_eq!(faults(&system, crowd(41, 10.0)), (Fault::Energy as u32, 41.0));
}
