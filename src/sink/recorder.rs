//! Recording a run: `run.mcap`, and `run.fluid.mcap` for the bulk of the fluid.

use super::track::{Track, When};
use super::{SinkError, cut::cut, scene, slice};
use crate::recording::{ATTACHMENT, FLUID, METADATA, RUN, RecordingError, run_metadata, segment, segments};
use crate::wire::{Fields, Header, Kind, Particles, Snapshot, Squirmers};
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Chunks of one file. A recording goes on in a new segment then: the index of a file is kept in memory until its end, 200 bytes
/// or so for each chunk, and a run may go for weeks.
const CHUNKS: u64 = 1 << 17;

/// What made a recording.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Provenance {
    /// Name of the run.
    pub run: String,
    /// Identity of the run, as in every header; hexadecimal in the file.
    #[serde(serialize_with = "hexadecimal")]
    pub run_id: [u8; 16],
    /// Seed of the random numbers.
    pub seed: u64,
    /// Version of the program.
    pub version: String,
    /// Whatever else is known: device, driver, command line, source revision.
    pub details: serde_json::Map<String, serde_json::Value>,
}

fn hexadecimal<S: serde::Serializer>(id: &[u8; 16], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&hex(id))
}

fn hex(id: &[u8; 16]) -> String {
    id.iter().map(|b| format!("{b:02x}")).collect()
}

/// One finished file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileInfo {
    /// Where it is.
    pub path: PathBuf,
    /// Messages in it.
    pub messages: u64,
    /// Its length.
    pub bytes: u64,
}

/// What of the recordings is certainly on the disk.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct Durable {
    /// Number of the segment being written: how often a new one was begun, by a resumption or because the last was full.
    pub segment: u32,
    /// All files so far, those of earlier segments first.
    pub files: Vec<Part>,
}

/// One file of a recording.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Part {
    /// Its name, without the directory.
    pub name: String,
    /// Messages in it.
    pub messages: u64,
}

/// One file and the handle through which it is synced.
struct Open {
    track: Track<BufWriter<File>>,
    file: File,
}

/// Writes snapshots into MCAP files. Call [`Recorder::finish`]: only it reports what goes wrong at the end.
pub struct Recorder {
    dir: PathBuf,
    provenance: Provenance,
    resolved: String,
    segment: u32,
    /// Files of earlier segments.
    earlier: Vec<Part>,
    run: Open,
    fluid: Option<Open>,
    /// Step at which viewers were last told where everything is.
    framed: Option<u64>,
    /// Chunks of one file at most.
    most: u64,
}

impl Recorder {
    /// Begins `run.mcap` in `dir`, which must exist. `resolved` is the pipeline with all its defaults.
    ///
    /// # Errors
    /// If one of the files exists, or cannot be written.
    pub fn create(dir: &Path, provenance: &Provenance, resolved: &str) -> Result<Self, SinkError> {
        Self::begin(dir, provenance, resolved, (0, Vec::new()))
    }

    /// Goes on in a new segment after a resumption; the files there have been cut ([`super::Kept::cut`]).
    ///
    /// # Errors
    /// If a file of the new segment exists, or cannot be written.
    pub fn resume(dir: &Path, provenance: &Provenance, resolved: &str, at: &Durable) -> Result<Self, SinkError> {
        // Where nothing was recorded yet there is nothing to go on from.
        let segment = if at.files.is_empty() { 0 } else { at.segment + 1 };
        Self::begin(dir, provenance, resolved, (segment, at.files.clone()))
    }

    fn begin(
        dir: &Path,
        provenance: &Provenance,
        resolved: &str,
        (number, earlier): (u32, Vec<Part>),
    ) -> Result<Self, SinkError> {
        let fluid = segment(&dir.join(FLUID), number);
        if fluid.exists() {
            return Err(SinkError::Exists(fluid));
        }
        let run = open(&segment(&dir.join(RUN), number), provenance, resolved, 0)?;
        let (dir, provenance, resolved) = (dir.into(), provenance.clone(), resolved.into());
        Ok(Self { dir, provenance, resolved, segment: number, earlier, run, fluid: None, framed: None, most: CHUNKS })
    }

