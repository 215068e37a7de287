//! What was measured, kept one file per part, so that a suite can be interrupted and goes on where it was.

use crate::case::{Outcome, Size, Trouble};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// One measured part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Case.
    pub case: String,
    /// Part.
    pub part: String,
    /// Size.
    pub size: Size,
    /// Adapter.
    pub adapter: String,
    /// Its driver.
    pub driver: String,
    /// Version of the program.
    pub version: String,
    /// When it was measured, ISO 8601 date.
    pub date: String,
    /// How long it took.
    pub seconds: f64,
    /// What it found.
    pub outcome: Outcome,
}

/// File of a part.
pub fn path(folder: &Path, case: &str, part: &str) -> PathBuf {
    folder.join(format!("{case}.{part}.json"))
}

/// A part measured before; none if it was not, or not in this size.
pub fn load(folder: &Path, case: &str, part: &str, size: Size) -> Result<Option<Record>, Trouble> {
    let path = path(folder, case, part);
    if !path.exists() {
        return Ok(None);
    }
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let record: Record = serde_json::from_str(&text).map_err(|e| format!("{}: {e}; remove it", path.display()))?;
    Ok(Some(record).filter(|r| r.size == size))
}

/// Keeps a part; a reader never sees half a file.
pub fn store(folder: &Path, record: &Record) -> Result<(), Trouble> {
    std::fs::create_dir_all(folder)?;
    let path = path(folder, &record.case, &record.part);
    let draft = path.with_extension("draft");
    std::fs::write(&draft, serde_json::to_string_pretty(record)? + "\n")?;
    std::fs::rename(&draft, &path)?;
    Ok(())
}

/// Today, from the clock (UTC): days since 1970 to a date, after Howard Hinnant's civil calendar.
pub fn today() -> String {
    let seconds = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let z = seconds / 86_400 + 719_468;
    let (era, day_of_era) = (z / 146_097, z % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}")
}
