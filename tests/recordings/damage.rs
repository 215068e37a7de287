//! Sweeps of damage over a recording: cut off anywhere, any bit turned over. What is read must be the original, or nothing.

use crate::made::Noise;
use squirm::recording::{RecordingError, Series, recover, verify};
use squirm::wire::Kind;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// What a sweep saw.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Figures {
    /// Damaged files.
    pub variants: u64,
    /// Of them, those that a reader took without a word.
    pub undetected: u64,
    /// Of them, those that `recover` made a complete file from.
    pub recovered: u64,
    /// Chunks that no damage touched, and that `recover` had to save.
    pub whole_chunks: u64,
}

/// A recording to be damaged.
pub struct Original {
    bytes: Vec<u8>,
    chunks: Vec<(usize, usize)>,
    messages: Vec<Vec<u8>>,
    known: BTreeSet<Vec<u8>>,
    dir: tempfile::TempDir,
}

impl Original {
    pub fn new(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap();
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        let end = |c: &mcap::records::ChunkIndex| {
            (c.chunk_start_offset as usize, (c.chunk_start_offset + c.chunk_length) as usize)
        };
        let chunks = summary.chunk_indexes.iter().map(end).collect();
        let (messages, warnings) = read(path).unwrap();
        assert!(warnings.is_empty() && !messages.is_empty());
        let known = messages.iter().cloned().collect();
        Self { bytes, chunks, messages, known, dir: tempfile::tempdir().unwrap() }
    }

    /// Cuts the file at every `step` bytes, and at every byte of its last `last`.
    pub fn cut(&self, step: usize, last: usize) -> Figures {
        let n = self.bytes.len();
        let mut figures = Figures::default();
        for length in (0..n).step_by(step).chain(n.saturating_sub(last)..n) {
            self.check(&self.bytes[..length], &|(_, end)| end <= length, &format!("cut at {length}"), &mut figures);
        }
        figures
    }

    /// Turns over one bit of each of `count` copies.
    pub fn flip(&self, count: usize, seed: u64) -> Figures {
        let mut noise = Noise(seed);
        let mut figures = Figures::default();
        for _ in 0..count {
            let (byte, bit) = (noise.below(self.bytes.len()), noise.below(8));
            let mut damaged = self.bytes.clone();
            damaged[byte] ^= 1 << bit;
            let untouched = |(start, end): (usize, usize)| byte < start || byte >= end;
            self.check(&damaged, &untouched, &format!("bit {bit} of byte {byte}"), &mut figures);
        }
        figures
    }

    /// Reads and recovers one damaged file.
    fn check(&self, bytes: &[u8], whole: &dyn Fn((usize, usize)) -> bool, what: &str, figures: &mut Figures) {
        let (damaged, out) = (self.dir.path().join("damaged.mcap"), self.dir.path().join("out.mcap"));
        std::fs::write(&damaged, bytes).unwrap();
        let _ = std::fs::remove_file(&out);
        figures.variants += 1;
        let mut given = Vec::new();
        let ending = read_into(&damaged, &mut given);
        assert_eq!(given, self.messages[..given.len()], "{what}: not the beginning of the original");
        figures.undetected += u64::from(ending.is_ok_and(|warnings| warnings.is_empty()));
        let untouched = self.chunks.iter().filter(|c| whole(**c)).count() as u64;
        figures.whole_chunks += untouched;
        match recover(&damaged, &out) {
            Ok(done) => {
                figures.recovered += 1;
                assert!(done.chunks >= untouched && !done.findings.is_empty(), "{what}: {done:?} of {untouched}");
                let (saved, _) = read(&out).unwrap();
                assert!(saved.iter().all(|m| self.known.contains(m)), "{what}: recovered what was never written");
                let complete = saved.len() == self.messages.len();
                // Where a file ends between two chunks, nothing tells what was to come.
                let open = done.findings.iter().any(|f| f.what == "the file's end is missing");
                assert!(done.lossy || complete || open, "{what}: a loss that is not reported");
                let findings = verify(&out).unwrap().findings;
                assert!(findings.iter().all(|f| f.what.contains("missing")), "{what}: {findings:?}");
            }
            Err(RecordingError::Empty(_) | RecordingError::NoRecording(_))
                if untouched == 0 || bytes.get(..8) != Some(mcap::MAGIC) =>
            {
                assert!(!out.exists(), "{what}: an empty file is left");
            }
            Err(error) => panic!("{what}: {error}"),
        }
    }
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

fn made(file: &str) -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    crate::made::record(dir.path(), 1, 0..6);
    // A name of its own, or the fluid beside it would be read along.
    let path = dir.path().join("original.mcap");
    std::fs::rename(dir.path().join(file), &path).unwrap();
    (dir, path)
}

#[test]
fn a_recording_that_is_cut_gives_its_beginning() {
    for file in ["run.mcap", "run.fluid.mcap"] {
        let (_dir, path) = made(file);
        let original = Original::new(&path);
        let figures = original.cut(997, 90);
        println!("{file}: {figures:?}");
        assert!(figures.variants > 90 && figures.undetected == 0 && figures.recovered > 90, "{figures:?}");
    }
}

#[test]
fn no_turned_bit_passes_and_all_other_chunks_are_saved() {
    for file in ["run.mcap", "run.fluid.mcap"] {
        let (_dir, path) = made(file);
        let figures = Original::new(&path).flip(150, 11);
        println!("{file}: {figures:?}");
        assert!(figures.undetected == 0 && figures.recovered >= 148, "{figures:?}");
    }
}

/// The full sweep: `cargo test --release --test recordings -- --ignored --nocapture`.
#[test]
#[ignore = "minutes"]
fn every_cut_and_a_thousand_turned_bits() {
    for file in ["run.mcap", "run.fluid.mcap"] {
        let (_dir, path) = made(file);
        let original = Original::new(&path);
        let (cut, flipped) = (original.cut(4096, 1024), original.flip(1000, 5));
        println!("{file}, {} bytes: cut {cut:?}; bits {flipped:?}", original.bytes.len());
        assert_eq!((cut.undetected, flipped.undetected), (0, 0));
    }
}
