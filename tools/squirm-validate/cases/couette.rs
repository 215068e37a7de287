//! Two walls shear the fluid: a straight profile, and the stress that both of them feel.

use crate::case::{Case, Control, Curve, Outcome, Part, Row, Sheet, Size, Trouble};
use crate::measure::{Fluid, counted, of_means, row, wall_impulses};
use crate::profile::Profile;
use crate::rig::{Planned, Rig, advance, sound};
use crate::rules::{self, Collision};
use glam::DVec3;
use squirm::analyze::statistics::blocked;

/// The case.
pub const CASE: Case = Case {
    name: "couette",
    title: "Couette flow",
    about: "Walls at y = 0 and y = L move along x with -U/2 and U/2, U = 0.4; 10 particles per cell, h = 0.1. With no-slip planes a \
            distance b behind the walls the velocity is straight with the slope U/(L + 2b), and the walls feel the stress \
            eta U/(L + 2b) in opposite directions. The stress is the momentum that bounces and ghosts hand to the walls per area and time; the slope is \
            fitted to bins of 0.5 a, those within 1 a of a wall left out. Expectations: eta by molecular chaos; b from an \
            independent program in f64 for the published rule and from a mean-field one with grip, and none with ghosts that continue the shear.",
    remarks: "",
    sheets: &[Sheet {
        name: "couette",
        title: "Velocity between two moving walls",
        x: "y / a",
        y: "u / sqrt(kT/m)",
        logarithmic: false,
    }],
    parts,
    controls: &[
        Control {
            name: "no-ghosts",
            about: "cells at the walls are not filled where they should be",
            part: "thermostat-continued",
            spoil: |plan| plan.stages.retain(|s| s.entry.kind != "wall-ghosts"),
        },
        Control {
            name: "one-wall-at-rest",
            about: "the high wall does not move",
            part: "thermostat-continued",
            spoil: |plan| {
                if let Some(walls) = &mut plan.system.domain.walls {
                    walls.velocity_high = [0.0; 3];
                }
            },
        },
    ],
};

