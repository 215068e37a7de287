//! What only shows when a run is to start, told at its place in the file: limits of an adapter, squirmers that find no room.

use super::Loaded;
use super::node::Node;
use crate::diag::Diagnostic;
use crate::state::System;
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
        no_start(error, &self.plan.system, &self.root)
    }
}

/// A start that cannot be made, told at its place in the file.
pub fn no_start(error: &StartError, system: &System, root: &Node) -> Diagnostic {
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
        StartError::Crowded { .. } => (
            &["squirmers", "0"][..],
            "first of them",
            "take fewer or smaller squirmers, a larger box, or start = \"lattice\"",
        ),
        StartError::Lattice { .. } => {
            (&["squirmers", "0"][..], "first of them", "take fewer or smaller squirmers, or a larger box")
        }
        StartError::Poses { .. } | StartError::NoDirection { .. } => {
            (&["squirmers", "0"][..], "first of them", "correct `poses`: a row x, y, z, ex, ey, ez for each squirmer")
        }
        StartError::InWall { squirmer, .. } => return misplaced(error, &[*squirmer], system, root),
        StartError::Overlap { first, second } => return misplaced(error, &[*second, *first], system, root),
    };
    Diagnostic::error(error.to_string()).at(root.place(place), label).help(help)
}

/// Squirmers that the user placed badly, by their numbers over all species.
fn misplaced(error: &StartError, squirmers: &[usize], system: &System, root: &Node) -> Diagnostic {
    let mut diagnostic = Diagnostic::error(error.to_string());
    for number in squirmers {
        let mut row = *number;
        let owner = system.species.iter().position(|s| {
            let here = row < s.count as usize;
            row -= if here { 0 } else { s.count as usize };
            here
        });
        let path = ["squirmers", &owner.unwrap_or(0).to_string(), "poses", &row.to_string()];
        diagnostic = diagnostic.at(root.place(&path), format!("squirmer {number}"));
    }
    diagnostic.help("move them apart in `poses`, and away from the walls")
}
