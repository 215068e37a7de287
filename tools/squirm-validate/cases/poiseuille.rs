//! Flow that a body force drives between two walls: viscosity and slip length from the parabola.

use crate::case::{Case, Control, Curve, Outcome, Part, Sheet, Size, Trouble};
use crate::measure::{of_means, row};
use crate::profile::Profile;
use crate::rig::{Planned, Rig, advance, sound};
use crate::rules::{self, Collision};
use squirm::graph::Plan;
use squirm::math::transport::Transport;
use squirm::state::State;

/// The case.
pub const CASE: Case = Case {
    name: "poiseuille",
    title: "Poiseuille flow",
    about: "A body force g along x drives the fluid, 10 particles per cell, h = 0.1, between walls at y = 0 and y = L; with no-slip \
            planes a distance b behind the walls the velocity is u = gamma g ((L/2 + b)^2 - (y - L/2)^2)/(2 eta). A parabola with free edges is fitted to each \
            frame in bins of 0.5 a, those within 1 a of a wall left out; its curvature gives eta, its zeros give b. \
            Expectations: eta by molecular chaos; b from an independent program in f64 (planar Couette flow) for the published rule and from a mean-field one with grip, and none with ghosts that continue the shear. The \
            flow begins developed. Its slowest fluctuation has the amplitude sqrt(2/N) and lives L^2/(pi^2 nu), 215 tau for \
            SRD+a and L = 30.",
    remarks: "The slip lengths for ghosts at the wall's velocity and without ghosts are those of an independent code in f64 (planar Couette \
              flow between walls 16 a apart): 0.111(9) and 0.370(12) a with SRD+a, 0.168(8) and 0.970(11) a with SRD-a. A mean-field model of \
              tracers (examples/slip_length.rs) gives 0.097, 0.53, 0.158 and 1.06: it knows nothing of how few particles share a \
              cell at a bare wall. Bare walls leave SRD-a 0.927(9) a here, 0.003 a too little: the fit finds the wall 16 a from where the flow is fastest, so that \
              a curvature that is larger by 1 % takes 0.08 a off the slip length. Here it is larger by 0.5(2) %; with the expected one the slip length is 0.97.",
    sheets: &[Sheet {
        name: "poiseuille",
        title: "Velocity between two walls, driven by a body force",
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
            spoil: without_ghosts,
        },
        Control {
            name: "no-angular-momentum",
            about: "SRD-a is run where SRD+a is meant",
            part: "thermostat-continued",
            spoil: rules::without_angular_momentum,
        },
    ],
};

fn without_ghosts(plan: &mut Plan) {
    plan.stages.retain(|s| s.entry.kind != "wall-ghosts");
}

/// What fills the parts of cells that lie in a wall.
#[derive(Clone, Copy)]
struct Filling {
    /// In names of parts.
    name: &'static str,
    /// In the report.
    title: &'static str,
    /// Rule of collision.
    rule: Collision,
    /// Laid over the pipeline file.
    sets: &'static [&'static str],
    /// What no parameter can say.
    change: fn(&mut Plan),
    /// Slip length in a.
    slip: f64,
    /// How well it is known, in a.
    tolerance: f64,
}

const CONTINUED: Filling = Filling {
    name: "continued",
    title: "ghosts that continue the shear",
    rule: rules::THERMOSTAT,
    sets: &["stage.wall-ghosts.velocity=continued"],
    change: |_| {},
    slip: 0.0,
    tolerance: 0.05,
};

const GRIP: Filling = Filling {
    name: "grip",
    title: "ghosts of the wall's velocity, with grip",
    sets: &["stage.wall-ghosts.velocity=wall", "stage.rotate.grip=1.22"],
    ..CONTINUED
};

const WALL: Filling = Filling {
    name: "wall",
    title: "ghosts of the wall's velocity",
    sets: &["stage.wall-ghosts.velocity=wall"],
    slip: 0.111,
    tolerance: 0.04,
    ..CONTINUED
};

const NONE: Filling =
    Filling { name: "none", title: "no ghosts", sets: &[], change: without_ghosts, slip: 0.37, ..WALL };

/// Every way to fill a wall, with the slip length that it should leave. The first one is what a quick run measures.
const FILLINGS: &[Filling] = &[
    CONTINUED,
    Filling { rule: rules::MINUS_THERMOSTAT, ..CONTINUED },
    GRIP,
    Filling { rule: rules::MINUS_THERMOSTAT, slip: 0.045, ..GRIP },
    WALL,
    Filling { rule: rules::MINUS_THERMOSTAT, slip: 0.168, ..WALL },
    NONE,
    Filling { rule: rules::MINUS_THERMOSTAT, slip: 0.97, ..NONE },
];

