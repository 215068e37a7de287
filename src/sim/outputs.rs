//! The outputs of a run: which snapshots are due, and handing them to the writer thread as they arrive from the GPU.

use super::frames::Frame;
use super::live::Live;
use super::saved::Saved;
use super::{Options, RunError, faults};
use crate::gpu::measure::Wanted;
use crate::gpu::{Measurement, Reading, Session};
use crate::graph::{Output, Plan};
use crate::sink::{Job, Kept, Offer, OnSlow, Outlets, Summary, Targets, Writer};
use crate::sink::{Provenance, Publisher, Recorder, Tables};
use crate::state::System;
use crate::wire::{Kind, Stamp};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::Receiver;
use std::time::Duration;

/// Messages that may wait for the disk before the run waits for it.
const DEPTH: usize = 8;

struct Due {
    output: Output,
    measurement: Measurement,
    content: Arc<Content>,
    sequence: u64,
}

/// What the snapshots of one output show, and of what: all that makes messages of a reading, on whatever thread.
struct Content {
    system: System,
    /// Fluid particles that there are, and that a snapshot takes.
    population: u64,
    samples: u64,
    fraction: f64,
    /// Blocks per axis, and cells along the edge of one.
    blocks: [u32; 3],
    block: u32,
    kinds: Vec<(Kind, Targets)>,
}

impl Content {
    fn encode(&self, kind: Kind, frame: &Frame, stamp: &Stamp) -> Vec<u8> {
        let system = &self.system;
        match kind {
            Kind::Squirmers => frame.squirmers_message(system).encode(stamp),
            Kind::Scalars => frame.scalars_message(system).encode(stamp),
            Kind::Fields => frame.fields_message(system, self.blocks, self.block).encode(stamp),
            Kind::Particles => {
                frame.particles_message(system, self.fraction, self.samples, self.population).encode(stamp)
            }
            Kind::Status => unreachable!("no output can ask for the status"),
        }
    }
}

/// All outputs of one run.
pub struct Outputs {
    due: Vec<Due>,
    waiting: VecDeque<(usize, u64, Reading)>,
    /// Until the writer has them.
    outlets: Outlets,
    writer: Option<Writer>,
    run_id: [u8; 16],
}

/// Where the outputs of a run stand at a checkpoint.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Marks {
    /// Output by output.
    pub outputs: Vec<Mark>,
    /// What is on the disk.
    pub kept: Kept,
}

/// Where one output stands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Mark {
    /// What it shows.
    kinds: Vec<String>,
    /// Snapshots so far.
    sequence: u64,
}

impl Mark {
    /// The number with which an output of these kinds goes on: that of the output that showed the same, or else some of it.
    fn sequence(marks: &[Self], kinds: &[(Kind, Targets)]) -> u64 {
        let shows = |mark: &Self, kind: Kind| mark.kinds.iter().any(|k| k == kind.topic());
        let same = |m: &&Self| m.kinds.len() == kinds.len() && kinds.iter().all(|(k, _)| shows(m, *k));
        let some = |m: &&Self| kinds.iter().any(|(k, _)| shows(m, *k));
        marks.iter().find(same).or_else(|| marks.iter().find(some)).map_or(0, |m| m.sequence)
    }
}

/// [`Marks`] on their way from the writer.
#[derive(Default)]
pub struct Marking {
    outputs: Vec<Mark>,
    kept: Option<Receiver<Kept>>,
}

impl Marking {
    /// Waits for the writer; `None` if it has failed.
    pub fn wait(self) -> Option<Marks> {
        let kept = self.kept.map_or_else(|| Some(Kept::default()), |answer| answer.recv().ok())?;
        Some(Marks { outputs: self.outputs, kept })
    }
}

/// What an output wants of one kind.
fn targets(output: &Output, kind: Kind) -> Targets {
    let has = |list: &[String]| list.iter().any(|t| t == kind.topic());
    Targets { publish: has(&output.publish), record: has(&output.record), csv: has(&output.csv) }
}

/// What the output says about slow readers.
fn on_slow(output: &Output) -> OnSlow {
    let limit = Duration::from_secs_f64(output.slow_limit);
    match output.on_slow.as_str() {
        "block" => OnSlow::Block(limit),
        "abort" => OnSlow::Abort(limit),
        _ => OnSlow::Drop,
    }
}

