//! Diffusion of passive spheres and spheroids.

use crate::bodies::{Tracks, isotropic, periodic};
use crate::case::{Case, Control, Curve, Outcome, Part, Row, Sheet, Size, Trouble};
use crate::periodic::{Mobility, PeriodicBody};
use crate::rig::{Planned, Rig, advance};
use crate::rules::{self, viscosity};
use squirm::analyze::statistics::{Estimate, blocked};

/// The case.
pub const CASE: Case = Case {
    name: "body-diffusion",
    title: "Diffusion of passive bodies",
    about: "Passive spheres and spheroids at h = 0.1 and 10 particles per cell (eta = 4.25, measured) in a periodic cube, a few of \
            them at once so that there is enough to average: 2 to 3 % of the volume. D is half the growth of the mean squared \
            displacement, in the frame of the body, between two lags; D_R the same of the accumulated rotation. Expected is \
            Perrin's friction (1934) with the correction \
            of Hasimoto (1959) for the periodic images; less what the neighbours' stresslets have taken at these lags (Batchelor 1976), 1 to 3 %, for it takes the vorticity r^2/nu to go \
            there, and as long to come back; \
            less what the memory of the fluid still owes at these lags (Alder and Wainwright 1970, as a sum over the modes of \
            the box), 5 to 20 %.",
    remarks: "Four prolate bodies of 3 x 6 in 32^3 diffuse 7(2) % faster than expected, 8(2) % across their axis; one alone in 36^3 does not \
              (3(2) and 1(2) %), nor do the other shapes. So it is not the bodies' own surface but what bodies 12 a long do to each other at 16 a, which \
              stresslets of spheres in an unbounded fluid do not tell. Taken as at long times, these stresslets had made every expectation too low: 3 % for \
              spheres, 4 % for the oblate bodies. The rotation of the single body about its axis has too large an error (2.5 %, where 2.3 % is wanted).",
    sheets: &[
        Sheet {
            name: "body-diffusion",
            title: "Diffusion of passive bodies",
            x: "lag / tau",
            y: "D(t) / D(theory, long times)",
            logarithmic: false,
        },
        Sheet {
            name: "body-rotation",
            title: "Rotational diffusion of passive bodies",
            x: "lag / tau",
            y: "D_R(t) / D_R(theory, long times)",
            logarithmic: false,
        },
    ],
    parts,
    controls: &[Control {
        name: "no-angular-momentum",
        about: "the fluid of SRD-a, twice as viscous, where SRD+a is meant",
        part: "sphere-2",
        spoil: rules::without_angular_momentum,
    }],
};

/// Bodies of one shape, and between which lags they are looked at.
#[derive(Debug, Clone, Copy)]
struct Setup {
    name: &'static str,
    across: f64,
    along: f64,
    count: u32,
    edge: u32,
    steps: u64,
    /// Lags for displacements in tau: from where R^2/nu is over, to where errors have grown enough.
    displaced: (f64, f64),
    /// Lags for rotations, whose memory is shorter.
    turned: (f64, f64),
    /// Relative, of translation; larger where a quick run has too little to average.
    tolerance: f64,
}

const QUICK: [Setup; 1] = [Setup {
    name: "sphere-2",
    across: 2.0,
    along: 2.0,
    count: 2,
    edge: 12,
    steps: 6000,
    displaced: (12.0, 24.0),
    turned: (6.0, 14.0),
    tolerance: 0.15,
}];

