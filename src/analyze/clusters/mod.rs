//! Clusters of squirmers: how large they are, how the largest one comes and goes, and how their number fluctuates in parts of the box.

mod neighbours;

pub use neighbours::{bodies, sizes};

use super::kinds::Definition;
use super::plot::{Chart, Curve, Scale};
use super::space::Space;
use super::statistics::{Estimate, blocked, course};
use super::stretches::Stretches;
use super::table::{Table, line};
use super::{AnalyzeError, Analyzer, Report};
use crate::params;
use crate::wire::{Kind, Snapshot, Squirmers};
use glam::DVec3;

params! {
    /// Clusters of squirmers: sizes, the largest one in time, mean size, and number fluctuations in parts of the box.
    /// Squirmers whose surfaces are closer than the gap belong to one cluster. The distance of surfaces is the
    /// directional one of Paramonov and Yaliraki (J. Chem. Phys. 123, 194111, 2005), exact for spheres and at contact,
    /// else a little more than the true gap; the one that steric forces use.
    pub struct ClustersOptions {
        /// Largest distance of the surfaces of neighbours in a cluster.
        pub gap: f64 = 1.0; "a", Float { min: 0.0, max: 1000.0 };
        /// The box is cut into 2, 3, ... up to this many parts along each periodic edge, to count squirmers in them.
        pub parts: u32 = 8u32; "", Integer { min: 2, max: 64 };
    }
}

/// The analyzer behind `squirm-analyze clusters`.
#[derive(Debug)]
pub struct Clusters {
    options: ClustersOptions,
    seen: Option<(Space, usize)>,
    times: Vec<f64>,
    /// Of every snapshot: the largest cluster, the number of clusters, the mean of the size, that of the cluster of a
    /// squirmer.
    courses: [Vec<f64>; 4],
    /// Clusters of size 1, 2, ...
    sizes: Stretches,
    /// Squared deviations of the counts for 2, 3, ... parts.
    deviations: Stretches,
}

impl Definition for Clusters {
    const NAME: &'static str = "clusters";
    const TOPICS: &'static [Kind] = &[Kind::Squirmers];
    type Options = ClustersOptions;

    fn new(options: ClustersOptions) -> Self {
        Self {
            options,
            seen: None,
            times: Vec::new(),
            courses: Default::default(),
            sizes: Stretches::default(),
            deviations: Stretches::default(),
        }
    }
}

/// Numbers of squirmers in the parts of the box, cut into `parts` along each periodic edge.
fn counts(space: &Space, places: impl Iterator<Item = DVec3>, parts: usize) -> Vec<u32> {
    let mut counts = vec![0; parts.pow(if space.walls { 2 } else { 3 })];
    for place in places {
        let index = (0..3).filter(|k| space.periodic(*k)).fold(0, |index, k| {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let part = (place[k] / space.edge[k] * parts as f64) as usize;
            index * parts + part.min(parts - 1)
        });
        counts[index] += 1;
    }
    counts
}

impl Analyzer for Clusters {
    fn topics(&self) -> Vec<Kind> {
        Self::TOPICS.to_vec()
    }

