//! The stages: one file each, one registry line each. A stage has no state and never sees the GPU.

pub mod entry;
pub mod shift_grid;
pub mod squirmer_move;

pub use entry::{Entry, Finding, Gravity, Phase, Stage};

/// Every stage, in the order in which a step usually runs them.
pub const REGISTRY: &[Entry] = &[Entry::of::<squirmer_move::SquirmerMove>(), Entry::of::<shift_grid::ShiftGrid>()];

/// The registry entry of this kind.
#[must_use]
pub fn find(kind: &str) -> Option<&'static Entry> {
    REGISTRY.iter().find(|e| e.kind == kind)
}
