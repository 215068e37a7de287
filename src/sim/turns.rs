//! The turns of the step loop: batches of steps, samples for the books and the outputs, checkpoints, and the end.

use super::inject::Injection;
use super::keeper::Keeper;
use super::live::Live;
use super::outputs::{Marks, Outputs};
use super::saved::{Draft, Note, Saved};
use super::summary::{Speed, Summary};
use super::{Books, Options, RunError, Watch, faults, frames::Frame};
use crate::gpu::measure::Wanted;
use crate::gpu::session::Submission;
use crate::gpu::{Measurement, Reading, Session};
use crate::graph::Plan;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Submissions that may wait for the GPU: enough that it never idles, few enough that the host stays near it.
const AHEAD: usize = 2;
/// Steps of one submission at most. Faults are looked at after each, so that no more than 100 steps are done after one.
const MOST: u64 = 99 / (AHEAD as u64 + 1);
/// Readings that may wait for the host before the loop waits for them.
const READINGS: usize = 8;
/// Aim for the length of one submission.
const BATCH: Duration = Duration::from_millis(100);
/// Every how manieth sample for the books includes the fluid.
const FLUID: u64 = 10;
/// What the end of a run takes besides its last checkpoint, with something to spare.
const CLOSING: Duration = Duration::from_secs(2);

/// Submissions under way, with their steps.
type Ahead = VecDeque<(Submission, u64)>;

/// A run between its start and its end.
pub struct Turns<'a> {
    plan: &'a Plan,
    session: Session,
    outputs: Outputs,
    live: &'a Live,
    keeper: Keeper,
    note: Note,
    /// What is measured for the books: always the squirmers; the fluid, too, every `FLUID`th time.
    light: Measurement,
    full: Measurement,
    books: Books,
    waiting: VecDeque<(Reading, bool)>,
    deadline: Option<Instant>,
    /// The longest wait for a submission.
    longest: Duration,
    inject: Option<Injection>,
    /// The step of the newest checkpoint.
    kept: u64,
    /// Wall time of earlier parts of the run, in seconds.
    before: f64,
    began: Instant,
}

/// Writes the checkpoint of a run that has done nothing yet: from now on its directory never lacks one.
///
/// # Errors
/// If it cannot be written.
pub fn keep_start(keeper: &mut Keeper, session: &Session, plan: &Plan, note: &Note) -> Result<(), RunError> {
    if !keeper.enabled() {
        return Ok(());
    }
    let note = Note { particles: session.particles(), every: every(plan), ..note.clone() };
    let books = Books::new(&plan.system).numbers();
    let draft = Draft { note, books, buffers: session.persistent()?, resolved: plan.resolved.clone() };
    keeper.write(&draft, &Marks::default())
}

/// Steps between two entries of the books.
fn every(plan: &Plan) -> u64 {
    (plan.system.run.steps / 1000).clamp(10, 1000)
}

