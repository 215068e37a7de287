//! Tables of numbers as CSV: units stand in the header, every number in the shortest form that reads back as the same.

use super::statistics::Estimate;

/// A table that is being written.
#[derive(Debug, Clone)]
pub struct Table(String);

impl Table {
    /// The header; an estimate takes two columns, the second named `error`.
    #[must_use]
    pub fn new(header: &str) -> Self {
        Self(format!("{header}\n"))
    }

    /// One row.
    pub fn row(&mut self, cells: &[Cell<'_>]) {
        for (i, cell) in cells.iter().enumerate() {
            if i > 0 {
                self.0.push(',');
            }
            match cell {
                Cell::Text(text) => self.0.push_str(&quoted(text)),
                Cell::Number(v) => self.0.push_str(&v.to_string()),
                Cell::Estimate(e) => self.0.push_str(&format!("{},{}", e.mean, e.error)),
            }
        }
        self.0.push('\n');
    }

    /// The text of the file.
    #[must_use]
    pub fn finish(self) -> String {
        self.0
    }
}

/// What stands in a table.
#[derive(Debug, Clone, Copy)]
pub enum Cell<'a> {
    /// A name.
    Text(&'a str),
    /// A number.
    Number(f64),
    /// A mean and its error, in two columns.
    Estimate(Estimate),
}

impl From<f64> for Cell<'_> {
    fn from(v: f64) -> Self {
        Self::Number(v)
    }
}

impl From<Estimate> for Cell<'_> {
    fn from(e: Estimate) -> Self {
        Self::Estimate(e)
    }
}

/// A name as CSV wants it.
#[must_use]
pub fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.to_owned() }
}

/// `name  mean +- error unit` for the terminal.
#[must_use]
pub fn line(name: &str, value: Estimate, unit: &str) -> String {
    format!("{name:<44} {:>12.5} +- {:<10.5} {unit}\n", value.mean, value.error)
}
