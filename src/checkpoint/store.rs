//! Checkpoint files in a run's directory: written beside the current one, made current by renaming, the one before kept.

use super::container::{Damage, Sections, decode, encode};
use std::fs::{File, rename};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The newest checkpoint.
pub const CURRENT: &str = "run.checkpoint";
/// The one before it.
pub const PREVIOUS: &str = "run.checkpoint.previous";
/// One that is being written.
pub const TEMPORARY: &str = "run.checkpoint.tmp";
/// Where a damaged newest one is put aside, lest it take the place of a good one.
const DAMAGED: &str = "run.checkpoint.damaged";

/// Why a checkpoint was not written. The one before is as it was.
#[derive(Debug, thiserror::Error)]
#[error("cannot {what} {}: {source}", path.display())]
pub struct WriteError {
    /// What was to be done.
    pub what: &'static str,
    /// With which file.
    pub path: PathBuf,
    /// What the system says.
    pub source: io::Error,
}

/// A checkpoint that was found.
#[derive(Debug)]
pub struct Found {
    /// Its file.
    pub path: PathBuf,
    /// Its content.
    pub sections: Sections,
    /// The newer file that could not be used, and why.
    pub refused: Option<(PathBuf, Damage)>,
}

/// There are checkpoints, but none can be used.
#[derive(Debug, thiserror::Error)]
pub enum Unreadable {
    /// All are damaged.
    #[error("no checkpoint in {} can be used: {}", dir.display(), reasons.join("; "))]
    Damaged {
        /// Directory.
        dir: PathBuf,
        /// File by file.
        reasons: Vec<String>,
    },
    /// The system does not let them be read.
    #[error("cannot read {}: {source}", path.display())]
    File {
        /// File.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

/// Writes a checkpoint into `dir`. Whenever the program or the machine stops meanwhile, one complete checkpoint is there, the
/// new one or that before.
///
/// # Errors
/// If the disk is full, or the directory cannot be written.
pub fn write(dir: &Path, sections: &[(String, &[u8])]) -> Result<(), WriteError> {
    let [current, previous, temporary] = [CURRENT, PREVIOUS, TEMPORARY].map(|name| dir.join(name));
    let failed = |what: &'static str, path: &Path| {
        let path = path.to_owned();
        move |source| WriteError { what, path, source }
    };
    let written = to_disk(&temporary, sections).map_err(failed("write", &temporary));
    if written.is_err() {
        // What is there of it only takes room.
        let _ = std::fs::remove_file(&temporary);
    }
    written?;
    match rename(&current, &previous) {
        Err(e) if e.kind() != ErrorKind::NotFound => return Err(failed("rename", &current)(e)),
        _ => {}
    }
    rename(&temporary, &current).map_err(failed("rename", &temporary))?;
    sync_directory(dir).map_err(failed("sync", dir))
}

fn to_disk(path: &Path, sections: &[(String, &[u8])]) -> io::Result<()> {
    let mut file = BufWriter::with_capacity(1 << 20, File::create(path)?);
    encode(sections, &mut file)?;
    file.flush()?;
    file.get_ref().sync_all()
}

/// Waits until renamed files have their new names on the disk, where the system can do that.
fn sync_directory(dir: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(dir)?.sync_all() } else { Ok(()) }
}

/// The newest checkpoint of `dir` whose bytes are right and that `usable` accepts; `None` where there is none at all. A newest
/// one that is refused is put aside if an older one takes its place.
///
/// # Errors
/// If none can be used.
pub fn load<T>(dir: &Path, usable: impl Fn(&Sections) -> Result<T, Damage>) -> Result<Option<(T, Found)>, Unreadable> {
    let mut refused: Vec<(PathBuf, Damage)> = Vec::new();
    for name in [CURRENT, PREVIOUS] {
        let path = dir.join(name);
        let bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == ErrorKind::NotFound => continue,
            Err(source) => return Err(Unreadable::File { path, source }),
        };
        match decode(bytes).and_then(|sections| Ok((usable(&sections)?, sections))) {
            Ok((content, sections)) => return Ok(Some((content, Found { path, sections, refused: refused.pop() }))),
            Err(damage) => refused.push((path, damage)),
        }
    }
    if refused.is_empty() {
        return Ok(None);
    }
    let reasons = refused.iter().map(|(path, why)| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        format!("{name}: {why}")
    });
    Err(Unreadable::Damaged { dir: dir.into(), reasons: reasons.collect() })
}

/// Puts a damaged newest checkpoint aside: the next one written would make it the previous one, and the good one would be gone.
///
/// # Errors
/// If the file cannot be renamed.
pub fn put_aside(damaged: &Path) -> Result<(), WriteError> {
    let failed = |source| WriteError { what: "rename", path: damaged.into(), source };
    rename(damaged, damaged.with_file_name(DAMAGED)).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn save(dir: &Path, content: &[u8]) {
        write(dir, &[("run".to_owned(), content)]).expect("written");
    }

    fn loaded(dir: &Path) -> Option<(Vec<u8>, Found)> {
        load(dir, |s| s.get("run").map(<[u8]>::to_vec)).expect("readable")
    }

    #[test]
    fn the_newest_good_one_is_found() {
        let folder = tempfile::tempdir().expect("a folder");
        let dir = folder.path();
        assert!(loaded(dir).is_none());
        save(dir, b"one");
        save(dir, b"two");
        assert_eq!(loaded(dir).expect("one").0, b"two");
        assert!(!dir.join(TEMPORARY).exists());
        std::fs::write(dir.join(CURRENT), b"").expect("damaged");
        let (content, found) = loaded(dir).expect("the one before");
        assert_eq!(content, b"one");
        let (path, why) = found.refused.expect("it says so");
        assert_eq!((path.clone(), why), (dir.join(CURRENT), Damage::Length { expected: 8, found: 0 }));
        put_aside(&path).expect("renamed");
        save(dir, b"three");
        assert_eq!(loaded(dir).expect("one").0, b"three");
        std::fs::write(dir.join(CURRENT), b"").expect("damaged");
        assert_eq!(loaded(dir).expect("the good one was kept").0, b"one");
        std::fs::write(dir.join(PREVIOUS), b"\x89SQ").expect("damaged");
        let refused = load(dir, |_| Ok(())).expect_err("both are damaged").to_string();
        assert!(
            refused.contains("run.checkpoint: it should") && refused.contains("run.checkpoint.previous: "),
            "{refused}"
        );
    }

    #[test]
    fn a_stop_between_the_two_names_loses_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let dir = folder.path();
        save(dir, b"one");
        rename(dir.join(CURRENT), dir.join(PREVIOUS)).expect("renamed");
        std::fs::write(dir.join(TEMPORARY), b"half").expect("written");
        let (content, found) = loaded(dir).expect("the one before");
        assert_eq!((content.as_slice(), found.refused), (&b"one"[..], None));
    }

    #[test]
    fn a_failure_leaves_what_was_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let dir = folder.path();
        save(dir, b"one");
        std::fs::create_dir(dir.join(TEMPORARY)).expect("in the way");
        assert_eq!(write(dir, &[("run".to_owned(), b"two")]).expect_err("it cannot").what, "write");
        assert_eq!(loaded(dir).expect("one").0, b"one");
    }
}
