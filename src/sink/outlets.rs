//! Handing each snapshot to those that asked for it, on a thread of its own, so that the step loop never waits for a disk.

use super::{Durable, FileInfo, Publisher, Recorder, Rows, SinkError, Tables};
use crate::wire::Kind;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long newcomers wait for the newest snapshot while no job takes longer.
const WELCOME: Duration = Duration::from_millis(200);
/// Time between two attempts to hand a job over.
const NAP: Duration = Duration::from_millis(1);

/// Who gets a snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Targets {
    /// Analyzers on this machine.
    pub publish: bool,
    /// The recording.
    pub record: bool,
    /// The tables.
    pub csv: bool,
}

/// The sinks of a run; those that nobody asked for are absent.
#[derive(Default)]
pub struct Outlets {
    /// Shared memory.
    pub publisher: Option<Publisher>,
    /// MCAP.
    pub recorder: Option<Recorder>,
    /// CSV.
    pub tables: Option<Tables>,
    /// What earlier parts of the run had handed over and lost.
    pub before: Kept,
}

/// What of a run's snapshots is certainly on the disk, and how many there were.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct Kept {
    /// In recordings.
    pub recording: Durable,
    /// In tables.
    pub tables: Vec<Rows>,
    /// Snapshots handed over.
    pub snapshots: u64,
    /// Snapshots that could not be published.
    pub dropped: u64,
}

/// What became of a run's snapshots.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Summary {
    /// Recorded files.
    pub files: Vec<FileInfo>,
    /// Snapshots handed over.
    pub snapshots: u64,
    /// Snapshots that could not be published, or that a reader missed although the run waited for it.
    pub dropped: u64,
    /// Those of them, since this process began, of topics that wait for their readers.
    pub lost: Vec<(Kind, u64)>,
}

impl Kept {
    /// Cuts the files in `dir` to this; those begun later go.
    ///
    /// # Errors
    /// If a file has lost what it had, or cannot be written.
    pub fn cut(&self, dir: &Path) -> Result<(), SinkError> {
        super::recorder::keep_only(dir, &self.recording)?;
        Tables::resume(dir, &self.tables).map(drop)
    }
}

impl Outlets {
    /// Hands one message to its targets; analyzers come first, for they are waiting.
    ///
    /// # Errors
    /// The first failure; the other targets get the message all the same.
    pub fn deliver(&mut self, bytes: &[u8], targets: Targets) -> Result<(), SinkError> {
        let published = match &mut self.publisher {
            Some(publisher) if targets.publish => publisher.publish(bytes).map(drop),
            _ => Ok(()),
        };
        let recorded = match &mut self.recorder {
            Some(recorder) if targets.record => recorder.write(bytes),
            _ => Ok(()),
        };
        let tabled = match &mut self.tables {
            Some(tables) if targets.csv => tables.write(bytes),
            _ => Ok(()),
        };
        published.and(recorded).and(tabled)
    }

    /// Waits until everything written so far is on the disk, and says what that is; what earlier parts of the run left stays known
    /// where nothing is recorded now.
    ///
    /// # Errors
    /// If the system cannot write it.
    pub fn sync(&mut self) -> Result<Kept, SinkError> {
        let before = &self.before;
        let recording = self.recorder.as_mut().map_or_else(|| Ok(before.recording.clone()), Recorder::sync)?;
        let tables = self.tables.as_mut().map_or_else(|| Ok(before.tables.clone()), Tables::sync)?;
        let dropped = before.dropped + self.publisher.as_ref().map_or(0, Publisher::dropped);
        Ok(Kept { recording, tables, snapshots: before.snapshots, dropped })
    }

    /// Finishes all files and closes the topics.
    ///
    /// # Errors
    /// If a file could not be finished.
    pub fn finish(self) -> Result<Summary, SinkError> {
        let dropped = self.before.dropped + self.publisher.as_ref().map_or(0, Publisher::dropped);
        let lost = self.publisher.as_ref().map_or_else(Vec::new, Publisher::lost);
        let files = self.recorder.map_or(Ok(Vec::new()), Recorder::finish)?;
        Ok(Summary { files, snapshots: self.before.snapshots, dropped, lost })
    }
}

/// Work for the thread.
pub enum Job {
    /// Make the messages of a snapshot and deliver them: encoding, too, is taken off the step loop.
    Snapshot(Box<dyn FnOnce() -> Vec<(Vec<u8>, Targets)> + Send>),
    /// Sync recordings and tables, then answer.
    Sync(SyncSender<Kept>),
}

impl Job {
    /// Deliver what this makes.
    pub fn snapshot(make: impl FnOnce() -> Vec<(Vec<u8>, Targets)> + Send + 'static) -> Self {
        Self::Snapshot(Box::new(make))
    }
}

