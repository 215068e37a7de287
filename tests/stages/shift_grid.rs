//! shift-grid: the host's random numbers, and cells that hold every particle.

use crate::bench::*;
use crate::rig;
use glam::DVec3;
use squirm::state::State;

#[test]
fn the_shift_is_the_hosts() {
    for size in [[16, 16, 16], [5, 6, 7], [3, 1000, 11]] {
        let mut system = rig::system(size);
        system.domain.walls = (size[0] != 16).then(rig::walls);
        for step in [0, 1, 77, (1 << 32) + 5] {
            let mut bench = Bench::new(&system, &State { step, ..State::default() }, &["shift-grid"], &[]);
            bench.run("shift-grid");
            // The units per cell and their product with the number round to f32, the result down to a unit.
            let unit = f64::from(*system.domain.period().iter().max().expect("three")) / 4_294_967_296.0;
            let off = (bench.shift() - bench.scene.shift).abs().max_element();
            assert!(off < 3.0 * ROUNDING + unit, "{} {}", bench.shift(), bench.scene.shift);
            assert!(bench.shift().min_element() >= 0.0 && bench.shift().max_element() <= 1.0);
        }
    }
}

/// Particles at the faces and corners of the box are counted in the reference's cell under every shift, none elsewhere.
#[test]
fn every_particle_is_in_its_cell() {
    let ends = [0.0, 1e-9, 0.5, 1.0 - 1e-9];
    for walled in [false, true] {
        let mut system = rig::system([5, 6, 7]);
        system.domain.walls = walled.then(rig::walls);
        let size = DVec3::from_array(system.domain.size.map(f64::from));
        let mut particles = gas(&system, 4, 500);
        for k in 0..64 {
            let position = DVec3::new(ends[k % 4], ends[k / 4 % 4], ends[k / 16]) * size;
            particles.push(squirm::state::Particle { position, velocity: DVec3::ZERO });
        }
        for step in 0..10 {
            let start = State { step, particles: particles.clone(), squirmers: Vec::new() };
            let mut bench = Bench::new(&system, &start, &["shift-grid", "cell-reduce"], &[]);
            bench.run_all(&["shift-grid"]);
            bench.run("cell-reduce");
            let counts: Vec<f64> = bench.moments().iter().map(|m| m.count).collect();
            assert_eq!(counts, bench.scene.moments.iter().map(|m| m.count).collect::<Vec<_>>());
            assert_eq!(counts.iter().sum::<f64>(), 564.0);
        }
    }
}
