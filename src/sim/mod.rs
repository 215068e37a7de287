//! The step loop: steps are submitted ahead, snapshots leave on a thread of their own, and nothing in the loop waits for the host.

mod analyzers;
mod books;
mod frames;
mod live;
mod outputs;
mod summary;

pub use books::Books;
pub use summary::{Speed, Summary, SwimSpeed};

use crate::gpu::measure::Wanted;
use crate::gpu::{Form, Gpu, GpuError, Measurement, Reading, Session};
use crate::graph::Plan;
use crate::sink::SinkError;
use crate::state::start::StartError;
use analyzers::Analyzers;
use frames::Frame;
use live::Live;
use outputs::Outputs;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// How a plan is to be run.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Directory for everything the run writes; must not hold a run yet.
    pub out: PathBuf,
    /// Number, or part of the name, of the adapter.
    pub adapter: Option<String>,
    /// The command line, for the record.
    pub command: String,
    /// How stages become kernels.
    pub form: Form,
}

/// Why a run did not finish.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The GPU.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The start.
    #[error(transparent)]
    Start(#[from] StartError),
    /// A recording, a topic or a table.
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// A file or directory.
    #[error("cannot {what} {}: {source}", path.display())]
    File {
        /// What was to be done.
        what: &'static str,
        /// With what.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The output directory holds a run already.
    #[error("{} holds a run already: name another directory with --out, or remove it", .0.display())]
    Occupied(PathBuf),
    /// What was named as the output directory is no directory.
    #[error("{} is a file, not a directory: name another directory with --out", .0.display())]
    NoDirectory(PathBuf),
    /// A kernel found that a sum left its range, or a velocity that is not a number.
    #[error("step {step}: {what}; the run was stopped, the recording up to here is complete")]
    Fault {
        /// Steps done when it was seen.
        step: u64,
        /// What happened and what to do.
        what: String,
    },
}

/// Told how the run goes on; what a progress bar needs.
pub trait Watch {
    /// The run begins on this adapter.
    fn begin(&mut self, adapter: &str, steps: u64);
    /// The name under which analyzers and `squirm top` find the run; not called for a run that cannot be watched.
    fn live(&mut self, _name: &str) {}
    /// So many steps are done.
    fn progress(&mut self, done: u64);
    /// Whether the run is to end before its last step, with everything that it has written complete.
    fn stop(&self) -> bool {
        false
    }
}

/// Runs a plan from its start to its last step, or until [`Watch::stop`].
///
/// # Errors
/// If it cannot start, or had to stop; what was recorded until then stays readable.
pub fn run(plan: &Plan, options: &Options, watch: &mut dyn Watch) -> Result<Summary, RunError> {
    outputs::check_directory(&options.out)?;
    let gpu = Gpu::open(options.adapter.as_deref())?;
    let state = crate::state::start::start(&plan.system)?;
    let session = Session::formed(&gpu, plan, &state, options.form)?;
    let run_id = outputs::identity(plan);
    let live = Live::open(plan, options, &session, run_id)?;
    let outputs = Outputs::open(plan, options, &session, run_id, &live)?;
    watch.begin(&session.adapter(), plan.system.run.steps);
    live.name().into_iter().for_each(|name| watch.live(name));
    let analyzers = Analyzers::start(&plan.analyzers, &options.out, live.name());
    let mut lap = Loop::new(plan, session, outputs, &live)?;
    let done = lap.turn(watch).and_then(|()| lap.close(options));
    live.end(done.as_ref().err());
    let complete = done.as_ref().is_ok_and(|summary| !summary.stopped);
    analyzers.end(if complete { analyzers::PATIENCE } else { analyzers::HASTE });
    done
}

/// Submissions that may wait for the GPU: enough that it never idles, few enough that the host stays near it.
const AHEAD: usize = 2;
/// Readings that may wait for the host before the loop waits for them.
const READINGS: usize = 8;
/// Aim for the length of one submission.
const BATCH: Duration = Duration::from_millis(100);

struct Loop<'a> {
    plan: &'a Plan,
    session: Session,
    outputs: Outputs,
    /// What is measured for the books: always the squirmers; the fluid, too, every `FLUID`th time.
    light: Measurement,
    full: Measurement,
    every: u64,
    books: Books,
    speed: Speed,
    waiting: VecDeque<(Reading, bool)>,
    began: Instant,
    live: &'a Live,
}

/// Every how manieth sample for the books includes the fluid.
const FLUID: u64 = 10;

impl<'a> Loop<'a> {
    fn new(plan: &'a Plan, session: Session, outputs: Outputs, live: &'a Live) -> Result<Self, RunError> {
        let light = Measurement::new(&session, Wanted { totals: false, block: None, fraction: None })?;
        let full = Measurement::new(&session, Wanted { totals: true, block: None, fraction: None })?;
        let every = (plan.system.run.steps / 1000).clamp(10, 1000);
        let speed = Speed::new(session.adapter());
        Ok(Self {
            plan,
            session,
            outputs,
            light,
            full,
            every,
            books: Books::new(&plan.system),
            speed,
            waiting: VecDeque::new(),
            began: Instant::now(),
            live,
        })
    }

