//! Diffusion of a fluid particle, from its mean square displacement.

use crate::case::{Case, Control, Curve, Outcome, Part, Row, Sheet, Size, Trouble};
use crate::measure::row;
use crate::rig::{Planned, Rig, advance, sound};
use crate::rules::{self, Collision};
use squirm::analyze::statistics::{Estimate, blocked};
use squirm::gpu::Session;

/// The case.
pub const CASE: Case = Case {
    name: "self-diffusion",
    title: "Self-diffusion of the fluid",
    about: "The mean square displacement of all fluid particles between a quarter and the whole of a window, divided by 6 times that time. \
            Particles keep their place in memory (the loose plan), and crossings of the box are undone from reading to reading. At h = 1 \
            velocities are forgotten within a step and the formula for molecular chaos holds; at short time steps a \
            particle drags its surroundings along, and D lies above it.",
    remarks: "",
    sheets: &[Sheet {
        name: "self-diffusion",
        title: "Self-diffusion at 10 particles per cell, 130 degrees, over molecular chaos",
        x: "time step h / tau",
        y: "D / D(molecular chaos)",
        logarithmic: true,
    }],
    parts,
    controls: &[Control {
        name: "angular-momentum",
        about: "SRD+a is run where SRD-a is meant",
        part: "srd-a-1",
        spoil: |plan| {
            for stage in plan.stages.iter_mut().filter(|s| s.entry.kind == "restore-thermostat") {
                stage.values.set("angular_momentum", squirm::params::Value::Boolean(true));
            }
        },
    }],
};

/// Time step h, steps of a window, steps from reading to reading.
type Window = (f64, u64, u64);

/// Windows are 20 tau or, at short time steps, 6 tau: long against the memory of a velocity, which is h/s = 1.1 h. Between two readings a particle
/// must not cross half the box: readings are at most 1 tau apart.
const WINDOWS: [Window; 3] = [(1.0, 20, 1), (0.1, 60, 10), (0.02, 300, 50)];

fn parts(size: Size) -> Vec<Part> {
    let part = |rule: Collision, window: Window| {
        Part::new(format!("{}-{}", rule.name, window.0), move |rig| diffusion(rig, rule, window))
    };
    match size {
        Size::Quick => vec![part(rules::MINUS, WINDOWS[0])],
        Size::Full => [rules::MINUS, rules::ENERGY].iter().flat_map(|r| WINDOWS.map(|w| part(*r, w))).collect(),
    }
}

/// The displacements of all particles since the start, in coordinate units.
struct Walk {
    last: Vec<u32>,
    moved: Vec<i64>,
    /// Edge of the box over 2^32, a.
    unit: f64,
}

impl Walk {
    fn new(planned: &Planned, positions: Vec<u32>) -> Self {
        let unit = f64::from(planned.system.domain.size[0]) / 4_294_967_296.0;
        Self { moved: vec![0; positions.len()], last: positions, unit }
    }

    /// Adds what happened since the last reading: coordinates wrap with the box, so that the signed difference is the nearest image.
    fn enter(&mut self, positions: Vec<u32>) {
        for ((moved, before), now) in self.moved.iter_mut().zip(&self.last).zip(&positions) {
            *moved += i64::from(now.wrapping_sub(*before).cast_signed());
        }
        self.last = positions;
    }

    /// Mean square displacement in a^2.
    fn square(&self) -> f64 {
        let sum: f64 = self.moved.iter().map(|d| (*d as f64 * self.unit).powi(2)).sum();
        3.0 * sum / self.moved.len() as f64
    }
}

fn positions(session: &Session) -> Result<Vec<u32>, Trouble> {
    Ok(session.raw()?.positions)
}

fn diffusion(rig: &Rig, rule: Collision, (dt, steps, every): Window) -> Result<Outcome, Trouble> {
    let edge = rig.pick(12, 24);
    let mut sets = rule.sets();
    sets.extend([rules::size_set([edge; 3]), format!("run.dt={dt:?}")]);
    let planned = rig.plan("self-diffusion", &sets)?;
    // Only the loose plan leaves particles where they are in memory.
    let mut session = rig.loose_session(&planned, &rig.start(&planned)?)?;
    advance(&mut session, 20)?;
    let mut values = Vec::new();
    for _ in 0..rig.pick(32, 24) {
        let mut walk = Walk::new(&planned, positions(&session)?);
        let mut early = 0.0;
        for reading in 1..=steps / every {
            advance(&mut session, every)?;
            walk.enter(positions(&session)?);
            if 4 * reading * every <= steps {
                early = walk.square();
            }
        }
        let from = steps / every / 4 * every;
        values.push((walk.square() - early) / (6.0 * (steps - from) as f64 * dt));
    }
    sound(&session)?;
    Ok(outcome(rule, dt, edge, blocked(&values)))
}

fn outcome(rule: Collision, dt: f64, edge: u32, found: Estimate) -> Outcome {
    let theory = rule.transport(dt).diffusion;
    let setup = format!("{}, h = {dt}, {edge} x {edge} x {edge}; formula {theory:.4}", rule.title);
    // The share s_D of SRD+a is a fit in 1/N: only SRD-a has a formula to be held to.
    let chaotic = dt >= 1.0 && !rule.conserved;
    let expected = chaotic.then_some(theory);
    let ratio = found.mean / theory;
    let note = if chaotic { String::new() } else { format!("{ratio:.3} of molecular chaos, which is a lower bound") };
    let rows =
        vec![Row { note, ..row(("D / (a^2/tau)", &setup), found, (expected, 0.02 * theory), "molecular chaos") }];
    let curve = Curve {
        sheet: "self-diffusion".into(),
        name: format!("{}, h = {dt}", rule.title),
        points: vec![(dt, ratio, found.error / theory)],
        guide: if chaotic { vec![(0.02, 1.0), (1.0, 1.0)] } else { Vec::new() },
        guide_name: "molecular chaos".into(),
    };
    Outcome { rows, curves: vec![curve] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two particles, one of which crosses the side of the box backwards and one forwards.
    #[test]
    fn a_walk_is_followed_across_the_sides() {
        let mut walk = Walk { last: vec![5, 0, 0, u32::MAX, 0, 0], moved: vec![0; 6], unit: 0.5 };
        walk.enter(vec![u32::MAX, 0, 0, 3, 0, 0]);
        walk.enter(vec![u32::MAX - 3, 0, 0, 4, 0, 0]);
        assert_eq!(walk.moved, [-9, 0, 0, 5, 0, 0]);
        assert!((walk.square() - (81.0 + 25.0) * 0.25 / 2.0).abs() < 1e-12);
    }
}
