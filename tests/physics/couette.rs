//! Flow between walls that move against each other: where the fluid stops.

use crate::{advance, alone, rig, size, sound};
use squirm::analyze::statistics::{Estimate, blocked};
use squirm::params::Value;
use squirm::state::State;

const SLIT: &[&str] =
    &["stream", "shift-grid", "sort-reorder", "cell-reduce", "wall-ghosts", "rotate", "restore-thermostat", "apply"];

/// Speed of either wall. Only the shear matters to the fluid, which is uniform along the flow.
const SPEED: f64 = 0.7;

/// Slope of u(y) by least squares over the particles farther than half a cell from either wall: nearer ones are slower.
fn slope(state: &State, height: f64) -> f64 {
    let inside = state.particles.iter().filter(|p| (p.position.y - height / 2.0).abs() < height / 2.0 - 0.5);
    let (mut n, mut y, mut v, mut yy, mut yv) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for p in inside {
        let (a, b) = (p.position.y, p.velocity.x);
        (n, y, v, yy, yv) = (n + 1.0, y + a, v + b, yy + a * a, yv + a * b);
    }
    (n * yv - y * v) / (n * yy - y * y)
}

/// How far behind the walls the fluid's profile reaches their velocity: 2 SPEED/slope = height + 2 b.
fn slip_length(velocity: &str) -> Estimate {
    let (edge, height) = size((16, 4), (64, 8));
    let depth = f64::from(height);
    let mut system = rig::system([edge, height, edge]);
    let wall = |speed| [speed, 0.0, 0.0];
    system.domain.walls =
        Some(squirm::state::Walls { velocity_low: wall(-SPEED), velocity_high: wall(SPEED), ..rig::walls() });
    let mut state = rig::fluid(&system, (10 * edge * height * edge) as usize);
    // The flow starts developed.
    state.particles.iter_mut().for_each(|p| p.velocity.x += SPEED * (2.0 * p.position.y / depth - 1.0));
    let plan = rig::plan(&system, SLIT, &[("wall-ghosts", "velocity", Value::Text(velocity.into()))]);
    let mut session = rig::fused(&plan, &state);
    // Some L^2/(pi^2 nu) = 4 tau (full: 15 tau) for what is left to develop.
    advance(&mut session, size(100, 1000));
    let mut slopes = Vec::new();
    for _ in 0..size(250, 4000) {
        advance(&mut session, 5);
        slopes.push(slope(&session.state().expect("a state"), depth));
    }
    sound(&session);
    let slope = blocked(&slopes);
    Estimate { mean: SPEED / slope.mean - depth / 2.0, error: SPEED * slope.error / slope.mean.powi(2) }
}

/// Known from long runs of this slit at a height of 6: 0.10 a with ghosts at the wall's velocity, 0.01 a with continued ones.
///
/// Of the quick run: a snapshot's slope errs by sqrt(12/(10 * 256 * 3^3)) = 0.013 of 0.35, hence the slip length by 0.075, and
/// 125 tau hold about 50 independent snapshots: 0.011.
#[test]
fn continued_ghosts_stop_the_fluid_at_the_wall() {
    let _turn = alone();
    let (wall, continued) = (slip_length("wall"), slip_length("continued"));
    for (name, b) in [("wall", wall), ("continued", continued)] {
        println!("{name}: slip length {:.3} +- {:.3}", b.mean, b.error);
    }
    let error = wall.error.hypot(continued.error);
    assert!(error < size(0.025, 0.005), "{error}");
    assert!(wall.mean - continued.mean > 3.0 * error, "{} {} +- {error}", wall.mean, continued.mean);
    assert!((wall.mean - 0.1).abs() < size(0.08, 0.03), "{}", wall.mean);
    assert!((continued.mean - 0.01).abs() < size(0.08, 0.03), "{}", continued.mean);
}
