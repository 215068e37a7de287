//! The sections of a pipeline file: one table that drives parsing, documentation and the schema.

use crate::graph::{AnalyzerProgram, Checkpoints, Output};
use crate::params::{Field, Params};
use crate::state::{Domain, Fluid, Init, Run, Species};

/// One section of the file; `[[stage]]` stands apart, since its keys depend on its kind.
#[derive(Debug, Clone, Copy)]
pub struct Section {
    /// Its name in brackets.
    pub name: &'static str,
    /// Whether it may stand any number of times, in double brackets.
    pub repeated: bool,
    /// What it says.
    pub summary: fn() -> &'static str,
    /// Its parameters.
    pub fields: fn() -> Vec<Field>,
}

impl Section {
    const fn of<P: Params>(name: &'static str, repeated: bool) -> Self {
        Self { name, repeated, summary: P::summary, fields: P::fields }
    }

    /// Whether a file without it is incomplete: it holds a required parameter.
    #[must_use]
    pub fn is_required(&self) -> bool {
        !self.repeated && (self.fields)().iter().any(is_required)
    }

    /// The name as it is written in the file.
    #[must_use]
    pub fn header(&self) -> String {
        if self.repeated { format!("[[{}]]", self.name) } else { format!("[{}]", self.name) }
    }
}

/// Whether a parameter must be given.
#[must_use]
pub fn is_required(field: &Field) -> bool {
    field.default.is_none() && !field.optional
}

/// The list of stages.
pub const STAGE: &str = "stage";

/// Every section but `[[stage]]`, in the order of the resolved file; stages come before outputs.
pub const SECTIONS: &[Section] = &[
    Section::of::<Run>("run", false),
    Section::of::<Domain>("box", false),
    Section::of::<Fluid>("fluid", false),
    Section::of::<Species>("squirmers", true),
    Section::of::<Init>("init", false),
    Section { name: STAGE, repeated: true, summary: stage_summary, fields: Vec::new },
    Section::of::<Output>("output", true),
    Section::of::<AnalyzerProgram>("analyzer", true),
    Section::of::<Checkpoints>("checkpoint", false),
];

fn stage_summary() -> &'static str {
    "One stage of the step; the order in the file is the order of execution. `squirm stages` documents every kind."
}
