//! Trajectories of one species: speeds, displacements and orientations, and their correlation in time.

use crate::analyze::statistics::{Estimate, blocked, course, independent, jackknife, mean};
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Squirmers of one species that are followed through time; the speeds are those of all.
const FOLLOWED: usize = 1024;
/// Stretches that are left out in turn for the error of a fit.
const STRETCHES: usize = 10;

/// One squirmer at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Unwrapped centre in a.
    pub position: DVec3,
    /// Velocity in sqrt(kT/m).
    pub velocity: DVec3,
    /// Swimming axis.
    pub axis: DVec3,
}

/// Unwrapped centre and swimming axis.
type Body = (DVec3, Vec3);

#[derive(Debug, Clone)]
struct Frame {
    index: u64,
    bodies: Vec<Body>,
}

/// A value at one distance in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lag {
    /// Distance in time in tau.
    pub time: f64,
    /// Mean over squirmers and origins of time.
    pub value: Estimate,
    /// Origins of time.
    pub origins: usize,
}

/// What is known of one species.
#[derive(Debug, Clone, Default)]
pub struct Trajectories {
    times: Vec<f64>,
    instantaneous: Vec<f64>,
    displaced: Vec<f64>,
    frames: Vec<Frame>,
    last: Option<(u64, f64, Vec<Sample>)>,
    spacing: f64,
}

impl Trajectories {
    /// Takes all squirmers of the species; `index` counts the moments, and jumps where some were lost.
    pub fn push(&mut self, index: u64, time: f64, samples: Vec<Sample>) {
        self.times.push(time);
        self.instantaneous.push(average(samples.iter().map(|s| s.velocity.dot(s.axis))));
        let stride = samples.len().div_ceil(FOLLOWED).max(1);
        let bodies = samples.iter().step_by(stride).map(|s| (s.position, s.axis.as_vec3())).collect();
        self.frames.push(Frame { index, bodies });
        if let Some((before, then, old)) = &self.last
            && index == before + 1
            && time > *then
        {
            self.spacing = time - then;
            let along = |(a, b): (&Sample, &Sample)| {
                (b.position - a.position).dot((a.axis + b.axis).normalize_or_zero()) / (time - then)
            };
            self.displaced.push(average(old.iter().zip(&samples).map(along)));
        }
        self.last = Some((index, time, samples));
    }

    /// Moments taken.
    #[must_use]
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether nothing was taken.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Squirmers of the species.
    #[must_use]
    pub fn squirmers(&self) -> usize {
        self.last.as_ref().map_or(0, |(_, _, samples)| samples.len())
    }

    /// <V . e> from velocities at the moments of the snapshots: exact moments, but with the full thermal noise.
    #[must_use]
    pub fn speed(&self) -> Estimate {
        blocked(&self.instantaneous)
    }

    /// <V . e> from displacements between snapshots along the mean of the two axes: thermal noise averages out within
    /// the interval, in which the axis must not turn much.
    #[must_use]
    pub fn displacement_speed(&self) -> Estimate {
        blocked(&self.displaced)
    }

    /// Mean of V . e over stretches of time: time, value and its error.
    #[must_use]
    pub fn speeds_in_time(&self) -> Vec<(f64, f64, f64)> {
        course(&self.times, &self.instantaneous)
    }

    /// Mean squared displacement in a^2.
    #[must_use]
    pub fn displacements(&self) -> Vec<Lag> {
        self.correlate(|a, b| a.0.distance_squared(b.0))
    }

    /// <e(t) . e(0)>.
    #[must_use]
    pub fn orientations(&self) -> Vec<Lag> {
        self.correlate(turned)
    }

