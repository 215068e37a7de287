//! What only shows when a run is to start, told at its place in the file: limits of an adapter, squirmers that find no room.

use super::Loaded;
use crate::diag::Diagnostic;
use crate::state::start::StartError;

impl Loaded {
    /// An error that a smaller box would cure.
    #[must_use]
    pub fn too_large(&self, message: String) -> Diagnostic {
        Diagnostic::error(message)
            .at(self.root.place(&["box", "size"]), "size of the box")
            .help("take a smaller box or a lower density, or another adapter (`squirm adapters` lists them)")
    }

    /// Why the start that the file asks for cannot be made.
    #[must_use]
    pub fn cannot_start(&self, error: &StartError) -> Diagnostic {
        let (place, label, help) = match error {
            StartError::Table { .. } => (
                &["init", "from"][..],
                "named here",
                "correct that row: a fluid particle lies in the box and outside every squirmer",
            ),
            StartError::Narrow { .. } => {
                (&["box", "size"][..], "size of the box", "make the box larger, or the body smaller")
            }
            StartError::NoFluid => {
                (&["box", "size"][..], "size of the box", "make the box larger, or take fewer squirmers")
            }
            StartError::Crowded { .. } | StartError::Lattice { .. } => {
                (&["squirmers"][..], "first of them", "take fewer or smaller squirmers, or a larger box")
            }
            StartError::Poses { .. } | StartError::NoDirection { .. } => {
                (&["squirmers"][..], "first of them", "correct `poses`: a row x, y, z, ex, ey, ez for each squirmer")
            }
            StartError::InWall { .. } | StartError::Overlap { .. } => {
                (&["squirmers"][..], "first of them", "move them apart in `poses`, and away from the walls")
            }
        };
        let first: Vec<&str> = place.iter().copied().chain((place == ["squirmers"]).then_some("0")).collect();
        Diagnostic::error(error.to_string()).at(self.root.place(&first), label).help(help)
    }
}
