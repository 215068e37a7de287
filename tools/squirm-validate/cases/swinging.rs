//! Swimmers that swing about the middle of a channel flow.

use crate::case::{Case, Control, Curve, Outcome, Part, Row, Sheet, Size, Trouble};
use crate::crowd::{Swimmer, swimmers, transport};
use crate::rig::{Planned, Rig, advance, sound};
use squirm::analyze::statistics::{Estimate, independent, jackknife};
use squirm::gpu::Session;
use squirm::state::{State, System, packed};

/// The case.
pub const CASE: Case = Case {
    name: "swinging",
    title: "Swinging against a channel flow",
    about: "Neutral prolate swimmers (4 along, 2 across; B1 = 0.2, h = 0.02) swim against the flow u_max (1 - y^2/H^2) between walls at \
            y = -H and H = 16, u_max = 0.2 (`pipelines/swinging.toml`). A swimmer that points upstream, tilted by psi, obeys y' = -U0 \
            sin(psi) and psi' = u_max (1 - Gamma cos(2 psi)) y/H^2 with Gamma = (r^2 - 1)/(r^2 + 1) for the aspect r (Jeffery 1922; \
            Zoettl and Stark 2012): it swings with omega = sqrt(U0 u_max (1 - Gamma))/H. One swing of 820 tau meets rotational \
            diffusion of 1/D_R = 10,000 tau: the amplitude wanders by 0.3 rad in a swing, so that omega is not read off single \
            swings but is sqrt(U a) from the two regressions dy = U e_y dt and de_y = a [y e_x (1 - Gamma + 2 Gamma \
            e_y^2)/(1 - Gamma)] dt over short times, which noise does not bias and which hold at any angle; readings nearer to a wall than \
            0.35 H are left out. U and a, in units of U0 and u_max (1 - Gamma)/H^2, are reported as well. Eight swimmers, 20 a apart, \
            start in the middle at psi = +-0.4, twice; errors by jackknife over stretches of half a swing. The theory knows no \
            walls, and the viscosity in u_max = gamma g H^2/(2 eta) is the measured one. Reynolds number 0.37, Peclet number 220. \
            The quick part is a narrow channel with strong slip and tells little more than the sign.",
    remarks: "",
    sheets: &[
        Sheet {
            name: "swinging-position",
            title: "Mean distance from the middle (toward the wall first swum to)",
            x: "time / tau",
            y: "y / H",
            logarithmic: false,
        },
        Sheet {
            name: "swinging-axis",
            title: "Mean component of the axis across the channel",
            x: "time / tau",
            y: "e_y",
            logarithmic: false,
        },
    ],
    parts,
    controls: &[Control {
        name: "reversed-flow",
        about: "the fluid is driven the other way, so that the swimmers point downstream",
        part: "neutral",
        spoil: |plan| {
            for g in &mut plan.system.fluid.acceleration {
                *g = -*g;
            }
        },
    }],
};

/// Readings in a unit of 1/omega, and readings over which an increment is taken: over 0.1/omega sines are straight lines to 0.2 %.
const READINGS: f64 = 50.0;
const LAG: usize = 5;

/// Largest distance from the middle at which a reading counts, in H.
const FREE: f64 = 0.65;

/// Stretches into which the path of a swimmer is cut for the jackknife.
const STRETCHES: usize = 4;

/// Viscosity at h = 0.02 and 10 particles per cell, by an independent code in f64; the formula gives 5 % more.
const VISCOSITY: f64 = 17.7;

fn parts(_: Size) -> Vec<Part> {
    let part = Part::new("neutral", |rig| {
        let sets = rig.pick(narrow(), Vec::new());
        let planned = rig.plan("../swinging", &sets)?;
        let theory = Theory::of(&planned.system);
        let paths = swim(rig, &planned, &theory)?;
        Ok(outcome(&planned.system, &theory, &paths))
    });
    vec![part.long()]
}

/// Three small swimmers with strong slip in a narrow channel at h = 0.1: u_max = 0.3 from 2 eta u_max/(gamma H^2).
fn narrow() -> Vec<String> {
    let poses = "[[5,8,5,-0.92106,0.38942,0],[15,8,5,-0.92106,-0.38942,0],[25,8,5,-0.92106,0.38942,0]]";
    let sets = [
        "run.dt=0.1",
        "box.size=[30,16,10]",
        "fluid.acceleration=[3.971e-3,0,0]",
        "squirmers.swimmer.count=3",
        "squirmers.swimmer.semi_axes={along=3.0,across=1.5}",
        "squirmers.swimmer.b1=0.3",
        &format!("squirmers.swimmer.poses={poses}"),
    ];
    sets.map(str::to_owned).to_vec()
}

