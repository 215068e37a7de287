//! sort-reorder: particles that are neighbours in space become neighbours in memory.

use super::{Fused, Phase, Stage};
use crate::buffers::Extent;
use crate::state::System;
use crate::state::scene::Scene;
use crate::{params, shared};

params! {
    /// Sorts the fluid particles by collision cell (counting sort) so that threads side by side touch the same cells. It
    /// changes speed only: no particle moves, and the sums over a cell do not depend on the order.
    pub struct SortReorder {
        /// Every how many steps: particles diffuse out of order slowly.
        pub every: u64 = 50u64; "steps", Integer { min: 1, max: 1_000_000_000 };
    }
}

shared! {
    /// No parameters on the GPU.
    pub struct SortReorderSettings {
        /// Not used.
        pad: u32,
    }
}

impl Stage for SortReorder {
    const KIND: &'static str = "sort-reorder";
    const WGSL: &'static str = include_str!("../../shaders/stages/sort-reorder.wgsl");
    const PHASES: &'static [Phase] = &[
        Phase { entry: "clear_places", over: Extent::Cells },
        Phase { entry: "count", over: Extent::Particles },
        Phase { entry: "scan_cells", over: Extent::Scans },
        Phase { entry: "scan_blocks", over: Extent::One },
        Phase { entry: "scatter", over: Extent::Particles },
        Phase { entry: "copy_back", over: Extent::Particles },
    ];
    /// Particles that lie brick by brick are sorted enough.
    const BRICKED: Option<Fused> = Some(Fused {
        wgsl: &[Self::WGSL],
        ahead: &[],
        instead: &[
            ("clear_places", &[]),
            ("count", &[]),
            ("scan_cells", &[]),
            ("scan_blocks", &[]),
            ("scatter", &[]),
            ("copy_back", &[]),
        ],
    });
    type Params = Self;
    type Uniform = SortReorderSettings;

    fn every(params: &Self) -> u64 {
        params.every
    }

    fn uniform(_: &Self, _: &System) -> SortReorderSettings {
        SortReorderSettings::default()
    }

    fn reference(_: &Self, system: &System, scene: &mut Scene) {
        let mut particles = std::mem::take(&mut scene.state.particles);
        particles.sort_by_key(|particle| scene.locate(system, particle.position).0);
        scene.state.particles = particles;
    }
}
