//! The stages: one file each, one registry line each. A stage has no state and never sees the GPU.

pub mod apply;
pub mod cell_reduce;
pub mod entry;
pub mod restore_thermostat;
pub mod rotate;
pub mod shift_grid;
pub mod sort_reorder;
pub mod squirmer_collide;
pub mod squirmer_fill;
pub mod squirmer_move;
pub mod stream;
pub mod wall_ghosts;

pub use entry::{Entry, Finding, Fused, Gravity, Phase, Stage};

/// Every stage, in the order in which a step usually runs them.
pub const REGISTRY: &[Entry] = &[
    Entry::of::<squirmer_move::SquirmerMove>(),
    Entry::of::<stream::Stream>(),
    Entry::of::<squirmer_collide::SquirmerCollide>(),
    Entry::of::<shift_grid::ShiftGrid>(),
    Entry::of::<sort_reorder::SortReorder>(),
    Entry::of::<cell_reduce::CellReduce>(),
    Entry::of::<wall_ghosts::WallGhosts>(),
    Entry::of::<squirmer_fill::SquirmerFill>(),
    Entry::of::<rotate::Rotate>(),
    Entry::of::<restore_thermostat::RestoreThermostat>(),
    Entry::of::<apply::Apply>(),
];

/// The registry entry of this kind.
#[must_use]
pub fn find(kind: &str) -> Option<&'static Entry> {
    REGISTRY.iter().find(|e| e.kind == kind)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::buffers::Gathering;
    use crate::shader::Lanes;

    #[test]
    fn every_stage_composes_and_has_its_entry_points() {
        for entry in REGISTRY {
            let module = entry.module().unwrap_or_else(|e| panic!("{e}"));
            for phase in entry.phases.iter().chain(entry.receive) {
                assert!(
                    module.entry_points().any(|n| n == phase.entry),
                    "{}: no entry point `{}`",
                    entry.kind,
                    phase.entry
                );
            }
        }
    }

    #[test]
    fn every_kernel_of_the_fused_plan_has_its_entry_point() {
        for entry in REGISTRY {
            let own = entry.phases.iter().chain(entry.receive);
            let mut points: Vec<&str> = Vec::new();
            for gathering in [Gathering::Chains, Gathering::Bricks] {
                let other = entry.otherwise(gathering);
                let ahead = other.iter().flat_map(|f| f.ahead.iter().map(|p| (*p, f.text(p.entry))));
                let phases: Vec<(Phase, &str)> =
                    own.clone().flat_map(|p| entry.fused_phases(*p, gathering)).chain(ahead).collect();
                for lanes in [Lanes::One, Lanes::Four] {
                    for (phase, wgsl) in &phases {
                        let module = entry.fused_module(wgsl, lanes).unwrap_or_else(|e| panic!("{e}"));
                        assert!(module.entry_points().any(|n| n == phase.entry), "{}: {}", entry.kind, phase.entry);
                    }
                }
                let mut replaced = other.iter().flat_map(|f| f.instead.iter().map(|(replaced, _)| replaced));
                assert!(replaced.all(|r| own.clone().any(|p| p.entry == *r)), "{}", entry.kind);
                points.extend(phases.iter().map(|(p, _)| p.entry));
            }
            let named = entry.shared.iter().chain(entry.own).copied().chain(entry.rare.iter().map(|r| r.entry));
            assert!(named.into_iter().all(|s| points.contains(&s)), "{}", entry.kind);
        }
    }
}
