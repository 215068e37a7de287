//! Shear viscosity from the decay of shear waves.

use crate::case::{Case, Control, Curve, Outcome, Part, Row, Sheet, Size, Trouble};
use crate::measure::Fluid;
use crate::rig::{Planned, Rig, advance, sound};
use crate::rules::{self, Collision, known_viscosity};
use glam::DVec3;
use squirm::analyze::statistics::{Estimate, independent};
use squirm::math::transport::{Rule, Transport};
use std::f64::consts::TAU;

/// The case.
pub const CASE: Case = Case {
    name: "viscosity",
    title: "Viscosity by the decay of shear waves",
    about: "A periodic box begins with a helical shear wave, v = A (sin kz, cos kz, 0) of the longest wavelength and A = 0.3. Its speed and \
            its dissipation are the same everywhere and nothing advects it, so that it decays as exp(-nu k^2 t) at any amplitude in an \
            incompressible fluid, and neither pressure nor density has to follow it in this one, which is a gas. nu is taken from the \
            ratios of both amplitudes at the start and after about one decay time. The expectation is the value of an independent code of the \
            same rules in f64 (0.1 to 0.2 %), from waves of the same kind. The formula for molecular chaos (Kikuchi et al. 2003; Noguchi and \
            Gompper 2008) stands beside it: at short steps the fluid has a memory and the formula lies up to 5 % off, at 90 degrees as well.",
    remarks: "",
    sheets: &[Sheet {
        name: "viscosity",
        title: "Kinematic viscosity at 10 particles per cell, 130 degrees",
        x: "time step h / tau",
        y: "nu / (a^2/tau)",
        logarithmic: true,
    }],
    parts,
    controls: &[Control {
        name: "no-angular-momentum",
        about: "SRD-a is run where SRD+a is meant",
        part: "energy-10-0.1-130",
        spoil: rules::without_angular_momentum,
    }],
};

fn parts(size: Size) -> Vec<Part> {
    let settings: &[(f64, f64, f64)] = match size {
        Size::Quick => &[(10.0, 0.1, 130.0)],
        Size::Full => &[
            (10.0, 0.02, 130.0),
            (10.0, 0.05, 130.0),
            (10.0, 0.1, 130.0),
            (50.0, 0.02, 130.0),
            (50.0, 0.05, 130.0),
            (50.0, 0.1, 130.0),
            (10.0, 0.1, 90.0),
            (10.0, 0.1, 160.0),
        ],
    };
    let part = |rule: Collision, (density, dt, angle): (f64, f64, f64)| {
        Part::new(format!("{}-{density}-{dt}-{angle}", rule.name), move |rig| {
            let mut sets = rule.sets();
            sets.extend([
                format!("fluid.density={density}"),
                format!("run.dt={dt}"),
                format!("stage.rotate.angle={angle}"),
            ]);
            let edge = rig.pick(16, if density > 20.0 { 24 } else { 32 });
            sets.push(rules::size_set([edge; 3]));
            let planned = rig.plan("shear-wave", &sets)?;
            let theory = Rule { density, temperature: 1.0, dt, angle, angular_momentum: rule.conserved }.transport();
            let found = viscosity(rig, &planned, &theory)?;
            Ok(outcome(rule.name, (density, dt, angle), &theory, found))
        })
    };
    rules::ALL.iter().flat_map(|rule| settings.iter().map(move |s| part(*rule, *s))).collect()
}

/// Kinematic viscosity, its error from waves and repetitions, which are independent.
fn viscosity(rig: &Rig, planned: &Planned, theory: &Transport) -> Result<Estimate, Trouble> {
    const AMPLITUDE: f64 = 0.3;
    let domain = &planned.system.domain;
    let k = TAU / f64::from(domain.size[2]);
    let dt = planned.system.run.dt;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let steps = (1.1 / (theory.kinematic() * k * k * dt)).round() as u64;
    let mut state = rig.start(planned)?;
    let mut session = rig.session(planned, &state)?;
    let thermal: Vec<_> = state.particles.iter().map(|p| p.velocity).collect();
    let mut values = Vec::new();
    for _ in 0..rig.pick(8, 40) {
        // The random numbers depend on the step: the same start goes another way each time.
        for (p, v) in state.particles.iter_mut().zip(&thermal) {
            let (sine, cosine) = (k * p.position.z).sin_cos();
            p.velocity = *v + AMPLITUDE * DVec3::new(sine, cosine, 0.0);
        }
        session.write_particles(&state.particles);
        let before = Fluid::of(&session)?.helix(k);
        advance(&mut session, steps)?;
        let after = Fluid::of(&session)?.helix(k);
        for (a, b) in before.iter().zip(after) {
            values.push((a / b).ln() / (k * k * steps as f64 * dt));
        }
    }
    sound(&session)?;
    Ok(independent(&values))
}

fn outcome(rule: &str, (density, dt, angle): (f64, f64, f64), theory: &Transport, found: Estimate) -> Outcome {
    let (expected, source) = match known_viscosity(rule, density, dt, angle) {
        Some(nu) => (nu, "independent f64 code"),
        None => (theory.kinematic(), "molecular chaos"),
    };
    let row = Row {
        quantity: "nu / (a^2/tau)".into(),
        setup: format!("{rule}, {density} per cell, h = {dt}, {angle} deg; formula {:.3}", theory.kinematic()),
        measured: found.mean,
        error: found.error,
        expected: Some(expected),
        tolerance: 0.02 * expected,
        source: source.into(),
        note: String::new(),
    };
    let mut curves = Vec::new();
    if density == 10.0 && angle == 130.0 {
        let conserved = rule != "srd-a";
        let formula =
            |dt| Rule { density, temperature: 1.0, dt, angle, angular_momentum: conserved }.transport().kinematic();
        curves.push(Curve {
            sheet: "viscosity".into(),
            name: rule.into(),
            points: vec![(dt, found.mean, found.error)],
            guide: (2..=10).map(|k| 0.01 * f64::from(k)).map(|h| (h, formula(h))).collect(),
            guide_name: "formula".into(),
        });
    }
    Outcome { rows: vec![row], curves }
}
