//! What the GPU tests share: hand-made systems and plans, and one opened adapter.
#![allow(dead_code)]

use squirm::gpu::{Form, Gpu, Session};
use squirm::graph::{Checkpoints, Plan, PlannedStage};
use squirm::params::{Value, Values};
use squirm::stages;
use squirm::state::{Domain, Fluid, Init, Run, SemiAxes, Species, State, System, Walls};
use std::sync::OnceLock;

/// The best adapter of this machine; SQUIRM_ADAPTER names another.
pub fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::open(std::env::var("SQUIRM_ADAPTER").ok().as_deref()).expect("an adapter"))
}

/// A periodic box with 10 particles per cell, h = 0.1, no squirmers.
pub fn system(size: [u32; 3]) -> System {
    System {
        run: Run { seed: 7, steps: 0, dt: 0.1, live: true },
        domain: Domain { size, walls: None },
        fluid: Fluid { density: 10.0, temperature: 1.0, acceleration: [0.0; 3] },
        species: Vec::new(),
        init: Init { from: None },
    }
}

/// No-slip walls at rest.
pub fn walls() -> Walls {
    Walls { axis: "y".into(), condition: "no-slip".into(), velocity_low: [0.0; 3], velocity_high: [0.0; 3] }
}

/// One species of squirmers.
pub fn species(along: f64, across: f64, b1: f64, beta: f64) -> Species {
    Species {
        name: "squirmer".into(),
        count: 1,
        semi_axes: SemiAxes { along, across },
        offset: 0.0,
        force: [0.0; 3],
        b1,
        beta,
        rotlet: 0.0,
        passive: false,
        held: false,
        start: "random".into(),
        poses: None,
    }
}

/// A plan of these stages with their defaults, changed by `changes` (kind, parameter, value).
pub fn plan(system: &System, kinds: &[&str], changes: &[(&str, &'static str, Value)]) -> Plan {
    let stages = kinds
        .iter()
        .map(|kind| {
            let entry = stages::find(kind).unwrap_or_else(|| panic!("no stage `{kind}`"));
            let mut values = Values::defaults(&(entry.fields)());
            for (owner, name, value) in changes {
                if owner == kind {
                    values.set(name, value.clone());
                }
            }
            PlannedStage { entry, values }
        })
        .collect();
    Plan {
        name: "test".into(),
        system: system.clone(),
        stages,
        outputs: Vec::new(),
        analyzers: Vec::new(),
        checkpoints: Checkpoints::default(),
        resolved: String::new(),
    }
}

/// A session at the start of a plan.
pub fn session(plan: &Plan, state: &State) -> Session {
    Session::new(gpu(), plan, state).expect("a session")
}

/// The same in the form in which users run.
pub fn fused(plan: &Plan, state: &State) -> Session {
    Session::formed(gpu(), plan, state, Form::Fused).expect("a session")
}

/// Every stage of a fluid in a periodic box.
pub const BULK: &[&str] =
    &["stream", "shift-grid", "sort-reorder", "cell-reduce", "rotate", "restore-thermostat", "apply"];

/// Every stage of squirmers in a slit.
pub const EVERYTHING: &[&str] = &[
    "squirmer-move",
    "stream",
    "squirmer-collide",
    "shift-grid",
    "sort-reorder",
    "cell-reduce",
    "wall-ghosts",
    "squirmer-fill",
    "rotate",
    "restore-thermostat",
    "apply",
];

/// A random fluid of `count` particles at rest on average, with Maxwell-Boltzmann velocities, anywhere in the box.
pub fn fluid(system: &System, count: usize) -> State {
    use squirm::math::rng::{Draw, Purpose};
    let draw = Draw::new(system.run.seed, Purpose::Start, 0);
    let size = glam::DVec3::from_array(system.domain.size.map(f64::from));
    let speed = system.fluid.temperature.sqrt();
    let mut particles: Vec<squirm::state::Particle> = (0..count)
        .map(|i| {
            let i = u32::try_from(i).expect("few particles");
            let [a, b, c, _] = draw.uniforms(i, 0, 0);
            let [p, q, r, s] = draw.uniforms(i, 1, 0);
            let radius = (-2.0 * p.ln()).sqrt();
            let (sine, cosine) = (std::f64::consts::TAU * q).sin_cos();
            let third = (-2.0 * r.ln()).sqrt() * (std::f64::consts::TAU * s).cos();
            squirm::state::Particle {
                position: glam::DVec3::new(a, b, c) * size,
                velocity: glam::DVec3::new(radius * cosine, radius * sine, third) * speed,
            }
        })
        .collect();
    let mean = particles.iter().map(|p| p.velocity).sum::<glam::DVec3>() / count as f64;
    particles.iter_mut().for_each(|p| p.velocity -= mean);
    State { step: 0, particles, squirmers: Vec::new() }
}
