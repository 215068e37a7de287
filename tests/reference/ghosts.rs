//! wall-ghosts, squirmer-fill: the ghosts' statistics, and that what they gain goes to walls and squirmers.

use super::*;
use glam::DMat3;
use squirm::params::Params;
use squirm::stages::restore_thermostat::RestoreThermostat;
use squirm::stages::rotate::Rotate;
use squirm::stages::squirmer_fill::SquirmerFill;
use squirm::stages::wall_ghosts::WallGhosts;
use squirm::state::scene::{Load, Moments, outer};

fn stages(kinds: &[&'static str]) -> Vec<(&'static str, squirm::params::Values)> {
    let values = |kind| match kind {
        "rotate" => Rotate { angle: 130.0, grip: 1.22 }.to_values(),
        "restore-thermostat" => RestoreThermostat { mode: "thermostat".into(), angular_momentum: true }.to_values(),
        "squirmer-fill" => rule("equipartition").to_values(),
        "wall-ghosts" => WallGhosts { velocity: "wall".into(), patch: 8, memory: 2.0 }.to_values(),
        kind => panic!("no parameters for `{kind}`"),
    };
    kinds.iter().map(|kind| (*kind, values(kind))).collect()
}

/// The sums over all ghosts of both layers, y measured inside the cell, in many steps of a slit of 40 x 40 columns.
#[test]
fn wall_ghosts_have_the_fluids_density_and_the_walls_motion() {
    let mut system = system([40, 4, 40], 0.1);
    system.domain.walls = walls("no-slip");
    system.fluid.temperature = 0.5;
    let (columns, density) = (1600.0, system.fluid.density);
    for step in 0..20 {
        let mut scene = scene(Vec::new(), Vec::new());
        scene.state.step = step;
        collide(&system, &mut scene, &stages(&["wall-ghosts", "rotate"]));
        let s = scene.shift.y;
        for (layer, fraction, middle, velocity) in
            [(0, s, 0.5 * s - 0.5, DVec3::new(0.2, 0.0, -0.1)), (4, 1.0 - s, 0.5 * s, DVec3::new(-0.3, 0.0, 0.4))]
        {
            let mut sum = Moments::default();
            for (_, m) in scene.moments.iter().enumerate().filter(|(i, _)| system.domain.cell_at(*i as u32)[1] == layer)
            {
                sum.count += m.count;
                sum.v += m.v;
                sum.energy += m.energy;
                sum.x += m.x;
            }
            let expected = columns * density * fraction;
            assert!((sum.count - expected).abs() < 5.0 * expected.sqrt(), "{} of {expected}", sum.count);
            let n = sum.count;
            let mean = sum.v / n;
            assert!((mean - velocity).abs().max_element() < 5.0 * (0.5 / n).sqrt(), "{mean}");
            let variance = sum.energy / n - velocity.length_squared() - 2.0 * velocity.dot(mean - velocity);
            assert!((variance - 1.5).abs() < 5.0 * 0.5 * (6.0 / n).sqrt(), "{variance}");
            let place = sum.x / n - DVec3::Y * middle;
            assert!(place.abs().max_element() < 5.0 * (1.0 / 12.0 / n).sqrt(), "{place}");
        }
        assert!(
            scene
                .moments
                .iter()
                .enumerate()
                .all(|(i, m)| [0, 4].contains(&system.domain.cell_at(i as u32)[1]) || m.count == 0.0)
        );
    }
}

#[test]
fn walls_gain_what_the_fluid_loses() {
    let mut system = system([8, 6, 8], 0.1);
    system.domain.walls = walls("no-slip");
    let before = gas(&system, 12, 3840);
    let mut scene = scene(before.clone(), Vec::new());
    collide(&system, &mut scene, &stages(&["wall-ghosts", "rotate", "restore-thermostat"]));
    let [low, high] = scene.wall_impulses;
    assert!(low.length() > 1.0 && high.length() > 1.0);
    assert_near(momentum(&scene.state.particles) + low + high, momentum(&before), 1e-10);
}

/// A box with one spheroid in motion in its middle, and fluid around it, away from the box's faces.
fn bath() -> (System, Scene) {
    let mut system = system([16, 16, 16], 0.1);
    system.species = vec![species(4.0, 2.0)];
    system.species[0].b1 = 0.2;
    system.species[0].beta = 2.0;
    system.species[0].rotlet = 0.1;
    let mut body = squirmer(DVec3::new(8.3, 7.9, 8.1));
    body.orientation = DQuat::from_rotation_arc(DVec3::Z, DVec3::new(0.36, 0.48, 0.8));
    body.velocity = DVec3::new(0.1, -0.2, 0.05);
    body.angular_momentum = DVec3::new(90.0, -30.0, 60.0);
    let mut particles = gas(&system, 13, 40_960);
    particles.retain(|p| (p.position - 8.0).abs().max_element() < 6.0);
    particles.retain(|p| {
        let arm = body.orientation.inverse() * (p.position - body.position);
        (arm / DVec3::new(2.0, 2.0, 4.0)).length() > 1.0
    });
    (system, scene(particles, vec![body]))
}

fn rule(ghosts: &str) -> SquirmerFill {
    SquirmerFill { ghosts: ghosts.into(), slip: "continued".into() }
}

/// The sums over a squirmer's ghosts about its centre in a step: number, sum v, sum s, sum s x v, sum of s.s 1 - s s^T.
fn about_centre(system: &System, scene: &Scene, step: u64, ghosts: &str) -> (f64, DVec3, DVec3, DVec3, DMat3) {
    let mut sums = (0.0, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, DMat3::ZERO);
    for (s, v) in rule(ghosts).drawn(system, &filled(system, scene, step, ghosts), 0) {
        sums.0 += 1.0;
        sums.1 += v;
        sums.2 += s;
        sums.3 += s.cross(v);
        sums.4 += s.length_squared() * DMat3::IDENTITY - outer(s, s);
    }
    sums
}

fn filled(system: &System, scene: &Scene, step: u64, ghosts: &str) -> Scene {
    let mut scene = scene.clone();
    scene.state.step = step;
    scene.state.particles.clear();
    ShiftGrid::reference(&ShiftGrid {}, system, &mut scene);
    CellReduce::reference(&CellReduce {}, system, &mut scene);
    SquirmerFill::reference(&rule(ghosts), system, &mut scene);
    scene
}

/// The angular velocity of the bath's body.
fn omega(system: &System, body: &Squirmer) -> DVec3 {
    let mass = f64::from(system.species[0].ghosts(&system.fluid));
    let inverse = DVec3::new(5.0 / (4.0 + 16.0), 5.0 / (4.0 + 16.0), 2.5 / 4.0) / mass;
    body.orientation * (inverse * (body.orientation.inverse() * body.angular_momentum))
}

#[test]
fn equipartition_ghosts_have_the_bodys_rigid_motion_exactly() {
    let (mut system, scene) = bath();
    system.species[0].b1 = 0.0;
    system.species[0].rotlet = 0.0;
    let body = scene.state.squirmers[0];
    let count = f64::from(system.species[0].ghosts(&system.fluid));
    let spin = omega(&system, &body);
    let mut published = (0.0, 0.0);
    for step in 0..40 {
        let (n, p, s, l, inertia) = about_centre(&system, &scene, step, "equipartition");
        assert_eq!(n, count);
        assert_near(p, n * body.velocity + spin.cross(s), 1e-9);
        assert_near(l, s.cross(body.velocity) + inertia * spin, 1e-9);
        let (_, p, s, l, inertia) = about_centre(&system, &scene, step, "published");
        published.0 += (p - n * body.velocity - spin.cross(s)).length_squared() / (3.0 * n);
        let excess = l - s.cross(body.velocity) - inertia * spin;
        published.1 += excess.dot(inertia.inverse() * excess) / 3.0;
    }
    // Thermal velocities as drawn carry kT per degree of freedom: 120 of them, each sum within five sigma.
    for mean in [published.0 / 40.0, published.1 / 40.0] {
        assert!((mean - 1.0).abs() < 5.0 * (2.0 / 120f64).sqrt(), "{mean}");
    }
}

#[test]
fn squirmer_ghosts_are_thermal_and_fill_the_body_evenly() {
    let (system, scene) = bath();
    let body = scene.state.squirmers[0];
    let (mut n, mut s, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    let (mut momentum, mut energy) = (DVec3::ZERO, 0.0);
    for step in 0..100 {
        let mut still = scene.clone();
        still.state.squirmers[0].velocity = DVec3::ZERO;
        still.state.squirmers[0].angular_momentum = DVec3::ZERO;
        let mut quiet = system.clone();
        quiet.species[0].b1 = 0.0;
        quiet.species[0].rotlet = 0.0;
        let sums = about_centre(&quiet, &still, step, "published");
        n += sums.0;
        momentum += sums.1;
        let filled = filled(&quiet, &still, step, "published");
        energy += rule("published").drawn(&quiet, &filled, 0).iter().map(|(_, v)| v.length_squared()).sum::<f64>();
        s += sums.2;
        second += sums.4;
    }
    assert!((momentum / n).abs().max_element() < 5.0 / n.sqrt());
    assert!((energy / n - 3.0).abs() < 5.0 * (6.0 / n).sqrt());
    // A homogeneous spheroid: <z^2> = along^2/5, and the inertia from it.
    let in_body = DMat3::from_quat(body.orientation.inverse());
    assert!((in_body * s / n).abs().max_element() < 5.0 * (16.0 / 5.0 / n).sqrt());
    let inertia = in_body * (second * (1.0 / n)) * in_body.transpose();
    for (found, expected) in [(inertia.x_axis.x, 4.0), (inertia.y_axis.y, 4.0), (inertia.z_axis.z, 1.6)] {
        assert!((found - expected).abs() < 5.0 * 4.0 / n.sqrt(), "{found} of {expected}");
    }
}

/// Ghosts without thermal motion show their slip: the mean over a sphere's ghosts is minus the swim speed (2/3) B1.
#[test]
fn ghosts_carry_the_slip_of_the_surface() {
    let (mut system, mut scene) = bath();
    system.fluid.temperature = 1e-6;
    system.species[0].semi_axes = SemiAxes { along: 3.0, across: 3.0 };
    scene.state.squirmers[0].velocity = DVec3::ZERO;
    scene.state.squirmers[0].angular_momentum = DVec3::ZERO;
    let (n, p, ..) = about_centre(&system, &scene, 0, "published");
    let axis = scene.state.squirmers[0].axis();
    assert_near(p / n, -axis * 0.2 * 2.0 / 3.0, 5.0 * 0.4 / n.sqrt());
}

#[test]
fn squirmers_gain_what_the_fluid_loses() {
    let (system, before) = bath();
    let mass = f64::from(system.species[0].ghosts(&system.fluid));
    for held in [false, true] {
        let mut system = system.clone();
        system.species[0].held = held;
        let mut scene = before.clone();
        scene.loads = vec![Load { force: DVec3::X, torque: DVec3::Y }];
        collide(&system, &mut scene, &stages(&["squirmer-fill", "rotate", "restore-thermostat"]));
        let (old, new) = (before.state.squirmers[0], scene.state.squirmers[0]);
        let lost = momentum(&before.state.particles) - momentum(&scene.state.particles);
        assert!(lost.length() > 1.0);
        assert_near(scene.loads[0].force - DVec3::X, lost, 1e-9);
        let about = |particles: &[Particle]| angular_momentum(particles) - old.position.cross(momentum(particles));
        let lost_about = about(&before.state.particles) - about(&scene.state.particles);
        assert_near(scene.loads[0].torque - DVec3::Y, lost_about, 1e-8);
        if held {
            assert_eq!(new, old);
        } else {
            assert_near(mass * (new.velocity - old.velocity), lost, 1e-9);
            assert_near(new.angular_momentum - old.angular_momentum, lost_about, 1e-8);
        }
    }
}

/// Cells wholly within a body are left out: with all ghosts in their cells, the squirmer gains the same.
#[test]
fn cells_within_a_body_change_nothing() {
    let (system, start) = bath();
    let (rotate, restore) =
        (Rotate { angle: 130.0, grip: 1.22 }, RestoreThermostat { mode: "thermostat".into(), angular_momentum: true });
    for step in 0..5 {
        let mut scene = start.clone();
        scene.state.step = step;
        ShiftGrid::reference(&ShiftGrid {}, &system, &mut scene);
        CellReduce::reference(&CellReduce {}, &system, &mut scene);
        let fluid = scene.moments.clone();
        SquirmerFill::reference(&rule("equipartition"), &system, &mut scene);
        let ghosts = rule("equipartition").drawn(&system, &scene, 0);
        let mut all = scene.clone();
        all.moments = fluid;
        let centre = all.state.squirmers[0].position;
        for (s, v) in &ghosts {
            let (cell, offset) = all.locate(&system, centre + s);
            all.moments[cell].add_ghost(offset, *v);
        }
        let left_out = all.moments.iter().zip(&scene.moments).map(|(a, b)| a.count - b.count).sum::<f64>();
        assert!(left_out > 100.0, "{left_out}");
        for scene in [&mut scene, &mut all] {
            Rotate::reference(&rotate, &system, scene);
            RestoreThermostat::reference(&restore, &system, scene);
        }
        let gained = |scene: &Scene, counted: &dyn Fn(usize) -> bool| {
            let mut load = Load::default();
            for (s, v) in &ghosts {
                let (cell, offset) = scene.locate(&system, centre + s);
                if counted(cell) {
                    let impulse = scene.operators[cell].apply(offset, *v) - v;
                    load.force += impulse;
                    load.torque += s.cross(impulse);
                }
            }
            load
        };
        let few = gained(&scene, &|cell| scene.moments[cell].count > 0.0);
        let many = gained(&all, &|_| true);
        assert!(few.force.length() > 1.0 && few.torque.length() > 1.0);
        assert_near(few.force, many.force, 1e-9);
        assert_near(few.torque, many.torque, 1e-9);
    }
}
