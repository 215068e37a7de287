//! A recording published again as the run published it: analyzers cannot tell the two apart.

mod readers;

use crate::recording::{Moment, Part, Range, RecordingError, Scan, Series, TOPICS, fluid_beside, segments};
use crate::sink::{Beacon, Now, Offer, OnSlow, Publisher, SinkError};
use crate::wire::{Header, Kind, Snapshot, Stamp, Status, WireError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Longest sleep: after it the commands are looked at again.
const NAP: Duration = Duration::from_millis(20);
/// How often newcomers get the newest snapshot while nothing is published.
const WELCOME: Duration = Duration::from_millis(200);
/// An analyzer subscribes to its topics one after another: so long they must remain the same before it is complete.
const SETTLED: Duration = Duration::from_millis(300);
/// A jump in seconds of replay, and the share of the recording where there is no pace.
const JUMP: (f64, f64) = (5.0, 0.05);

/// How fast a recording is replayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    /// So many tau in a second.
    Speed(f64),
    /// As fast as its readers take it; none of them misses a snapshot unless it takes longer than this for one.
    Max(Duration),
}

/// What to replay, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Name under which to publish; none for the name of the run.
    pub name: Option<String>,
    /// How fast.
    pub pace: Pace,
    /// Which snapshots.
    pub range: Range,
    /// Begin again at the end.
    pub repeat: bool,
    /// Readers to wait for before the first snapshot.
    pub wait_for: usize,
}

/// What a user may ask for while a recording is replayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    /// Hold, or go on.
    Pause,
    /// Jump ahead by 5 s of replay; at the fastest pace by a twentieth of the recording.
    Forward,
    /// Jump back as far.
    Back,
    /// Go on from here.
    Seek(Moment),
    /// End.
    Quit,
}

/// Who steers a replay and watches it.
pub trait Control {
    /// Called with the name once everything is open.
    fn begin(&mut self, _name: &str) {}
    /// What the user asks for next, if anything.
    fn command(&mut self) -> Option<Command>;
    /// Called now and then with the newest step and time.
    fn progress(&mut self, _step: u64, _time: f64, _paused: bool) {}
}

/// What was replayed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Replayed {
    /// Snapshots published.
    pub snapshots: u64,
    /// Snapshots that some reader did not get.
    pub dropped: u64,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Why a replay failed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Publishing.
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// A message that is no snapshot.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// iceoryx2 refused.
    #[error("cannot look for readers: {0}")]
    Readers(String),
}

/// Publishes the recording at `path` from its beginning to its end.
///
/// # Errors
/// If the recording cannot be read to its end, or cannot be published.
pub fn replay(path: &Path, options: &Options, control: &mut dyn Control) -> Result<Replayed, ReplayError> {
    let kinds = kinds(path)?;
    let Survey { lengths, span, last } = survey(path, &kinds, &options.range)?;
    let wanted = options.name.clone().map_or_else(|| run_name(path), Ok)?;
    let beacon = Beacon::light(&wanted, introduction(path, &last))?;
    let name = beacon.name().to_owned();
    let on_slow = match options.pace {
        Pace::Max(limit) => OnSlow::Block(limit),
        Pace::Speed(_) => OnSlow::Drop,
    };
    let offers: Vec<Offer> = lengths.into_iter().map(|(kind, max)| Offer { kind, max, on_slow }).collect();
    let publisher = Publisher::offer(&name, &offers)?;
    control.begin(&name);
    let series = Series::open(path, &kinds)?;
    let mut player = Player {
        path: path.into(),
        kinds,
        options: options.clone(),
        span,
        beacon,
        publisher,
        series,
        skip_to: options.range.from,
        clock: None,
        paused: false,
        once: false,
        newest: None,
        done: Replayed::default(),
    };
    if readers::wait(&name, &player.kinds, options.wait_for, control)? {
        player.play(control)?;
    }
    Status::ENDED.clone_into(&mut player.beacon.now().status.phase);
    player.done.dropped = player.publisher.dropped();
    player.done.warnings.extend(player.series.finish().warnings);
    Ok(player.done)
}

