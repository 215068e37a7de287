//! The fluid at rest: velocities after Maxwell and Boltzmann, numbers after Poisson, and both up to a wall.

use crate::case::{Case, Control, Curve, Outcome, Part, Sheet, Size, Trouble};
use crate::measure::{Fluid, of_means, row, temper};
use crate::rig::{Rig, advance, sound};
use crate::rules::{self, Collision};
use glam::DVec3;
use squirm::analyze::statistics::{Estimate, blocked};

/// The case.
pub const CASE: Case = Case {
    name: "equilibrium",
    title: "Equilibrium",
    about: "A fluid at rest, 10 particles per cell, h = 0.1. In a periodic box: second moments of the velocity, the kurtosis of one \
            component (3 for a Gaussian), and the variance of the number of particles in the cells of a fixed lattice, which for \
            a fixed total in M cells is 1 - 1/M of the mean. SRD+a that sets the energy of the residual keeps all second moments \
            exactly, but its fourth moments are off by a term of order 1/N, a property of the rule. In a slit: density and \
            temperature from wall to wall, both walls folded together.",
    remarks: "",
    sheets: &[
        Sheet {
            name: "velocity-law",
            title: "Velocity of one component: probability over the law of Maxwell and Boltzmann",
            x: "speed of the component / sqrt(kT/m)",
            y: "ratio",
            logarithmic: false,
        },
        Sheet {
            name: "slit-at-rest",
            title: "Density and temperature from the wall inwards",
            x: "distance from the wall / a",
            y: "over the value at rest",
            logarithmic: false,
        },
    ],
    parts,
    controls: &[
        Control {
            name: "no-angular-momentum",
            about: "SRD-a is run where SRD+a is meant: the kurtosis tells",
            part: "law-energy",
            spoil: rules::without_angular_momentum,
        },
        Control {
            name: "pulled-to-a-wall",
            about: "a body force presses the fluid at rest against one wall",
            part: "slit",
            spoil: |plan| plan.system.fluid.acceleration = [0.0, 0.3, 0.0],
        },
    ],
};

fn parts(size: Size) -> Vec<Part> {
    let rules: &[Collision] = match size {
        Size::Quick => &[rules::ENERGY],
        Size::Full => &rules::ALL,
    };
    let laws = rules.iter().map(|rule| Part::new(format!("law-{}", rule.name), move |rig| law(rig, *rule)));
    laws.chain([Part::new("slit", slit)]).collect()
}

/// Kurtosis of one velocity component at 10 particles per cell. SRD+a: known from a simulation of the rule, to 0.001.
fn kurtosis(rule: Collision) -> (f64, &'static str) {
    match (rule.conserved, rule.mode) {
        (false, _) => (3.0, "Maxwell and Boltzmann"),
        (true, "energy") => (3.036, "the rule, of order 1/N"),
        (true, _) => (3.025, "the rule, of order 1/N"),
    }
}

/// Edge of the bins of the velocity, and how many there are.
const BIN: f64 = 0.25;
const BINS: usize = 16;

