//! Kinetic temperature of passive bodies.

use crate::bodies::bodies;
use crate::case::{Case, Control, Outcome, Part, Row, Size, Trouble};
use crate::rig::{Rig, advance, sound};
use squirm::analyze::statistics::blocked;
use squirm::params::Value;

/// The case.
pub const CASE: Case = Case {
    name: "body-temperature",
    title: "Kinetic temperature of bodies",
    about: "Prolate bodies, 2 across and 4 along (quick: 1.5 and 3), in a periodic cube. Energy per degree of freedom at the end of the step, in units of \
            kT/2: M <V^2>/3, over 1 - M/M_total, since fluid and bodies together have no momentum; (L.e)^2/I_par; and the rest of \
            L^2 over 2 I_perp. Equipartition wants 1. With ghosts whose thermal velocities are drawn anew in each step (`published`) \
            a body is too hot by 1/(1 - kappa/2) at most, kappa being the share of its velocity that relaxes in a step; that is \
            reported only. `equipartition` takes the rigid motion out of those velocities; the bounces still heat a little.",
    remarks: "At h = 0.1 (translation 1.024(2), rotation across e 1.020(3)) bounces heat the bodies by 2 %: each takes up impulses that were computed with its velocity at \
              the beginning of the step, which overshoots by half the share of its velocity that relaxes in a step. At \
              h = 0.02 nothing is left of it. A joint solution of all hits of a step with the mean of the velocities \
              before and after would cure it.",
    sheets: &[],
    parts,
    controls: &[Control {
        name: "published-ghosts",
        about: "the ghosts' thermal velocities keep their rigid motion",
        part: "equipartition-0.1",
        spoil: |plan| {
            for stage in plan.stages.iter_mut().filter(|s| s.entry.kind == "squirmer-fill") {
                stage.values.set("ghosts", Value::Text("published".into()));
            }
        },
    }],
};

fn parts(size: Size) -> Vec<Part> {
    let settings: &[(&str, f64)] = match size {
        Size::Quick => &[("equipartition", 0.1)],
        Size::Full => &[("equipartition", 0.1), ("equipartition", 0.02), ("published", 0.1), ("published", 0.02)],
    };
    let part = |(ghosts, dt): &(&'static str, f64)| {
        let (ghosts, dt) = (*ghosts, *dt);
        Part::new(format!("{ghosts}-{dt}"), move |rig| measure(rig, ghosts, dt))
    };
    settings.iter().map(part).collect()
}

/// M V^2/3 and L.Omega by axis, as one series each.
#[derive(Default)]
struct Temperatures {
    translation: Vec<f64>,
    spin: Vec<f64>,
    tumble: Vec<f64>,
}

fn measure(rig: &Rig, ghosts: &str, dt: f64) -> Result<Outcome, Trouble> {
    // In the quick run shorter bodies, of which more fit in.
    let (edge, count, along, across) = rig.pick((12, 8, 3.0, 1.5), (24, 16, 4.0, 2.0));
    let sets = [
        format!("run.dt={dt}"),
        format!("box.size=[{edge},{edge},{edge}]"),
        format!("squirmers.body.count={count}"),
        format!("squirmers.body.semi_axes={{along={along:?},across={across:?}}}"),
        format!("stage.squirmer-fill.ghosts={ghosts}"),
    ];
    let planned = rig.plan("passive-bodies", &sets)?;
    let species = &planned.system.species[0];
    let mass = f64::from(species.ghosts(&planned.system.fluid));
    let (about, tumbling) = species.hull().inertia(mass);
    let mut session = rig.session(&planned, &rig.start(&planned)?)?;
    let total = session.particles() as f64 + mass * f64::from(count);
    let free = 1.0 - mass / total;
    // Velocities are forgotten within a few tau.
    advance(&mut session, rig.pick(200, 1000))?;
    let mut found = Temperatures::default();
    // A rotation is forgotten within 1 tau at h = 0.1 and a fifth of that at h = 0.02.
    let judged = if dt < 0.05 { 150_000 } else { 110_000 };
    let (steps, every) = rig.pick((3000, 10), (if ghosts == "published" { judged / 2 } else { judged }, 10));
    for _ in 0..steps / every {
        advance(&mut session, every)?;
        let now = bodies(&session)?;
        let n = now.len() as f64;
        let mean = |f: &dyn Fn(&squirm::state::Squirmer) -> f64| now.iter().map(f).sum::<f64>() / n;
        found.translation.push(mean(&|b| mass * b.velocity.length_squared() / (3.0 * free)));
        found.spin.push(mean(&|b| b.angular_momentum.dot(b.axis()).powi(2) / about));
        found.tumble.push(mean(&|b| {
            let l = b.angular_momentum;
            (l.length_squared() - l.dot(b.axis()).powi(2)) / (2.0 * tumbling)
        }));
    }
    sound(&session)?;
    let row = |quantity: &str, series: &[f64]| {
        let estimate = blocked(series);
        Row {
            quantity: quantity.into(),
            setup: format!("{across} x {along}, {count} in {edge}^3, ghosts = {ghosts}, h = {dt}"),
            measured: estimate.mean,
            error: estimate.error,
            expected: (ghosts == "equipartition").then_some(1.0),
            tolerance: 0.02,
            source: "equipartition".into(),
            note: String::new(),
        }
    };
    let rows = vec![
        row("temperature of translation / kT", &found.translation),
        row("temperature of rotation about e / kT", &found.spin),
        row("temperature of rotation across e / kT", &found.tumble),
    ];
    Ok(Outcome { rows, curves: Vec::new() })
}