impl Due {
    fn new(output: &Output, session: &Session) -> Result<Self, RunError> {
        let kinds: Vec<(Kind, Targets)> =
            Kind::ALL.into_iter().map(|k| (k, targets(output, k))).filter(|(_, t)| *t != Targets::default()).collect();
        let wants = |kind: Kind| kinds.iter().any(|(k, _)| *k == kind);
        let wanted = Wanted {
            totals: wants(Kind::Scalars),
            block: wants(Kind::Fields).then_some(output.block),
            fraction: wants(Kind::Particles).then_some(output.fraction),
        };
        let measurement = Measurement::new(session, wanted)?;
        let content = Content {
            system: session.system().clone(),
            population: session.particles(),
            samples: measurement.samples,
            fraction: output.fraction,
            blocks: measurement.blocks,
            block: output.block,
            kinds,
        };
        Ok(Self { output: output.clone(), measurement, content: Arc::new(content), sequence: 0 })
    }

    fn stamp(&self, run_id: [u8; 16], step: u64) -> Stamp {
        let system = &self.content.system;
        #[allow(clippy::cast_precision_loss)]
        let time = step as f64 * system.run.dt;
        Stamp {
            run_id,
            step,
            time,
            seq: self.sequence,
            every: self.output.every,
            box_size: system.domain.size.map(f64::from),
            walls: system.domain.walls.is_some(),
        }
    }
}

/// Identity of a run: a hash of what it is, when it began and which process it is.
pub fn identity(plan: &Plan) -> [u8; 16] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(plan.resolved.as_bytes());
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    hasher.update(&now.as_nanos().to_le_bytes());
    hasher.update(&std::process::id().to_le_bytes());
    hasher.finalize().as_bytes()[..16].try_into().expect("16 bytes")
}