    fn turn(&mut self, watch: &mut dyn Watch) -> Result<(), RunError> {
        let last = self.plan.system.run.steps;
        let mut ended = last == 0;
        self.sample(0, ended)?;
        let mut ahead = VecDeque::new();
        let mut batch = 1;
        self.began = Instant::now();
        while !ended {
            let step = self.session.step();
            let due = self.outputs.next_due(step).min(step - step % self.every + self.every).min(last);
            let steps = batch.min(due - step);
            ahead.push_back((self.session.advance(steps, true), steps, Instant::now()));
            ended = self.session.step() == last || watch.stop();
            self.sample(self.session.step(), ended)?;
            if ahead.len() > AHEAD {
                let (submission, steps, _) = ahead.pop_front().expect("not empty");
                let before = Instant::now();
                self.session.wait_for(&submission)?;
                if let Some(times) = self.session.times(&submission) {
                    self.speed.add(&times);
                }
                batch = next_batch(batch, steps, before.elapsed());
                let done = self.session.step().saturating_sub(ahead.iter().map(|(_, n, _)| n).sum());
                watch.progress(done);
                self.tell(done);
            }
            self.collect(false, watch)?;
        }
        self.session.wait()?;
        let done = self.session.step();
        self.speed.finish(done, self.began.elapsed());
        for (submission, _, _) in &ahead {
            if let Some(times) = self.session.times(submission) {
                self.speed.add(&times);
            }
        }
        watch.progress(done);
        self.tell(done);
        self.collect(true, watch)
    }

    #[allow(clippy::cast_precision_loss)]
    fn tell(&self, done: u64) {
        self.live.progress(done, done as f64 * self.plan.system.run.dt, &self.speed);
    }

    /// Takes what is due after `step` steps, for the books and for the outputs; the last sample is always a full one.
    fn sample(&mut self, step: u64, last: bool) -> Result<(), RunError> {
        if step.is_multiple_of(self.every) || last {
            let fluid = last || step.is_multiple_of(self.every * FLUID);
            let measurement = if fluid { &self.full } else { &self.light };
            self.waiting.push_back((measurement.take(&self.session), fluid));
        }
        self.outputs.take(&self.session, step)?;
        Ok(())
    }

    /// Enters readings that have arrived into the books; with `all`, or if too many are under way, waits for them.
    fn collect(&mut self, all: bool, watch: &dyn Watch) -> Result<(), RunError> {
        if all || self.waiting.len() > READINGS || self.outputs.crowded() {
            self.session.wait()?;
        }
        self.session.poll()?;
        while self.waiting.front().is_some_and(|(r, _)| r.settled()) {
            let (reading, fluid) = self.waiting.pop_front().expect("not empty");
            let frame = Frame::new(&self.session, &reading, reading.take()?);
            faults(frame.step, frame.faults)?;
            self.books.enter(&frame, fluid);
            self.live.frame(&frame, fluid);
        }
        self.outputs.hand_over(&self.session, &|| watch.stop())
    }

    fn close(self, options: &Options) -> Result<Summary, RunError> {
        let digest = self.session.raw()?.digest();
        let memory = self.session.memory();
        let files = self.outputs.finish()?;
        let summary = Summary::new(self.plan, &self.books, self.speed, memory, files, digest);
        summary.write(&options.out)?;
        Ok(summary)
    }
}

/// Grows the batch towards [`BATCH`]; waiting for the GPU tells how long the last one took.
fn next_batch(batch: u64, steps: u64, waited: Duration) -> u64 {
    if waited > 2 * BATCH && steps > 1 {
        (batch / 2).max(1)
    } else if waited < BATCH / 2 && steps == batch {
        (batch * 2).min(512)
    } else {
        batch
    }
}

/// Faults that stop a run, and what to do about each.
fn faults(step: u64, flags: u32) -> Result<(), RunError> {
    use crate::buffers::Fault;
    let said = |fault: Fault| match fault {
        Fault::Speed => {
            "a particle is faster than 12 thermal speeds: the fluid is being heated; use the thermostat, or a smaller force or dt"
        }
        Fault::Count => "a cell holds more particles than its sums allow: the fluid is being compressed somewhere",
        Fault::Energy => "the kinetic energy of one cell left the range of its sum: the fluid is being heated",
        Fault::Steric => "a steric force left its range: squirmers overlap; use more substeps or a smaller dt",
        Fault::Impulse => {
            "an impulse on a squirmer left its range: the fluid is being heated, or a body turns too fast"
        }
        Fault::Crowded => "more than seven squirmers are near one cell: they overlap",
        Fault::Nan => "a velocity is not a number",
        Fault::Spill => {
            "more than a sixteenth of all particles share cells whose lists are full, at nearly two standard deviations above the mean: the fluid is being compressed somewhere"
        }
        Fault::Stuck => "",
    };
    let what: Vec<&str> =
        Fault::ALL.iter().filter(|f| flags & **f as u32 != 0).map(|f| said(*f)).filter(|s| !s.is_empty()).collect();
    if what.is_empty() { Ok(()) } else { Err(RunError::Fault { step, what: what.join("; ") }) }
}