/// A way to fill the walls: name, what makes a pipeline file use it, and the slip lengths in a that it leaves with SRD+a and SRD-a.
type Filling = (&'static str, &'static [&'static str], [f64; 2]);

const FILLINGS: [Filling; 3] = [
    ("continued", &["stage.wall-ghosts.velocity=continued"], [0.0; 2]),
    ("grip", &["stage.wall-ghosts.velocity=wall", "stage.rotate.grip=1.22"], [0.0, 0.045]),
    ("wall", &["stage.wall-ghosts.velocity=wall"], [0.111, 0.168]),
];

fn parts(size: Size) -> Vec<Part> {
    let part = |filling: &'static Filling, minus: bool| {
        let rule = if minus { rules::MINUS_THERMOSTAT } else { rules::THERMOSTAT };
        Part::new(format!("{}-{}", rule.name, filling.0), move |rig| {
            sheared(rig, rule, filling, filling.2[usize::from(minus)])
        })
    };
    let all = FILLINGS.iter().flat_map(|filling| [part(filling, false), part(filling, true)]);
    if size == Size::Quick { all.take(1).collect() } else { all.collect() }
}

/// What was seen of a sheared slit.
struct Seen {
    profile: Profile,
    /// Stress on the low and the high wall along x, per frame.
    stresses: Vec<[f64; 2]>,
    /// Momentum along x that appeared in fluid and walls together, per particle.
    gained: f64,
}

fn sheared(rig: &Rig, rule: Collision, &(ghosts, filling, _): &Filling, slip: f64) -> Result<Outcome, Trouble> {
    let (edge, height) = rig.pick((8, 8), (32, 20));
    let mut sets = rule.sets();
    sets.push(rules::size_set([edge, height, edge]));
    sets.extend(filling.iter().map(|s| (*s).to_owned()));
    let planned = rig.plan("couette", &sets)?;
    let seen = watch(rig, &planned, rule, slip)?;
    let domain = &planned.system.domain;
    let speed = domain.walls.as_ref().map_or(0.0, |w| w.velocity_high[0] - w.velocity_low[0]);
    let (height, eta) = (f64::from(height), rule.transport(planned.system.run.dt).viscosity);
    let stress = eta * speed / (height + 2.0 * slip);
    let setup = format!("{}, ghosts: {ghosts}, L = {height}", rule.title);
    let on = |wall: usize| {
        let sign = [1.0, -1.0][wall];
        blocked(&seen.stresses.iter().map(|s| sign * s[wall]).collect::<Vec<_>>())
    };
    let expected = (Some(stress), 0.02 * stress);
    let found = of_means(&seen.profile.lines(), |[_, slope]| speed / (2.0 * slope) - height / 2.0);
    let source = "eta U/(L + 2b), molecular chaos";
    let gained = ("momentum gained by fluid and walls per particle / sqrt(m kT)", setup.as_str());
    let rows = vec![
        row(("stress on the low wall / (kT/a^3)", &setup), on(0), expected, source),
        row(("stress on the high wall, reversed / (kT/a^3)", &setup), on(1), expected, source),
        row(
            ("slip length b / a", &setup),
            found,
            (Some(slip), if slip > 0.1 { 0.04 } else { 0.05 }),
            "independent f64 code",
        ),
        Row {
            note: "the exact figure of this run".into(),
            ..row(gained, counted(seen.gained), (Some(0.0), 1e-6), "rounding of f32")
        },
    ];
    let velocity = |y: f64| speed * (y - height / 2.0) / (height + 2.0 * slip);
    let curve = Curve {
        sheet: "couette".into(),
        name: format!("{}, ghosts: {ghosts}", rule.title),
        points: seen.profile.points(),
        guide: [0.0, height].map(|y| (y, velocity(y))).to_vec(),
        guide_name: format!("b = {slip}"),
    };
    Ok(Outcome { rows, curves: vec![curve] })
}

fn watch(rig: &Rig, planned: &Planned, rule: Collision, slip: f64) -> Result<Seen, Trouble> {
    let system = &planned.system;
    let [x, height, z] = system.domain.size;
    let speed = system.domain.walls.as_ref().map_or(0.0, |w| w.velocity_high[0] - w.velocity_low[0]);
    let length = f64::from(height);
    let mut state = rig.start(planned)?;
    state
        .particles
        .iter_mut()
        .for_each(|p| p.velocity.x += speed * (p.position.y - length / 2.0) / (length + 2.0 * slip));
    let mut session = rig.session(planned, &state)?;
    // Half a wavelength across the slit is the slowest part of what the start lacks.
    let slowest = length.powi(2) / (std::f64::consts::PI.powi(2) * rule.transport(system.run.dt).kinematic());
    let slowest = (slowest / system.run.dt).ceil() as u64;
    advance(&mut session, 4 * slowest)?;
    let mut profile = Profile::new(height);
    let every = rig.pick(25, 100);
    let frames = rig.pick(70, 160) * slowest / every;
    let (mut before, mut stresses) = (wall_impulses(&session)?, Vec::new());
    let begin = momentum(&session, before)?;
    let per = f64::from(x * z) * every as f64 * system.run.dt;
    for _ in 0..frames {
        profile.follow(&mut session, 1, every)?;
        let now = wall_impulses(&session)?;
        stresses.push([0, 1].map(|wall| (now[wall] - before[wall]).x / per));
        before = now;
    }
    sound(&session)?;
    let gained = (momentum(&session, before)? - begin).x.abs() / session.particles() as f64;
    Ok(Seen { profile, stresses, gained })
}

/// Momentum of the fluid and of what the walls have received.
fn momentum(session: &squirm::gpu::Session, walls: [DVec3; 2]) -> Result<DVec3, Trouble> {
    Ok(Fluid::of(session)?.momentum() + walls[0] + walls[1])
}