pub(super) fn file(what: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> RunError {
    let path = path.to_owned();
    move |source| RunError::File { what, path, source }
}

impl Outputs {
    /// The outputs of a plan, with their topics open but nothing on the disk yet: of a run that is refused nothing is left.
    ///
    /// # Errors
    /// If another run publishes under this name, or shared memory is too small.
    pub fn new(
        plan: &Plan,
        session: &Session,
        (run_id, live): ([u8; 16], &Live),
        saved: Option<&Saved>,
    ) -> Result<Self, RunError> {
        let mut due = plan.outputs.iter().map(|o| Due::new(o, session)).collect::<Result<Vec<_>, _>>()?;
        let marks = saved.map_or(&[] as &[Mark], |s| &s.marks.outputs);
        due.iter_mut().for_each(|d| d.sequence = Mark::sequence(marks, &d.content.kinds));
        let before = saved.map_or_else(Kept::default, |s| s.marks.kept.clone());
        let outlets = Outlets { before, ..Outlets::default() };
        let mut outputs = Self { due, waiting: VecDeque::new(), outlets, writer: None, run_id };
        if let Some(name) = live.name().filter(|_| outputs.any(|t| t.publish)) {
            let publisher = Publisher::offer(name, &outputs.offers(session)?)?;
            live.count(publisher.counters());
            outputs.outlets.publisher = Some(publisher);
        }
        Ok(outputs)
    }

    fn any(&self, pick: fn(&Targets) -> bool) -> bool {
        self.due.iter().any(|d| d.content.kinds.iter().any(|(_, t)| pick(t)))
    }

    /// Opens the files in the run's directory; what is there of a run that goes on is cut to its checkpoint.
    ///
    /// # Errors
    /// If a file cannot be written, or has lost what it had at the checkpoint.
    pub fn open(
        &mut self,
        plan: &Plan,
        options: &Options,
        session: &Session,
        saved: Option<&Saved>,
    ) -> Result<(), RunError> {
        let dir = &options.out;
        let resolved = dir.join("pipeline.toml");
        std::fs::write(&resolved, &plan.resolved).map_err(file("write", &resolved))?;
        let mut outlets = std::mem::take(&mut self.outlets);
        if saved.is_some() {
            outlets.before.cut(dir)?;
        }
        if self.any(|t| t.record) {
            let mut details = details(session, options);
            if let Some(saved) = saved {
                details.insert("resumed_at_step".into(), saved.note.step.into());
            }
            let provenance = Provenance {
                run: plan.name.clone(),
                run_id: self.run_id,
                seed: plan.system.run.seed,
                version: env!("CARGO_PKG_VERSION").to_owned(),
                details,
            };
            let recorder = match saved {
                Some(_) => Recorder::resume(dir, &provenance, &plan.resolved, &outlets.before.recording)?,
                None => Recorder::create(dir, &provenance, &plan.resolved)?,
            };
            outlets.recorder = Some(recorder);
        }
        if self.any(|t| t.csv) {
            let tables = match saved {
                Some(_) => Tables::resume(dir, &outlets.before.tables)?,
                None => Tables::create(dir)?,
            };
            outlets.tables = Some(tables);
        }
        self.writer = Some(Writer::spawn(outlets, DEPTH).map_err(file("start a thread for", dir))?);
        Ok(())
    }

    /// Where the outputs stand, once all that was handed over is on the disk.
    ///
    /// # Errors
    /// If the writer had to stop.
    pub fn mark(&mut self) -> Result<Marking, RunError> {
        let mark = |d: &Due| Mark {
            kinds: d.content.kinds.iter().map(|(k, _)| k.topic().to_owned()).collect(),
            sequence: d.sequence,
        };
        let kept = self.writer.as_mut().map(Writer::mark).transpose()?;
        Ok(Marking { outputs: self.due.iter().map(mark).collect(), kept })
    }

    /// Length of the messages of every published kind: they do not change during a run, so one reading tells.
    fn offers(&self, session: &Session) -> Result<Vec<Offer>, RunError> {
        let mut offers: Vec<Offer> = Vec::new();
        for due in &self.due {
            let reading = due.measurement.take(session);
            session.wait()?;
            let frame = Frame::new(session.system(), &reading.take()?);
            for (kind, _) in due.content.kinds.iter().filter(|(_, t)| t.publish) {
                let max = due.content.encode(*kind, &frame, &due.stamp(self.run_id, frame.step)).len();
                match offers.iter_mut().find(|o| o.kind == *kind) {
                    Some(offer) => offer.max = max.max(offer.max),
                    None => offers.push(Offer { kind: *kind, max, on_slow: on_slow(&due.output) }),
                }
            }
        }
        Ok(offers)
    }

    /// The first step after `step` at which something is due.
    #[must_use]
    pub fn next_due(&self, step: u64) -> u64 {
        self.due.iter().map(|d| step - step % d.output.every + d.output.every).min().unwrap_or(u64::MAX)
    }

    /// Takes what is due after `step` steps.
    ///
    /// # Errors
    /// If the GPU refuses.
    pub fn take(&mut self, session: &Session, step: u64) -> Result<(), RunError> {
        for (index, due) in self.due.iter().enumerate() {
            if step.is_multiple_of(due.output.every) && !due.content.kinds.is_empty() {
                self.waiting.push_back((index, step, due.measurement.take(session)));
            }
        }
        Ok(())
    }

    /// Whether so many readings are under way that the loop should wait for them.
    #[must_use]
    pub fn crowded(&self) -> bool {
        self.waiting.len() > DEPTH
    }

    /// Hands what has arrived to the writer thread, which also makes the messages: a large snapshot takes longer to copy than the
    /// steps that are submitted ahead. Once `stop` is true nothing waits for slow readers.
    ///
    /// # Errors
    /// If a snapshot was lost or the writer had to stop.
    pub fn hand_over(&mut self, plan: &Plan, stop: &dyn Fn() -> bool) -> Result<(), RunError> {
        while self.waiting.front().is_some_and(|(_, _, r)| r.settled()) {
            let (index, _, reading) = self.waiting.pop_front().expect("not empty");
            let parts = reading.take()?;
            faults::check(plan, parts.step, &parts.get::<u32>("faults"))?;
            let due = &mut self.due[index];
            let (content, stamp) = (due.content.clone(), due.stamp(self.run_id, parts.step));
            let job = Job::snapshot(move || {
                let frame = Frame::new(&content.system, &parts);
                drop(parts);
                content.kinds.iter().map(|(kind, to)| (content.encode(*kind, &frame, &stamp), *to)).collect()
            });
            if let Some(writer) = &mut self.writer {
                writer.send_until(job, stop)?;
            }
            due.sequence += 1;
        }
        Ok(())
    }

    /// Waits for the writer and closes everything.
    ///
    /// # Errors
    /// If a file could not be finished.
    pub fn finish(self) -> Result<Summary, RunError> {
        Ok(self.writer.map_or(Ok(Summary::default()), Writer::finish)?)
    }
}

fn details(session: &Session, options: &Options) -> serde_json::Map<String, serde_json::Value> {
    let mut map = serde_json::Map::new();
    map.insert("adapter".into(), session.adapter().into());
    map.insert("driver".into(), session.driver().into());
    map.insert("command".into(), options.command.clone().into());
    map
}
