//! The thermostat's temperature.

use crate::{advance, alone, rig, size, sound, temperature};
use squirm::analyze::statistics::{Estimate, blocked};
use squirm::params::Value;

/// Mean temperature of a fluid that starts 5 % too hot, after 20 units of time.
fn settled(mode: &str) -> Estimate {
    let edge = size(12, 32);
    let system = rig::system([edge; 3]);
    let mut state = rig::fluid(&system, 10 * (edge as usize).pow(3));
    state.particles.iter_mut().for_each(|p| p.velocity *= 1.05f64.sqrt());
    let plan = rig::plan(&system, rig::BULK, &[("restore-thermostat", "mode", Value::Text(mode.into()))]);
    let mut session = rig::fused(&plan, &state);
    advance(&mut session, 200);
    let series: Vec<f64> = (0..64)
        .map(|_| {
            advance(&mut session, 5);
            temperature(session.state().expect("a state").particles.iter())
        })
        .collect();
    sound(&session);
    blocked(&series)
}

/// The energy of 17,000 particles scatters by sqrt(2/(3 N)) = 0.6 %, and the thermostat draws it anew within two steps: 64
/// readings leave 0.08 %.
#[test]
fn the_thermostat_holds_its_temperature() {
    let _turn = alone();
    let t = settled("thermostat");
    println!("temperature {:.5} +- {:.5}", t.mean, t.error);
    assert!(t.error < 0.0015, "{}", t.error);
    assert!((t.mean - 1.0).abs() < 0.005, "{} +- {}", t.mean, t.error);
}

/// The same reading tells a fluid that nothing cools.
#[test]
fn without_thermostat_it_stays_hot() {
    let _turn = alone();
    let t = settled("energy");
    assert!((t.mean - 1.05).abs() < 0.02, "{} +- {}", t.mean, t.error);
}
