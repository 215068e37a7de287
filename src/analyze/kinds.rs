//! The analyzers that come with the program: one list, from which pipeline files follow.

use crate::wire::Kind;

/// Every analyzer by its name.
pub const KINDS: &[Entry] = &[Entry { name: "swim", topics: &[Kind::Squirmers] }];

/// An analyzer without its type.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// Its name: the subcommand of `squirm-analyze`, the kind in a pipeline file, and the ending of its folder.
    pub name: &'static str,
    /// Topics that a run must publish, or have recorded, for it.
    pub topics: &'static [Kind],
}

/// The analyzer of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Entry> {
    KINDS.iter().find(|entry| entry.name == name)
}
