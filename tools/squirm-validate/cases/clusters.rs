//! Clusters of spheres and of prolate swimmers in a narrow slit.

use crate::case::{Case, Curve, Outcome, Part, Row, Sheet, Size, Trouble};
use crate::crowd::{clusters, peclet, reynolds, swimmers, transport};
use crate::rig::{Planned, Rig, advance, sound};
use squirm::analyze::statistics::{Estimate, blocked};
use squirm::math::spheroid::Spheroid;
use squirm::state::System;

/// The case.
pub const CASE: Case = Case {
    name: "clusters",
    title: "Clusters of spheres and of prolate swimmers",
    about: "Spheres of radius 3 a and prolate swimmers (6 along, 3 across) in a slit of 7 a, at the same area fraction 0.40 and the same \
            Peclet number U0/(2 b D_R) of 108 (`pipelines/clusters.toml`): B1 = 0.1 for the prolate ones (Reynolds number 0.65), 0.187 for \
            the spheres (0.49); h = 0.05. Swimmers belong to one cluster if a chain of surfaces less than 1 a apart (directional \
            distance) joins them; steric forces begin at 0.56 a. The mean size is the one that a swimmer sees, sum n^2/N. Means are over \
            the second half of one run of 2500 tau: 17 lengths of the prolate swimmers, 52 of the spheres, which is short for \
            clusters to ripen, and the box is small; the start is random without overlap. Published (Theers, Westphal, Qi, Winkler \
            and Gompper 2018, abstract): hydrodynamic interactions suppress the clustering of spheres and enhance that of prolate \
            swimmers.",
    remarks: "",
    sheets: &[
        Sheet {
            name: "clusters-largest",
            title: "Share of the swimmers in the largest cluster",
            x: "time / tau",
            y: "share",
            logarithmic: false,
        },
        Sheet {
            name: "clusters-mean",
            title: "Mean cluster size that a swimmer sees, as a share of all swimmers",
            x: "time / tau",
            y: "sum n^2 / N^2",
            logarithmic: false,
        },
        Sheet {
            name: "clusters-sizes",
            title: "Share of the swimmers in clusters of n to 2n - 1, second half of the run",
            x: "cluster size n",
            y: "share",
            logarithmic: true,
        },
    ],
    parts,
    controls: &[],
};

/// Largest gap between the surfaces of neighbours in a cluster, in a.
const REACH: f64 = 1.0;

/// Steps between two readings.
fn between(rig: &Rig) -> u64 {
    rig.pick(50, 200)
}

/// Swim mode of the prolate swimmers; that of the spheres follows from the Peclet number.
const B1: f64 = 0.1;

const PROLATE: Spheroid = Spheroid { along: 6.0, across: 3.0 };
const SPHERE: Spheroid = Spheroid { along: 3.0, across: 3.0 };

