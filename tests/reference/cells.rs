//! rotate, restore-thermostat, sort-reorder: what a collision keeps, and the temperature it sets.

use super::*;
use glam::DMat3;
use squirm::params::Params;
use squirm::stages::restore_thermostat::RestoreThermostat;
use squirm::stages::rotate::Rotate;
use squirm::stages::sort_reorder::SortReorder;
use squirm::state::scene::{Moments, outer};

fn rotate() -> (&'static str, squirm::params::Values) {
    ("rotate", Rotate { angle: 130.0, grip: 1.22 }.to_values())
}

fn restore(mode: &str, angular_momentum: bool) -> (&'static str, squirm::params::Values) {
    ("restore-thermostat", RestoreThermostat { mode: mode.into(), angular_momentum }.to_values())
}

/// `count` particles in one cell of the shifted grid, which may lie on a line.
fn crowd(system: &System, count: u32, collinear: bool) -> Vec<Particle> {
    let mut probe = scene(Vec::new(), Vec::new());
    ShiftGrid::reference(&ShiftGrid {}, system, &mut probe);
    let corner = DVec3::splat(2.0) - probe.shift;
    let line = DVec3::new(0.9, 0.5, 0.7);
    let particle = |i| {
        let (u, n) = random(count, i);
        let place = if collinear { 0.02 + u.x * line } else { u };
        Particle { position: corner + place, velocity: n + DVec3::new(0.3, 0.0, -2.0) }
    };
    (0..count).map(particle).collect()
}

/// Changes of momentum, angular momentum and energy in one collision of a crowd.
fn changes(count: u32, collinear: bool, stages: &[(&str, squirm::params::Values)]) -> (f64, f64, f64) {
    let system = system([4, 4, 4], 0.1);
    let before = crowd(&system, count, collinear);
    let mut scene = scene(before.clone(), Vec::new());
    collide(&system, &mut scene, stages);
    let after = &scene.state.particles;
    let scale = f64::from(count);
    (
        (momentum(after) - momentum(&before)).length() / scale,
        (angular_momentum(after) - angular_momentum(&before)).length() / scale,
        (energy(after) - energy(&before)).abs() / scale,
    )
}

#[test]
fn energy_mode_keeps_momentum_angular_momentum_and_energy() {
    for (count, collinear) in (1..=60).flat_map(|n| [(n, false), (n, true)]) {
        let (p, l, e) = changes(count, collinear, &[rotate(), restore("energy", true)]);
        assert!(p < 1e-12 && l < 1e-12 && e < 1e-12, "{count} {collinear}: {p:e} {l:e} {e:e}");
    }
}

#[test]
fn the_other_modes_keep_what_they_promise() {
    for (count, collinear) in (2..=60).flat_map(|n| [(n, false), (n, true)]) {
        let (p, l, e) = changes(count, collinear, &[rotate(), restore("thermostat", true)]);
        let heated = e > 1e-9 || (count == 2 && collinear);
        assert!(p < 1e-12 && l < 1e-12 && heated, "thermostat {count}: {p:e} {l:e} {e:e}");
        let (p, l, _) = changes(count, collinear, &[rotate(), restore("angular-momentum-only", true)]);
        assert!(p < 1e-12 && l < 1e-12, "angular momentum only {count}: {p:e} {l:e}");
        let (p, l, e) = changes(count, collinear, &[rotate(), restore("energy", false)]);
        assert!(p < 1e-12 && l > 1e-6 && e < 1e-12, "energy alone {count}: {p:e} {l:e} {e:e}");
        let (p, l, e) = changes(count, collinear, &[rotate(), restore("thermostat", false)]);
        assert!(p < 1e-12 && l > 1e-6 && e > 1e-9, "thermostat alone {count}: {p:e} {l:e} {e:e}");
    }
}

#[test]
fn single_particles_and_coincident_pairs_are_left_alone() {
    let system = system([4, 4, 4], 0.1);
    for mode in ["thermostat", "energy", "angular-momentum-only"] {
        let mut particles = crowd(&system, 2, false);
        particles[1].position = particles[0].position + 1e-3;
        particles.push(Particle { position: particles[0].position + DVec3::Z, velocity: DVec3::X });
        let mut scene = scene(particles.clone(), Vec::new());
        collide(&system, &mut scene, &[rotate(), restore(mode, true)]);
        assert_eq!(scene.state.particles, particles);
    }
}

