//! Conservation in a periodic box.
mod rig;

use squirm::params::Value;
use squirm::state::State;

fn totals(state: &State) -> (f64, glam::DVec3) {
    let energy = state.particles.iter().map(|p| 0.5 * p.velocity.length_squared()).sum();
    let momentum = state.particles.iter().map(|p| p.velocity).sum();
    (energy, momentum)
}

#[test]
fn energy_and_momentum_are_conserved() {
    let system = rig::system([12, 12, 12]);
    let state = rig::fluid(&system, 17_280);
    let plan = rig::plan(&system, rig::BULK, &[("restore-thermostat", "mode", Value::Text("energy".into()))]);
    let mut session = rig::session(&plan, &state);
    let (e0, p0) = totals(&session.state().expect("state"));
    let t = std::time::Instant::now();
    let steps = 200;
    session.advance(steps, true);
    session.wait().expect("done");
    let n = state.particles.len() as f64;
    println!("{} ns/particle/step", t.elapsed().as_nanos() as f64 / n / steps as f64);
    let (e1, p1) = totals(&session.state().expect("state"));
    println!("dE/E {:e} dP/N {:e} faults {}", e1 / e0 - 1.0, (p1 - p0).length() / n, session.faults().expect("faults"));
    assert!((e1 / e0 - 1.0).abs() < 1e-5);
    assert!((p1 - p0).length() / n < 1e-6);
    assert_eq!(session.faults().expect("faults"), 0);
}