fn law(rig: &Rig, rule: Collision) -> Result<Outcome, Trouble> {
    let edge = rig.pick(16, 32);
    let sets: Vec<String> = rule.sets().into_iter().chain([rules::size_set([edge; 3])]).collect();
    let planned = rig.plan("equilibrium", &sets)?;
    let mut state = rig.start(&planned)?;
    temper(&mut state, planned.plan.system.fluid.temperature);
    let mut session = rig.session(&planned, &state)?;
    advance(&mut session, 100)?;
    let (mut moments, mut kurtoses, mut numbers) = (Vec::new(), Vec::new(), Vec::new());
    let mut histogram = vec![Vec::new(); BINS];
    for _ in 0..rig.pick(140, 300) {
        advance(&mut session, 5)?;
        let fluid = Fluid::of(&session)?;
        let frame = Velocities::of(&fluid);
        moments.push([frame.squares.to_array(), frame.products.to_array()]);
        kurtoses.push(fluid.kurtosis());
        numbers.push(dispersion(&fluid.occupancy()));
        histogram.iter_mut().zip(frame.histogram).for_each(|(bin, n)| bin.push(n));
    }
    sound(&session)?;
    let temperature = planned.system.fluid.temperature;
    let whole = planned.system.particle_count() as f64;
    let cells = planned.system.domain.volume();
    let setup = format!("{}, {edge} x {edge} x {edge}", rule.title);
    let series = |kind: usize, axis: usize| blocked(&moments.iter().map(|m| m[kind][axis]).collect::<Vec<_>>());
    let mut rows = Vec::new();
    for (axis, names) in [
        ("<v_x^2> / (kT/m)", "<v_x v_y> / (kT/m)"),
        ("<v_y^2> / (kT/m)", "<v_y v_z> / (kT/m)"),
        ("<v_z^2> / (kT/m)", "<v_z v_x> / (kT/m)"),
    ]
    .into_iter()
    .enumerate()
    {
        // The centre of mass is at rest.
        let expected = temperature * (1.0 - 1.0 / whole);
        rows.push(row((names.0, &setup), series(0, axis), (Some(expected), 1e-3), "Maxwell and Boltzmann"));
        rows.push(row((names.1, &setup), series(1, axis), (Some(0.0), 1e-3), "isotropy"));
    }
    let (expected, source) = kurtosis(rule);
    rows.push(row(("kurtosis of a component", &setup), blocked(&kurtoses), (Some(expected), 3e-3), source));
    let quantity = "variance / mean of the number in a cell";
    rows.push(row((quantity, &setup), blocked(&numbers), (Some(1.0 - 1.0 / cells), 5e-3), "Poisson, fixed total"));
    Ok(Outcome { rows, curves: vec![velocity_curve(rule, &histogram, 3.0 * whole)] })
}

/// Sums over the velocities of one frame, per particle.
struct Velocities {
    /// v_i^2.
    squares: DVec3,
    /// v_x v_y, v_y v_z, v_z v_x.
    products: DVec3,
    /// Components in bins of their size, counted; not per particle.
    histogram: [f64; BINS],
}

impl Velocities {
    fn of(fluid: &Fluid) -> Self {
        let (mut squares, mut products, mut histogram) = (DVec3::ZERO, DVec3::ZERO, [0.0; BINS]);
        for v in fluid.velocities() {
            squares += v * v;
            products += DVec3::new(v.x * v.y, v.y * v.z, v.z * v.x);
            for c in v.to_array() {
                let bin = (c.abs() / BIN) as usize;
                if bin < BINS {
                    histogram[bin] += 1.0;
                }
            }
        }
        let n = fluid.len() as f64;
        Self { squares: squares / n, products: products / n, histogram }
    }
}

/// Variance over mean of a set of numbers.
fn dispersion(counts: &[u32]) -> f64 {
    let n = counts.len() as f64;
    let (sum, squares) = counts.iter().fold((0.0, 0.0), |(s, q), c| (s + f64::from(*c), q + f64::from(*c).powi(2)));
    let mean = sum / n;
    (squares / n - mean * mean) / mean
}

/// Probability that a normal variate lies in a bin of its size: Simpson's rule in 16 strips, good to 1e-8 here.
fn gaussian_share(bin: usize) -> f64 {
    let density = |v: f64| (-0.5 * v * v).exp() * (2.0 / std::f64::consts::PI).sqrt();
    let step = BIN / 16.0;
    let at = |k: usize| density(bin as f64 * BIN + k as f64 * step);
    let sum: f64 = (0..8).map(|k| at(2 * k) + 4.0 * at(2 * k + 1) + at(2 * k + 2)).sum();
    sum * step / 3.0
}

fn velocity_curve(rule: Collision, histogram: &[Vec<f64>], components: f64) -> Curve {
    let centre = |bin: usize| (bin as f64 + 0.5) * BIN;
    let point = |(bin, series): (usize, &Vec<f64>)| {
        let (found, whole) = (blocked(series), components * gaussian_share(bin));
        (centre(bin), found.mean / whole, found.error / whole)
    };
    // The first correction of Gram and Charlier: the excess of the kurtosis over 24 times the fourth Hermite polynomial.
    let excess = kurtosis(rule).0 - 3.0;
    let guide = |k: u32| {
        let v = f64::from(k) * 0.05;
        (v, 1.0 + excess / 24.0 * (v.powi(4) - 6.0 * v * v + 3.0))
    };
    Curve {
        sheet: "velocity-law".into(),
        name: rule.title.into(),
        // Beyond 3.5 too few are left for a frame's error.
        points: histogram.iter().enumerate().take(14).map(point).collect(),
        guide: (0..=70).map(guide).collect(),
        guide_name: format!("kurtosis {}", kurtosis(rule).0),
    }
}

