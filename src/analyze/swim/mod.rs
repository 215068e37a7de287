//! How squirmers swim: speed along the axis, mean squared displacement, and how long they remember their direction.

mod trajectories;

pub use trajectories::{Lag, Sample, Trajectories};

use super::kinds::Definition;
use super::plot::{Chart, Curve, Scale};
use super::statistics::Estimate;
use super::table::quoted;
use super::{AnalyzeError, Analyzer, Report};
use crate::params;
use crate::wire::{Kind, Snapshot, SpeciesRow, Squirmers};
use glam::DVec3;
use std::fmt::Write;

params! {
    /// Swimming speed along the axis, mean squared displacement and memory of the orientation. Species by species: the speed
    /// against theory, and the rotational diffusion that follows from the memory.
    pub struct SwimOptions {}
}

/// The analyzer behind `squirm-analyze swim`.
#[derive(Debug, Default)]
pub struct Swim {
    table: Vec<SpeciesRow>,
    tracks: Vec<Trajectories>,
    first: Option<u64>,
    every: u64,
}

impl Definition for Swim {
    const NAME: &'static str = "swim";
    const TOPICS: &'static [Kind] = &[Kind::Squirmers];
    type Options = SwimOptions;

    fn new(_: SwimOptions) -> Self {
        Self::default()
    }
}

impl Analyzer for Swim {
    fn topics(&self) -> Vec<Kind> {
        Self::TOPICS.to_vec()
    }

