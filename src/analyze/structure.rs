//! How squirmers stand to each other: pair correlation, polar and nematic order, and how far orientations are correlated.

use super::kinds::Definition;
use super::plot::{Chart, Curve, Scale};
use super::space::Space;
use super::statistics::{Estimate, blocked, course};
use super::stretches::Stretches;
use super::table::{Table, line};
use super::{AnalyzeError, Analyzer, Report};
use crate::math::linear::{eigen, outer};
use crate::params;
use crate::wire::{Kind, Snapshot, Squirmers};
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

params! {
    /// Pair correlation g(r), polar and nematic order, and correlation of the orientations over distance. Distances are
    /// between centres. g(r) is 1 for squirmers that do not feel each other. Polar order is the length of the mean
    /// axis; nematic order is the largest eigenvalue of Q = mean of (3 e e - 1)/2. Without any order they are about
    /// sqrt(1/N) for N squirmers, not zero.
    pub struct StructureOptions {
        /// Width of the bins of the distance.
        pub bin: f64 = 0.5; "a", Float { min: 0.01, max: 100.0 };
        /// Largest distance; at most half the shortest periodic edge, which is the default.
        pub reach: Option<f64>; "a", Float { min: 0.1, max: 1e6 };
        /// Distances: full takes them in space, plane in x and z only, as a narrow slit wants it; auto takes plane
        /// where there are walls. g(r) is normalised accordingly; between walls, full accounts for the shells that the
        /// walls cut.
        pub distance: String = "auto"; "", Choice(&["auto", "full", "plane"]);
    }
}

/// The analyzer behind `squirm-analyze structure`.
#[derive(Debug)]
pub struct Structure {
    options: StructureOptions,
    seen: Option<(Space, usize)>,
    times: Vec<f64>,
    polar: Vec<f64>,
    nematic: Vec<f64>,
    /// Of every bin: pairs, sum of e.e', sum of (3 (e.e')^2 - 1)/2.
    pairs: Stretches,
}

impl Definition for Structure {
    const NAME: &'static str = "structure";
    const TOPICS: &'static [Kind] = &[Kind::Squirmers];
    type Options = StructureOptions;

    fn new(options: StructureOptions) -> Self {
        let (times, polar, nematic) = (Vec::new(), Vec::new(), Vec::new());
        Self { options, seen: None, times, polar, nematic, pairs: Stretches::default() }
    }
}

/// |mean of e| and the largest eigenvalue of the mean of (3 e e - 1)/2.
fn order(axes: &[DVec3]) -> (f64, f64) {
    let n = axes.len() as f64;
    let mean = axes.iter().sum::<DVec3>() / n;
    let squares = axes.iter().fold(DMat3::ZERO, |sum, e| sum + outer(*e, *e));
    let (values, _) = eigen(squares * (1.5 / n) - DMat3::IDENTITY * 0.5);
    (mean.length(), values.max_element())
}

impl Structure {
    fn flat(&self, space: &Space) -> bool {
        match self.options.distance.as_str() {
            "plane" => true,
            "full" => false,
            _ => space.walls,
        }
    }

    fn bins(&self, space: &Space) -> usize {
        let half = if self.flat(space) { space.edge.x.min(space.edge.z) / 2.0 } else { space.reach() };
        let reach = self.options.reach.unwrap_or(half).min(half);
        // A last bin that is not whole would reach too far.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bins = (reach / self.options.bin * (1.0 + 1e-12)) as usize;
        bins.max(1)
    }

    /// Share of the box's volume, or area, within a distance of a squirmer that may be anywhere.
    fn share(&self, space: &Space, r: f64) -> f64 {
        if self.flat(space) {
            return PI * r * r / (space.edge.x * space.edge.z);
        }
        let volume = space.edge.element_product();
        let sphere = 4.0 / 3.0 * PI * r.powi(3);
        if !space.walls {
            return sphere / volume;
        }
        // The area of a sphere about a point of a slit of height h that lies in the slit, averaged over the point:
        // 4 pi r^2 - 2 pi r^3/h up to r = h, then 2 pi r h.
        let h = space.edge.y;
        let near = |r: f64| 4.0 / 3.0 * PI * r.powi(3) - PI * r.powi(4) / (2.0 * h);
        (if r < h { near(r) } else { near(h) + PI * h * (r * r - h * h) }) / volume
    }

