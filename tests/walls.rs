//! Momentum handed to walls.
mod rig;

use glam::DVec3;

fn momentum(session: &squirm::gpu::Session) -> DVec3 {
    session.state().expect("state").particles.iter().map(|p| p.velocity).sum()
}

/// What the walls received, from the 64 partial sums of six wide sums.
fn received(session: &squirm::gpu::Session) -> [DVec3; 2] {
    let words = session.read::<u32>("wall_impulses").expect("words");
    assert_eq!(words.len(), 64 * 12);
    let mut out = [DVec3::ZERO; 2];
    for partial in words.chunks_exact(12) {
        for (k, pair) in partial.chunks_exact(2).enumerate() {
            let value = ((u64::from(pair[1]) << 32) | u64::from(pair[0])) as i64;
            out[k / 3][k % 3] += value as f64 / 1_048_576.0;
        }
    }
    out
}

#[test]
fn walls_receive_what_the_fluid_loses() {
    let mut system = rig::system([8, 8, 8]);
    system.domain.walls = Some(rig::walls());
    let state = rig::fluid(&system, 5120);
    let kinds = ["stream", "shift-grid", "cell-reduce", "wall-ghosts", "rotate", "restore-thermostat", "apply"];
    let plan = rig::plan(&system, &kinds, &[]);
    let mut session = rig::session(&plan, &state);
    let before = momentum(&session);
    session.advance(20, false);
    session.wait().expect("done");
    let [low, high] = received(&session);
    // The low wall is pushed down, the high wall up: pressure 10 kT/a^3 on 64 a^2 for 2 tau.
    assert!(low.y < -1000.0 && high.y > 1000.0, "{low} {high}");
    // Sums of some thousand terms rounded to 2^-21 each, and f32 velocities.
    let missing = momentum(&session) - before + low + high;
    assert!(missing.length() < 2e-2, "{missing}");
}
