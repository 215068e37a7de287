//! Viscosity from the decay of a shear wave, against the theory of the collision rule.

use crate::{advance, alone, rig, size, sound};
use squirm::analyze::statistics::independent;
use squirm::math::transport::Rule;
use squirm::state::State;
use std::f64::consts::TAU;

/// Amplitude of v_x ~ sin(k z).
fn amplitude(state: &State, k: f64) -> f64 {
    let sum: f64 = state.particles.iter().map(|p| p.velocity.x * (k * p.position.z).sin()).sum();
    2.0 * sum / state.particles.len() as f64
}

/// The amplitude scatters by sqrt(2/N) = 0.7 % of the thermal speed for 16^3 cells. A wave that started with 0.4 has fallen to
/// 0.15 after t = 1/(nu k^2): 4.8 % of its exponent from one run, 1.4 % from twelve. A full run has 32^3 cells, a wave that is
/// twice as long, and 16 seeds: 0.4 %. The theory assumes molecular chaos, which independent codes find good to a few per cent.
#[test]
fn shear_waves_decay_with_the_viscosity_of_the_rule() {
    let _turn = alone();
    let edge = size(16, 32);
    let theory = Rule { density: 10.0, temperature: 1.0, dt: 0.1, angle: 130.0, angular_momentum: true }.transport();
    let k = TAU / f64::from(edge);
    let steps = (10.0 / (theory.kinematic() * k * k)).round() as u64;
    let values: Vec<f64> = (0..size(12, 16))
        .map(|seed| {
            let mut system = rig::system([edge; 3]);
            system.run.seed = 100 + seed;
            let mut state = rig::fluid(&system, 10 * (edge as usize).pow(3));
            state.particles.iter_mut().for_each(|p| p.velocity.x += 0.4 * (k * p.position.z).sin());
            let mut session = rig::fused(&rig::plan(&system, rig::BULK, &[]), &state);
            let before = amplitude(&state, k);
            advance(&mut session, steps);
            let after = amplitude(&session.state().expect("a state"), k);
            sound(&session);
            assert!(after > 0.05, "{after}");
            10.0 * (before / after).ln() / (k * k * steps as f64 * 0.1)
        })
        .collect();
    let found = independent(&values);
    println!("viscosity {:.3} +- {:.3}, theory {:.3}", found.mean, found.error, theory.viscosity);
    assert!((found.mean / theory.viscosity - 1.0).abs() < size(0.1, 0.05), "{found:?} {}", theory.viscosity);
}
