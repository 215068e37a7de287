//! What a case measures, and what is said of it.

use crate::rig::Rig;
use serde::{Deserialize, Serialize};
use squirm::graph::Plan;

/// How much work a case does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Size {
    /// Minutes on two cores: catches errors of principle.
    Quick,
    /// For a GPU: the statistical error is below a third of the tolerance.
    Full,
}

/// One comparison: a line of the report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What was measured, with its unit.
    pub quantity: String,
    /// Of which system.
    pub setup: String,
    /// The value found.
    pub measured: f64,
    /// Its standard error, from blocks or independent seeds.
    pub error: f64,
    /// The value expected; none if the row only reports what was seen.
    pub expected: Option<f64>,
    /// Largest difference allowed, in the same unit.
    pub tolerance: f64,
    /// Where the expectation comes from.
    pub source: String,
    /// What else the reader should know.
    #[serde(default)]
    pub note: String,
}

/// What a row says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// As expected.
    Pass,
    /// Off by more than the tolerance.
    Miss,
    /// The statistical error is too large for a judgement.
    Vague,
    /// Nothing was expected.
    Seen,
}

impl Verdict {
    /// In tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Miss => "**misses**",
            Self::Vague => "**too vague**",
            Self::Seen => "seen",
        }
    }

    /// Whether the row may stand in a report without a word of explanation.
    pub fn good(self) -> bool {
        matches!(self, Self::Pass | Self::Seen)
    }
}

impl Row {
    /// A full run must meet the tolerance with an error below a third of it; a quick one may miss by three of its errors, but must
    /// know the value to twice the tolerance.
    pub fn verdict(&self, size: Size) -> Verdict {
        let Some(expected) = self.expected else { return Verdict::Seen };
        let (slack, largest_error) = match size {
            Size::Quick => (3.0 * self.error, 2.0 * self.tolerance),
            Size::Full => (0.0, self.tolerance / 3.0),
        };
        // Comparisons with what is not a number are false: such a value misses, such an error is vague.
        let near = (self.measured - expected).abs() <= self.tolerance + slack;
        let sharp = self.error <= largest_error;
        match (near, sharp) {
            (true, true) => Verdict::Pass,
            (true, false) => Verdict::Vague,
            (false, _) => Verdict::Miss,
        }
    }
}

/// Points and theory for a chart of the report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Name of the case's [`Sheet`] that it goes into.
    pub sheet: String,
    /// In the legend.
    pub name: String,
    /// x, y and error of y.
    pub points: Vec<(f64, f64, f64)>,
    /// The theory.
    pub guide: Vec<(f64, f64)>,
    /// In the legend.
    pub guide_name: String,
}

/// A chart of the report.
#[derive(Debug, Clone, Copy)]
pub struct Sheet {
    /// File name without ending.
    pub name: &'static str,
    /// Caption.
    pub title: &'static str,
    /// Label of the x axis, with its unit.
    pub x: &'static str,
    /// Label of the y axis, with its unit.
    pub y: &'static str,
    /// Both axes logarithmic.
    pub logarithmic: bool,
}

/// What one part of a case found.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Outcome {
    /// Comparisons.
    pub rows: Vec<Row>,
    /// For the charts.
    pub curves: Vec<Curve>,
}

/// Why a part could not be measured.
pub type Trouble = Box<dyn std::error::Error>;

/// Does the work of a part.
pub type Measure = dyn Fn(&Rig) -> Result<Outcome, Trouble>;

/// A piece of a case that is measured, kept and repeated by itself.
pub struct Part {
    /// Unique in its case; also a file name.
    pub name: String,
    /// Does the work.
    pub measure: Box<Measure>,
    /// Takes so much longer than others that it should begin first where several are measured at a time.
    pub long: bool,
}

impl Part {
    /// A part.
    pub fn new(name: impl Into<String>, measure: impl Fn(&Rig) -> Result<Outcome, Trouble> + 'static) -> Self {
        Self { name: name.into(), measure: Box::new(measure), long: false }
    }

    /// The same as a long one.
    pub fn long(self) -> Self {
        Self { long: true, ..self }
    }
}

/// A variant that is wrong on purpose, and that the case must notice.
pub struct Control {
    /// Name.
    pub name: &'static str,
    /// What is wrong.
    pub about: &'static str,
    /// The part of the quick case that must notice it.
    pub part: &'static str,
    /// Spoils what is simulated; the theory keeps to what was meant.
    pub spoil: fn(&mut Plan),
}

/// Something that is known, and how the program is held against it.
pub struct Case {
    /// On the command line.
    pub name: &'static str,
    /// In the report.
    pub title: &'static str,
    /// Set-up, theory and method in a few sentences; Markdown.
    pub about: &'static str,
    /// What misses its tolerance in the committed report, and why, or what else is to be said of it; Markdown, empty if there is nothing.
    pub remarks: &'static str,
    /// Charts.
    pub sheets: &'static [Sheet],
    /// What is measured.
    pub parts: fn(Size) -> Vec<Part>,
    /// What it must not miss.
    pub controls: &'static [Control],
}