/// For one direction and a run of the length T with n bodies, the relative error is sqrt(2 (2 from + (2/3)(to - from))/(n T)): the
/// variance of a spectral density at zero frequency, seen through a window of these lags.
const FULL: [Setup; 5] = [
    Setup {
        name: "sphere-3",
        across: 3.0,
        along: 3.0,
        count: 8,
        edge: 32,
        steps: 200_000,
        displaced: (30.0, 60.0),
        turned: (20.0, 40.0),
        tolerance: 0.07,
    },
    Setup {
        name: "prolate-3-6",
        across: 3.0,
        along: 6.0,
        count: 4,
        edge: 32,
        steps: 700_000,
        displaced: (30.0, 60.0),
        turned: (16.0, 36.0),
        tolerance: 0.07,
    },
    Setup {
        name: "prolate-3-6-alone",
        across: 3.0,
        along: 6.0,
        count: 1,
        edge: 36,
        steps: 1_600_000,
        displaced: (30.0, 60.0),
        turned: (16.0, 36.0),
        tolerance: 0.07,
    },
    Setup {
        name: "prolate-2-6",
        across: 2.0,
        along: 6.0,
        count: 8,
        edge: 32,
        steps: 300_000,
        displaced: (30.0, 60.0),
        turned: (16.0, 36.0),
        tolerance: 0.07,
    },
    Setup {
        name: "oblate-6-3",
        across: 6.0,
        along: 3.0,
        count: 6,
        edge: 40,
        steps: 650_000,
        displaced: (50.0, 100.0),
        turned: (30.0, 70.0),
        tolerance: 0.07,
    },
];

fn parts(size: Size) -> Vec<Part> {
    let setups: &[Setup] = match size {
        Size::Quick => &QUICK,
        Size::Full => &FULL,
    };
    setups.iter().map(|setup| Part::new(setup.name, move |rig| measure(rig, setup))).collect()
}

fn measure(rig: &Rig, setup: &Setup) -> Result<Outcome, Trouble> {
    let edge = setup.edge;
    let sets = [
        format!("box.size=[{edge},{edge},{edge}]"),
        format!("squirmers.body.count={}", setup.count),
        format!("squirmers.body.semi_axes={{along={:?},across={:?}}}", setup.along, setup.across),
    ];
    let planned = rig.plan("passive-bodies", &sets)?;
    let mut session = rig.session(&planned, &rig.start(&planned)?)?;
    advance(&mut session, rig.pick(300, 3000))?;
    let tracks = Tracks::follow(&mut session, setup.steps, 20)?;
    Ok(Found::new(setup, &planned, &tracks).outcome(&tracks))
}

/// Theory and measurement of one run.
struct Found<'a> {
    setup: &'a Setup,
    system: String,
    theory: PeriodicBody,
    hindrance: f64,
}

impl<'a> Found<'a> {
    fn new(setup: &'a Setup, planned: &Planned, tracks: &Tracks) -> Self {
        let system = &planned.system;
        let shape = system.species[0].spheroid();
        let theory = periodic(system);
        let percent = 100.0 * f64::from(setup.count) * shape.volume() / system.domain.volume();
        Self {
            setup,
            system: format!(
                "{}, {} in {}^3 ({percent:.1} %), h = {}, eta = {:.3}",
                setup.name,
                setup.count,
                setup.edge,
                system.run.dt,
                viscosity(system)
            ),
            hindrance: theory.hindrance(&tracks.neighbours, setup.displaced),
            theory,
        }
    }

    /// At these lags: along, across, spin, tumble.
    fn expected(&self, body: &PeriodicBody) -> Mobility {
        let m = body.mobility();
        let (along, across) = body.missing_translation(self.setup.displaced);
        let rotation = body.missing_rotation(self.setup.turned);
        Mobility {
            along: m.along - self.hindrance - along,
            across: m.across - self.hindrance - across,
            spin: m.spin - rotation,
            tumble: m.tumble - rotation,
        }
    }

    fn outcome(&self, tracks: &Tracks) -> Outcome {
        let (displaced, turned) = (tracks.growth(self.setup.displaced), tracks.growth(self.setup.turned));
        let here = self.expected(&self.theory);
        let mut rows = Vec::new();
        let mut row = |name: &str, found: Estimate, expected: f64, lags, tolerance: f64| {
            rows.push(self.row(name, found, expected, lags, tolerance));
        };
        let tolerance = self.setup.tolerance;
        let (d, r) = (self.setup.displaced, self.setup.turned);
        let average = isotropic(&displaced.along, &displaced.across);
        row("D", average, mean(here.along, here.across), d, tolerance);
        if self.setup.along == self.setup.across {
            let average = isotropic(&turned.spin, &turned.tumble);
            row("D_R", average, mean(here.spin, here.tumble), r, 0.07);
        } else {
            // One direction has more noise than two.
            row("D_par", blocked(&displaced.along), here.along, d, 0.1);
            row("D_perp", blocked(&displaced.across), here.across, d, tolerance);
            row("D_R,par", blocked(&turned.spin), here.spin, r, 0.07);
            row("D_R,perp", blocked(&turned.tumble), here.tumble, r, 0.07);
        }
        Outcome { rows, curves: self.curves(tracks) }
    }

