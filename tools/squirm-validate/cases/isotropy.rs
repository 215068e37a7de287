//! The viscosity of waves along an axis of the lattice and along its diagonal.

use crate::case::{Case, Control, Outcome, Part, Size, Trouble};
use crate::measure::{Fluid, row};
use crate::rig::{Planned, Rig, advance, sound};
use crate::rules::{self, Collision};
use glam::DVec3;
use squirm::analyze::statistics::{Estimate, independent};
use squirm::state::packed;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// The case.
pub const CASE: Case = Case {
    name: "isotropy",
    title: "Isotropy of the viscosity",
    about: "Collision cells are cubes, and a fluid with the symmetry of a cube has two shear viscosities: one for waves along an axis and \
            for waves along (1,1,0) with velocities along z, another for waves along (1,1,0) with velocities along (1,-1,0). \
            In a box of 34 x 34 x 24 (17 x 17 x 12 in a quick run) waves along z and along (1,1,0) are equally long to 0.2 %. One sine wave \
            at a time, of amplitude 0.3, decays to about a third; no single wave advects itself. \
            Every repetition has a new thermal start.",
    sheets: &[],
    parts,
    controls: &[Control {
        name: "no-shift",
        about: "the collision grid stays where it is",
        part: "energy",
        spoil: |plan| plan.stages.retain(|s| s.entry.kind != "shift-grid"),
    }],
};

fn parts(size: Size) -> Vec<Part> {
    let rules: &[Collision] = match size {
        Size::Quick => &[rules::ENERGY],
        Size::Full => &rules::ALL,
    };
    rules.iter().map(|rule| Part::new(rule.name, move |rig| isotropy(rig, *rule))).collect()
}

/// A wave: name, wave vector in units of the longest along each axis, direction of the velocity.
const WAVES: [(&str, DVec3, DVec3); 3] = [
    ("k along z", DVec3::Z, DVec3::X),
    ("k along (1,1,0), v along z", DVec3::new(1.0, 1.0, 0.0), DVec3::Z),
    ("k along (1,1,0), v along (1,-1,0)", DVec3::new(1.0, 1.0, 0.0), DVec3::new(FRAC_1_SQRT_2, -FRAC_1_SQRT_2, 0.0)),
];

fn isotropy(rig: &Rig, rule: Collision) -> Result<Outcome, Trouble> {
    let size = rig.pick([17, 17, 12], [34, 34, 24]);
    let mut sets = rule.sets();
    sets.push(rules::size_set(size));
    let planned = rig.plan("isotropy", &sets)?;
    let mut found = Vec::new();
    for (k, (_, vector, velocity)) in WAVES.into_iter().enumerate() {
        found.push(viscosity(rig, &planned, rule, k as u64, (vector, velocity))?);
    }
    let theory = rule.transport(planned.system.run.dt).kinematic();
    let setup = format!("{}, {} x {} x {}", rule.title, size[0], size[1], size[2]);
    let mut rows = Vec::new();
    for ((name, ..), nu) in WAVES.iter().zip(&found) {
        let quantity = format!("nu / (a^2/tau), {name}; formula {theory:.3}");
        rows.push(row((&quantity, &setup), *nu, (None, 0.02 * theory), "-"));
    }
    for ((name, ..), nu) in WAVES.iter().zip(&found).skip(1) {
        let ratio = nu.mean / found[0].mean;
        let error = ratio * (nu.error / nu.mean).hypot(found[0].error / found[0].mean);
        let quantity = format!("nu over that of {}, {name}", WAVES[0].0);
        rows.push(row((&quantity, &setup), Estimate { mean: ratio, error }, (Some(1.0), 0.02), "isotropy"));
    }
    Ok(Outcome { rows, curves: Vec::new() })
}

/// Kinematic viscosity of one wave from independent repetitions.
fn viscosity(
    rig: &Rig,
    planned: &Planned,
    rule: Collision,
    seed: u64,
    (vector, direction): (DVec3, DVec3),
) -> Result<Estimate, Trouble> {
    const AMPLITUDE: f64 = 0.3;
    let size = DVec3::from_array(planned.system.domain.size.map(f64::from));
    let (k, dt) = (TAU * vector / size, planned.system.run.dt);
    let rate = k.length_squared() * rule.transport(dt).kinematic();
    let steps = (1.1 / (rate * dt)).round() as u64;
    let mut planned = planned.clone();
    let mut session = rig.session(&planned, &rig.start(&planned)?)?;
    let mut values = Vec::new();
    for repetition in 0..rig.pick(12, 48) {
        planned.plan.system.run.seed = 1000 * seed + repetition;
        let mut state = rig.start(&planned)?;
        state.particles.iter_mut().for_each(|p| p.velocity += AMPLITUDE * direction * k.dot(p.position).sin());
        let (positions, velocities) = packed::pack_particles(&planned.system.domain, &state.particles);
        session.write("positions", bytemuck::cast_slice(&positions));
        session.write("velocities", bytemuck::cast_slice(&velocities));
        let before = Fluid::of(&session)?.wave(k, direction);
        advance(&mut session, steps)?;
        let after = Fluid::of(&session)?.wave(k, direction);
        values.push((before / after).ln() / (k.length_squared() * steps as f64 * dt));
    }
    sound(&session)?;
    Ok(independent(&values))
}