/// The point model: y' = U e_y, e_y' = a y e_x (1 - Gamma + 2 Gamma e_y^2)/(1 - Gamma), x along the flow.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Theory {
    /// Half width H of the channel, in a.
    half: f64,
    /// Swim speed U0.
    speed: f64,
    /// a = u_max (1 - Gamma)/H^2, in 1/(a tau).
    turning: f64,
    /// Gamma, 0 for a sphere.
    shape: f64,
}

impl Theory {
    fn of(system: &System) -> Self {
        let species = &system.species[0];
        let aspect2 = (species.semi_axes.along / species.semi_axes.across).powi(2);
        let shape = (aspect2 - 1.0) / (aspect2 + 1.0);
        let force = system.fluid.density * system.fluid.acceleration[0];
        Self {
            half: f64::from(system.domain.size[1]) / 2.0,
            speed: species.spheroid().swim_speed(species.b1),
            turning: force / (2.0 * viscosity(system)) * (1.0 - shape),
            shape,
        }
    }

    fn frequency(&self) -> f64 {
        (self.speed * self.turning).sqrt()
    }

    /// What a multiplies in e_y'.
    fn lever(&self, r: &Reading) -> f64 {
        r.y * r.along * (1.0 + 2.0 * self.shape / (1.0 - self.shape) * r.across * r.across)
    }

    /// y and e_y at multiples of `interval`, of a swimmer that starts in the middle and points upstream but for `tilt` = e_y.
    fn path(&self, tilt: f64, interval: f64, readings: usize) -> Vec<Reading> {
        let substeps = 20;
        let dt = interval / f64::from(substeps);
        // e_x = -cos psi, e_y = -sin psi.
        let (mut y, mut psi) = (0.0, -tilt.asin());
        let mut path = Vec::new();
        for _ in 0..readings {
            path.push(Reading { y, along: -f64::cos(psi), across: -f64::sin(psi) });
            for _ in 0..substeps {
                // Leapfrog: the model has a conserved energy, and keeps it.
                y -= 0.5 * dt * self.speed * psi.sin();
                psi += dt * self.turning * y * (1.0 - self.shape * (2.0 * psi).cos()) / (1.0 - self.shape);
                y -= 0.5 * dt * self.speed * psi.sin();
            }
        }
        path
    }
}

fn viscosity(system: &System) -> f64 {
    if system.run.dt < 0.03 { VISCOSITY } else { transport(system).viscosity }
}

/// A swimmer at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Reading {
    /// Distance from the middle, in a.
    y: f64,
    /// e_x, along the flow.
    along: f64,
    /// e_y, across the channel.
    across: f64,
}

impl Reading {
    fn of(swimmer: &Swimmer, half: f64) -> Self {
        let e = swimmer.body.axis;
        Self { y: swimmer.position.y - half, along: e.x, across: e.y }
    }
}

/// Steps between two readings.
fn interval(theory: &Theory, dt: f64) -> u64 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let steps = (1.0 / (READINGS * theory.frequency() * dt)).round() as u64;
    steps.max(1)
}

/// The path of every swimmer, from the same start again and again.
fn swim(rig: &Rig, planned: &Planned, theory: &Theory) -> Result<Vec<Vec<Reading>>, Trouble> {
    let start = driven(&planned.plan.system, rig.start(planned)?);
    let mut session = rig.session(planned, &start)?;
    let every = interval(theory, planned.system.run.dt);
    let mut paths = Vec::new();
    for _ in 0..2 {
        // The random numbers depend on the step: the same start goes another way each time.
        put_back(&session, &start);
        let mut now: Vec<Vec<Reading>> = vec![Vec::new(); start.squirmers.len()];
        for reading in 0..rig.pick(2500, 80_000) / every {
            if reading > 0 {
                advance(&mut session, every)?;
            }
            let swimmers = swimmers(&session)?;
            now.iter_mut().zip(&swimmers).for_each(|(path, s)| path.push(Reading::of(s, theory.half)));
        }
        paths.extend(now);
    }
    sound(&session)?;
    Ok(paths)
}

/// The start with the developed flow laid over it, of which the body force is part of what is run.
fn driven(system: &System, mut start: State) -> State {
    let half = f64::from(system.domain.size[1]) / 2.0;
    let curvature = system.fluid.density * system.fluid.acceleration[0] / (2.0 * viscosity(system));
    let flow = |y: f64| curvature * (half * half - (y - half).powi(2));
    start.particles.iter_mut().for_each(|p| p.velocity.x += flow(p.position.y));
    start.squirmers.iter_mut().for_each(|s| s.velocity.x += flow(s.position.y));
    start
}

fn put_back(session: &Session, start: &State) {
    let system = session.system();
    session.write_particles(&start.particles);
    session.write("squirmers", bytemuck::cast_slice(&packed::pack_squirmers(system, &start.squirmers)));
}

/// Sums of two regressions of an increment on two variables each.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    position: Normal,
    axis: Normal,
}

