//! Measuring one case: batches of steps that follow each other without a gap, then stage times in batches of their own.

use super::BenchError;
use super::cases::Measure;
use super::report::{CopyRate, Measured, Memory, StageCost, Target};
use super::statistics::Spread;
use crate::buffers::{Extent, Fault};
use crate::gpu::{Form, Gpu, Session};
use crate::graph::Plan;
use crate::graph::traffic::{self, Work};
use crate::sim::RunError;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// How long to measure.
#[derive(Debug, Clone, Copy, Default)]
pub struct Effort {
    /// For at least this long, in seconds.
    pub seconds: Option<f64>,
    /// This many steps instead.
    pub steps: Option<u64>,
}

/// Batches at least.
const BATCHES: u64 = 5;
/// Steps per batch on a GPU.
const BATCH: (u64, u64) = (50, 100);
/// Steps at least on a GPU.
const STEPS: u64 = 500;
/// Seconds per case on a GPU, and on a CPU.
const SECONDS: f64 = 1.0;
const SECONDS_CPU: f64 = 10.0;
/// Seconds that a GPU takes until its clock no longer rises.
const WARM: f64 = 0.5;

/// What is measured.
struct Subject<'a> {
    session: Session,
    /// Every how many steps those stages run that do not run in each.
    period: u64,
    cpu: bool,
    fused: bool,
    stop: &'a dyn Fn() -> bool,
}

/// The bandwidth of a copy on this adapter.
///
/// # Errors
/// If memory runs out or the device was lost.
pub fn copy(gpu: &Gpu) -> Result<CopyRate, BenchError> {
    let time = if gpu.summary.kind == "CPU" { 0.05 } else { WARM };
    let copied = gpu.copy_bandwidth(7, Duration::from_secs_f64(time))?;
    let gb_per_s = Spread::of(&copied.rates).ok_or(BenchError::Stopped)?.times(1e-9);
    Ok(CopyRate { bytes: copied.bytes, gb_per_s })
}

/// Measures a plan without its outputs; `name` and `what` tell which it is.
///
/// # Errors
/// If it cannot start, a kernel reports a fault, or `stop` says so.
#[allow(clippy::cast_precision_loss)]
pub fn measure(
    (gpu, copy, form): (&Gpu, &CopyRate, Form),
    (name, what, plan): (&str, &str, &Plan),
    effort: Effort,
    stop: &dyn Fn() -> bool,
) -> Result<Measured, BenchError> {
    Session::fits(gpu, plan, form)?;
    let state = crate::state::start::start(&plan.system).map_err(RunError::from)?;
    let session = Session::formed(gpu, plan, &state, form)?;
    drop(state);
    let fused = form == Form::Fused;
    let period = traffic::period(plan, session.sizes());
    let mut subject = Subject { session, period, cpu: gpu.summary.kind == "CPU", fused, stop };
    let (batch, seconds) = subject.batches(effort)?;
    let stamped = subject.stages()?;
    let faults = subject.session.faults()? & !(Fault::Stuck as u32);
    if faults != 0 {
        return Err(BenchError::Faults(faults));
    }
    let session = &subject.session;
    let particles = session.particles();
    let sizes = session.sizes();
    let work = if fused { traffic::fused(plan, sizes) } else { traffic::loose(plan, sizes) };
    let work = work.map_err(crate::gpu::GpuError::from)?;
    let us_per_step = Spread::of(&seconds).ok_or(BenchError::Stopped)?.times(1e6 / batch as f64);
    let ns = us_per_step.times(1e3 / particles.max(1) as f64);
    let bytes_per_particle = work.iter().map(|w| w.bytes).sum();
    let gb_per_s = bytes_per_particle / ns.median;
    Ok(Measured {
        case: name.to_owned(),
        what: what.to_owned(),
        size: plan.system.domain.size,
        particles,
        squirmers: u64::from(plan.system.squirmer_count()),
        steps: batch * seconds.len() as u64,
        batch,
        us_per_step,
        ns_per_particle_step: ns,
        target: None,
        launches: work.iter().map(|w| w.launches).sum(),
        bytes_per_particle,
        gb_per_s,
        share_of_copy: gb_per_s / copy.gb_per_s.median,
        memory: memory(session),
        stages: stages(&work, &stamped, ns.median, copy),
        notes: notes(batch, period, &stamped),
    })
}

impl Measured {
    /// Holds it against a target; `before` are the cases measured before it.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn with_target(mut self, target: Option<(Measure, f64)>, density: f64, before: &[Self]) -> Self {
        self.target = target.map(|(measure, at_most)| {
            let full = density * self.size.iter().map(|n| f64::from(*n)).product::<f64>();
            let measured = match measure {
                Measure::Particle => Some(self.ns_per_particle_step.median),
                Measure::FullBox => Some(1e3 * self.us_per_step.median / full),
                Measure::Step => Some(self.us_per_step.median),
                Measure::Times(other) => {
                    let other = before.iter().find(|m| m.case == other && m.size == self.size);
                    other.map(|other| self.us_per_step.median / other.us_per_step.median)
                }
            };
            Target { unit: measure.unit(), at_most, measured }
        });
        self
    }
}

