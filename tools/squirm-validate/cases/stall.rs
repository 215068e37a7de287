//! The force that stops a squirmer.

use crate::case::{Case, Control, Outcome, Part, Row, Size, Trouble};
use crate::measure::Fluid;
use crate::rig::{Rig, advance, sound};
use crate::rules::viscosity;
use crate::swimmer::{Swimmer, friction_periodic, squirmers};
use squirm::analyze::statistics::{Estimate, blocked};

/// The case.
pub const CASE: Case = Case {
    name: "stall",
    title: "Stall force and pumping of a held squirmer",
    about: "A squirmer that is held in a periodic cube drives the fluid until the mean flow over the whole box, body included, is -U_L: \
            it pumps as fast as it would swim. A body force gamma g L^3 (with the share that the body's place would have) shifts \
            that flow by itself over the friction zeta_L eta, Perrin's with the images of Hasimoto (1959). Two runs, one without and one with \
            twice the force that theory wants for a standstill, so that the flow is +U_L, give by a straight line the stall force, \
            where the mean flow vanishes, against zeta_L eta U_L, and the friction. A steady mean momentum of the \
            fluid makes the mean force on the body equal to that on the fluid exactly. The flow starts at its expected value.",
    remarks: "",
    sheets: &[],
    parts,
    controls: &[
        Control {
            name: "slip-reversed",
            about: "the slip velocity has the wrong sign",
            part: "2x3",
            spoil: |plan| plan.system.species.iter_mut().for_each(|s| s.b1 = -s.b1),
        },
        Control {
            name: "no-ghosts",
            about: "squirmers hold no virtual particles",
            part: "2x3",
            spoil: |plan| plan.stages.retain(|s| s.entry.kind != "squirmer-fill"),
        },
    ],
};

fn parts(size: Size) -> Vec<Part> {
    let held = Swimmer {
        across: 2.0,
        along: 4.0,
        b1: 0.1,
        beta: 0.0,
        edge: 16,
        density: 50,
        dt: 0.02,
        temperature: 1.0,
        seed: 1,
    };
    let settings = match size {
        Size::Quick => vec![(Swimmer { along: 3.0, b1: 0.25, edge: 10, density: 10, ..held }, 750)],
        Size::Full => vec![(held, 60_000), (Swimmer { across: 3.0, along: 3.0, ..held }, 60_000)],
    };
    let part = |(swimmer, steps): (Swimmer, u64)| {
        Part::new(format!("{}x{}", swimmer.across, swimmer.along), move |rig| measure(rig, &swimmer, steps))
    };
    settings.into_iter().map(part).collect()
}

/// Mean flow of the whole box along the axis under an acceleration along it, from a start with the flow `start`.
fn flow(rig: &Rig, swimmer: &Swimmer, acceleration: f64, start: f64, steps: u64) -> Result<Estimate, Trouble> {
    let axis = glam::DVec3::new(0.3, 0.5, 0.8).normalize();
    let g = acceleration * axis;
    let mut sets = swimmer.sets();
    sets.push(format!("fluid.acceleration=[{:?},{:?},{:?}]", g.x, g.y, g.z));
    let planned = rig.plan("stall", &sets)?;
    let mut state = rig.start(&planned)?;
    state.particles.iter_mut().for_each(|p| p.velocity += start * axis);
    let mut session = rig.session(&planned, &state)?;
    let axis = squirmers(&session)?[0].axis();
    advance(&mut session, steps / 10)?;
    let every = rig.pick(25, 100);
    let mass = planned.system.fluid.density * planned.system.domain.volume();
    let mut series = Vec::new();
    for _ in 0..steps / every {
        advance(&mut session, every)?;
        series.push(Fluid::of(&session)?.momentum().dot(axis) / mass);
    }
    sound(&session)?;
    // The flow relaxes slowly, and a short series underestimates its error: it is not below that of the Langevin equation.
    let friction = friction_periodic(swimmer.shape(), f64::from(swimmer.edge)) * viscosity(&planned.system);
    let least = (2.0 / (friction * steps as f64 * planned.system.run.dt)).sqrt();
    let found = blocked(&series);
    Ok(Estimate { error: found.error.max(least), ..found })
}

fn measure(rig: &Rig, swimmer: &Swimmer, steps: u64) -> Result<Outcome, Trouble> {
    let system = rig.plan("stall", &swimmer.sets())?.system;
    let friction = friction_periodic(swimmer.shape(), f64::from(swimmer.edge)) * viscosity(&system);
    let (speed, mass) = (swimmer.speed(), system.fluid.density * system.domain.volume());
    let stall = friction * speed;
    let force = 2.0 * stall;
    let free = flow(rig, swimmer, 0.0, -speed, steps)?;
    let driven = flow(rig, swimmer, force / mass, speed, steps)?;
    // u = (F - F_stall)/zeta.
    let change = driven.mean - free.mean;
    let change_error = driven.error.hypot(free.error);
    let ratio = -free.mean / change;
    let ratio_error = (driven.mean * free.error).hypot(free.mean * driven.error) / change.powi(2);
    let row = |quantity: &str, measured: f64, error: f64, source: &str| Row {
        quantity: quantity.into(),
        setup: swimmer.name(),
        measured,
        error: error.abs(),
        expected: Some(1.0),
        tolerance: 0.05,
        source: source.into(),
        note: String::new(),
    };
    let rows = vec![
        row("pumping speed / U_L", -free.mean / speed, free.error / speed, "Keller and Wu 1977"),
        Row {
            note: format!("zeta_L eta U_L = {stall:.1} kT/a with eta = {:.1}", viscosity(&system)),
            ..row("stall force / (zeta_L eta U_L)", force * ratio / stall, force * ratio_error / stall, "Hasimoto 1959")
        },
        row(
            "friction / (zeta_L eta)",
            force / change / friction,
            force * change_error / change.powi(2) / friction,
            "Perrin 1934; Hasimoto 1959",
        ),
    ];
    Ok(Outcome { rows, curves: Vec::new() })
}