/// A thread that owns the outlets. Where the disk is slower than the run, the run waits rather than losing a recording.
pub struct Writer {
    jobs: Option<SyncSender<Job>>,
    thread: Option<JoinHandle<Result<Summary, SinkError>>>,
    hurry: Option<Box<dyn Fn() + Send + Sync>>,
}

impl Writer {
    /// Starts the thread; `depth` jobs may wait for it.
    ///
    /// # Errors
    /// If the system has no thread left.
    pub fn spawn(outlets: Outlets, depth: usize) -> std::io::Result<Self> {
        let (jobs, queue) = sync_channel(depth);
        let hurry = outlets.publisher.as_ref().map(Publisher::hurrier);
        let thread = std::thread::Builder::new().name("snapshots".into()).spawn(move || work(outlets, &queue))?;
        Ok(Self { jobs: Some(jobs), thread: Some(thread), hurry })
    }

    /// Hands over one job; waits only while `depth` others are waiting.
    ///
    /// # Errors
    /// What an earlier job failed with; the outlets are closed then.
    pub fn send(&mut self, job: Job) -> Result<(), SinkError> {
        match self.jobs.as_ref().map(|jobs| jobs.send(job)) {
            Some(Ok(())) => Ok(()),
            // The thread has gone, and says why.
            _ => Err(self.join().err().unwrap_or(SinkError::Ended)),
        }
    }

    /// As [`Writer::send`], but once `stop` is true no job waits for slow readers any more.
    ///
    /// # Errors
    /// What an earlier job failed with; the outlets are closed then.
    pub fn send_until(&mut self, mut job: Job, stop: &dyn Fn() -> bool) -> Result<(), SinkError> {
        loop {
            if stop() {
                self.hurry.iter().for_each(|hurry| hurry());
                return self.send(job);
            }
            match self.jobs.as_ref().map(|jobs| jobs.try_send(job)) {
                Some(Ok(())) => return Ok(()),
                Some(Err(TrySendError::Full(returned))) => job = returned,
                _ => return Err(self.join().err().unwrap_or(SinkError::Ended)),
            }
            std::thread::sleep(NAP);
        }
    }

    /// Asks for all jobs handed over so far to be done and on the disk; the answer comes when they are, or never if one failed.
    ///
    /// # Errors
    /// What an earlier job failed with.
    pub fn mark(&mut self) -> Result<Receiver<Kept>, SinkError> {
        let (answer, done) = sync_channel(1);
        self.send(Job::Sync(answer))?;
        Ok(done)
    }

    /// Waits until all jobs handed over so far are done and on the disk.
    ///
    /// # Errors
    /// What a job failed with.
    pub fn sync(&mut self) -> Result<Kept, SinkError> {
        let done = self.mark()?;
        done.recv().map_err(|_| self.join().err().unwrap_or(SinkError::Ended))
    }

    /// Does the jobs that wait, then finishes all files.
    ///
    /// # Errors
    /// What a job or the end failed with.
    pub fn finish(mut self) -> Result<Summary, SinkError> {
        self.join()
    }

    fn join(&mut self) -> Result<Summary, SinkError> {
        self.jobs = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            _ => Err(SinkError::Ended),
        }
    }
}

impl Drop for Writer {
    /// An abandoned writer still finishes its files.
    fn drop(&mut self) {
        if self.thread.is_some() {
            let _ = self.join();
        }
    }
}

/// The thread's life: jobs until the channel closes or one fails; the files are finished in both cases.
fn work(mut outlets: Outlets, queue: &Receiver<Job>) -> Result<Summary, SinkError> {
    let mut snapshots = 0;
    let mut failure = None;
    let mut welcomed = Instant::now();
    loop {
        if welcomed.elapsed() >= WELCOME {
            welcomed = Instant::now();
            outlets.publisher.iter_mut().for_each(Publisher::welcome);
        }
        let done = match queue.recv_timeout(WELCOME) {
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => Ok(()),
            Ok(Job::Snapshot(make)) => {
                make().iter().try_for_each(|(bytes, targets)| outlets.deliver(bytes, *targets).map(|()| snapshots += 1))
            }
            Ok(Job::Sync(answer)) => outlets.sync().map(|kept| {
                // A caller that no longer listens needs no answer.
                let _ = answer.send(Kept { snapshots: kept.snapshots + snapshots, ..kept });
            }),
        };
        if let Err(e) = done {
            failure = Some(e);
            break;
        }
    }
    let finished = outlets.finish();
    match failure {
        Some(e) => Err(e),
        None => finished.map(|summary| Summary { snapshots: summary.snapshots + snapshots, ..summary }),
    }
}