    fn enter_pairs(&mut self, space: &Space, places: &[DVec3], axes: &[DVec3]) {
        let (flat, bins, width) = (self.flat(space), self.bins(space), self.options.bin);
        let sums = self.pairs.begin();
        for i in 0..places.len() {
            for j in 0..i {
                let mut r = space.nearest(places[i], places[j]);
                if flat {
                    r.y = 0.0;
                }
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let bin = (r.length() / width) as usize;
                if bin < bins {
                    let cosine = axes[i].dot(axes[j]);
                    sums[3 * bin] += 1.0;
                    sums[3 * bin + 1] += cosine;
                    sums[3 * bin + 2] += 1.5 * cosine * cosine - 0.5;
                }
            }
        }
    }
}

impl Analyzer for Structure {
    fn topics(&self) -> Vec<Kind> {
        Self::TOPICS.to_vec()
    }

    fn take(&mut self, snapshot: &Snapshot<'_>) -> Result<(), AnalyzeError> {
        let squirmers = Squirmers::decode(snapshot)?;
        let now = (Space::of(&snapshot.header), squirmers.id.len());
        if self.seen.is_none() {
            self.pairs = Stretches::new(3 * self.bins(&now.0));
        }
        if *self.seen.get_or_insert(now) != now {
            return Err(AnalyzeError::changed());
        }
        if now.1 == 0 {
            return Ok(());
        }
        let vectors =
            |list: &[[f32; 3]]| -> Vec<DVec3> { list.iter().map(|v| DVec3::from_array(v.map(f64::from))).collect() };
        let axes: Vec<DVec3> = vectors(&squirmers.axis).iter().map(|e| e.normalize_or_zero()).collect();
        let (polar, nematic) = order(&axes);
        self.times.push(snapshot.header.time);
        self.polar.push(polar);
        self.nematic.push(nematic);
        self.enter_pairs(&now.0, &vectors(&squirmers.position), &axes);
        Ok(())
    }

    fn finish(&mut self) -> Result<Report, AnalyzeError> {
        let Some((space, n)) = self.seen.filter(|(_, n)| *n > 0 && !self.times.is_empty()) else {
            return Err(AnalyzeError::nothing(Kind::Squirmers));
        };
        let shells = self.shells(&space, n);
        let (polar, nematic) = (blocked(&self.polar), blocked(&self.nematic));
        let mut summary =
            format!("{n} squirmers, {} snapshots; sqrt(1/N) = {:.4}\n", self.times.len(), (n as f64).sqrt().recip());
        summary += &line("polar order |<e>|", polar, "");
        summary += &line("nematic order", nematic, "");
        Ok(Report {
            summary,
            files: vec![
                ("pairs.csv".into(), shells_csv(&shells)),
                ("order.csv".into(), self.order_csv()),
                ("pairs.svg".into(), pairs_chart(&shells, self.flat(&space)).svg()?),
                ("orientations.svg".into(), orientations_chart(&shells).svg()?),
                ("order.svg".into(), self.order_chart(polar, nematic).svg()?),
            ],
        })
    }
}

/// What was found at one distance.
struct Shell {
    /// Middle of the bin.
    r: f64,
    pairs: f64,
    g: Estimate,
    polar: Estimate,
    nematic: Estimate,
}

impl Structure {
    fn shells(&self, space: &Space, n: usize) -> Vec<Shell> {
        let all = n as f64 * (n as f64 - 1.0) / 2.0;
        let width = self.options.bin;
        let shell = |bin: usize| {
            let (low, high) = (bin as f64 * width, (bin + 1) as f64 * width);
            let ideal = all * (self.share(space, high) - self.share(space, low));
            let found = self.pairs.mean(3 * bin);
            Shell {
                r: f64::midpoint(low, high),
                pairs: self.pairs.total(3 * bin),
                g: Estimate { mean: found.mean / ideal, error: found.error / ideal },
                polar: self.pairs.ratio(3 * bin + 1, 3 * bin),
                nematic: self.pairs.ratio(3 * bin + 2, 3 * bin),
            }
        };
        (0..self.bins(space)).map(shell).collect()
    }

    fn order_csv(&self) -> String {
        let mut table = Table::new("time [tau],polar order,nematic order");
        for ((time, polar), nematic) in self.times.iter().zip(&self.polar).zip(&self.nematic) {
            table.row(&[(*time).into(), (*polar).into(), (*nematic).into()]);
        }
        table.finish()
    }