/// Normal equations of z = p x + q y.
#[derive(Debug, Clone, Copy, Default)]
struct Normal {
    xx: f64,
    xy: f64,
    yy: f64,
    xz: f64,
    yz: f64,
}

impl Normal {
    fn add(&mut self, x: f64, y: f64, z: f64) {
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
        self.xz += x * z;
        self.yz += y * z;
    }

    fn join(&mut self, other: &Self) {
        self.xx += other.xx;
        self.xy += other.xy;
        self.yy += other.yy;
        self.xz += other.xz;
        self.yz += other.yz;
    }

    /// p; 0 where nothing is known of it.
    fn first(&self) -> f64 {
        let determinant = self.xx * self.yy - self.xy * self.xy;
        if determinant > 0.0 { (self.xz * self.yy - self.yz * self.xy) / determinant } else { 0.0 }
    }
}

/// Sums over the increments that begin in one stretch of a path. The second variable takes up what noise and the curvature of a
/// swing add in proportion to the changing quantity itself.
fn sums(theory: &Theory, path: &[Reading], range: std::ops::Range<usize>) -> Sums {
    let mut sums = Sums::default();
    for (now, then) in path.iter().zip(path.iter().skip(LAG)).take(range.end).skip(range.start) {
        if now.y.abs() < FREE * theory.half {
            sums.position.add(now.across, now.y, then.y - now.y);
            sums.axis.add(theory.lever(now), now.across, then.across - now.across);
        }
    }
    sums
}

/// Swim speed U, a, and the frequency sqrt(U a), negative if their product is; `interval` in tau.
fn fit(theory: &Theory, paths: &[Vec<Reading>], interval: f64) -> [Estimate; 3] {
    let mut stretches = Vec::new();
    for path in paths {
        let cut = |k: usize| k * path.len() / STRETCHES;
        stretches.extend((0..STRETCHES).map(|k| sums(theory, path, cut(k)..cut(k + 1))));
    }
    let lag = LAG as f64 * interval;
    let of = |kept: &dyn Fn(usize) -> bool| {
        let mut total = Sums::default();
        for (_, s) in stretches.iter().enumerate().filter(|(i, _)| kept(*i)) {
            total.position.join(&s.position);
            total.axis.join(&s.axis);
        }
        let (speed, turning) = (total.position.first() / lag, total.axis.first() / lag);
        let product = speed * turning;
        [speed, turning, product.abs().sqrt().copysign(product)]
    };
    let means = of(&|_| true);
    let n = stretches.len();
    [0, 1, 2].map(|k| Estimate { mean: means[k], error: jackknife(n, n, |kept| of(kept)[k]) })
}

fn outcome(system: &System, theory: &Theory, paths: &[Vec<Reading>]) -> Outcome {
    let interval = interval(theory, system.run.dt) as f64 * system.run.dt;
    let [speed, turning, frequency] = fit(theory, paths, interval);
    let fastest = theory.turning * theory.half.powi(2) / (1.0 - theory.shape);
    let axes = &system.species[0].semi_axes;
    let setup = format!(
        "{} along, {} across, H = {}, U0 = {:.3}, u_max = {fastest:.2}, {} swimmers",
        axes.along,
        axes.across,
        theory.half,
        theory.speed,
        paths.len()
    );
    let row = |quantity: &str, found: Estimate, unit: f64, expected: Option<f64>| Row {
        quantity: quantity.into(),
        setup: setup.clone(),
        measured: found.mean / unit,
        error: found.error / unit,
        expected,
        tolerance: expected.map_or(0.0, |e| 0.1 * e),
        source: "Zoettl and Stark 2012; Jeffery 1922".into(),
        note: String::new(),
    };
    let rows = vec![
        row("omega tau", frequency, 1.0, Some(theory.frequency())),
        row("U / U0", speed, theory.speed, None),
        row("a / (u_max (1 - Gamma)/H^2)", turning, theory.turning, None),
    ];
    let readings = paths.iter().map(Vec::len).min().unwrap_or(0);
    let tilt = paths[0][0].across.abs();
    let guide = theory.path(tilt, interval, readings);
    let curve = |sheet: &str, value: &dyn Fn(&Reading) -> f64| Curve {
        sheet: sheet.into(),
        name: format!("mean of {} swimmers", paths.len()),
        points: mean_path(paths, readings, interval, value),
        guide: guide.iter().enumerate().map(|(k, r)| (k as f64 * interval, value(r))).collect(),
        guide_name: "point model without noise".into(),
    };
    let curves = vec![curve("swinging-position", &|r| r.y / theory.half), curve("swinging-axis", &|r| r.across)];
    Outcome { rows, curves }
}

