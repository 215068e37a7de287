//! cell-reduce: the sums over each collision cell's particles from which the whole collision follows.

use super::{Fused, Phase, Stage};
use crate::buffers::Extent;
use crate::state::System;
use crate::state::scene::{Moments, Scene};
use crate::{params, shared};

params! {
    /// Sums over the particles of each collision cell: their number, positions and velocities, and the products of these
    /// up to second order, positions taken from the cell's centre. Starts the sums anew; stages that add ghosts follow it.
    pub struct CellReduce {}
}

shared! {
    /// No parameters.
    pub struct CellReduceSettings {
        /// Not used.
        pad: u32,
    }
}

impl Stage for CellReduce {
    const KIND: &'static str = "cell-reduce";
    const WGSL: &'static str = include_str!("../../shaders/stages/cell-reduce.wgsl");
    const PHASES: &'static [Phase] =
        &[Phase { entry: "clear", over: Extent::Cells }, Phase { entry: "reduce", over: Extent::Particles }];
    const FUSED: Option<Fused> = Some(Fused {
        wgsl: &[
            include_str!("../../shaders/fused/cell-reduce-tally.wgsl"),
            include_str!("../../shaders/fused/cell-reduce-gather.wgsl"),
        ],
        ahead: &[],
        instead: &[
            ("clear", &[]),
            (
                "reduce",
                &[Phase { entry: "tally", over: Extent::Particles }, Phase { entry: "gather", over: Extent::Cells }],
            ),
        ],
    });
    const BRICKED: Option<Fused> = Some(Fused {
        wgsl: &[include_str!("../../shaders/fused/cell-reduce-bricked.wgsl")],
        ahead: &[],
        instead: &[
            ("clear", &[]),
            (
                "reduce",
                &[Phase { entry: "tally", over: Extent::Particles }, Phase { entry: "gather", over: Extent::Cells }],
            ),
        ],
    });
    const EACH: &'static [(&'static str, &'static str)] = &[("tally", "tallied"), ("gather", "gathered")];
    const AFTER: &'static [&'static str] = &["shift-grid"];
    type Params = Self;
    type Uniform = CellReduceSettings;

    fn uniform(_: &Self, _: &System) -> CellReduceSettings {
        CellReduceSettings::default()
    }

    fn reference(_: &Self, system: &System, scene: &mut Scene) {
        scene.moments = vec![Moments::default(); Scene::cell_count(system)];
        for particle in &scene.state.particles {
            let (cell, offset) = scene.locate(system, particle.position);
            scene.moments[cell].add(offset, particle.velocity);
        }
    }
}
