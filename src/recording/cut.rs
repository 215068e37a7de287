//! A part of a recording as a recording of its own.

use super::copy::Copy;
use super::range::{Choice, Range};
use super::scan::{Part, Scan};
use super::series::THINNED;
use super::{RecordingError, TOPICS, fluid_beside, segments};
use crate::wire::{Kind, Snapshot};
use mcap::records::Metadata;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What a cut took.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Cut {
    /// Snapshots taken.
    pub snapshots: u64,
    /// Messages taken, those for viewers included.
    pub messages: u64,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Copies the snapshots of `range` and what viewers draw of them out of `path` and its later segments into the new file `out`.
/// `topics` are kinds (`squirmers`) or full topics (`/squirmers/scene`); none means all.
///
/// # Errors
/// At damage, if nothing is in the range, or if `out` exists or cannot be written.
pub fn cut(path: &Path, out: &Path, range: Range, topics: &[String]) -> Result<Cut, RecordingError> {
    let files = segments(path)?;
    let mut copy = Copy::create(out)?;
    let mut selection = Selection { choice: Choice::new(range), topics, last: BTreeMap::new(), kept: None };
    let mut done = Cut::default();
    let particles = format!("{TOPICS}{}", Kind::Particles.topic());
    done.warnings.extend(fluid_apart(path).filter(|_| selection.wants(&particles)));
    for file in &files {
        selection.last.values_mut().for_each(|last| last.1 = true);
        one(file, &mut copy, &mut selection, &mut done)?;
    }
    if done.messages == 0 {
        let (name, topics) = (path.display(), if topics.is_empty() { "any topic".into() } else { topics.join(", ") });
        let apart = done.warnings.iter().map(|warning| format!("; {warning}")).collect::<String>();
        return Err(RecordingError::Nothing(format!("{name} has no snapshot of {topics} in that range{apart}")));
    }
    if range.every > 1 {
        let every = ("every".to_owned(), range.every.to_string());
        copy.describe(&Metadata { name: THINNED.into(), metadata: BTreeMap::from([every]) })?;
    }
    copy.finish()?;
    Ok(done)
}

/// What to say of the fluid's particles if `path` is a folder that has them in a recording of their own, which is not copied along.
#[must_use]
pub fn fluid_apart(path: &Path) -> Option<String> {
    let fluid = path.is_dir().then(|| fluid_beside(path)).flatten()?;
    Some(format!("the particles are not taken along: name their recording by itself, {}", fluid.display()))
}

/// What is to be copied.
struct Selection<'a> {
    choice: Choice,
    topics: &'a [String],
    /// The newest step of each output, and whether it came from an earlier segment.
    last: BTreeMap<(Kind, u64), (u64, bool)>,
    /// Time and number of the newest snapshot, if it was taken: what viewers draw of a snapshot follows it.
    kept: Option<(u64, u32)>,
}

impl Selection<'_> {
    fn wants(&self, topic: &str) -> bool {
        let word = topic.strip_prefix(TOPICS).unwrap_or(topic);
        self.topics.is_empty() || self.topics.iter().any(|t| t == topic || t == word)
    }

    /// Whether a snapshot is to be copied.
    fn takes(&mut self, snapshot: &Snapshot<'_>) -> bool {
        let (kind, header) = (snapshot.kind(), &snapshot.header);
        let key = (kind, header.every);
        if self.last.get(&key).is_some_and(|(step, earlier)| *earlier && header.step <= *step) {
            return false;
        }
        self.last.insert(key, (header.step, false));
        self.choice.takes(kind, header)
    }
}

fn one(file: &Path, copy: &mut Copy, selection: &mut Selection<'_>, done: &mut Cut) -> Result<(), RecordingError> {
    let mut scan = Scan::open(file)?;
    while let Some(part) = scan.next_part()? {
        match part {
            Part::Chunk(chunk) => {
                for (header, bytes) in chunk.messages() {
                    let channels = scan.channels();
                    let Some(channel) = channels.channels.get(&header.channel_id) else { continue };
                    let moment = (header.log_time, header.sequence);
                    let taken = if channel.topic.starts_with(TOPICS) {
                        let wire = |source| RecordingError::Wire { path: file.into(), at: chunk.at, source };
                        let taken = selection.takes(&Snapshot::parse(bytes).map_err(wire)?);
                        selection.kept = taken.then_some(moment);
                        taken
                    } else {
                        selection.kept == Some(moment)
                    };
                    if taken && selection.wants(&channel.topic) {
                        done.messages += 1;
                        done.snapshots += u64::from(channel.topic.starts_with(TOPICS));
                        copy.message(header, bytes, channels, channel)?;
                    }
                }
                copy.end_chunk()?;
            }
            Part::Attachment(attachment) => copy.attach(attachment)?,
            Part::Metadata(metadata) => copy.describe(&metadata)?,
            part => done.warnings.extend(strict(file, part)?),
        }
    }
    Ok(())
}

/// What copying must not pass over: damage is an error, a missing end a warning.
pub(super) fn strict(file: &Path, part: Part) -> Result<Option<String>, RecordingError> {
    let path: PathBuf = file.into();
    match part {
        Part::Damaged { at, what, .. } => Err(RecordingError::Damaged { path, at, what }),
        Part::Cut { at, .. } => {
            Ok(Some(format!("{} ends in the middle: what is whole ends at byte {at}", path.display())))
        }
        Part::End { flaw } => Ok(flaw.map(|flaw| format!("{}: {flaw}; the snapshots are whole", path.display()))),
        _ => Ok(None),
    }
}