impl Subject<'_> {
    /// Warms up, and measures: steps per batch, and the wall time of each batch in seconds.
    fn batches(&mut self, effort: Effort) -> Result<(u64, Vec<f64>), BenchError> {
        let pace = self.warm_up(effort)?;
        let seconds = effort.seconds.unwrap_or(if self.cpu { SECONDS_CPU } else { SECONDS });
        let batch = batch(effort.steps, seconds / pace.max(1e-9), self.period, self.cpu);
        let usual = BATCHES.max(if self.cpu { 0 } else { STEPS.div_ceil(batch) });
        let wanted = effort.steps.map_or(usual, |steps| steps.div_ceil(batch));
        // A GPU must not idle between batches; the first then begins before its time is taken.
        let ahead = usize::from(!self.cpu);
        let (mut waiting, mut times) = (VecDeque::new(), Vec::new());
        let (mut mark, mut first) = (Instant::now(), ahead > 0);
        let began = mark;
        loop {
            while waiting.len() <= ahead {
                waiting.push_back(self.session.advance(batch, false));
            }
            self.session.wait_for(&waiting.pop_front().expect("not empty"))?;
            let now = Instant::now();
            if !std::mem::take(&mut first) {
                times.push((now - mark).as_secs_f64());
            }
            mark = now;
            let long = effort.steps.is_some() || began.elapsed().as_secs_f64() >= seconds;
            if times.len() as u64 >= wanted && long {
                break;
            }
            self.go_on()?;
        }
        self.session.wait()?;
        Ok((batch, times))
    }

    /// Runs until the clock has risen; seconds per step.
    #[allow(clippy::cast_precision_loss)]
    fn warm_up(&mut self, effort: Effort) -> Result<f64, BenchError> {
        let (steps, least) = if self.cpu { (2, 0.0) } else { (BATCH.0, WARM) };
        let steps = effort.steps.map_or(steps, |n| n.clamp(1, steps));
        // Drivers compile when a kernel runs for the first time; the very first step may be one of those with rare stages.
        for _ in 0..2 {
            self.session.advance(steps, false);
            self.session.wait()?;
        }
        let began = Instant::now();
        loop {
            let before = Instant::now();
            self.session.advance(steps, false);
            self.session.wait()?;
            self.go_on()?;
            if began.elapsed().as_secs_f64() >= least {
                return Ok(before.elapsed().as_secs_f64() / steps as f64);
            }
        }
    }

    fn go_on(&self) -> Result<(), BenchError> {
        if (self.stop)() { Err(BenchError::Stopped) } else { Ok(()) }
    }

    /// Nanoseconds of each stage in an average step, from timestamps.
    #[allow(clippy::cast_precision_loss)]
    fn stages(&mut self) -> Result<Vec<(String, f64)>, BenchError> {
        let rare = 1.0 / self.period as f64;
        let (often, seldom, length) = if self.cpu { (3, 1, 3) } else { (20, 5, 10) };
        let mut kinds = vec![(false, often, 1.0 - rare)];
        if self.period > 1 {
            kinds.push((true, seldom, rare));
        } else {
            kinds[0].2 = 1.0;
        }
        let mut mean: Vec<(String, f64)> = Vec::new();
        for (at_period, count, weight) in kinds {
            let mut submissions = Vec::new();
            // The first is not used: a driver may compile kernels in it that have not run before.
            for _ in 0..=count {
                let gap = self.gap(at_period);
                if gap > 0 {
                    self.session.advance(gap, false);
                }
                submissions.push(self.session.advance(length, true));
            }
            self.session.wait()?;
            self.go_on()?;
            let times: Vec<_> = submissions.iter().skip(1).filter_map(|s| self.session.times(s)).collect();
            for (label, _) in times.first().map_or(&[][..], |t| &t.stages) {
                let each =
                    times.iter().flat_map(|t| t.stages.iter().filter(|(l, _)| l == label).map(|(_, time)| *time));
                let median = weight * Spread::of(&each.collect::<Vec<_>>()).map_or(0.0, |s| s.median);
                match mean.iter_mut().find(|(known, _)| known == label) {
                    Some((_, sum)) => *sum += median,
                    None => mean.push((label.clone(), median)),
                }
            }
        }
        Ok(mean)
    }

    /// Steps until a submission's timed step is one in which the rare stages run, or is not.
    fn gap(&self, at_period: bool) -> u64 {
        // Of the fused plan the second step is timed.
        let timed = self.session.step() + u64::from(self.fused);
        let late = timed % self.period;
        match (at_period, late) {
            _ if self.period == 1 => 0,
            (true, 0) => 0,
            (true, late) => self.period - late,
            (false, 0) => 1,
            (false, _) => 0,
        }
    }
}