/// About 60 points of the mean over swimmers, those that start toward the low wall mirrored.
fn mean_path(
    paths: &[Vec<Reading>],
    readings: usize,
    interval: f64,
    value: &dyn Fn(&Reading) -> f64,
) -> Vec<(f64, f64, f64)> {
    let at = |k: usize| {
        let values: Vec<f64> = paths.iter().map(|path| path[0].across.signum() * value(&path[k])).collect();
        let found = independent(&values);
        (k as f64 * interval, found.mean, if found.error.is_finite() { found.error } else { 0.0 })
    };
    (0..readings).step_by((readings / 60).max(1)).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const THEORY: Theory = Theory { half: 16.0, speed: 0.165, turning: 3.1e-4, shape: 0.6 };

    fn interval_of(theory: &Theory) -> f64 {
        1.0 / (READINGS * theory.frequency())
    }

    #[test]
    fn small_swings_have_the_frequency_of_the_formula() {
        let interval = interval_of(&THEORY);
        let path = THEORY.path(0.01, interval, 800);
        let crossings: Vec<f64> = path
            .windows(2)
            .enumerate()
            .filter(|(k, w)| *k > 0 && w[0].y * w[1].y < 0.0)
            .map(|(k, w)| (k as f64 + w[0].y / (w[0].y - w[1].y)) * interval)
            .collect();
        let half_period = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
        assert!((half_period * THEORY.frequency() / std::f64::consts::PI - 1.0).abs() < 1e-3, "{half_period}");
    }

    /// Without noise only the finite lag remains, (omega lag)^2/6 = 0.17 %.
    #[test]
    fn large_swings_are_fitted_with_the_frequency_of_small_ones() {
        let interval = interval_of(&THEORY);
        let paths: Vec<Vec<Reading>> = [0.3, -0.5].map(|tilt| THEORY.path(tilt, interval, 600)).to_vec();
        let [speed, turning, frequency] = fit(&THEORY, &paths, interval);
        assert!((speed.mean / THEORY.speed - 1.0).abs() < 0.005, "{speed:?}");
        assert!((turning.mean / THEORY.turning - 1.0).abs() < 0.01, "{turning:?}");
        assert!((frequency.mean / THEORY.frequency() - 1.0).abs() < 0.005, "{frequency:?}");
    }

    /// A swimmer in space that diffuses: angle by 1e-4, position by 1e-3, from uniform random numbers of Lehmer's generator.
    fn noisy(seed: u64, interval: f64, readings: usize) -> Vec<Reading> {
        let mut state = seed;
        let mut kick = move |diffusion: f64, dt: f64| {
            state = state * 48_271 % 2_147_483_647;
            (state as f64 / 2_147_483_647.0 - 0.5) * (24.0 * diffusion * dt).sqrt()
        };
        let dt = interval / 10.0;
        let (mut y, mut e) = (0.0, glam::DVec3::new(-0.92, 0.39, 0.0));
        let mut path = Vec::new();
        for _ in 0..readings {
            path.push(Reading { y, along: e.x, across: e.y });
            for _ in 0..10 {
                y = (y + THEORY.speed * e.y * dt + kick(1e-3, dt)).clamp(-14.0, 14.0);
                // Jeffery in a flow along x that changes along y at the rate s.
                let s = -2.0 * THEORY.turning / (1.0 - THEORY.shape) * y;
                let strain = 0.5 * s * glam::DVec3::new(e.y, e.x, 0.0);
                let turn = 0.5 * s * glam::DVec3::new(e.y, -e.x, 0.0);
                let random = glam::DVec3::new(kick(1e-4, dt), kick(1e-4, dt), kick(1e-4, dt));
                e += (turn + THEORY.shape * (strain - e * e.dot(strain))) * dt + random.cross(e);
                e = e.normalize();
            }
        }
        path
    }

    /// Lasting noise and turns in all three dimensions: the fit must be right within its own errors, which must be useful.
    #[test]
    fn noise_does_not_bias_the_fit() {
        let interval = interval_of(&THEORY);
        let paths: Vec<Vec<Reading>> = (1..=48).map(|seed| noisy(seed * 7_919, interval, 600)).collect();
        let found = fit(&THEORY, &paths, interval);
        for (found, known) in found.iter().zip([THEORY.speed, THEORY.turning, THEORY.frequency()]) {
            assert!(found.error < 0.03 * known, "{found:?} for {known}");
            assert!((found.mean - known).abs() < 4.0 * found.error + 0.004 * known, "{found:?} for {known}");
        }
        println!("{found:?}");
    }

    #[test]
    fn the_other_direction_has_the_other_sign() {
        let interval = interval_of(&THEORY);
        let path = THEORY.path(0.3, interval, 300);
        let mirrored: Vec<Reading> = path.iter().map(|r| Reading { along: -r.along, ..*r }).collect();
        assert!(fit(&THEORY, &[mirrored], interval)[2].mean < -0.9 * THEORY.frequency());
    }
}
