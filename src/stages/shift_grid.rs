//! shift-grid: a new random position of the collision grid in every step (Ihle and Kroll, Phys. Rev. E 63, 020201, 2001).

use super::{Fused, Phase, Stage};
use crate::buffers::Extent;
use crate::math::rng::{Draw, Purpose, unit};
use crate::state::System;
use crate::state::scene::Scene;
use crate::{params, shared};
use glam::DVec3;

params! {
    /// Moves the collision grid by a random vector, uniform in one cell, the same for all cells and new in each step:
    /// without it particles that meet stay together for several collisions and the fluid is not Galilean invariant.
    pub struct ShiftGrid {}
}

shared! {
    /// No parameters.
    pub struct ShiftGridSettings {
        /// Not used.
        pad: u32,
    }
}

impl Stage for ShiftGrid {
    const KIND: &'static str = "shift-grid";
    const WGSL: &'static str = include_str!("../../shaders/stages/shift-grid.wgsl");
    const PHASES: &'static [Phase] = &[Phase { entry: "shift_grid", over: Extent::One }];
    const FUSED: Option<Fused> = Some(Fused {
        wgsl: &[include_str!("../../shaders/fused/shift-grid.wgsl")],
        ahead: &[Phase { entry: "shift_ahead", over: Extent::Steps }],
        instead: &[("shift_grid", &[])],
    });
    type Params = Self;
    type Uniform = ShiftGridSettings;

    fn uniform(_: &Self, _: &System) -> ShiftGridSettings {
        ShiftGridSettings::default()
    }

    fn reference(_: &Self, system: &System, scene: &mut Scene) {
        let words = Draw::new(system.run.seed, Purpose::Shift, scene.state.step).words(0, 0, 0);
        scene.shift = DVec3::from_array([0, 1, 2].map(|i| unit(words[i])));
    }
}