    fn take(&mut self, snapshot: &Snapshot<'_>) -> Result<(), AnalyzeError> {
        let squirmers = Squirmers::decode(snapshot)?;
        let all = bodies(&squirmers);
        let now = (Space::of(&snapshot.header), all.len());
        if self.seen.is_none() {
            self.sizes = Stretches::new(all.len());
            self.deviations = Stretches::new(self.options.parts as usize - 1);
        }
        if *self.seen.get_or_insert(now) != now {
            return Err(AnalyzeError::changed());
        }
        if all.is_empty() {
            return Ok(());
        }
        let (space, n) = (now.0, all.len() as f64);
        let sizes = sizes(&space, &all, self.options.gap);
        let count = sizes.len() as f64;
        let squares: f64 = sizes.iter().map(|s| (*s as f64).powi(2)).sum();
        self.times.push(snapshot.header.time);
        for (course, value) in self.courses.iter_mut().zip([sizes[0] as f64, count, n / count, squares / n]) {
            course.push(value);
        }
        let now = self.sizes.begin();
        sizes.iter().for_each(|size| now[size - 1] += 1.0);
        for (i, sum) in self.deviations.begin().iter_mut().enumerate() {
            let counts = counts(&space, all.iter().map(|(_, place)| *place), i + 2);
            let mean = n / counts.len() as f64;
            *sum += counts.iter().map(|c| (f64::from(*c) - mean).powi(2)).sum::<f64>() / counts.len() as f64;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<Report, AnalyzeError> {
        let Some((space, n)) = self.seen.filter(|(_, n)| *n > 0 && !self.times.is_empty()) else {
            return Err(AnalyzeError::nothing(Kind::Squirmers));
        };
        let means = [0, 1, 2, 3].map(|k| blocked(&self.courses[k]));
        let fluctuations = self.fluctuations(&space, n);
        let mut summary = format!("{n} squirmers, {} snapshots, gap {} a\n", self.times.len(), self.options.gap);
        for (name, value) in COURSES.iter().zip(means) {
            summary += &line(name, value, "");
        }
        Ok(Report {
            summary,
            files: vec![
                ("sizes.csv".into(), self.sizes_csv(n)),
                ("time.csv".into(), self.time_csv()),
                ("fluctuations.csv".into(), fluctuations_csv(&fluctuations)),
                ("sizes.svg".into(), self.sizes_chart(n).svg()?),
                ("time.svg".into(), self.time_chart(&means).svg()?),
                ("fluctuations.svg".into(), fluctuations_chart(&fluctuations).svg()?),
            ],
        })
    }
}

/// What is followed in time.
const COURSES: [&str; 4] =
    ["squirmers in the largest cluster", "clusters", "squirmers per cluster", "size of the cluster of a squirmer"];

/// Counts in parts of one size.
struct Fluctuation {
    parts: usize,
    edge: [f64; 2],
    mean: f64,
    variance: Estimate,
    /// That of squirmers without any correlation, whose total is fixed.
    independent: f64,
}

impl Clusters {
    fn fluctuations(&self, space: &Space, n: usize) -> Vec<Fluctuation> {
        let one = |i: usize| {
            let parts = (i + 2).pow(if space.walls { 2 } else { 3 });
            let mean = n as f64 / parts as f64;
            Fluctuation {
                parts,
                edge: [space.edge.x, space.edge.z].map(|edge| edge / (i + 2) as f64),
                mean,
                variance: self.deviations.mean(i),
                independent: mean * (1.0 - 1.0 / parts as f64),
            }
        };
        (0..self.options.parts as usize - 1).map(one).collect()
    }

    fn sizes_csv(&self, n: usize) -> String {
        let mut table = Table::new("size,clusters per snapshot,error,share of squirmers,error");
        for size in (1..=n).filter(|s| self.sizes.total(s - 1) > 0.0) {
            let clusters = self.sizes.mean(size - 1);
            let factor = size as f64 / n as f64;
            let share = Estimate { mean: clusters.mean * factor, error: clusters.error * factor };
            table.row(&[(size as f64).into(), clusters.into(), share.into()]);
        }
        table.finish()
    }

    fn time_csv(&self) -> String {
        let mut table = Table::new(&format!("time [tau],{}", COURSES.join(",")));
        for (i, time) in self.times.iter().enumerate() {
            let [largest, count, mean, weighted] = [0, 1, 2, 3].map(|k| self.courses[k][i].into());
            table.row(&[(*time).into(), largest, count, mean, weighted]);
        }
        table.finish()
    }

    fn sizes_chart(&self, n: usize) -> Chart {
        let point = |size: usize| {
            let found = self.sizes.mean(size - 1);
            (size as f64, found.mean, found.error)
        };
        let points = (1..=n).filter(|s| self.sizes.total(s - 1) > 0.0).map(point).collect();
        let name = format!("surfaces closer than {} a", self.options.gap);
        Chart {
            title: "Sizes of clusters".into(),
            x: "squirmers in a cluster".into(),
            y: "clusters per snapshot".into(),
            scale: Scale::Logarithmic,
            curves: vec![Curve { name, points, ..Curve::default() }],
        }
    }

    fn time_chart(&self, means: &[Estimate; 4]) -> Chart {
        let curve = |k: usize| {
            let points = course(&self.times, &self.courses[k]);
            let guide = [points.first(), points.last()].into_iter().flatten().map(|p| (p.0, means[k].mean)).collect();
            let name = format!("{}: {:.2} +- {:.2}", COURSES[k], means[k].mean, means[k].error);
            Curve { name, points, guide, guide_name: "mean".into() }
        };
        Chart {
            title: "Clusters in time".into(),
            x: "time [tau]".into(),
            y: "squirmers".into(),
            scale: Scale::Linear,
            curves: [0, 3, 2].map(curve).to_vec(),
        }
    }
}

fn fluctuations_csv(all: &[Fluctuation]) -> String {
    let mut table =
        Table::new("parts,edge along x [a],edge along z [a],mean count,variance,error,variance if independent");
    for f in all {
        let [x, z] = f.edge.map(Into::into);
        table.row(&[(f.parts as f64).into(), x, z, f.mean.into(), f.variance.into(), f.independent.into()]);
    }
    table.finish()
}

fn fluctuations_chart(all: &[Fluctuation]) -> Chart {
    let points = all.iter().map(|f| (f.mean, f.variance.mean, f.variance.error)).collect();
    let guide = all.iter().map(|f| (f.mean, f.independent)).collect();
    Chart {
        title: "Number fluctuations in parts of the box".into(),
        x: "mean count".into(),
        y: "variance of the count".into(),
        scale: Scale::Logarithmic,
        curves: vec![Curve { name: "measured".into(), points, guide, guide_name: "without correlations".into() }],
    }
}