    fn row(&self, name: &str, found: Estimate, expected: f64, (from, to): (f64, f64), tolerance: f64) -> Row {
        let unit = if name.starts_with("D_R") { "1/tau" } else { "a^2/tau" };
        Row {
            quantity: format!("{name} / ({unit}), lags {from} to {to}"),
            setup: self.system.clone(),
            measured: found.mean,
            error: found.error,
            expected: Some(expected),
            tolerance: tolerance * expected,
            source: "Perrin, Hasimoto, memory".into(),
            note: String::new(),
        }
    }

    /// D(t) in steps of a few lags, over its final value, and how theory approaches that.
    fn curves(&self, tracks: &Tracks) -> Vec<Curve> {
        let m = self.theory.mobility();
        let stretch = |sheet: &str, part: &str, end: f64, at: &dyn Fn((f64, f64)) -> (f64, Estimate)| {
            let width = end / 10.0;
            let lags: Vec<(f64, f64)> = (0..10).map(|k| (width * f64::from(k), width * f64::from(k + 1))).collect();
            let middle = |l: &(f64, f64)| f64::midpoint(l.0, l.1);
            let values: Vec<(f64, f64, Estimate)> =
                lags.iter().map(|l| (middle(l), at(*l))).map(|(t, (g, e))| (t, g, e)).collect();
            Curve {
                sheet: sheet.into(),
                name: format!("{} {part}", self.setup.name),
                points: values.iter().map(|(t, _, e)| (*t, e.mean, e.error)).collect(),
                // The first modes of the sum describe the flow once it is larger than the body.
                guide: values.iter().skip(3).map(|(t, g, _)| (*t, *g)).collect(),
                guide_name: "theory".into(),
            }
        };
        let scaled = |e: Estimate, d: f64| Estimate { mean: e.mean / d, error: e.error / d };
        let d = mean(m.along, m.across) - self.theory.long_hindrance(&tracks.neighbours);
        let r = mean(m.spin, m.tumble);
        let translation = |l: (f64, f64)| {
            let g = tracks.growth(l);
            let late = self.theory.long_hindrance(&tracks.neighbours) - self.theory.hindrance(&tracks.neighbours, l);
            let (along, across) = self.theory.missing_translation(l);
            (1.0 + (late - mean(along, across)) / d, scaled(isotropic(&g.along, &g.across), d))
        };
        let spin = |l: (f64, f64)| {
            let g = tracks.growth(l);
            let owed = self.theory.missing_rotation(l);
            if self.setup.along == self.setup.across {
                (1.0 - owed / r, scaled(isotropic(&g.spin, &g.tumble), r))
            } else {
                (1.0 - owed / m.spin, scaled(blocked(&g.spin), m.spin))
            }
        };
        let tumble = |l: (f64, f64)| {
            let g = tracks.growth(l);
            (1.0 - self.theory.missing_rotation(l) / m.tumble, scaled(blocked(&g.tumble), m.tumble))
        };
        let (far, turned) = (2.0 * self.setup.displaced.1, 2.0 * self.setup.turned.1);
        let mut curves = vec![stretch("body-diffusion", "", far, &translation)];
        if self.setup.along == self.setup.across {
            curves.push(stretch("body-rotation", "", turned, &spin));
        } else {
            curves.push(stretch("body-rotation", "about e", turned, &spin));
            curves.push(stretch("body-rotation", "across e", turned, &tumble));
        }
        curves
    }
}

/// Over three directions, of which two are across.
fn mean(along: f64, across: f64) -> f64 {
    (along + 2.0 * across) / 3.0
}