    fn take(&mut self, snapshot: &Snapshot<'_>) -> Result<(), AnalyzeError> {
        let squirmers = Squirmers::decode(snapshot)?;
        let (step, time) = (snapshot.header.step, snapshot.header.time);
        if self.tracks.is_empty() {
            self.tracks.resize_with(squirmers.table.len(), Trajectories::default);
            self.table.clone_from(&squirmers.table);
        }
        if squirmers.table.len() != self.table.len() {
            return Err(AnalyzeError::TooLittle(
                "the species changed: these are snapshots of more than one run".into(),
            ));
        }
        let first = *self.first.get_or_insert(step);
        if self.every == 0 {
            self.every = if snapshot.header.every > 0 { snapshot.header.every } else { step - first };
        }
        let index = (step - first) / self.every.max(1);
        let mut samples: Vec<Vec<Sample>> = vec![Vec::new(); self.table.len()];
        for i in 0..squirmers.id.len() {
            samples[squirmers.species[i] as usize].push(Sample {
                position: DVec3::from_array(squirmers.unwrapped[i]),
                velocity: DVec3::from_array(squirmers.velocity[i].map(f64::from)),
                axis: DVec3::from_array(squirmers.axis[i].map(f64::from)).normalize_or_zero(),
            });
        }
        for (track, samples) in self.tracks.iter_mut().zip(samples) {
            track.push(index, time, samples);
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<Report, AnalyzeError> {
        let snapshots = self.tracks.first().map_or(0, Trajectories::len);
        if snapshots < 2 {
            return Err(AnalyzeError::TooLittle(format!("{snapshots} snapshots of squirmers: at least 2 are needed")));
        }
        let results: Vec<Found> = self.table.iter().zip(&self.tracks).map(|(s, t)| Found::new(s, t)).collect();
        Ok(Report {
            summary: summary(&results),
            files: vec![
                ("swim.csv".into(), swim_csv(&results)),
                ("msd.csv".into(), lags_csv(&results, "msd [a^2]", |f| &f.displacements)),
                ("orientation.csv".into(), lags_csv(&results, "correlation", |f| &f.orientations)),
                ("swim.svg".into(), speed_chart(&results).svg()?),
                ("msd.svg".into(), displacement_chart(&results).svg()?),
                ("orientation.svg".into(), orientation_chart(&results).svg()?),
            ],
        })
    }
}

/// What was found about one species.
struct Found {
    species: SpeciesRow,
    squirmers: usize,
    snapshots: usize,
    displaced: Estimate,
    instantaneous: Estimate,
    diffusion: Estimate,
    course: Vec<(f64, f64, f64)>,
    displacements: Vec<Lag>,
    orientations: Vec<Lag>,
}

impl Found {
    fn new(species: &SpeciesRow, track: &Trajectories) -> Self {
        Self {
            species: species.clone(),
            squirmers: track.squirmers(),
            snapshots: track.len(),
            displaced: track.displacement_speed(),
            instantaneous: track.speed(),
            diffusion: track.rotational_diffusion(),
            course: track.speeds_in_time(),
            displacements: track.displacements(),
            orientations: track.orientations(),
        }
    }
}

fn summary(results: &[Found]) -> String {
    let mut text = format!(
        "{:<16} {:>9} {:>22} {:>22} {:>10} {:>22}\n",
        "species", "squirmers", "<V.e> displacement", "<V.e> instantaneous", "U0 theory", "D_R [1/tau]"
    );
    let shown = |e: Estimate| format!("{:.5} +- {:.5}", e.mean, e.error);
    for f in results {
        let (name, n) = (&f.species.name, f.squirmers);
        let (displaced, instantaneous, diffusion) = (shown(f.displaced), shown(f.instantaneous), shown(f.diffusion));
        let _ = writeln!(
            text,
            "{name:<16} {n:>9} {displaced:>22} {instantaneous:>22} {:>10.5} {diffusion:>22}",
            f.species.u0
        );
    }
    text
}

fn swim_csv(results: &[Found]) -> String {
    let mut text = String::from(
        "species,squirmers,snapshots,speed from displacement [sqrt(kT/m)],error,speed from velocity [sqrt(kT/m)],error,\
         predicted U0 [sqrt(kT/m)],D_R [1/tau],error\n",
    );
    for f in results {
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{},{}",
            quoted(&f.species.name),
            f.squirmers,
            f.snapshots,
            f.displaced.mean,
            f.displaced.error,
            f.instantaneous.mean,
            f.instantaneous.error,
            f.species.u0,
            f.diffusion.mean,
            f.diffusion.error
        );
    }
    text
}

fn lags_csv(results: &[Found], column: &str, lags: fn(&Found) -> &Vec<Lag>) -> String {
    let mut text = format!("species,time [tau],{column},error,origins\n");
    for f in results {
        let name = quoted(&f.species.name);
        for lag in lags(f) {
            let _ = writeln!(text, "{name},{},{},{},{}", lag.time, lag.value.mean, lag.value.error, lag.origins);
        }
    }
    text
}

fn points(lags: &[Lag]) -> Vec<(f64, f64, f64)> {
    lags.iter().map(|l| (l.time, l.value.mean, l.value.error)).collect()
}

fn speed_chart(results: &[Found]) -> Chart {
    let curve = |f: &Found| {
        let points = f.course.clone();
        let guide =
            if f.species.u0.is_finite() { points.iter().map(|p| (p.0, f.species.u0)).collect() } else { Vec::new() };
        let name = format!("{}: {:.4} +- {:.4}", f.species.name, f.instantaneous.mean, f.instantaneous.error);
        Curve { name, points, guide, guide_name: "U0, theory".into() }
    };
    Chart {
        title: "Swimming speed".into(),
        x: "time [tau]".into(),
        y: "V . e [sqrt(kT/m)]".into(),
        scale: Scale::Linear,
        curves: results.iter().map(curve).collect(),
    }
}

fn displacement_chart(results: &[Found]) -> Chart {
    let curve = |f: &Found| {
        let u0 = f.species.u0;
        let ballistic = |l: &Lag| (l.time, (u0 * l.time).powi(2));
        let guide =
            if u0.is_finite() && u0 != 0.0 { f.displacements.iter().map(ballistic).collect() } else { Vec::new() };
        Curve { name: f.species.name.clone(), points: points(&f.displacements), guide, guide_name: "(U0 t)^2".into() }
    };
    Chart {
        title: "Mean squared displacement".into(),
        x: "time [tau]".into(),
        y: "MSD [a^2]".into(),
        scale: Scale::Logarithmic,
        curves: results.iter().map(curve).collect(),
    }
}

fn orientation_chart(results: &[Found]) -> Chart {
    let curve = |f: &Found| {
        let rate = 2.0 * f.diffusion.mean;
        let decay = |l: &Lag| (l.time, (-rate * l.time).exp());
        let guide = if rate.is_finite() { f.orientations.iter().map(decay).collect() } else { Vec::new() };
        let name = format!("{}: D_R = {:.3e} +- {:.1e}", f.species.name, f.diffusion.mean, f.diffusion.error);
        Curve { name, points: points(&f.orientations), guide, guide_name: "exp(-2 D_R t)".into() }
    };
    Chart {
        title: "Memory of the orientation".into(),
        x: "time [tau]".into(),
        y: "<e(t) . e(0)>".into(),
        scale: Scale::Linear,
        curves: results.iter().map(curve).collect(),
    }
}
