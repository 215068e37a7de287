//! What a case found, as a table.

use std::fmt::Write;

/// One claim and how often it held.
pub struct Row {
    /// The claim.
    pub claim: &'static str,
    /// Trials.
    pub trials: u32,
    /// Trials in which it held.
    pub held: u32,
    /// Figures, or why there were no trials.
    pub figures: String,
    /// The first trials that failed, and how.
    pub failures: Vec<String>,
}

impl Row {
    /// A claim without trials.
    pub fn new(claim: &'static str) -> Self {
        Self { claim, trials: 0, held: 0, figures: String::new(), failures: Vec::new() }
    }

    /// Enters one trial.
    pub fn enter(&mut self, result: Result<(), String>) {
        self.trials += 1;
        match result {
            Ok(()) => self.held += 1,
            Err(why) if self.failures.len() < 5 => self.failures.push(format!("trial {}: {why}", self.trials)),
            Err(_) => {}
        }
    }

    /// Enters the only trial, with its figures if it held.
    pub fn tell(&mut self, result: Result<String, String>) {
        let entered = result.map(|figures| self.figures = figures);
        self.enter(entered);
    }

    /// Whether it always held.
    pub fn passed(&self) -> bool {
        self.held == self.trials
    }
}

/// The table, as Markdown.
pub fn text(rows: &[Row]) -> String {
    let mut text = String::from("| claim | held | figures |\n|---|---|---|\n");
    for row in rows {
        let held = if row.trials == 0 { "skipped".to_owned() } else { format!("{}/{}", row.held, row.trials) };
        let _ = writeln!(text, "| {} | {held} | {} |", row.claim, row.figures);
    }
    for failure in rows.iter().flat_map(|row| &row.failures) {
        let _ = writeln!(text, "FAILED {failure}");
    }
    text
}