/// Kinds of snapshots in a recording: as its end says, or else as its chunks do.
fn kinds(path: &Path) -> Result<Vec<Kind>, RecordingError> {
    let mut kinds = Vec::new();
    for file in [Some(path.to_owned()), fluid_beside(path)].into_iter().flatten() {
        for segment in segments(&file)? {
            let mut scan = Scan::open(&segment)?;
            while scan.statistics().is_none() && scan.next_part()?.is_some() {}
            let topics = scan.channels().channels.values().map(|c| c.topic.as_str());
            kinds.extend(topics.filter_map(|t| t.strip_prefix(TOPICS)).filter_map(Kind::from_topic));
        }
    }
    kinds.sort();
    kinds.dedup();
    if kinds.is_empty() {
        return Err(RecordingError::Empty(path.into()));
    }
    Ok(kinds)
}

/// What must be known before anything is sent.
struct Survey {
    /// Length of the longest message of each kind.
    lengths: Vec<(Kind, usize)>,
    /// First and last time.
    span: [f64; 2],
    /// Of the last message.
    last: Header,
}

/// Looks at everything, so that damage is known, too.
fn survey(path: &Path, kinds: &[Kind], range: &Range) -> Result<Survey, ReplayError> {
    let mut series = Series::open(path, kinds)?;
    let (mut longest, mut span) = (BTreeMap::new(), None::<([f64; 2], Header)>);
    while let Some(bytes) = series.next_message()? {
        let header = Snapshot::parse(&bytes)?.header;
        if range.contains(&header) {
            let length: &mut usize = longest.entry(header.kind()?).or_default();
            *length = bytes.len().max(*length);
            span = Some(([span.map_or(header.time, |(s, _)| s[0]), header.time], header));
        }
    }
    match span {
        Some((span, last)) => Ok(Survey { lengths: longest.into_iter().collect(), span, last }),
        None => Err(RecordingError::Nothing(format!("{} has no snapshot in that range", path.display())).into()),
    }
}

/// What those who list and watch runs see of a replay.
fn introduction(path: &Path, last: &Header) -> Now {
    let folder = std::path::absolute(path).unwrap_or_else(|_| path.into());
    let status = Status {
        pid: std::process::id(),
        started: SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64(),
        steps: last.step,
        temperature: f64::NAN,
        swim_speed: f64::NAN,
        phase: Status::RUNNING.into(),
        adapter: "replay".into(),
        folder: folder.display().to_string(),
        ..Status::default()
    };
    Now { stamp: Stamp { step: 0, time: 0.0, ..last.stamp() }, status }
}

/// The name of the run that was recorded, or of the file.
fn run_name(path: &Path) -> Result<String, RecordingError> {
    let first = segments(path)?.swap_remove(0);
    let mut scan = Scan::open(&first)?;
    while let Some(part) = scan.next_part()? {
        let name = match part {
            Part::Attachment(attachment) => crate::recording::Provenance::of(&attachment).and_then(|p| p.get("run")),
            Part::Chunk(_) => break,
            _ => None,
        };
        if let Some(name) = name.filter(|n| !n.is_empty()) {
            return Ok(name);
        }
    }
    Ok(first.file_stem().unwrap_or_default().to_string_lossy().into_owned())
}

/// A replay under way.
struct Player {
    path: PathBuf,
    kinds: Vec<Kind>,
    options: Options,
    span: [f64; 2],
    beacon: Beacon,
    publisher: Publisher,
    series: Series,
    /// Snapshots before this are passed over.
    skip_to: Option<Moment>,
    /// When which simulated time was sent, from which on the pace counts.
    clock: Option<(Instant, f64)>,
    paused: bool,
    /// Send one snapshot although the replay holds, so that a jump is seen.
    once: bool,
    newest: Option<Header>,
    done: Replayed,
}

