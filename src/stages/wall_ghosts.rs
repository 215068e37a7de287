//! wall-ghosts: virtual particles in the parts of the cells that the shifted grid puts into the walls
//! (Lamura, Gompper, Ihle, Kroll, Europhys. Lett. 56, 319, 2001).

use super::stream::wall_velocity;
use super::{Finding, Gravity, Phase, Stage};
use crate::buffers::Extent;
use crate::math::draws::{arrivals, normals};
use crate::math::rng::{Draw, Purpose};
use crate::state::System;
use crate::state::scene::Scene;
use crate::{params, shared};
use glam::DVec3;

params! {
    /// Fills the parts of collision cells that lie within a wall with virtual particles of the fluid's density, the
    /// wall's velocity and the fluid's temperature, new in each step (after Lamura, Gompper, Ihle, Kroll, Europhys. Lett. 56,
    /// 319, 2001). Without them cells at a wall are thinner than others and the fluid slips along it. Their number per
    /// cell obeys the Poisson law; the momentum that they gain in the collision goes to the wall.
    pub struct WallGhosts {}
}

shared! {
    /// No parameters.
    pub struct WallGhostsSettings {
        /// Not used.
        pad: u32,
    }
}

impl Stage for WallGhosts {
    const KIND: &'static str = "wall-ghosts";
    const WGSL: &'static str = include_str!("../../shaders/stages/wall-ghosts.wgsl");
    const PHASES: &'static [Phase] = &[Phase { entry: "fill", over: Extent::WallCells }];
    const RECEIVE: &'static [Phase] = &[Phase { entry: "receive", over: Extent::WallCells }];
    const AFTER: &'static [&'static str] = &["cell-reduce"];
    type Params = Self;
    type Uniform = WallGhostsSettings;

    fn check(_: &Self, system: &System) -> Vec<Finding> {
        let (message, help) = match &system.domain.walls {
            None => ("the box has no walls to fill", "remove this stage, or add `walls` to the domain"),
            Some(walls) if walls.condition == "slip" => (
                "ghosts make the fluid stick to walls that are meant to let it slip",
                "remove this stage, or set the walls' condition to \"no-slip\"",
            ),
            Some(_) => return Vec::new(),
        };
        vec![Finding { gravity: Gravity::Warning, field: "", message: message.into(), help: help.into() }]
    }

    fn uniform(_: &Self, _: &System) -> WallGhostsSettings {
        WallGhostsSettings::default()
    }

    fn reference(_: &Self, system: &System, scene: &mut Scene) {
        for ghost in ghosts(system, scene) {
            scene.moments[ghost.cell].add(ghost.offset, ghost.velocity);
        }
    }

    fn reference_receive(_: &Self, system: &System, scene: &mut Scene) {
        for ghost in ghosts(system, scene) {
            let after = scene.operators[ghost.cell].apply(ghost.offset, ghost.velocity);
            scene.wall_impulses[ghost.wall] += after - ghost.velocity;
        }
    }
}

/// One virtual particle.
struct Ghost {
    /// 0 low, 1 high.
    wall: usize,
    cell: usize,
    /// From the cell's centre.
    offset: DVec3,
    velocity: DVec3,
}

/// The ghosts of this step: the same whenever they are asked for within the step. On the grid moved by s the lowest layer
/// of cells lies in the wall up to the height s of the cell, the highest layer from there on.
fn ghosts(system: &System, scene: &Scene) -> Vec<Ghost> {
    let Some(walls) = &system.domain.walls else { return Vec::new() };
    let draw = Draw::new(system.run.seed, Purpose::WallGhost, scene.state.step);
    let [nx, ny, nz] = system.domain.cells();
    let mut ghosts = Vec::new();
    for (wall, layer, from, to) in [(0, 0, 0.0, scene.shift.y), (1, ny - 1, scene.shift.y, 1.0)] {
        for (x, z) in (0..nz).flat_map(|z| (0..nx).map(move |x| (x, z))) {
            let owner = (z * ny + layer) * nx + x;
            for (i, u) in arrivals(draw, owner, system.fluid.density * (to - from)) {
                let place = DVec3::new(u[1], from + u[3] * (to - from), u[2]);
                let thermal = system.fluid.temperature.sqrt() * normals(draw.uniforms(owner, i, 1));
                ghosts.push(Ghost {
                    wall,
                    cell: owner as usize,
                    offset: place - 0.5,
                    velocity: wall_velocity(walls, wall) + thermal,
                });
            }
        }
    }
    ghosts
}