    /// Records one message, after it what viewers draw of it, and closes its chunk, so that a run that is killed loses at most the message being written.
    ///
    /// # Errors
    /// If the bytes are no snapshot, or the file cannot be written; after that the file takes no more.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), SinkError> {
        let snapshot = Snapshot::parse(bytes)?;
        let header = &snapshot.header;
        #[allow(clippy::cast_possible_truncation)]
        let when = When { nanoseconds: scene::nanoseconds(header.time), sequence: header.seq as u32 };
        let track = match snapshot.kind() {
            Kind::Particles => {
                let particles = Particles::decode(&snapshot)?;
                let track = &mut self.fluid()?.track;
                track.snapshot("/squirm/particles", snapshot.bytes(), when)?;
                // A chunk of their own keeps the points for viewers cheap to read.
                track.flush()?;
                track.view("/fluid/points", &scene::fluid_points(header, &particles), when)?;
                track
            }
            Kind::Squirmers => {
                let squirmers = Squirmers::decode(&snapshot)?;
                self.run.track.snapshot("/squirm/squirmers", snapshot.bytes(), when)?;
                self.frame(header, when)?;
                let track = &mut self.run.track;
                track.view("/squirmers/poses", &scene::poses(header, &squirmers), when)?;
                track.view("/squirmers/scene", &scene::scene(header, &squirmers), when)?;
                track.view("/squirmers/points", &scene::squirmer_points(header, &squirmers), when)?;
                track
            }
            Kind::Scalars => {
                self.run.track.snapshot("/squirm/scalars", snapshot.bytes(), when)?;
                &mut self.run.track
            }
            Kind::Fields => {
                let fields = Fields::decode(&snapshot)?;
                self.run.track.snapshot("/squirm/fields", snapshot.bytes(), when)?;
                self.frame(header, when)?;
                let track = &mut self.run.track;
                track.view("/fluid/slice", &slice::grid(header, &fields), when)?;
                track.view("/fluid/slab", &slice::slab(header, &fields), when)?;
                track
            }
            Kind::Status => return Ok(()),
        };
        track.flush()?;
        if track.chunks() >= self.most { self.roll() } else { Ok(()) }
    }

    /// Begins a new segment whenever a file has so many chunks, instead of some hundred thousand.
    #[must_use]
    pub fn in_segments_of(self, chunks: u64) -> Self {
        Self { most: chunks.max(1), ..self }
    }

    /// Finishes the files of this segment and begins the next.
    fn roll(&mut self) -> Result<(), SinkError> {
        self.segment += 1;
        let next = open(&segment(&self.dir.join(RUN), self.segment), &self.provenance, &self.resolved, 0)?;
        let full = std::mem::replace(&mut self.run, next);
        for open in [Some(full), self.fluid.take()].into_iter().flatten() {
            let FileInfo { path, messages, .. } = close(open)?;
            self.earlier.push(Part { name: named(&path), messages });
        }
        self.framed = None;
        Ok(())
    }

    /// Waits until everything written so far is on the disk, and says what that is.
    ///
    /// # Errors
    /// If the system cannot write it.
    pub fn sync(&mut self) -> Result<Durable, SinkError> {
        let mut files = self.earlier.clone();
        for open in [Some(&mut self.run), self.fluid.as_mut()].into_iter().flatten() {
            open.track.flush()?;
            let path = open.track.path();
            open.file.sync_data().map_err(|e| SinkError::io(path, e))?;
            files.push(Part { name: named(path), messages: open.track.messages() });
        }
        Ok(Durable { segment: self.segment, files })
    }

    /// Writes summaries and indexes and waits until the files are on the disk. Every file is finished, also after a failure.
    ///
    /// # Errors
    /// The first failure.
    pub fn finish(self) -> Result<Vec<FileInfo>, SinkError> {
        let finished: Vec<_> = [Some(self.run), self.fluid].into_iter().flatten().map(close).collect();
        let earlier = self.earlier.into_iter().map(|part| {
            let path = self.dir.join(part.name);
            let bytes = path.metadata().map_or(0, |m| m.len());
            Ok(FileInfo { path, messages: part.messages, bytes })
        });
        earlier.chain(finished).collect()
    }

    /// The frame, the box and its walls, once for all messages of a step.
    fn frame(&mut self, header: &Header, when: When) -> Result<(), SinkError> {
        if self.framed == Some(header.step) {
            return Ok(());
        }
        self.run.track.view("/tf", &scene::transform(header), when)?;
        self.run.track.view("/box", &scene::surroundings(header), when)?;
        self.framed = Some(header.step);
        Ok(())
    }

    fn fluid(&mut self) -> Result<&mut Open, SinkError> {
        let open = match self.fluid.take() {
            Some(open) => open,
            None => {
                let path = segment(&self.dir.join(FLUID), self.segment);
                open(&path, &self.provenance, &self.resolved, 2)?
            }
        };
        Ok(self.fluid.insert(open))
    }
}

/// Cuts the recordings of `dir` to what they had at a checkpoint. Segments that were begun later go: the resumed run records all
/// that is in them again.
pub(super) fn keep_only(dir: &Path, at: &Durable) -> Result<(), SinkError> {
    let known = |name: &str| at.files.iter().find(|part| part.name == name);
    for first in [RUN, FLUID] {
        let found = match segments(&dir.join(first)) {
            Err(RecordingError::Io { path, source }) => return Err(SinkError::io(&path, source)),
            // None is there.
            found => found.unwrap_or_default(),
        };
        for path in found {
            if known(&path.file_name().unwrap_or_default().to_string_lossy()).is_none() {
                std::fs::remove_file(&path).map_err(|e| SinkError::io(&path, e))?;
            }
        }
    }
    at.files.iter().try_for_each(|part| cut(&dir.join(&part.name), part.messages))
}

fn named(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn open(path: &Path, provenance: &Provenance, resolved: &str, threads: u32) -> Result<Open, SinkError> {
    let io = |e| SinkError::io(path, e);
    let file = File::create_new(path).map_err(io)?;
    let handle = file.try_clone().map_err(io)?;
    let mut track = Track::new(path, BufWriter::with_capacity(1 << 16, file), threads)?;
    track.attach("pipeline.toml", "application/toml", resolved)?;
    let json = serde_json::to_string_pretty(provenance).map_err(|e| io(e.into()))?;
    track.attach(ATTACHMENT, "application/json", &json)?;
    let entries = [
        ("run", provenance.run.clone()),
        ("run_id", hex(&provenance.run_id)),
        ("seed", provenance.seed.to_string()),
        ("version", provenance.version.clone()),
    ];
    track.metadata(METADATA, run_metadata(entries.map(|(k, v)| (k.to_owned(), v))))?;
    track.flush()?;
    Ok(Open { track, file: handle })
}

fn close(open: Open) -> Result<FileInfo, SinkError> {
    let Open { mut track, file } = open;
    let path = track.path().to_owned();
    let messages = track.finish()?;
    let io = |e| SinkError::io(&path, e);
    track.into_inner().into_inner().map_err(|e| io(e.into_error()))?;
    file.sync_all().map_err(io)?;
    let bytes = file.metadata().map_err(io)?.len();
    Ok(FileInfo { path, messages, bytes })
}