    /// Rotational diffusion coefficient D_R in 1/tau of <e(t).e(0)> = exp(-2 D_R t), fitted where the correlation is
    /// above 0.3: a line through the origin in the logarithm, each point with the weight of its error. Lags at which the
    /// body's inertia still keeps it turning are left out: there -ln<e(t).e(0)>/2t is still rising towards D_R.
    #[must_use]
    pub fn rotational_diffusion(&self) -> Estimate {
        let lookup = self.lookup();
        let used: Vec<Lag> = self.orientations().into_iter().take_while(|l| l.value.mean > 0.3).collect();
        let used = diffusive(&used);
        let mut series = Vec::new();
        for lag in used {
            let steps = (lag.time / self.spacing).round();
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let values = self.over_origins(&lookup, steps as u64, &turned);
            let weight = if lag.value.error > 0.0 { (lag.value.mean / lag.value.error).powi(2) } else { 1.0 };
            series.push((lag.time, weight, values));
        }
        let fit = |keep: &dyn Fn(usize) -> bool| {
            let (mut above, mut below) = (0.0, 0.0);
            for (time, weight, values) in &series {
                let correlation =
                    average(values.iter().filter(|(origin, _)| keep(*origin)).map(|(_, bodies)| mean(bodies)));
                if correlation > 0.0 {
                    above -= weight * time * correlation.ln();
                    below += weight * 2.0 * time * time;
                }
            }
            above / below
        };
        if series.is_empty() {
            return Estimate::NONE;
        }
        Estimate { mean: fit(&|_| true), error: jackknife(self.frames.len(), STRETCHES, fit) }
    }

    /// Frames by their index.
    fn lookup(&self) -> HashMap<u64, usize> {
        self.frames.iter().enumerate().map(|(i, f)| (f.index, i)).collect()
    }

    /// For every origin that has a partner `steps` later: the origin, and `f` of each squirmer.
    fn over_origins(
        &self,
        lookup: &HashMap<u64, usize>,
        steps: u64,
        f: &dyn Fn(&Body, &Body) -> f64,
    ) -> Vec<(usize, Vec<f64>)> {
        let pair = |(origin, a): (usize, &Frame)| {
            let b = &self.frames[*lookup.get(&(a.index + steps))?];
            Some((origin, a.bodies.iter().zip(&b.bodies).map(|(a, b)| f(a, b)).collect()))
        };
        self.frames.iter().enumerate().filter_map(pair).collect()
    }

    /// `f` at about ten distances per factor of ten up to a quarter of the whole time. The error is the larger of that
    /// from blocking in time and that between squirmers: the first fails where few independent stretches remain, the
    /// second where there are few squirmers.
    fn correlate(&self, f: impl Fn(&Body, &Body) -> f64) -> Vec<Lag> {
        let span = self.frames.last().map_or(0, |last| last.index - self.frames[0].index);
        let lookup = self.lookup();
        let mut lags = Vec::new();
        for steps in logarithmic((span / 4).max(1)) {
            let rows = self.over_origins(&lookup, steps, &f);
            if rows.is_empty() {
                continue;
            }
            let in_time = blocked(&rows.iter().map(|(_, bodies)| mean(bodies)).collect::<Vec<_>>());
            let count = rows[0].1.len();
            let per_squirmer = |i| average(rows.iter().filter_map(|(_, bodies)| bodies.get(i).copied()));
            let between = independent(&(0..count).map(per_squirmer).collect::<Vec<_>>());
            let value = Estimate { error: in_time.error.max(between.error), ..in_time };
            lags.push(Lag { time: steps as f64 * self.spacing, value, origins: rows.len() });
        }
        lags
    }
}

fn turned(a: &Body, b: &Body) -> f64 {
    f64::from(a.1.dot(b.1))
}

/// Mean of an iterator; NaN of nothing.
fn average(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0usize), |(sum, n), v| (sum + v, n + 1));
    sum / n as f64
}

/// Whole numbers from 1 to `last`, about ten per factor of ten.
fn logarithmic(last: u64) -> Vec<u64> {
    let (mut list, mut next) = (Vec::new(), 1);
    while next <= last {
        list.push(next);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
        let grown = (next as f64 * 1.258_925).round() as u64;
        next = grown.max(next + 1);
    }
    list
}

/// The lags from the first one whose -ln<e(t).e(0)>/2t no later lag exceeds by more than two of its errors.
fn diffusive(lags: &[Lag]) -> &[Lag] {
    let rate = |l: &Lag| -l.value.mean.ln() / (2.0 * l.time);
    let error = |l: &Lag| l.value.error / (l.value.mean * 2.0 * l.time);
    let settled = |k: usize| !lags[k + 1..].iter().any(|later| rate(later) - rate(&lags[k]) > 2.0 * error(later));
    let first = (0..lags.len()).find(|k| settled(*k)).unwrap_or(0);
    &lags[first..]
}
