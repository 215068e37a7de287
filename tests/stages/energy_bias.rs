//! rotate, apply: roundings of the energy do not lean to one side. A bias of a hundredth of a rounding, 1e-9, adds up to 1e-4 of the
//! energy within 10^5 steps.

use crate::rig;
use glam::{DMat3, DVec3};
use squirm::gpu::Session;
use squirm::params::Value;

fn vectors(words: &[f32]) -> Vec<DVec3> {
    words.chunks_exact(3).map(|v| DVec3::new(v[0].into(), v[1].into(), v[2].into())).collect()
}

/// Sum of squares in f64.
fn energy(velocities: &[DVec3]) -> f64 {
    velocities.iter().map(|v| v.length_squared()).sum()
}

/// SRD-a with exact energy on 24^3 cells for twenty steps: each of 1.4e5 particles rounds its energy by some 1e-7 in a step, so that the
/// mean over all is known to 1e-7/sqrt(2.8e6) = 6e-11 relative to 3 kT.
#[test]
fn a_collision_neither_heats_nor_cools() {
    let system = rig::system([24; 3]);
    let state = rig::fluid(&system, 10 * 24 * 24 * 24);
    let changes = [
        ("restore-thermostat", "mode", Value::Text("energy".into())),
        ("restore-thermostat", "angular_momentum", Value::Boolean(false)),
    ];
    let mut session = rig::session(&rig::plan(&system, rig::BULK, &changes), &state);
    let (mut drift, mut stretch, mut cells) = (0.0, 0.0, 0.0);
    let steps = 20;
    let velocities = |session: &Session| vectors(&session.raw().expect("particles").velocities);
    for _ in 0..steps {
        for kind in ["stream", "shift-grid", "cell-reduce", "rotate", "restore-thermostat"] {
            session.run_stage(kind, false).expect("it runs");
        }
        let before = energy(&velocities(&session));
        session.run_stage("apply", false).expect("it runs");
        drift += (energy(&velocities(&session)) - before) / before / f64::from(steps);
        for o in session.read::<f32>("operators").expect("operators").chunks_exact(16) {
            let a = DMat3::from_cols_array(&std::array::from_fn(|i| f64::from(o[i / 3 * 4 + i % 3])));
            stretch += (a * a.transpose() - DMat3::IDENTITY).to_cols_array().iter().step_by(4).sum::<f64>() / 3.0;
            cells += 1.0;
        }
        // Another step's random numbers.
        session.advance(1, false);
        session.wait().expect("the device answers");
    }
    stretch /= cells;
    println!("energy per collision {drift:.2e}, stretch of the rotations {stretch:.2e}");
    // The length of one axis is off by 5e-8: 1e-10 for the mean over 2.8e5 cells, of which five are allowed.
    assert!(stretch.abs() < 5e-10, "{stretch:e}");
    // Without a fused multiply and add, as on lavapipe, the cells' mean velocities lean by another 5e-10.
    assert!(drift.abs() < 1.2e-9, "{drift:e}");
}
