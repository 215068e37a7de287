//! apply: the particles receive the collision of their cells.

use super::{Phase, Stage};
use crate::buffers::Extent;
use crate::state::System;
use crate::state::scene::Scene;
use crate::{params, shared};

params! {
    /// Ends the collision: every fluid particle receives its new velocity from the map of its cell,
    /// v' = b + A v + W x x with x from the cell's centre; ghosts receive theirs right after.
    pub struct Apply {}
}

shared! {
    /// No parameters.
    pub struct ApplySettings {
        /// Not used.
        pad: u32,
    }
}

impl Stage for Apply {
    const KIND: &'static str = "apply";
    const WGSL: &'static str = include_str!("../../shaders/stages/apply.wgsl");
    const EACH: &'static [(&'static str, &'static str)] = &[("apply", "applied")];
    const PHASES: &'static [Phase] = &[Phase { entry: "apply", over: Extent::Particles }];
    const AFTER: &'static [&'static str] = &["rotate"];
    type Params = Self;
    type Uniform = ApplySettings;

    fn uniform(_: &Self, _: &System) -> ApplySettings {
        ApplySettings::default()
    }

    fn reference(_: &Self, system: &System, scene: &mut Scene) {
        for i in 0..scene.state.particles.len() {
            let particle = scene.state.particles[i];
            let (cell, offset) = scene.locate(system, particle.position);
            scene.state.particles[i].velocity = scene.operators[cell].apply(offset, particle.velocity);
        }
    }
}
