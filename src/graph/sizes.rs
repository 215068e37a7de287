//! How large every buffer of a run is.

use super::kernels::Kernel;
use crate::buffers::{Buffer, CATALOGUE, Sizes};
use crate::math::steric::{SAFETY, SIGMA};
use crate::state::System;
use crate::state::packed::smallest_patches;

/// Room by which a bin is wider than the farthest contact, in a.
const BIN_SLACK: f64 = 0.1;

/// Most bins along one axis.
const MAX_BINS: u32 = 64;

/// Elements of every extent of a step's buffers; `particles` is that of a random start, and snapshots have none.
#[must_use]
pub fn sizes(system: &System) -> Sizes {
    let [x, _, z] = system.domain.size;
    let longest = longest_semi_axis(system);
    let ghosts = system.species.iter().map(|s| s.ghosts(&system.fluid)).max().unwrap_or(0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let box_edge = if longest > 0.0 { (2.0 * longest + 4.0).ceil() as u64 } else { 0 };
    Sizes {
        particles: system.particle_count(),
        cells: system.domain.cells().iter().map(|n| u64::from(*n)).product(),
        wall_cells: if system.domain.walls.is_some() { 2 * u64::from(x) * u64::from(z) } else { 0 },
        wall_patches: system.domain.walls.as_ref().map_or(0, |_| smallest_patches(system.domain.cells())),
        squirmers: u64::from(system.squirmer_count()),
        species: system.species.len() as u64,
        ghost_stride: u64::from(ghosts).next_multiple_of(64),
        box_edge,
        bins: bins(system).iter().map(|n| u64::from(*n)).product(),
        ..Sizes::default()
    }
}

/// Bins of the squirmers' pair search along each axis: each at least as wide as the farthest contact.
#[must_use]
pub fn bins(system: &System) -> [u32; 3] {
    if system.species.is_empty() {
        return [1; 3];
    }
    let width = contact_range(longest_semi_axis(system)) + BIN_SLACK;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    system.domain.size.map(|edge| ((f64::from(edge) / width) as u32).clamp(1, MAX_BINS))
}

/// Distance of centres up to which two bodies with this longest semi-axis may touch, in a: both safety margins and the range
/// (2^(1/6) - 1) sigma < 0.123 sigma of the steric potential, at their default values.
#[must_use]
pub fn contact_range(longest: f64) -> f64 {
    2.0 * (longest + SAFETY) + 0.123 * SIGMA
}

fn longest_semi_axis(system: &System) -> f64 {
    system.species.iter().map(|s| s.semi_axes.along.max(s.semi_axes.across)).fold(0.0, f64::max)
}

/// Buffers that the kernels bind and the bytes of each, in the order of the catalogue.
#[must_use]
pub fn memory(kernels: &[Kernel], sizes: &Sizes) -> Vec<(&'static Buffer, u64)> {
    let bound = |b: &&Buffer| kernels.iter().any(|k| k.uses.iter().any(|u| u.buffer == b.name));
    CATALOGUE.iter().filter(bound).map(|b| (b, sizes.bytes(b))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::kernels::Use;
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
        // (3, 3, 6): volume 226.19, so 2262 ghosts at 10 per cell; (2, 2, 2) has fewer.
        let s = sizes(&system(true, &[(6.0, 3.0), (2.0, 2.0)]));
        assert_eq!(s.cells, 30 * 11 * 20);
        assert_eq!(s.wall_cells, 2 * 30 * 20);
        assert_eq!(s.wall_patches, 2 * 8 * 5);
        assert_eq!((s.squirmers, s.species), (6, 2));
        assert_eq!(s.ghost_stride, 2304);
        assert_eq!(s.box_edge, 16);
        // Contacts up to 12.56, bins at least 12.66 wide.
        assert_eq!(bins(&system(true, &[(6.0, 3.0), (2.0, 2.0)])), [2, 1, 1]);
        assert_eq!(s.bins, 2);
    }

    #[test]
    fn a_fluid_alone() {
        let s = sizes(&system(false, &[]));
        assert_eq!((s.cells, s.wall_cells, s.particles), (6000, 0, 60_000));
        assert_eq!((s.squirmers, s.ghost_stride, s.box_edge, s.bins), (0, 0, 0, 1));
    }

    #[test]
    fn memory_counts_each_bound_buffer_once() {
        let used = |name: &str| Use { buffer: name.into(), read: true, write: true };
        let kernel =
            |uses: Vec<Use>| Kernel { stage: 0, kind: "k", entry: "e", receive: false, every_step: true, uses };
        let kernels = [kernel(vec![used("positions"), used("moments")]), kernel(vec![used("positions")])];
        let list = memory(&kernels, &sizes(&system(false, &[])));
        let bytes: Vec<(&str, u64)> = list.iter().map(|(b, n)| (b.name, *n)).collect();
        let words = crate::buffers::find("moments").unwrap().words as u64;
        assert_eq!(bytes, [("positions", 60_000 * 12), ("moments", 6000 * 4 * words)]);
    }
}