impl Player {
    fn play(&mut self, control: &mut dyn Control) -> Result<(), ReplayError> {
        loop {
            let Some(bytes) = self.series.next_message()? else {
                if !self.options.repeat {
                    return Ok(());
                }
                self.from(self.options.range.from)?;
                continue;
            };
            let header = Snapshot::parse(&bytes)?.header;
            let range = Range { from: self.skip_to, ..self.options.range };
            if range.before(&header) {
                continue;
            }
            if range.after(&header) {
                if !self.options.repeat {
                    return Ok(());
                }
                self.from(self.options.range.from)?;
                continue;
            }
            // A moment has several kinds; a jump shows all of them.
            self.once &= self.newest.is_none_or(|n| n.step == header.step);
            match self.wait(&header, control)? {
                Next::Send => {
                    self.publisher.publish(&bytes)?;
                    self.done.snapshots += 1;
                    self.newest = Some(header);
                    let mut now = self.beacon.now();
                    (now.stamp.step, now.stamp.time) = (header.step, header.time);
                    (now.status.published, now.status.dropped) = (self.done.snapshots, self.publisher.dropped());
                }
                Next::Elsewhere => {}
                Next::End => return Ok(()),
            }
        }
    }

    /// Begins again at a moment.
    fn from(&mut self, moment: Option<Moment>) -> Result<(), ReplayError> {
        self.series = Series::open(&self.path, &self.kinds)?;
        (self.skip_to, self.clock, self.newest) = (moment, None, None);
        Ok(())
    }

    /// Waits until the snapshot is due, and does meanwhile what the user asks for.
    fn wait(&mut self, header: &Header, control: &mut dyn Control) -> Result<Next, ReplayError> {
        let (mut welcomed, mut told) = (Instant::now(), None::<Instant>);
        loop {
            while let Some(command) = control.command() {
                match command {
                    Command::Quit => return Ok(Next::End),
                    Command::Pause => (self.paused, self.clock) = (!self.paused, None),
                    Command::Seek(moment) => return self.jump(moment),
                    Command::Forward => return self.jump(Moment::Time(header.time + self.stride())),
                    Command::Back => return self.jump(Moment::Time((header.time - self.stride()).max(self.span[0]))),
                }
            }
            if told.is_none_or(|t| t.elapsed() >= WELCOME) {
                let newest = self.newest.unwrap_or(*header);
                control.progress(newest.step, newest.time, self.paused);
                told = Some(Instant::now());
            }
            let rest = if self.paused && !self.once { Some(NAP) } else { self.rest(header.time) };
            let Some(rest) = rest else { return Ok(Next::Send) };
            std::thread::sleep(rest.min(NAP));
            if welcomed.elapsed() >= WELCOME {
                welcomed = Instant::now();
                self.publisher.welcome();
            }
        }
    }

    /// How long it is until a snapshot of this time is due; `None` if it is.
    fn rest(&mut self, time: f64) -> Option<Duration> {
        let Pace::Speed(speed) = self.options.pace else { return None };
        let (began, first) = *self.clock.get_or_insert((Instant::now(), time));
        let due = Duration::try_from_secs_f64(((time - first) / speed).max(0.0)).unwrap_or(Duration::MAX);
        due.checked_sub(began.elapsed()).filter(|rest| !rest.is_zero())
    }

    /// Length of a jump in tau.
    fn stride(&self) -> f64 {
        match self.options.pace {
            Pace::Speed(speed) => JUMP.0 * speed,
            Pace::Max(_) => JUMP.1 * (self.span[1] - self.span[0]),
        }
    }

    fn jump(&mut self, moment: Moment) -> Result<Next, ReplayError> {
        // Not beyond the end: the last moment is shown then.
        let moment = match moment {
            Moment::Time(time) => Moment::Time(time.min(self.span[1])),
            step @ Moment::Step(_) => step,
        };
        self.from(Some(moment))?;
        self.once = true;
        Ok(Next::Elsewhere)
    }
}

/// What becomes of the snapshot that was waited with.
enum Next {
    Send,
    Elsewhere,
    End,
}