    fn order_chart(&self, polar: Estimate, nematic: Estimate) -> Chart {
        let curve = |name: &str, series: &[f64], mean: Estimate| {
            let points = course(&self.times, series);
            let guide = [points.first(), points.last()].into_iter().flatten().map(|p| (p.0, mean.mean)).collect();
            let name = format!("{name}: {:.3} +- {:.3}", mean.mean, mean.error);
            Curve { name, points, guide, guide_name: "mean".into() }
        };
        Chart {
            title: "Order of the orientations".into(),
            x: "time [tau]".into(),
            y: "order".into(),
            scale: Scale::Linear,
            curves: vec![curve("polar", &self.polar, polar), curve("nematic", &self.nematic, nematic)],
        }
    }
}

fn shells_csv(shells: &[Shell]) -> String {
    let mut table = Table::new("r [a],g(r),error,<e.e'>(r),error,<(3 (e.e')^2 - 1)/2>(r),error,pairs seen");
    for s in shells {
        table.row(&[s.r.into(), s.g.into(), s.polar.into(), s.nematic.into(), s.pairs.into()]);
    }
    table.finish()
}

fn points(shells: &[Shell], pick: fn(&Shell) -> Estimate) -> Vec<(f64, f64, f64)> {
    shells
        .iter()
        .map(|s| (s.r, pick(s)))
        .filter(|(_, e)| e.mean.is_finite())
        .map(|(r, e)| (r, e.mean, e.error))
        .collect()
}

fn pairs_chart(shells: &[Shell], flat: bool) -> Chart {
    let points = points(shells, |s| s.g);
    let guide = [points.first(), points.last()].into_iter().flatten().map(|p| (p.0, 1.0)).collect();
    let name = if flat { "distances in the plane x, z" } else { "distances in space" };
    Chart {
        title: "Pair correlation".into(),
        x: "distance of the centres r [a]".into(),
        y: "g(r)".into(),
        scale: Scale::Linear,
        curves: vec![Curve { name: name.into(), points, guide, guide_name: "without correlations".into() }],
    }
}

fn orientations_chart(shells: &[Shell]) -> Chart {
    let curve = |name: &str, pick| Curve { name: name.into(), points: points(shells, pick), ..Curve::default() };
    Chart {
        title: "Correlation of the orientations".into(),
        x: "distance of the centres r [a]".into(),
        y: "correlation".into(),
        scale: Scale::Linear,
        curves: vec![curve("<e.e'>", |s| s.polar), curve("<(3 (e.e')^2 - 1)/2>", |s| s.nematic)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{Params, Values};

    #[test]
    fn order_of_known_orientations() {
        assert_eq!(order(&[DVec3::X; 5]), (1.0, 1.0));
        let (polar, nematic) = order(&[DVec3::X, -DVec3::X]);
        assert!(polar == 0.0 && (nematic - 1.0).abs() < 1e-12);
        // All directions of a plane: eigenvalues 1/4, 1/4, -1/2. All axes of a cube: none.
        let (_, plane) = order(&[DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y]);
        let (_, cube) = order(&[DVec3::X, DVec3::Y, DVec3::Z]);
        assert!((plane - 0.25).abs() < 1e-12 && cube.abs() < 1e-12);
    }

    /// Points uniform in a slit: the share of the partners within r, by counting.
    #[test]
    fn shells_cut_by_walls_have_their_volume() {
        let mut values = Values::defaults(&StructureOptions::fields());
        values.set("distance", crate::params::Value::Text("full".into()));
        let structure = Structure::new(StructureOptions::from_values(&values));
        let slit = Space { edge: DVec3::new(20.0, 4.0, 20.0), walls: true };
        for r in [1.0, 3.0, 4.0, 7.0, 10.0] {
            let (n, fine) = (400, 400);
            let mut inside = 0.0;
            for (i, j) in (0..n).flat_map(|i| (0..fine).map(move |j| (i, j))) {
                let (y0, y1) = ((f64::from(i) + 0.5) * 4.0 / 400.0, (f64::from(j) + 0.5) * 4.0 / 400.0);
                inside += PI * (r * r - (y1 - y0).powi(2)).max(0.0);
            }
            let counted = inside / 160_000.0 / 400.0;
            let formula = structure.share(&slit, r);
            assert!((formula / counted - 1.0).abs() < 1e-3, "{r}: {formula} {counted}");
        }
        let free = Space { walls: false, ..slit };
        assert_eq!(structure.share(&free, 1.5), 4.0 / 3.0 * PI * 3.375 / 1600.0);
    }
}