/// Twice the kinetic energy of the motion relative to the rigid one that has the crowd's momentum and angular momentum.
fn residual_energy(particles: &[Particle]) -> f64 {
    let count = particles.len() as f64;
    let centre = particles.iter().map(|p| p.position).sum::<DVec3>() / count;
    let mean = momentum(particles) / count;
    let relative: Vec<(DVec3, DVec3)> = particles.iter().map(|p| (p.position - centre, p.velocity - mean)).collect();
    if let [(x, w), _] = relative.as_slice() {
        return 2.0 * x.normalize().dot(*w).powi(2);
    }
    let inertia =
        relative.iter().fold(DMat3::ZERO, |sum, (x, _)| sum + x.length_squared() * DMat3::IDENTITY - outer(*x, *x));
    let omega = inertia.inverse() * relative.iter().map(|(x, w)| x.cross(*w)).sum::<DVec3>();
    relative.iter().map(|(x, w)| (*w - omega.cross(*x)).length_squared()).sum()
}

/// Crowds of `count` in every cell, far from the wanted temperature, after one thermostatted collision.
fn thermostatted(count: u32, temperature: f64, angular_momentum: bool) -> Vec<Vec<Particle>> {
    let mut system = system([16, 16, 16], 0.1);
    system.fluid.temperature = temperature;
    let mut probe = scene(Vec::new(), Vec::new());
    ShiftGrid::reference(&ShiftGrid {}, &system, &mut probe);
    let mut particles = Vec::new();
    for cell in 0..4096u32 {
        let corner = DVec3::new(f64::from(cell % 16), f64::from(cell / 16 % 16), f64::from(cell / 256)) - probe.shift;
        for i in 0..count {
            let (u, n) = random(cell, i);
            let position = (corner + u).rem_euclid(DVec3::splat(16.0));
            particles.push(Particle { position, velocity: 3.0 * n });
        }
    }
    let mut scene = scene(particles, Vec::new());
    collide(&system, &mut scene, &[rotate(), restore("thermostat", angular_momentum)]);
    let mut cells = vec![Vec::new(); 4096];
    for particle in &scene.state.particles {
        let (cell, offset) = scene.locate(&system, particle.position);
        cells[cell].push(Particle { position: offset, velocity: particle.velocity });
    }
    cells
}

fn assert_energies(energies: impl Iterator<Item = f64>, dof: f64, temperature: f64) {
    let energies: Vec<f64> = energies.map(|e| e / temperature).collect();
    let count = energies.len() as f64;
    let mean = energies.iter().sum::<f64>() / count;
    assert!((mean - dof).abs() < 5.0 * (2.0 * dof / count).sqrt(), "mean {mean} of {dof}");
    // Of a chi-squared law with k degrees of freedom: variance 2k, fourth central moment 12 k (k + 4).
    let variance = energies.iter().map(|e| (e - dof).powi(2)).sum::<f64>() / count;
    let error = ((12.0 * dof * (dof + 4.0) - 4.0 * dof * dof) / count).sqrt();
    assert!((variance - 2.0 * dof).abs() < 5.0 * error, "variance {variance} of {}", 2.0 * dof);
}

#[test]
fn thermostat_draws_the_residual_energy_from_its_law() {
    for (count, dof, temperature) in [(2, 1.0, 1.0), (3, 3.0, 1.0), (5, 9.0, 0.4), (10, 24.0, 2.0)] {
        let cells = thermostatted(count, temperature, true);
        // Pairs too near each other keep their velocities.
        let spread = |cell: &Vec<Particle>| (cell[0].position - cell[1].position).length_squared() > 2e-3;
        let cells: Vec<_> = cells.into_iter().filter(|c| count > 2 || spread(c)).collect();
        assert!(cells.len() > 4050);
        assert_energies(cells.iter().map(|c| residual_energy(c)), dof, temperature);
        let cells = thermostatted(count, temperature, false);
        let relative = |c: &Vec<Particle>| energy(c) - momentum(c).length_squared() / f64::from(count);
        assert_energies(cells.iter().map(relative), 3.0 * f64::from(count - 1), temperature);
    }
}

