//! How large every buffer of a run is.

use crate::buffers::{Buffer, CATALOGUE, Sizes, lodgers};
use crate::math::steric::{SAFETY, SIGMA};
use crate::state::System;
use crate::state::packed;
use std::collections::HashSet;

/// Elements of every extent of a step's buffers; `particles` is that of a random start, and snapshots have none.
#[must_use]
pub fn sizes(system: &System) -> Sizes {
    packed::sizes(system, system.particle_count())
}

/// Distance of centres up to which two bodies with this longest semi-axis may touch, in a: both safety margins and the range
/// (2^(1/6) - 1) sigma < 0.123 sigma of the steric potential, at their default values.
#[must_use]
pub fn contact_range(longest: f64) -> f64 {
    2.0 * (longest + SAFETY) + 0.123 * SIGMA
}

/// Buffers that snapshots read, whatever the stages use.
pub const SHOWN: [&str; 9] = [
    "particles",
    "velocities_yz",
    "squirmers",
    "species",
    "moments",
    "faults",
    "fluid_force",
    "steric",
    "wall_impulses",
];

/// The buffers of a run whose kernels bind these, and the memory that each takes, in the order of the catalogue: none if it lies in that of
/// others.
#[must_use]
pub fn memory<'a>(bound: impl Iterator<Item = &'a str>, sizes: &Sizes) -> Vec<(&'static Buffer, u64)> {
    let names: HashSet<&str> = bound.chain(SHOWN).collect();
    let here = |b: &&Buffer| names.contains(b.name) && b.name != "settings";
    let lodging = lodgers(|name| names.contains(name), sizes);
    let taken = |b: &Buffer| if lodging.contains(&b.name) { 0 } else { sizes.bytes(b) };
    CATALOGUE.iter().filter(here).map(|b| (b, taken(b))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{Params, Value, Values};
    use crate::state::{Domain, Fluid, Init, Run, SemiAxes, Species, Walls};

    fn system(walls: bool, axes: &[(f64, f64)]) -> System {
        let mut run = Values::defaults(&Run::fields());
        run.set("steps", Value::Integer(1));
        run.set("dt", Value::Float(0.1));
        let species = axes.iter().map(|(along, across)| {
            let mut values = Values::defaults(&Species::fields());
            values.set("count", Value::Integer(3));
            let shape = SemiAxes { along: *along, across: *across };
            values.set("semi_axes", Value::Table(shape.to_values()));
            Species::from_values(&values)
        });
        System {
            run: Run::from_values(&run),
            domain: Domain {
                size: [30, 10, 20],
                walls: walls.then(|| Walls::from_values(&Values::defaults(&Walls::fields()))),
            },
            fluid: Fluid::from_values(&Values::defaults(&Fluid::fields())),
            species: species.collect(),
            init: Init { from: None },
        }
    }

    #[test]
    fn a_slit_with_squirmers() {
        // A hull of (3.12, 3.12, 6.12): volume 249.55, so 2495 ghosts at 10 per cell; (2, 2, 2) has fewer.
        let s = sizes(&system(true, &[(6.0, 3.0), (2.0, 2.0)]));
        // Bricks of 4^3: 8 x 3 x 5.
        assert_eq!(s.cells, 8 * 3 * 5 * 64);
        assert_eq!(s.wall_cells, 2 * 32 * 24);
        assert_eq!(s.wall_patches, 2 * 8 * 5);
        assert_eq!((s.squirmers, s.species), (6, 2));
        assert_eq!(s.ghost_stride, 2496);
        // 6.12 a, half of the longest path of a step 0.6 a, half the diagonal of a cell, and a cell on either side.
        assert_eq!(s.box_edge, 18);
        assert_eq!(s.bins, 0);
        let mut many = system(true, &[(6.0, 3.0)]);
        many.species[0].count = 1025;
        // At least 2 (6.12 + 1) a wide: two along x.
        assert_eq!(sizes(&many).bins, 2);
    }

    #[test]
    fn a_fluid_alone() {
        let s = sizes(&system(false, &[]));
        assert_eq!((s.cells, s.wall_cells, s.particles), (7680, 0, 60_000));
        assert_eq!((s.squirmers, s.ghost_stride, s.box_edge, s.bins), (0, 0, 0, 0));
    }

    /// A crowd counts wherever the bricks begin, also across the edges of a periodic box.
    #[test]
    fn bricks_have_room_for_the_largest_crowd() {
        let system = system(false, &[]);
        let usual = packed::brick_room(&system);
        // 1,280 in the mean, 8 x 35.8 more, and 16.
        assert_eq!(usual, 1584);
        let at = |cell: [u32; 3]| -> [u32; 3] {
            let lengths = [30u64, 10, 20];
            std::array::from_fn(|k| u32::try_from((u64::from(cell[k]) << 32).div_ceil(lengths[k])).expect("in the box"))
        };
        let even = (0..60_000).map(|i| at([i % 30, i / 30 % 10, i / 300 % 20]));
        assert_eq!(packed::brick_room_for(&system, even), usual);
        // 2,000 each in two cells: at opposite corners, which touch around the edges; in neighbours, which share a room; and in two that no two
        // bricks hold together.
        let crowd = |cell| (0..4000).map(move |i| if i % 2 == 0 { at([0, 0, 0]) } else { at(cell) });
        assert_eq!(packed::brick_room_for(&system, crowd([29, 9, 19])), 4528);
        assert_eq!(packed::brick_room_for(&system, crowd([7, 0, 0])), 4528);
        for apart in [[9, 0, 0], [0, 4, 0], [0, 0, 4], [2, 4, 0]] {
            assert_eq!(packed::brick_room_for(&system, crowd(apart)), 2384, "{apart:?}");
        }
    }

    #[test]
    fn bodies_may_compress_the_fluid() {
        // Hulls of 3 spheres, 0.12 larger than these, take 0.48, 0.1462 and 0.0636 of the volume.
        for (radius, mean) in [(6.0, 1792.0), (4.0, 1280.0 * (1.0 + 2.5 * (0.1462 - 0.08))), (3.0, 1280.0)] {
            let system = system(false, &[(radius, radius)]);
            let room = packed::brick_room(&system) as f64;
            let wanted = mean + 8.0 * f64::sqrt(mean) + 16.0;
            assert!(room >= wanted && room < wanted + 17.0, "{radius}: {room} for {wanted}");
        }
    }

    /// Where a row has an odd number of bricks the last of one row and the first of the next share a room, and so do rows of layers.
    #[test]
    fn partners_may_be_far_apart() {
        let mut system = system(false, &[]);
        system.domain.size = [36, 36, 36];
        let at = |cell: [u32; 3]| cell.map(|c| u32::try_from((u64::from(c) << 32).div_ceil(36)).expect("in the box"));
        let crowd = |cell| (0..4000).map(move |i| if i % 2 == 0 { at([1, 1, 1]) } else { at(cell) });
        // Bricks 8 and 9 are (8, 0, 0) and (0, 1, 0), bricks 80 and 81 (8, 8, 0) and (0, 0, 1).
        for together in [[5, 1, 1], [5, 5, 1], [5, 5, 5], [8, 8, 8]] {
            assert_eq!(packed::brick_room_for(&system, crowd(together)), 4528, "{together:?}");
        }
        for apart in [[1, 9, 1], [9, 1, 1], [1, 1, 9]] {
            assert_eq!(packed::brick_room_for(&system, crowd(apart)), 2384, "{apart:?}");
        }
    }

    #[test]
    fn memory_counts_each_buffer_once() {
        let list =
            memory(["particles", "velocities_yz", "particles", "settings"].into_iter(), &sizes(&system(false, &[])));
        let bytes: Vec<(&str, u64)> = list.iter().map(|(b, n)| (b.name, *n)).collect();
        let words = crate::buffers::find("moments").unwrap().words as u64;
        for wanted in [("particles", 60_000 * 16), ("velocities_yz", 60_000 * 8), ("moments", 7680 * 4 * words)] {
            assert_eq!(bytes.iter().filter(|b| **b == wanted).count(), 1, "{bytes:?}");
        }
        assert!(!bytes.iter().any(|(name, _)| *name == "links" || *name == "settings"));
    }
}
