//! Nothing depends on the unit of time: the same system in another one does the same.

use crate::collision::active_slit;
use crate::rig;
use squirm::buffers::Gathering;
use squirm::gpu::{Form, Session};
use squirm::params::Value;
use squirm::state::packed::{Raw, wall_impulses};
use squirm::state::{State, System};

/// A slit with squirmers where speeds are `unit` times as large, and times as much smaller. A power of two changes no bit of a number but its exponent.
fn slit(unit: f64) -> (System, State) {
    let (mut system, mut start) = active_slit();
    let energy = unit * unit;
    system.run.dt /= unit;
    system.fluid.temperature *= energy;
    system.fluid.acceleration = system.fluid.acceleration.map(|a| a * energy);
    if let Some(walls) = &mut system.domain.walls {
        walls.velocity_low = walls.velocity_low.map(|v| v * unit);
        walls.velocity_high = walls.velocity_high.map(|v| v * unit);
    }
    for species in &mut system.species {
        (species.b1, species.rotlet) = (species.b1 * unit, species.rotlet * unit);
        species.force = [0.5 * energy, 0.0, 0.0];
    }
    start.particles.iter_mut().for_each(|p| p.velocity *= unit);
    for squirmer in &mut start.squirmers {
        squirmer.velocity *= unit;
        squirmer.angular_momentum *= unit;
    }
    (system, start)
}

fn after(unit: f64, steps: u64, form: Form) -> (System, Raw, Vec<f32>, [glam::DVec3; 2]) {
    let (system, start) = slit(unit);
    let energy = unit * unit;
    let changes: [(&str, &'static str, Value); 4] = [
        ("wall-ghosts", "memory", Value::Float(2.0 / unit)),
        ("wall-ghosts", "patch", Value::Integer(4)),
        ("squirmer-move", "epsilon", Value::Float(5.0 * energy)),
        ("squirmer-move", "max_force", Value::Float(1000.0 * energy)),
    ];
    // Sorting orders the particles of a cell by chance.
    let kinds: Vec<&str> = rig::EVERYTHING.iter().copied().filter(|k| *k != "sort-reorder").collect();
    let mut gpu = rig::gpu().clone();
    gpu.gathering = Some(Gathering::Chains);
    let mut session = Session::formed(&gpu, &rig::plan(&system, &kinds, &changes), &start, form).expect("a session");
    session.advance(steps, false);
    assert_eq!(session.faults().expect("readable"), 0, "{unit}");
    let walls = wall_impulses(&system, &session.read("wall_impulses").expect("readable"));
    (system, session.raw().expect("readable"), session.read("fluid_force").expect("readable"), walls)
}

/// At the limits of what a temperature may be, too, where sums in fixed point would not fit if their units were not the fluid's.
#[test]
fn a_hot_slit_is_a_cold_one_in_other_units() {
    for form in [Form::Loose, Form::Fused] {
        let (_, plain, force, walls) = after(1.0, 12, form);
        for unit in [512.0f32, 1.0 / 512.0] {
            let (_, other, other_force, other_walls) = after(f64::from(unit), 12, form);
            assert_eq!(other.positions, plain.positions, "{unit}");
            assert!(other.velocities.iter().zip(&plain.velocities).all(|(a, b)| *a == b * unit), "{unit}");
            for (a, b) in other.squirmers.iter().zip(&plain.squirmers) {
                assert_eq!((a.position, a.orientation), (b.position, b.orientation), "{unit}");
                assert_eq!(a.velocity, b.velocity.map(|v| v * unit), "{unit}");
                assert_eq!(a.angular_momentum, b.angular_momentum.map(|l| l * unit), "{unit}");
            }
            assert!(other_force.iter().zip(&force).all(|(a, b)| *a == b * unit * unit), "{unit}");
            for (a, b) in other_walls.into_iter().zip(walls) {
                assert_eq!(a, b * f64::from(unit), "{unit}");
            }
        }
    }
}