fn parts(size: Size) -> Vec<Part> {
    let count = if size == Size::Quick { 1 } else { FILLINGS.len() };
    let part = |f: &'static Filling| Part::new(format!("{}-{}", f.rule.name, f.name), move |rig| channel(rig, f));
    FILLINGS[..count].iter().map(part).collect()
}

/// A driven slit.
struct Channel {
    planned: Planned,
    theory: Transport,
    /// Distance of the walls, a.
    height: f64,
    /// Body acceleration along x, a/tau^2.
    acceleration: f64,
    /// Slip length meant, a.
    slip: f64,
}

impl Channel {
    /// Velocity at a height above the low wall, with the slip length that is expected.
    fn velocity(&self, y: f64) -> f64 {
        let (half, x) = (self.height / 2.0, y - self.height / 2.0);
        10.0 * self.acceleration / (2.0 * self.theory.viscosity) * ((half + self.slip).powi(2) - x * x)
    }

    /// Life of the slowest fluctuation of the flow, in steps.
    fn slowest(&self) -> u64 {
        let time = self.height.powi(2) / (std::f64::consts::PI.powi(2) * self.theory.kinematic());
        (time / self.planned.system.run.dt).ceil() as u64
    }
}

fn plan(rig: &Rig, filling: &Filling) -> Result<Channel, Trouble> {
    let (edge, height, top) = rig.pick((8, 12, 0.3), (32, 30, 0.2));
    let theory = filling.rule.transport(0.1);
    let height_squared = f64::from(height * height);
    let acceleration = 8.0 * theory.viscosity * top / (10.0 * height_squared);
    let mut sets = filling.rule.sets();
    sets.push(rules::size_set([edge, height, edge]));
    sets.push(format!("fluid.acceleration=[{acceleration:.9},0.0,0.0]"));
    sets.extend(filling.sets.iter().map(|s| (*s).to_owned()));
    let mut planned = rig.plan("poiseuille", &sets)?;
    (filling.change)(&mut planned.plan);
    let acceleration = planned.system.fluid.acceleration[0];
    Ok(Channel { planned, theory, height: height.into(), acceleration, slip: filling.slip })
}

fn channel(rig: &Rig, filling: &Filling) -> Result<Outcome, Trouble> {
    let channel = plan(rig, filling)?;
    let mut state: State = rig.start(&channel.planned)?;
    state.particles.iter_mut().for_each(|p| p.velocity.x += channel.velocity(p.position.y));
    let mut session = rig.session(&channel.planned, &state)?;
    // What the flow of the start lacks has time to come: half of it is gone after ln 2 lives of the slowest part.
    advance(&mut session, 2 * channel.slowest())?;
    let mut profile = Profile::new(channel.planned.system.domain.size[1]);
    // As many lives for either rule: equal errors. A long slip length lies further from where the fluid is. Of few lives blocks do not tell how
    // long the slowest part of the flow remembers: of forty quick runs of 18 the velocity in the middle scattered twice as much as each said.
    let every = rig.pick(25, 100);
    let lives = rig.pick(60, if filling.slip > 0.3 { 150 } else { 50 });
    let frames = usize::try_from(lives * channel.slowest() / every)?;
    profile.follow(&mut session, frames, every)?;
    sound(&session)?;
    Ok(outcome(&channel, filling, &profile))
}

fn outcome(channel: &Channel, filling: &Filling, profile: &Profile) -> Outcome {
    let (g, half, eta) = (channel.acceleration, channel.height / 2.0, channel.theory.viscosity);
    let fits = profile.parabolas();
    let viscosity = of_means(&fits, |[_, c]| -10.0 * g / (2.0 * c));
    let slip = of_means(&fits, |[top, c]| (-top / c).abs().sqrt() - half);
    let top = of_means(&fits, |[top, _]| *top);
    let setup = format!("{}, {}, L = {}", filling.rule.title, filling.title, channel.height);
    let fastest = channel.velocity(half);
    let rows = vec![
        row(("eta / (sqrt(m kT)/a^2)", &setup), viscosity, (Some(eta), 0.02 * eta), "molecular chaos"),
        row(("slip length b / a", &setup), slip, (Some(filling.slip), filling.tolerance), "independent f64 code"),
        row(
            ("u in the middle / sqrt(kT/m)", &setup),
            top,
            (Some(fastest), 0.02 * fastest),
            "parabola with that eta and b",
        ),
    ];
    let guide = |k: u32| {
        let y = channel.height * f64::from(k) / 60.0;
        (y, channel.velocity(y))
    };
    let curve = Curve {
        sheet: "poiseuille".into(),
        name: format!("{}, {}", filling.rule.title, filling.title),
        points: profile.points(),
        guide: (0..=60).map(guide).collect(),
        guide_name: format!("b = {}", filling.slip),
    };
    Outcome { rows, curves: vec![curve] }
}
