//! The analyzers that come with the program: one list, from which subcommands, their help and pipeline files follow.

use super::Analyzer;
use super::clusters::Clusters;
use super::flow_field::FlowField;
use super::profile::Profile;
use super::spectrum::Spectrum;
use super::structure::Structure;
use super::swim::Swim;
use crate::params::{Field, Params, Values};
use crate::wire::Kind;

/// Every analyzer by its name.
pub const KINDS: &[Entry] = &[
    Entry::of::<Swim>(),
    Entry::of::<FlowField>(),
    Entry::of::<Structure>(),
    Entry::of::<Clusters>(),
    Entry::of::<Spectrum>(),
    Entry::of::<Profile>(),
];

/// What an analyzer of this list says of itself.
pub trait Definition: Analyzer + Sized + 'static {
    /// Its name: the subcommand, the kind in a pipeline file, and the ending of its folder.
    const NAME: &'static str;
    /// See [`Analyzer::topics`].
    const TOPICS: &'static [Kind];
    /// See [`Analyzer::extras`].
    const EXTRAS: &'static [Kind] = &[];
    /// Its options; their doc comment says what the analyzer does.
    type Options: Params;

    /// The analyzer with these options.
    fn new(options: Self::Options) -> Self;
}

/// An analyzer without its type.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// See [`Definition::NAME`].
    pub name: &'static str,
    /// Topics that a run must publish, or have recorded, for it.
    pub topics: &'static [Kind],
    /// Topics that it uses, too, where they are there.
    pub extras: &'static [Kind],
    /// What it does.
    pub summary: fn() -> &'static str,
    /// Its options, with units, ranges and defaults; each has a default or may be left out.
    pub fields: fn() -> Vec<Field>,
    /// The analyzer with these options, which must be complete for `fields`, as [`Values::defaults`] of them is.
    pub make: fn(&Values) -> Box<dyn Analyzer>,
}

impl Entry {
    /// The entry of an analyzer.
    #[must_use]
    pub const fn of<A: Definition>() -> Self {
        Self {
            name: A::NAME,
            topics: A::TOPICS,
            extras: A::EXTRAS,
            summary: A::Options::summary,
            fields: A::Options::fields,
            make: |values| Box::new(A::new(A::Options::from_values(values))),
        }
    }

    /// The topics as a sentence.
    #[must_use]
    pub fn needs(&self) -> String {
        let list = |topics: &[Kind]| topics.iter().map(|t| t.topic()).collect::<Vec<_>>().join(", ");
        let extras = list(self.extras);
        let extras = if extras.is_empty() { extras } else { format!(" Uses, where they are there: {extras}.") };
        format!("Needs the topics: {}.{extras}", list(self.topics))
    }
}

/// The analyzer of this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Entry> {
    KINDS.iter().find(|entry| entry.name == name)
}
