//! A part of a source: the snapshots of some steps.

use super::{AnalyzeError, Ending, Source, Visit};
use crate::wire::Kind;
use std::collections::HashSet;
use std::ops::{ControlFlow, RangeInclusive};

/// The snapshots of a source whose steps lie in a range.
pub struct Window {
    source: Box<dyn Source>,
    steps: RangeInclusive<u64>,
}

impl Window {
    /// The snapshots of `source` at these steps, the last one included.
    #[must_use]
    pub fn new(source: Box<dyn Source>, steps: RangeInclusive<u64>) -> Self {
        Self { source, steps }
    }
}

impl Source for Window {
    fn offers(&self, topic: Kind) -> bool {
        self.source.offers(topic)
    }

    /// Ends as soon as every topic has reached the last step.
    fn drive(&mut self, topics: &[Kind], visit: &mut Visit<'_>) -> Result<Ending, AnalyzeError> {
        let steps = &self.steps;
        let (mut given, mut through) = (0, HashSet::new());
        let ending = self.source.drive(topics, &mut |snapshot| {
            let step = snapshot.header.step;
            if step >= *steps.end() {
                through.insert(snapshot.kind());
            }
            if steps.contains(&step) {
                given += 1;
                if visit(snapshot)?.is_break() {
                    return Ok(ControlFlow::Break(()));
                }
            }
            Ok(if through.len() == topics.len() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
        })?;
        Ok(Ending { snapshots: given, ..ending })
    }
}
