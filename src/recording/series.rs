//! The snapshots of a run out of all of its segments, in the order of time, none twice and none that is damaged.

use super::scan::{Chunk, Part, Scan};
use super::{RecordingError, TOPICS, fluid_beside, segments};
use crate::wire::{Header, Kind, Snapshot};
use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};

/// The metadata record of a file that left snapshots out on purpose.
pub(super) const THINNED: &str = "squirm:cut";

/// How reading ended.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Read {
    /// Snapshots given.
    pub snapshots: u64,
    /// Snapshots that the run made and the files do not have.
    pub missing: u64,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// The snapshots of some kinds, to be taken one after another.
pub struct Series {
    lanes: Vec<Lane>,
    read: Read,
    run: Identity,
}

/// The run that everything must come from, and the file that said so.
type Identity = Option<([u8; 16], PathBuf)>;

/// A snapshot's header and its message.
struct Frame {
    header: Header,
    bytes: Vec<u8>,
}

/// One recording: its segments one after another.
struct Lane {
    kinds: Vec<Kind>,
    files: VecDeque<PathBuf>,
    scan: Option<Scan>,
    waiting: VecDeque<Frame>,
    /// The newest snapshot of each output: its step, its number, and whether it came from an earlier segment.
    last: BTreeMap<(Kind, u64), (u64, u64, bool)>,
    chunks: u64,
    missing: u64,
    thinned: bool,
}

impl Series {
    /// Opens a run's folder or a recording with its later segments. Where particles are wanted and `path` is the small
    /// topics' recording, that of the fluid beside it is read along.
    ///
    /// # Errors
    /// If there is no such recording.
    pub fn open(path: &Path, kinds: &[Kind]) -> Result<Self, RecordingError> {
        let fluid = fluid_beside(path).filter(|_| kinds.contains(&Kind::Particles));
        let lane = |path: &Path, kinds: Vec<Kind>| segments(path).map(|files| Lane::new(files, kinds));
        let mut lanes = Vec::new();
        let (small, bulk) = kinds.iter().copied().partition(|k| fluid.is_none() || *k != Kind::Particles);
        let small: Vec<Kind> = small;
        if !small.is_empty() {
            lanes.push(lane(path, small)?);
        }
        if let Some(fluid) = fluid {
            lanes.push(lane(&fluid, bulk)?);
        }
        Ok(Self { lanes, read: Read::default(), run: None })
    }

    /// The next snapshot's message; `None` at the end.
    ///
    /// # Errors
    /// At damage: what was given before is whole.
    pub fn next_message(&mut self) -> Result<Option<Vec<u8>>, RecordingError> {
        let mut earliest: Option<(u64, usize)> = None;
        for index in 0..self.lanes.len() {
            let lane = &mut self.lanes[index];
            lane.fill(&mut self.read, &mut self.run)?;
            let step = lane.waiting.front().map(|f| f.header.step);
            if let Some(step) = step.filter(|step| earliest.is_none_or(|(first, _)| *step < first)) {
                earliest = Some((step, index));
            }
        }
        let Some((_, index)) = earliest else { return Ok(None) };
        let lane = &mut self.lanes[index];
        let Some(frame) = lane.waiting.pop_front() else { return Ok(None) };
        self.read.snapshots += 1;
        Ok(Some(frame.bytes))
    }

    /// How reading has gone so far.
    #[must_use]
    pub fn finish(mut self) -> Read {
        let read = &mut self.read;
        // A file that left snapshots out on purpose lacks them rightly.
        read.missing = self.lanes.iter().filter(|lane| !lane.thinned).map(|lane| lane.missing).sum();
        if read.missing > 0 {
            read.warnings.push(format!("{} snapshots that the run made are not in its recording", read.missing));
        }
        self.read
    }
}

impl Lane {
    fn new(files: Vec<PathBuf>, kinds: Vec<Kind>) -> Self {
        let (files, waiting) = (files.into(), VecDeque::new());
        Self { kinds, files, scan: None, waiting, last: BTreeMap::new(), chunks: 0, missing: 0, thinned: false }
    }

    /// Reads on until a snapshot waits or the last segment ends.
    fn fill(&mut self, read: &mut Read, run: &mut Identity) -> Result<(), RecordingError> {
        while self.waiting.is_empty() {
            let Some(scan) = &mut self.scan else {
                let Some(path) = self.files.pop_front() else { return Ok(()) };
                self.scan = Some(Scan::open(&path)?);
                self.last.values_mut().for_each(|last| last.2 = true);
                continue;
            };
            let path = scan.path().to_owned();
            match scan.next_part()? {
                Some(Part::Chunk(chunk)) => {
                    self.chunks += 1;
                    self.take(&chunk, run)?;
                }
                Some(Part::Damaged { at, what, messages: true }) => {
                    return Err(RecordingError::Damaged { path, at, what });
                }
                Some(Part::Damaged { at, what, messages: false }) => {
                    read.warnings
                        .push(format!("{} is damaged at byte {at}: {what}; the snapshots are whole", path.display()));
                }
                Some(Part::Cut { .. }) => {
                    if self.chunks == 0 && self.files.is_empty() {
                        return Err(RecordingError::Empty(path));
                    }
                    read.warnings.push(format!(
                        "{} ends in the middle: the run was killed or is still going; its {} whole chunks are read",
                        path.display(),
                        self.chunks
                    ));
                }
                Some(Part::End { flaw: Some(flaw) }) => {
                    read.warnings.push(format!("{}: {flaw}; the snapshots are whole", path.display()));
                }
                Some(Part::Metadata(metadata)) => self.thinned |= metadata.name == THINNED,
                Some(Part::Attachment(_) | Part::End { flaw: None }) => {}
                None if self.files.is_empty() => return Ok(()),
                None => self.scan = None,
            }
        }
        Ok(())
    }

    /// Keeps what is wanted of a chunk and was not in an earlier segment.
    fn take(&mut self, chunk: &Chunk, run: &mut Identity) -> Result<(), RecordingError> {
        let Some(scan) = &self.scan else { return Ok(()) };
        for (message, bytes) in chunk.messages() {
            let topic = scan.channels().topic(message.channel_id);
            let Some(kind) = topic.and_then(|t| t.strip_prefix(TOPICS)).and_then(Kind::from_topic) else { continue };
            if !self.kinds.contains(&kind) {
                continue;
            }
            let parsed = Snapshot::parse(bytes).and_then(|s| s.expect(kind).map(|()| s));
            let wire = |source| RecordingError::Wire { path: scan.path().into(), at: chunk.at, source };
            let header = parsed.map_err(wire)?.header;
            let (run_id, first) = run.get_or_insert_with(|| (header.run_id, scan.path().into()));
            if *run_id != header.run_id {
                let (first, second) = (first.clone(), scan.path().into());
                return Err(RecordingError::Foreign { first, second, why: "the two come from different runs".into() });
            }
            let key = (kind, header.every);
            if let Some((step, seq, earlier)) = self.last.get(&key) {
                // What a resumed run made once more is in the segment before, bit by bit.
                if *earlier && header.step <= *step {
                    continue;
                }
                self.missing += header.seq.saturating_sub(seq + 1);
            }
            self.last.insert(key, (header.step, header.seq, false));
            self.waiting.push_back(Frame { header, bytes: bytes.to_vec() });
        }
        Ok(())
    }
}