fn parts(size: Size) -> Vec<Part> {
    let kinds: &[(&'static str, Spheroid, f64)] = match size {
        Size::Quick => &[("prolate", PROLATE, 1.0)],
        Size::Full => &[
            ("prolate", PROLATE, 0.0),
            ("sphere", SPHERE, 0.0),
            ("prolate", PROLATE, 1.0),
            ("sphere", SPHERE, 1.0),
            ("prolate", PROLATE, -1.0),
            ("sphere", SPHERE, -1.0),
        ],
    };
    let part = |(name, shape, beta): &(&'static str, Spheroid, f64)| {
        let (name, shape, beta) = (*name, *shape, *beta);
        Part::new(format!("{name}{beta}"), move |rig| measure(rig, name, shape, beta))
    };
    kinds.iter().map(part).collect()
}

/// Swimmers that cover the area fraction of the file, where 50 prolate ones swim in 84 x 84.
fn count(shape: Spheroid, edge: u32) -> u32 {
    let same_area =
        50.0 * (f64::from(edge) / 84.0).powi(2) * PROLATE.along * PROLATE.across / (shape.along * shape.across);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let count = same_area.round() as u32;
    count
}

fn measure(rig: &Rig, name: &str, shape: Spheroid, beta: f64) -> Result<Outcome, Trouble> {
    let edge = rig.pick(32, 84);
    // The viscosity is the same for both shapes and drops out.
    let b1 = B1 * peclet(PROLATE, 1.0, 1.0) / peclet(shape, 1.0, 1.0);
    let sets = [
        format!("box.size=[{edge},7,{edge}]"),
        format!("squirmers.swimmer.count={}", count(shape, edge)),
        format!("squirmers.swimmer.semi_axes.along={}", shape.along),
        format!("squirmers.swimmer.semi_axes.across={}", shape.across),
        format!("squirmers.swimmer.b1={b1}"),
        format!("squirmers.swimmer.beta={beta}"),
    ];
    let planned = rig.plan("../clusters", &sets)?;
    let sizes = follow(rig, &planned)?;
    let interval = between(rig) as f64 * planned.system.run.dt;
    Ok(outcome(&planned.system, &format!("{name}, beta = {beta}"), (&sizes, interval)))
}

/// Cluster sizes at every reading, the start included.
fn follow(rig: &Rig, planned: &Planned) -> Result<Vec<Vec<usize>>, Trouble> {
    let mut session = rig.session(planned, &rig.start(planned)?)?;
    let domain = &planned.system.domain;
    let mut series = vec![clusters(domain, &swimmers(&session)?, REACH)];
    let every = between(rig);
    for _ in 0..rig.pick(200, planned.system.run.steps) / every {
        advance(&mut session, every)?;
        series.push(clusters(domain, &swimmers(&session)?, REACH));
    }
    sound(&session)?;
    Ok(series)
}

fn all(sizes: &[usize]) -> f64 {
    sizes.iter().sum::<usize>().max(1) as f64
}

/// Share of the swimmers in the largest cluster; sizes come largest first.
fn largest(sizes: &[usize]) -> f64 {
    sizes.first().map_or(0.0, |n| *n as f64 / all(sizes))
}

/// Mean size of the cluster that a swimmer is in, as a share of all swimmers.
fn mean_size(sizes: &[usize]) -> f64 {
    sizes.iter().map(|n| (n * n) as f64).sum::<f64>() / all(sizes).powi(2)
}

/// Share of the swimmers in clusters of `from` to 2 `from` - 1.
fn octave(sizes: &[usize], from: usize) -> f64 {
    sizes.iter().filter(|n| (from..2 * from).contains(*n)).sum::<usize>() as f64 / all(sizes)
}

/// Mean over the second half, its error from blocks; none for what is too short for them.
fn settled(series: &[Vec<usize>], value: impl Fn(&[usize]) -> f64) -> Estimate {
    let values: Vec<f64> = series[series.len() / 2..].iter().map(|sizes| value(sizes)).collect();
    let found = blocked(&values);
    Estimate { error: if found.error.is_finite() { found.error } else { 0.0 }, ..found }
}

fn outcome(system: &System, name: &str, (series, interval): (&[Vec<usize>], f64)) -> Outcome {
    let species = &system.species[0];
    let (shape, b1) = (species.spheroid(), species.b1);
    let n = f64::from(species.count);
    let area = std::f64::consts::PI * shape.along * shape.across * n;
    let [x, _, z] = system.domain.size.map(f64::from);
    let setup = format!(
        "{name}, {n} of area fraction {:.2}, B1 = {b1:.3}, Re = {:.2}, Pe = {:.0}",
        area / (x * z),
        reynolds(shape, b1, system),
        peclet(shape, b1, transport(system).viscosity)
    );
    let start = &series[0];
    let row = |quantity: &str, value: &dyn Fn(&[usize]) -> f64| {
        let found = settled(series, value);
        Row {
            quantity: quantity.into(),
            setup: setup.clone(),
            measured: found.mean,
            error: found.error,
            expected: None,
            tolerance: 0.0,
            source: "Theers et al. 2018".into(),
            note: format!("{:.3} at the random start", value(start)),
        }
    };
    let rows = vec![
        row("share of the swimmers in the largest cluster", &largest),
        row("mean cluster size, sum n^2 / N", &|sizes| mean_size(sizes) * n),
        row("share of the swimmers that are alone", &|sizes| octave(sizes, 1)),
    ];
    let curve = |sheet: &str, points: Vec<(f64, f64, f64)>| Curve {
        sheet: sheet.into(),
        name: name.into(),
        points,
        guide: Vec::new(),
        guide_name: String::new(),
    };
    let octaves = (0..).map(|k| 1usize << k).take_while(|from| *from <= species.count as usize);
    let sizes = octaves.map(|from| (from, settled(series, |s| octave(s, from))));
    let curves = vec![
        curve("clusters-largest", smoothed(series, interval, largest)),
        curve("clusters-mean", smoothed(series, interval, mean_size)),
        curve("clusters-sizes", sizes.map(|(from, e)| (from as f64, e.mean, e.error)).collect()),
    ];
    Outcome { rows, curves }
}

/// Time in tau and the mean of each tenth reading and its neighbours: 25 points of a full run.
fn smoothed(series: &[Vec<usize>], interval: f64, value: fn(&[usize]) -> f64) -> Vec<(f64, f64, f64)> {
    let window = |(k, chunk): (usize, &[Vec<usize>])| {
        let middle = (10 * k) as f64 + 0.5 * (chunk.len() as f64 - 1.0);
        (middle * interval, chunk.iter().map(|s| value(s)).sum::<f64>() / chunk.len() as f64, 0.0)
    };
    series.chunks(10).enumerate().map(window).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_of_a_known_distribution() {
        let sizes = [5, 2, 2, 1];
        assert_eq!(largest(&sizes), 0.5);
        assert_eq!(mean_size(&sizes), 0.34);
        assert_eq!((octave(&sizes, 1), octave(&sizes, 2), octave(&sizes, 4)), (0.1, 0.4, 0.5));
        assert_eq!((largest(&[]), mean_size(&[])), (0.0, 0.0));
    }

    #[test]
    fn both_shapes_cover_the_same_area() {
        assert_eq!((count(PROLATE, 84), count(SPHERE, 84)), (50, 100));
        assert_eq!(count(PROLATE, 32), 7);
    }

    #[test]
    fn means_are_over_the_second_half() {
        let series: Vec<Vec<usize>> = (0..40).map(|k| if k < 20 { vec![1, 1] } else { vec![2] }).collect();
        assert_eq!(settled(&series, largest), Estimate { mean: 1.0, error: 0.0 });
        assert_eq!(smoothed(&series, 2.0, largest)[1], (29.0, 0.5, 0.0));
    }
}
