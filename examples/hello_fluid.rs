//! A periodic fluid built in code, without a pipeline file: a few hundred steps, then its temperature.

use glam::DVec3;
use squirm::gpu::{Gpu, Session};
use squirm::graph::{Checkpoints, Plan, PlannedStage};
use squirm::params::Values;
use squirm::state::{Domain, Fluid, Init, Run, System, start};
use squirm::{diag, stages};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let system = System {
        run: Run { seed: 1, steps: 300, dt: 0.1, live: true },
        domain: Domain { size: [12, 12, 12], walls: None },
        fluid: Fluid { density: 10.0, temperature: 1.0, acceleration: [0.0; 3] },
        species: Vec::new(),
        init: Init { from: None },
    };
    // One step: every stage with its defaults, in this order.
    let mut list = Vec::new();
    for kind in ["stream", "shift-grid", "cell-reduce", "rotate", "restore-thermostat", "apply"] {
        let entry =
            stages::find(kind).ok_or_else(|| diag::suggestion(kind, stages::REGISTRY.iter().map(|e| e.kind)))?;
        list.push(PlannedStage { entry, values: Values::defaults(&(entry.fields)()) });
    }
    let plan = Plan {
        name: "hello".into(),
        system,
        stages: list,
        outputs: Vec::new(),
        analyzers: Vec::new(),
        checkpoints: Checkpoints::default(),
        resolved: String::new(),
    };

    let gpu = Gpu::open(None)?;
    let begin = start::start(&plan.system)?;
    let mut session = Session::new(&gpu, &plan, &begin)?;
    session.advance(plan.system.run.steps, false);
    session.wait()?;

    let particles = session.state()?.particles;
    let n = particles.len() as f64;
    let mean: DVec3 = particles.iter().map(|p| p.velocity).sum::<DVec3>() / n;
    let temperature = particles.iter().map(|p| (p.velocity - mean).length_squared()).sum::<f64>() / (3.0 * n);
    // The mean of 3 n squares of normal variates scatters by sqrt(2 / (3 n)).
    let error = (2.0 / (3.0 * n)).sqrt();
    println!("{n} particles on {}: temperature {temperature:.4} +- {error:.4} kT", session.adapter());
    Ok(())
}