#[test]
fn rotation_has_its_angle_and_an_isotropic_axis() {
    let system = system([16, 16, 16], 0.1);
    let mut scene = scene(gas(&system, 1, 40_960), Vec::new());
    let angle = 130f64.to_radians();
    collide(&system, &mut scene, &[rotate()]);
    let mut sum = DMat3::ZERO;
    for (operator, moments) in scene.operators.iter().zip(&scene.moments).filter(|(_, m)| m.count >= 2.0) {
        let a = operator.a;
        assert!((a.x_axis.x + a.y_axis.y + a.z_axis.z - (1.0 + 2.0 * angle.cos())).abs() < 1e-4);
        assert!((a.determinant() - 1.0).abs() < 1e-12);
        let mean = moments.v / moments.count;
        assert_near(operator.apply(DVec3::ONE, mean), mean, 1e-12);
        sum += a;
    }
    // <R> = (1 + 2 cos a)/3; entries have a variance below 1.
    let mean = sum * (1.0 / 4096.0);
    let expected = DMat3::from_diagonal(DVec3::splat((1.0 + 2.0 * angle.cos()) / 3.0));
    for (found, wanted) in mean.to_cols_array().into_iter().zip(expected.to_cols_array()) {
        assert!((found - wanted).abs() < 5.0 / 64.0);
    }
}

/// A cell with a ghost turns further, and by half a turn at the most.
#[test]
fn cells_with_ghosts_turn_further() {
    let system = system([1, 1, 1], 0.1);
    for (angle, grip, wanted) in [(130.0, 1.0, 130.0), (130.0, 1.22, 180.0), (90.0, 1.5, 120.0), (60.0, 3.0, 120.0)] {
        let mut scene = scene(Vec::new(), Vec::new());
        scene.moments = vec![Moments::default(); 2];
        for k in 0..3 {
            let (x, v) = (DVec3::splat(0.1 * f64::from(k)), DVec3::new(f64::from(k), 1.0, 0.0));
            scene.moments[0].add(x, v);
            scene.moments[1].add_ghost(x, v);
        }
        Rotate::reference(&Rotate { angle, grip }, &system, &mut scene);
        for (operator, angle) in scene.operators.iter().zip([angle, wanted]) {
            let trace = operator.a.x_axis.x + operator.a.y_axis.y + operator.a.z_axis.z;
            // The cosine may be 1000 units of 2^-23 off, for a better sine.
            assert!((trace - 1.0 - 2.0 * f64::to_radians(angle).cos()).abs() < 2.4e-4, "{angle}: {trace}");
        }
    }
}

#[test]
fn sine_and_cosine_are_unimodular_in_f32() {
    let system = system([4, 4, 4], 0.1);
    for angle in [0.0, 5.0, 90.0, 120.0, 130.0, 180.0] {
        let settings = Rotate::uniform(&Rotate { angle, grip: 1.0 }, &system);
        let (cos, sin) = (f64::from(settings.cos), f64::from(settings.sin));
        assert!((cos * cos + sin * sin - 1.0).abs() < 1e-9, "{angle}");
        assert_eq!(f64::from(settings.one_minus_cos), 1.0 - cos, "{angle}");
        assert!((sin.atan2(cos).to_degrees() - angle).abs() < 0.02, "{angle}");
    }
}

#[test]
fn sorting_changes_the_order_only() {
    let system = system([4, 5, 6], 0.1);
    let particles = gas(&system, 8, 1000);
    let mut scene = scene(particles.clone(), Vec::new());
    ShiftGrid::reference(&ShiftGrid {}, &system, &mut scene);
    SortReorder::reference(&SortReorder { every: 50 }, &system, &mut scene);
    let cells: Vec<usize> = scene.state.particles.iter().map(|p| scene.locate(&system, p.position).0).collect();
    assert!(cells.is_sorted() && cells[0] == 0 && cells[999] == system.domain.cell_index([3, 4, 5]) as usize);
    let mut remaining = particles;
    for particle in &scene.state.particles {
        let place = remaining.iter().position(|p| p == particle).expect("each particle once");
        remaining.swap_remove(place);
    }
    assert!(remaining.is_empty());
}