/// Edges of the bins from a wall to the middle of a slit of 8 a.
fn depths() -> Vec<f64> {
    (0..=10).map(|k| f64::from(k) * 0.1).chain((3..=8).map(|k| f64::from(k) * 0.5)).collect()
}

fn slit(rig: &Rig) -> Result<Outcome, Trouble> {
    let edge = rig.pick(8, 32);
    let planned = rig.plan("slit", &[rules::size_set([edge, 8, edge])])?;
    let mut session = rig.session(&planned, &rig.start(&planned)?)?;
    let edges = depths();
    let mut bins = vec![Vec::new(); edges.len() - 1];
    advance(&mut session, 100)?;
    for _ in 0..rig.pick(400, 800) {
        advance(&mut session, 8)?;
        let mut frame = vec![[0.0; 2]; bins.len()];
        for (r, v) in Fluid::of(&session)?.particles() {
            let depth = r.y.min(8.0 - r.y);
            // A particle behind a wall counts as beside it: the density there tells.
            let bin = edges.partition_point(|e| *e <= depth).clamp(1, bins.len()) - 1;
            frame[bin][0] += 1.0;
            frame[bin][1] += v.length_squared() / 3.0;
        }
        bins.iter_mut().zip(frame).for_each(|(bin, sums)| bin.push(sums));
    }
    sound(&session)?;
    let share = |k: usize| planned.system.particle_count() as f64 * (edges[k + 1] - edges[k]) / 4.0;
    let density = |k: usize| of_means(&bins[k], |[n, _]| n / share(k));
    let kt = planned.system.fluid.temperature;
    let temperature = |k: usize| of_means(&bins[k], |[n, e]| e / n / kt);
    let setup = format!("{}, {edge} x 8 x {edge}", rules::THERMOSTAT.title);
    let (mut rows, mut curves) = (Vec::new(), Vec::new());
    let quantities: [(&str, &dyn Fn(usize) -> Estimate); 2] = [("density", &density), ("temperature", &temperature)];
    for (name, of) in quantities {
        let found: Vec<Estimate> = (0..bins.len()).map(of).collect();
        let worst = found.iter().max_by(|a, b| (a.mean - 1.0).abs().total_cmp(&(b.mean - 1.0).abs())).copied();
        let worst = worst.unwrap_or(Estimate::NONE);
        let largest = Estimate { mean: worst.mean - 1.0, error: worst.error };
        let first = format!("{name} within 0.1 a of a wall, relative");
        rows.push(row((&first, &setup), found[0], (Some(1.0), 0.01), "equilibrium"));
        let quantity = format!("largest deviation of the {name} in {} bins, relative", bins.len());
        rows.push(row((&quantity, &setup), largest, (Some(0.0), 0.01), "equilibrium"));
        curves.push(Curve {
            sheet: "slit-at-rest".into(),
            name: name.into(),
            points: found
                .iter()
                .enumerate()
                .map(|(k, f)| (f64::midpoint(edges[k], edges[k + 1]), f.mean, f.error))
                .collect(),
            guide: if name == "density" { vec![(0.0, 1.0), (4.0, 1.0)] } else { Vec::new() },
            guide_name: "equilibrium".into(),
        });
    }
    Ok(Outcome { rows, curves })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Probability of |v| < 1 and |v| < 4 of a normal variate.
    #[test]
    fn the_shares_of_the_bins_are_those_of_a_gaussian() {
        let sum = |bins: usize| (0..bins).map(gaussian_share).sum::<f64>();
        assert!((sum(4) - 0.682_689_492).abs() < 1e-8, "{}", sum(4));
        assert!((sum(16) - 0.999_936_658).abs() < 1e-8, "{}", sum(16));
    }

    #[test]
    fn dispersion_is_variance_over_mean() {
        assert!((dispersion(&[1, 3]) - 0.5).abs() < 1e-15);
        assert_eq!(depths().len(), 17);
    }
}
