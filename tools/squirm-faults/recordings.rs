//! Damaged recordings: cut anywhere, any bit turned over. What is read must be the original, or nothing.

use super::child::{Folder, Trial};
use super::table::Row;
use rand::{Rng, RngExt};
use squirm::recording::{RecordingError, Series, recover, verify};
use squirm::wire::Kind;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Bytes between two cuts.
const STEP: usize = 4096;
/// Bytes at the end after each of which the file is cut, too.
const LAST: usize = 1024;

/// Cuts both recordings of a run at every [`STEP`] bytes and at each of the last [`LAST`], or as many as `count`, and turns over one
/// bit in each of `count` copies.
pub fn recordings(squirm: &Path, count: u32, random: &mut impl Rng) -> Result<Vec<Row>, String> {
    let trial = Trial::new(squirm, &[])?;
    trial.finish()?;
    let mut cut = Row::new("a recording that is cut gives its beginning with a word, and all of its whole chunks back");
    let mut turned = Row::new("a turned bit is noticed, and all chunks without it come back");
    let mut sizes = Vec::new();
    for name in ["run.mcap", "run.fluid.mcap"] {
        let original = Original::new(&trial.dir().join(name))?;
        let n = original.bytes.len();
        sizes.push(n.to_string());
        let last = LAST.min(count as usize);
        for length in (0..n).step_by(STEP).chain(n.saturating_sub(last)..n) {
            cut.enter(original.damaged(&original.bytes[..length], |(_, end)| end <= length));
        }
        for _ in 0..count {
            let (byte, bit) = (random.random_range(0..n), random.random_range(0..8));
            let mut bytes = original.bytes.clone();
            bytes[byte] ^= 1 << bit;
            let found = original.damaged(&bytes, |(start, end)| byte < start || byte >= end);
            turned.enter(found.map_err(|why| format!("bit {bit} of byte {byte}: {why}")));
        }
    }
    cut.figures = format!("files of {} bytes", sizes.join(" and "));
    Ok(vec![cut, turned])
}

/// A recording to be damaged.
struct Original {
    bytes: Vec<u8>,
    /// Beginning and end of each chunk in bytes.
    chunks: Vec<(usize, usize)>,
    messages: Vec<Vec<u8>>,
    known: BTreeSet<Vec<u8>>,
    folder: Folder,
}

impl Original {
    fn new(path: &Path) -> Result<Self, String> {
        let folder = Folder::new()?;
        // A name of its own, or the fluid beside it would be read along.
        let alone = folder.path().join("original.mcap");
        std::fs::copy(path, &alone).map_err(|e| format!("{}: {e}", path.display()))?;
        let bytes = std::fs::read(&alone).map_err(|e| e.to_string())?;
        let summary = mcap::Summary::read(&bytes).map_err(|e| e.to_string())?.ok_or("it has no summary")?;
        let at = |offset: u64| usize::try_from(offset).map_err(|e| e.to_string());
        let place =
            |c: &mcap::records::ChunkIndex| Ok((at(c.chunk_start_offset)?, at(c.chunk_start_offset + c.chunk_length)?));
        let chunks = summary.chunk_indexes.iter().map(place).collect::<Result<_, String>>()?;
        let (messages, warnings) = read(&alone).map_err(|e| e.to_string())?;
        if messages.is_empty() || !warnings.is_empty() {
            return Err(format!("the undamaged recording has {} messages, {warnings:?}", messages.len()));
        }
        let known = messages.iter().cloned().collect();
        Ok(Self { bytes, chunks, messages, known, folder })
    }

    /// What becomes of damaged bytes, of which `whole` tells the chunks that are as they were. Nothing may panic.
    fn damaged(&self, bytes: &[u8], whole: impl Fn((usize, usize)) -> bool) -> Result<(), String> {
        catch_unwind(AssertUnwindSafe(|| self.check(bytes, whole))).unwrap_or_else(|_| Err("it panicked".into()))
    }

    fn check(&self, bytes: &[u8], whole: impl Fn((usize, usize)) -> bool) -> Result<(), String> {
        let (path, out) = (self.folder.path().join("damaged.mcap"), self.folder.path().join("out.mcap"));
        std::fs::write(&path, bytes).map_err(|e| e.to_string())?;
        let _ = std::fs::remove_file(&out);
        let mut given = Vec::new();
        let ending = read_into(&path, &mut given);
        claim(self.messages.starts_with(&given), "what is read is not the beginning of the original")?;
        claim(!ending.is_ok_and(|warnings| warnings.is_empty()), "it is read without a word")?;
        let untouched = self.chunks.iter().filter(|c| whole(**c)).count() as u64;
        match recover(&path, &out) {
            Ok(done) => {
                claim(done.chunks >= untouched, "a whole chunk is lost")?;
                claim(!done.findings.is_empty(), "it is recovered without a word")?;
                let (saved, _) = read(&out).map_err(|e| e.to_string())?;
                claim(saved.iter().all(|m| self.known.contains(m)), "recovered what was never written")?;
                // Where a file ends between two chunks, nothing tells what was to come.
                let open = done.findings.iter().any(|f| f.what == "the file's end is missing");
                claim(done.lossy || open || saved.len() == self.messages.len(), "a loss is not reported")?;
                let findings = verify(&out).map_err(|e| e.to_string())?.findings;
                claim(findings.iter().all(|f| f.what.contains("missing")), "the recovered file is damaged")
            }
            Err(RecordingError::Empty(_) | RecordingError::NoRecording(_))
                if untouched == 0 || bytes.get(..8) != Some(mcap::MAGIC) =>
            {
                claim(!out.exists(), "an empty file is left")
            }
            Err(error) => Err(error.to_string()),
        }
    }
}

fn claim(holds: bool, otherwise: &str) -> Result<(), String> {
    if holds { Ok(()) } else { Err(otherwise.into()) }
}

fn read(path: &Path) -> Result<(Vec<Vec<u8>>, Vec<String>), RecordingError> {
    let mut given = Vec::new();
    read_into(path, &mut given).map(|warnings| (given, warnings))
}

fn read_into(path: &Path, given: &mut Vec<Vec<u8>>) -> Result<Vec<String>, RecordingError> {
    let mut series = Series::open(path, &Kind::ALL)?;
    while let Some(message) = series.next_message()? {
        given.push(message);
    }
    Ok(series.finish().warnings)
}
