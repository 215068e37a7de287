//! Names of a recording's files: `run.mcap`, and after each resumption of the run one more, `run.0001.mcap` and so on.

use std::path::{Path, PathBuf};

/// Ending of every recording.
const ENDING: &str = ".mcap";

/// Name of the segment with this number, of the recording `stem`.
#[must_use]
pub fn name(stem: &str, number: u32) -> String {
    if number == 0 { format!("{stem}{ENDING}") } else { format!("{stem}.{number:04}{ENDING}") }
}

/// The number of a segment of the recording `stem`, if `file` is the name of one.
#[must_use]
pub fn number(stem: &str, file: &str) -> Option<u32> {
    let between = file.strip_prefix(stem)?.strip_suffix(ENDING)?;
    if between.is_empty() {
        return Some(0);
    }
    let digits = between.strip_prefix('.').filter(|d| d.len() >= 4 && d.bytes().all(|b| b.is_ascii_digit()))?;
    digits.parse().ok().filter(|n| *n > 0)
}

/// The segments of a recording that are there, in the order of time: of the one whose first segment is `path`, of `run.mcap` in
/// the directory `path`; any other file stands for itself alone.
#[must_use]
pub fn of(path: &Path) -> Vec<PathBuf> {
    let first = if path.is_dir() { path.join(name("run", 0)) } else { path.to_owned() };
    let stem = first.file_name().and_then(|n| n.to_str()).and_then(|n| n.strip_suffix(ENDING));
    let folder = first.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let numbered = |stem: &str| {
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut found: Vec<(u32, PathBuf)> =
            files.filter_map(|f| Some((number(stem, f.file_name().to_str()?).filter(|n| *n > 0)?, f.path()))).collect();
        found.sort();
        found.into_iter().map(|(_, path)| path)
    };
    let later: Vec<PathBuf> = stem.into_iter().flat_map(numbered).collect();
    // A recording may begin after a resumption. Where there is none at all, the name that was asked for is what is missing.
    let begins = first.exists() || later.is_empty();
    begins.then_some(first).into_iter().chain(later).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_numbers_agree() {
        for (number_, name_) in [(0, "run.mcap"), (1, "run.0001.mcap"), (12_345, "run.12345.mcap")] {
            assert_eq!(name("run", number_), name_);
            assert_eq!(number("run", name_), Some(number_));
        }
        for other in
            ["run.fluid.mcap", "run.fluid.0001.mcap", "run.1.mcap", "run.0000.mcap", "run.00x1.mcap", "run.csv"]
        {
            assert_eq!(number("run", other), None, "{other}");
        }
        assert_eq!(number("run.fluid", "run.fluid.0001.mcap"), Some(1));
    }

    #[test]
    fn segments_come_in_order_and_a_single_one_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        for file in ["run.mcap", "run.0010.mcap", "run.0002.mcap", "run.fluid.0001.mcap", "run.0001.mcap.tmp"] {
            std::fs::write(folder.path().join(file), "").expect("written");
        }
        let expected = ["run.mcap", "run.0002.mcap", "run.0010.mcap"].map(|f| folder.path().join(f));
        assert_eq!(of(folder.path()), expected);
        assert_eq!(of(&folder.path().join("run.mcap")), expected);
        assert_eq!(of(&expected[1]), [expected[1].clone()]);
        assert_eq!(of(&folder.path().join("run.fluid.mcap")), [folder.path().join("run.fluid.0001.mcap")]);
        assert_eq!(of(&folder.path().join("other.mcap")), [folder.path().join("other.mcap")]);
    }
}
