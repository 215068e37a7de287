//! Which files a run was recorded into: a run that was resumed, or whose file is full, goes on in a new segment.

use super::RecordingError;
use std::path::{Path, PathBuf};

/// The first segment of a run's small topics.
pub const RUN: &str = "run.mcap";
/// The first segment of the fluid's particles.
pub const FLUID: &str = "run.fluid.mcap";

/// The name of segment `number` of the recording whose first segment is `first`: `run.mcap`, `run.0001.mcap`, `run.0002.mcap`.
#[must_use]
pub fn segment(first: &Path, number: u32) -> PathBuf {
    if number == 0 { first.into() } else { first.with_extension(format!("{number:04}.mcap")) }
}

/// The files of a recording in order. `path` is a run's folder, the first segment, or a later one, which then stands alone.
///
/// # Errors
/// If there is no such recording, or its folder cannot be read.
pub fn segments(path: &Path) -> Result<Vec<PathBuf>, RecordingError> {
    let first = if path.is_dir() { path.join(RUN) } else { path.to_owned() };
    // A run may begin to record the fluid when it is resumed.
    let mut found = if first.is_file() { vec![(0, first.clone())] } else { Vec::new() };
    let stem = first.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let alone = number(&stem).is_some() || first.extension().is_none_or(|e| e != "mcap");
    if alone && !found.is_empty() {
        return Ok(vec![first]);
    }
    let folder = first.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let io = RecordingError::io(folder);
    if alone || !folder.is_dir() {
        return Err(RecordingError::Absent(first.clone()));
    }
    for entry in std::fs::read_dir(folder).map_err(&io)? {
        let name = entry.map_err(&io)?.file_name().to_string_lossy().into_owned();
        let later = name.strip_suffix(".mcap").filter(|s| s.rsplit_once('.').is_some_and(|(before, _)| before == stem));
        if let Some(number) = later.and_then(number) {
            found.push((number, first.with_file_name(&name)));
        }
    }
    if found.is_empty() {
        return Err(RecordingError::Absent(first.clone()));
    }
    found.sort();
    Ok(found.into_iter().map(|(_, path)| path).collect())
}

/// The files of every recording that `path` means: of a run's folder those of the small topics and those of the fluid, each in
/// order; of a file its own.
///
/// # Errors
/// As [`segments`]; a folder may have either recording alone.
pub fn recordings(path: &Path) -> Result<Vec<Vec<PathBuf>>, RecordingError> {
    if !path.is_dir() {
        return Ok(vec![segments(path)?]);
    }
    let small = segments(&path.join(RUN));
    match segments(&path.join(FLUID)) {
        Ok(fluid) => match small {
            Ok(small) => Ok(vec![small, fluid]),
            Err(RecordingError::Absent(_)) => Ok(vec![fluid]),
            Err(error) => Err(error),
        },
        Err(RecordingError::Absent(_)) => Ok(vec![small?]),
        Err(error) => Err(error),
    }
}

/// The number of a later segment, at least four digits behind the last dot.
fn number(stem: &str) -> Option<u32> {
    let (_, digits) = stem.rsplit_once('.')?;
    (digits.len() >= 4 && digits.bytes().all(|b| b.is_ascii_digit())).then(|| digits.parse().ok())?
}

/// The first segment of the recording of the fluid's particles beside that of the small topics, if there is any of its segments.
#[must_use]
pub fn fluid_beside(path: &Path) -> Option<PathBuf> {
    let first = if path.is_dir() { path.join(RUN) } else { path.to_owned() };
    let beside = first.with_file_name(FLUID);
    (first.file_name().is_some_and(|n| n == RUN) && segments(&beside).is_ok()).then_some(beside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_come_in_order_and_fluid_apart() {
        let dir = tempfile::tempdir().unwrap();
        let names = ["run.mcap", "run.0010.mcap", "run.0002.mcap", "run.fluid.mcap", "run.fluid.0001.mcap"];
        for name in names.iter().chain(&["run.recovered.mcap", "run.01.mcap", "other.mcap", "run.0003.txt"]) {
            std::fs::write(dir.path().join(name), "").unwrap();
        }
        let named = |path: &Path| -> Vec<String> {
            let name = |p: PathBuf| p.file_name().unwrap().to_string_lossy().into_owned();
            segments(path).unwrap().into_iter().map(name).collect()
        };
        let run = ["run.mcap", "run.0002.mcap", "run.0010.mcap"];
        assert_eq!(named(dir.path()), run);
        assert_eq!(named(&dir.path().join(RUN)), run);
        assert_eq!(named(&dir.path().join(FLUID)), ["run.fluid.mcap", "run.fluid.0001.mcap"]);
        assert_eq!(named(&dir.path().join("run.0002.mcap")), ["run.0002.mcap"]);
        assert_eq!(named(&dir.path().join("other.mcap")), ["other.mcap"]);
        assert_eq!(fluid_beside(dir.path()), Some(dir.path().join(FLUID)));
        assert_eq!(fluid_beside(&dir.path().join("other.mcap")), None);
        assert_eq!(segment(&dir.path().join(FLUID), 1), dir.path().join("run.fluid.0001.mcap"));
        assert!(matches!(segments(&dir.path().join("absent.mcap")), Err(RecordingError::Absent(_))));
        assert!(matches!(segments(&dir.path().join("no folder/run.mcap")), Err(RecordingError::Absent(_))));
        let lengths = |path: &Path| recordings(path).unwrap().iter().map(Vec::len).collect::<Vec<_>>();
        assert_eq!(lengths(dir.path()), [3, 2]);
        assert_eq!(lengths(&dir.path().join(RUN)), [3], "a file means itself");
        std::fs::remove_file(dir.path().join(FLUID)).unwrap();
        assert_eq!(named(&fluid_beside(dir.path()).unwrap()), ["run.fluid.0001.mcap"]);
        run.iter().for_each(|name| std::fs::remove_file(dir.path().join(name)).unwrap());
        assert_eq!(lengths(dir.path()), [1], "the fluid alone");
        std::fs::remove_file(dir.path().join("run.fluid.0001.mcap")).unwrap();
        assert!(matches!(recordings(dir.path()), Err(RecordingError::Absent(path)) if path.ends_with(RUN)));
    }
}
