//! Swimming speeds against Stokes flow.

use crate::{SQUIRMERS, advance, alone, listed, mass, rig, size, sound};
use glam::{DQuat, DVec3};
use squirm::analyze::statistics::{Estimate, blocked};
use squirm::buffers::SquirmerState;
use squirm::gpu::Session;
use squirm::state::start::start;
use squirm::state::{Species, System, packed};

/// Where a squirmer is, crossings of the box included, and its axis.
fn pose(system: &System, s: &SquirmerState) -> (DVec3, DVec3) {
    let image = DVec3::from_array(s.image.map(f64::from));
    let size = DVec3::from_array(system.domain.size.map(f64::from));
    let position = packed::unpack_position(&system.domain, s.position) + image * size;
    (position, DQuat::from_array(s.orientation.map(f64::from)).normalize() * DVec3::Z)
}

fn squirmers(session: &Session) -> Vec<SquirmerState> {
    session.read("squirmers").expect("squirmers are readable")
}

/// One squirmer in a periodic cube; its speed along the axis from displacements over `every` steps each.
pub fn speed(species: Species, edge: u32, dt: f64, seed: u64, steps: u64) -> (Estimate, f64) {
    let mut system = rig::system([edge; 3]);
    system.run.dt = dt;
    system.run.seed = seed;
    let middle = f64::from(edge) / 2.0;
    let (b1, shape) = (species.b1, species.spheroid());
    system.species = vec![listed(species, vec![[middle, middle, middle, 0.3, 0.5, 0.8]])];
    let state = start(&system).expect("there is room");
    let mut session = rig::session(&rig::plan(&system, SQUIRMERS, &[]), &state);
    // Flow needs about L^2/(4 pi^2 nu) to develop, here a few units of time.
    let settle = (size(5.0, 20.0) / dt) as u64;
    advance(&mut session, settle);
    let every = 20;
    let mut series = Vec::new();
    let mut before = pose(&system, &squirmers(&session)[0]);
    for _ in 0..steps / every {
        advance(&mut session, every);
        let now = pose(&system, &squirmers(&session)[0]);
        series.push((now.0 - before.0).dot((now.1 + before.1).normalize()) / (every as f64 * dt));
        before = now;
    }
    sound(&session);
    let _ = mass(&system, 0);
    (blocked(&series), shape.swim_speed_periodic(b1, system.domain.volume()))
}

#[test]
fn explore() {
    let _turn = alone();
    let get = |n: &str, d: f64| std::env::var(n).ok().and_then(|v| v.parse().ok()).unwrap_or(d);
    let s = rig::species(get("ALONG", 4.0), get("ACROSS", 2.0), get("B1", 0.2), get("BETA", 0.0));
    let t = std::time::Instant::now();
    let (e, u) =
        speed(s, get("EDGE", 14.0) as u32, get("H", 0.1), get("SEED", 7.0) as u64, get("STEPS", 1000.0) as u64);
    println!(
        "RESULT {:?} speed {:.5} +- {:.5} U_L {u:.5} ratio {:.3}({:.3}) {:.1} s",
        std::env::vars()
            .filter(|(k, _)| ["ALONG", "ACROSS", "B1", "BETA", "EDGE", "H", "STEPS"].contains(&k.as_str()))
            .collect::<Vec<_>>(),
        e.mean,
        e.error,
        e.mean / u,
        e.error / u,
        t.elapsed().as_secs_f64()
    );
}