/// Steps per batch: as many as fit the time, whole periods of the rare stages where there is room for them.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn batch(steps: Option<u64>, affordable: f64, period: u64, cpu: bool) -> u64 {
    let (least, most) = if cpu { (1, BATCH.0) } else { BATCH };
    let fits = match steps {
        Some(steps) => (steps / BATCHES).clamp(1, most),
        None => ((affordable / BATCHES as f64) as u64).clamp(least, most),
    };
    match period {
        // After an odd number of steps particles are where they are looked for.
        1 => (fits - 1) | 1,
        _ if fits > period => fits - fits % period,
        _ => fits,
    }
}

/// What a reader should know of how it was measured.
fn notes(batch: u64, period: u64, stamped: &[(String, f64)]) -> Vec<String> {
    let mut notes = Vec::new();
    if batch < period {
        notes.push(format!("batches of {batch} steps: the median leaves out stages that run every {period}"));
    }
    if stamped.is_empty() {
        notes.push("this adapter has no timestamps: no times of kernels".into());
    }
    notes
}

/// Each kernel with its share of the time.
fn stages(work: &[Work], stamped: &[(String, f64)], ns: f64, copy: &CopyRate) -> Vec<StageCost> {
    let total: f64 = stamped.iter().map(|(_, time)| time).sum();
    let cost = |w: &Work| {
        let time = stamped.iter().find(|(label, _)| *label == w.label).map(|(_, time)| *time);
        let share = time.filter(|_| total > 0.0).map(|time| time / total);
        let own = share.map(|share| share * ns);
        let gb_per_s = own.filter(|own| *own > 0.0).map(|own| w.bytes / own);
        StageCost {
            stage: w.label.clone(),
            launches: w.launches,
            share,
            ns_per_particle_step: own,
            bytes_per_particle: w.bytes,
            gb_per_s,
            share_of_copy: gb_per_s.map(|rate| rate / copy.gb_per_s.median),
        }
    };
    work.iter().map(cost).collect()
}

#[allow(clippy::cast_precision_loss)]
fn memory(session: &Session) -> Memory {
    let taken = crate::graph::memory(session.buffers().map(|(name, _)| name), session.sizes());
    let bytes_over = |extents: &[Extent]| -> u64 {
        taken.iter().filter(|(b, _)| extents.contains(&b.extent)).map(|(_, bytes)| bytes).sum()
    };
    let particles = bytes_over(&[Extent::Particles, Extent::Links, Extent::Waiting, Extent::Rooms]);
    let cells = bytes_over(&[Extent::Cells, Extent::Bricks, Extent::Blocks, Extent::Scans]);
    let bytes = session.memory();
    let count: f64 = session.system().domain.volume();
    Memory {
        bytes,
        per_particle: particles as f64 / session.particles().max(1) as f64,
        per_cell: cells as f64 / count.max(1.0),
        others: bytes.saturating_sub(particles + cells),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_are_whole_periods_where_they_can_be() {
        assert_eq!(batch(Some(20), 0.0, 50, true), 4);
        assert_eq!(batch(Some(3), 0.0, 50, true), 1);
        assert_eq!(batch(Some(1000), 0.0, 50, false), 100);
        assert_eq!(batch(None, 1e6, 1, false), 99);
        assert_eq!((batch(Some(5), 0.0, 1, true), batch(Some(255), 0.0, 1, false)), (1, 51));
        assert_eq!(batch(None, 400.0, 50, false), 50);
        assert_eq!(batch(None, 60.0, 50, true), 12);
    }

    #[test]
    fn shares_scale_stamps_to_the_measured_time() {
        let of = |label: &str, bytes| Work { label: label.into(), launches: 1.0, bytes };
        let work = [of("a", 30.0), of("b", 0.0), of("c", 1.0)];
        let rate = Spread { median: 100.0, low: 100.0, high: 100.0 };
        let copy = CopyRate { bytes: 16, gb_per_s: rate };
        let costs = stages(&work, &[("a".into(), 300.0), ("b".into(), 100.0)], 0.8, &copy);
        assert_eq!(costs[0].share, Some(0.75));
        // 30 bytes in 0.6 ns are 50 GB/s.
        assert!(costs[0].share_of_copy.is_some_and(|s| (s - 0.5).abs() < 1e-12), "{costs:?}");
        assert_eq!((costs[1].share, costs[2].share, costs[2].gb_per_s), (Some(0.25), None, None));
    }
}