impl<'a> Turns<'a> {
    /// A run that begins, or goes on from what was saved.
    ///
    /// # Errors
    /// If the GPU refuses, or the books that were saved are not those of the plan.
    pub fn new(
        plan: &'a Plan,
        (session, outputs, live): (Session, Outputs, &'a Live),
        (keeper, note): (Keeper, Note),
        saved: Option<&Saved>,
        options: &Options,
    ) -> Result<Self, RunError> {
        let light = Measurement::new(&session, Wanted { totals: false, block: None, fraction: None })?;
        let full = Measurement::new(&session, Wanted { totals: true, block: None, fraction: None })?;
        let books = saved.map_or_else(|| Ok(Books::new(&plan.system)), |s| s.books(plan))?;
        let before = saved.map_or(0.0, |s| s.note.speed.seconds);
        let note = Note {
            particles: session.particles(),
            every: saved.map_or_else(|| every(plan), |s| s.note.every.max(1)),
            speed: Speed::new(session.adapter()),
            ..note
        };
        let (waiting, began) = (VecDeque::new(), Instant::now());
        let (deadline, inject) = (options.deadline, options.inject);
        Ok(Self {
            plan,
            session,
            outputs,
            live,
            keeper,
            note,
            light,
            full,
            books,
            waiting,
            deadline,
            longest: BATCH,
            inject,
            kept: saved.map_or(0, |s| s.note.step),
            before,
            began,
        })
    }

    /// All steps that are left, or as many as there is time for; the last checkpoint is on the disk then.
    ///
    /// # Errors
    /// What stopped the run.
    pub fn run(&mut self, watch: &mut dyn Watch) -> Result<(), RunError> {
        let last = self.plan.system.run.steps;
        if self.session.step() == 0 {
            self.sample(0)?;
        }
        let mut ahead = Ahead::new();
        let mut batch = 1;
        self.began = Instant::now();
        while self.session.step() < last && !watch.stop() && !self.late() {
            let steps = batch.min(self.next_due().min(last) - self.session.step());
            ahead.push_back((self.session.advance(steps, true), steps));
            let step = self.session.step();
            self.sample(step)?;
            if let Some(injection) = self.inject.take_if(|i| i.step <= step) {
                injection.apply(&self.session);
            }
            if ahead.len() > AHEAD {
                batch = next_batch(batch, self.settle(&mut ahead)?);
                self.tell(step.saturating_sub(ahead.iter().map(|(_, n)| n).sum()), watch);
            }
            self.collect(false, watch)?;
            self.keeper.glance()?;
            if self.keeper.due(step) {
                self.drain(&mut ahead, watch)?;
                self.keep()?;
            }
        }
        self.drain(&mut ahead, watch)?;
        self.tell(self.session.step(), watch);
        self.note.speed.finish(self.session.step(), self.before + self.began.elapsed().as_secs_f64());
        if self.keeper.enabled() && self.session.step() > self.kept {
            self.keep()?;
            self.keeper.settle()?;
        }
        Ok(())
    }

    /// Says to all who watch that so many steps are done.
    #[allow(clippy::cast_precision_loss)]
    fn tell(&self, done: u64, watch: &mut dyn Watch) {
        watch.progress(done);
        self.live.progress(done, done as f64 * self.plan.system.run.dt, &self.note.speed);
    }

    /// Whether the run has to end now to be over at its deadline.
    fn late(&self) -> bool {
        let left = self.deadline.map(|d| d.saturating_duration_since(Instant::now()));
        left.is_some_and(|left| left < CLOSING + 3 * self.longest + 2 * self.keeper.took())
    }

    /// The next step at which something is due.
    fn next_due(&self) -> u64 {
        let (step, every) = (self.session.step(), self.note.every);
        let injected = self.inject.map_or(u64::MAX, |i| i.step.max(step + 1));
        let books = step - step % every + every;
        self.outputs.next_due(step).min(books).min(self.keeper.next_due(step)).min(injected)
    }

    /// Waits for the oldest submission; its steps, and how long it was waited for.
    fn settle(&mut self, ahead: &mut Ahead) -> Result<(u64, Duration), RunError> {
        let (submission, steps) = ahead.pop_front().expect("not empty");
        let before = Instant::now();
        self.session.wait_for(&submission)?;
        let waited = before.elapsed();
        self.longest = self.longest.max(waited);
        if let Some(times) = self.session.times(&submission) {
            self.note.speed.add(&times);
        }
        let done = self.session.step() - ahead.iter().map(|(_, n)| n).sum::<u64>();
        faults::check(self.plan, done, &self.session.found(&submission)?)?;
        Ok((steps, waited))
    }

    /// Waits for all submissions and readings.
    fn drain(&mut self, ahead: &mut Ahead, watch: &dyn Watch) -> Result<(), RunError> {
        self.session.wait()?;
        while !ahead.is_empty() {
            self.settle(ahead)?;
        }
        self.collect(true, watch)
    }

    /// Begins a checkpoint; nothing is under way.
    fn keep(&mut self) -> Result<(), RunError> {
        self.kept = self.session.step();
        let mut note = Note { step: self.session.step(), ..self.note.clone() };
        note.speed.finish(note.step, self.before + self.began.elapsed().as_secs_f64());
        let (books, resolved) = (self.books.numbers(), self.plan.resolved.clone());
        let draft = Draft { note, books, buffers: self.session.persistent()?, resolved };
        self.keeper.begin(draft, self.outputs.mark()?)
    }

    /// Takes what is due after `step` steps, for the books and for the outputs.
    fn sample(&mut self, step: u64) -> Result<(), RunError> {
        if step.is_multiple_of(self.note.every) {
            self.measure(step.is_multiple_of(self.note.every * FLUID));
        }
        self.outputs.take(&self.session, step)
    }

    fn measure(&mut self, fluid: bool) {
        let measurement = if fluid { &self.full } else { &self.light };
        self.waiting.push_back((measurement.take(&self.session), fluid));
    }

    /// Enters readings that have arrived into the books; with `all`, or if too many are under way, waits for them.
    fn collect(&mut self, all: bool, watch: &dyn Watch) -> Result<(), RunError> {
        if all || self.waiting.len() > READINGS || self.outputs.crowded() {
            self.session.wait()?;
        }
        self.session.poll()?;
        while self.waiting.front().is_some_and(|(r, _)| r.settled()) {
            let (reading, fluid) = self.waiting.pop_front().expect("not empty");
            let frame = Frame::new(self.session.system(), &reading.take()?);
            faults::check(self.plan, frame.step, &frame.faults)?;
            self.books.enter(&frame, fluid);
            self.live.frame(&frame, fluid);
        }
        self.outputs.hand_over(self.plan, &|| watch.stop())
    }

    /// Enters the end into the books, which the checkpoint must not have, since the run may go on; then closes the outputs.
    ///
    /// # Errors
    /// If something cannot be written.
    pub fn close(mut self, options: &Options, watch: &dyn Watch) -> Result<Summary, RunError> {
        self.measure(true);
        self.collect(true, watch)?;
        let digest = self.session.raw()?.digest();
        let memory = self.session.memory();
        let files = self.outputs.finish()?;
        let summary = Summary::new(self.plan, &self.books, self.note.speed, memory, files, digest);
        summary.write(&options.out)?;
        Ok(summary)
    }
}

/// Grows the batch towards [`BATCH`]; waiting for the GPU tells how long the last one took. Batches are odd: after an even number of steps
/// particles that lie brick by brick have to be copied to where they are looked for.
fn next_batch(batch: u64, (steps, waited): (u64, Duration)) -> u64 {
    if waited > 2 * BATCH && steps > 1 {
        (batch / 2) | 1
    } else if waited < BATCH / 2 && steps == batch {
        (batch * 2 + 1).min(MOST)
    } else {
        batch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_are_odd() {
        let (mut batch, mut seen) = (1, Vec::new());
        for _ in 0..7 {
            batch = next_batch(batch, (batch, Duration::ZERO));
            seen.push(batch);
        }
        assert_eq!(seen, [3, 7, 15, 31, MOST, MOST, MOST]);
        for expected in [17, 9, 5, 3, 1, 1] {
            batch = next_batch(batch, (batch, 3 * BATCH));
            assert_eq!(batch, expected);
        }
        // What was due cut one short: that says nothing.
        assert_eq!(next_batch(7, (2, Duration::ZERO)), 7);
    }
}
