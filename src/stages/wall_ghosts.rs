//! wall-ghosts: virtual particles in the parts of the cells that the shifted grid puts into the walls
//! (Lamura, Gompper, Ihle, Kroll, Europhys. Lett. 56, 319, 2001).

use super::stream::wall_velocity;
use super::{Finding, Fused, Gravity, Phase, Stage};
use crate::buffers::{Extent, SMALLEST_PATCH};
use crate::math::draws::{normals, poisson};
use crate::math::rng::{Draw, Purpose, seven};
use crate::state::System;
use crate::state::scene::{Scene, WallGhost, WallShear};
use crate::{params, shared};
use glam::DVec3;

const SMALLEST: i64 = SMALLEST_PATCH as i64;

/// sum y^2 per column of cells beside a wall and unit density, below which a patch counts as empty to that part: a quarter of
/// the mean in a full column. That one reaches to y = 1 + s with s uniform in [0, 1): <(1 + s)^3>/3 = 5/4.
const FULL_ENOUGH: f64 = 0.25 * 1.25;

params! {
    /// Fills the parts of collision cells that lie within a wall with virtual particles of the fluid's density, the
    /// wall's velocity and the fluid's temperature, new in each step (after Lamura, Gompper, Ihle, Kroll, Europhys. Lett. 56,
    /// 319, 2001). Without them cells at a wall are thinner than others and the fluid slips along it. Their number per
    /// cell obeys the Poisson law; the momentum that they gain in the collision goes to the wall.
    pub struct WallGhosts {
        /// Mean velocity of the virtual particles. wall: that of the wall; the fluid then stops about 0.1 a behind the wall.
        /// continued: the fluid's velocity profile continued through the wall's velocity at the wall into the wall, with the
        /// shear that the fluid beside the wall has had; the fluid then stops at the wall.
        pub velocity: String = "continued"; "", Choice(&["wall", "continued"]);
        /// With velocity = "continued": edge of the square patches of the wall over which the shear is averaged; those at the
        /// end may be smaller.
        pub patch: u32 = 8u32; "a", Integer { min: SMALLEST, max: 16384 };
        /// With velocity = "continued": time over which the shear of the steps before is averaged, weights falling off exponentially;
        /// 0 takes the last of them alone.
        pub memory: f64 = 2.0; "tau", Float { min: 0.0, max: 1e6 };
    }
}

shared! {
    /// The ghosts' mean velocity.
    pub struct WallGhostsSettings {
        /// 1 if the ghosts continue the fluid's velocity into the wall.
        continued: u32,
        /// Cells along the edge of a patch.
        edge: u32,
        /// Patches of a wall along x.
        patches_x: u32,
        /// Patches of a wall along z.
        patches_z: u32,
        /// Weight of the present step in the averages.
        fresh: f32,
        /// Least sum y^2 per column of cells by which the shear is divided.
        least: f32,
    }
}

impl Stage for WallGhosts {
    const KIND: &'static str = "wall-ghosts";
    const WGSL: &'static str = include_str!("../../shaders/stages/wall-ghosts.wgsl");
    const PHASES: &'static [Phase] =
        &[Phase { entry: "observe", over: Extent::WallCells }, Phase { entry: "fill", over: Extent::WallCells }];
    const RECEIVE: &'static [Phase] = &[Phase { entry: "receive", over: Extent::WallCells }];
    const BRICKED: Option<Fused> = Some(Fused {
        wgsl: &[include_str!("../../shaders/fused/wall-ghosts-bricked.wgsl")],
        ahead: &[],
        instead: &[
            ("observe", &[Phase { entry: "observe_bricks", over: Extent::Cells }]),
            (
                "fill",
                &[
                    Phase { entry: "draw_behind", over: Extent::WallCells },
                    Phase { entry: "fill_cells", over: Extent::Cells },
                ],
            ),
        ],
    });
    const EACH: &'static [(&'static str, &'static str)] =
        &[("observe_bricks", "observe_brick"), ("fill_cells", "filled")];
    const AFTER: &'static [&'static str] = &["cell-reduce"];
    const SHARED: &'static [&'static str] = &["fill", "draw_behind"];
    type Params = Self;
    type Uniform = WallGhostsSettings;

    fn places(params: &Self) -> bool {
        params.velocity == "continued"
    }

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

    #[allow(clippy::cast_possible_truncation)]
    fn uniform(params: &Self, system: &System) -> WallGhostsSettings {
        let Patches { edge, along: [patches_x, patches_z], .. } = Patches::of(params, system);
        WallGhostsSettings {
            continued: (params.velocity == "continued").into(),
            edge,
            patches_x,
            patches_z,
            fresh: fresh(params, system) as f32,
            least: (FULL_ENOUGH * system.fluid.density) as f32,
        }
    }

    fn reference(params: &Self, system: &System, scene: &mut Scene) {
        if params.velocity == "continued" {
            average(params, system, scene);
            scene.wall_seen = seen(params, system, scene);
        }
        scene.wall_ghosts = ghosts(params, system, scene);
        for ghost in &scene.wall_ghosts {
            scene.moments[ghost.cell].add_ghost(ghost.offset, ghost.velocity);
        }
    }

    fn reference_receive(_: &Self, _: &System, scene: &mut Scene) {
        for ghost in &scene.wall_ghosts {
            let after = scene.operators[ghost.cell].apply(ghost.offset, ghost.velocity);
            scene.wall_impulses[ghost.wall] += after - ghost.velocity;
        }
    }
}

/// How the walls are cut into patches.
struct Patches {
    /// Cells along the edge of a patch.
    edge: u32,
    /// Patches of one wall along x and z.
    along: [u32; 2],
    /// Cells along x and z.
    cells: [u32; 2],
}

impl Patches {
    fn of(params: &WallGhosts, system: &System) -> Self {
        let [x, _, z] = system.domain.cells();
        Self { edge: params.patch, along: [x, z].map(|n| n.div_ceil(params.patch)), cells: [x, z] }
    }

    /// Patches of both walls.
    fn count(&self) -> usize {
        2 * (self.along[0] * self.along[1]) as usize
    }

    /// The patch that holds the column of cells at (x, z).
    fn index(&self, wall: usize, x: u32, z: u32) -> usize {
        let [nx, nz] = self.along.map(|n| n as usize);
        (wall * nz + (z / self.edge) as usize) * nx + (x / self.edge) as usize
    }

    /// Columns of cells in each patch.
    fn columns(&self) -> Vec<f64> {
        let mut columns = vec![0.0; self.count()];
        for wall in [0, 1] {
            for (x, z) in (0..self.cells[1]).flat_map(|z| (0..self.cells[0]).map(move |x| (x, z))) {
                columns[self.index(wall, x, z)] += 1.0;
            }
        }
        columns
    }
}

/// The weight of the present step in the averages.
fn fresh(params: &WallGhosts, system: &System) -> f64 {
    -(-system.run.dt / params.memory).exp_m1()
}

/// sum y (v - u_w), tangential, and sum y^2 over the particles of the two layers of cells next to each patch.
fn seen(params: &WallGhosts, system: &System, scene: &Scene) -> Vec<(DVec3, f64)> {
    let Some(walls) = &system.domain.walls else { return Vec::new() };
    let patches = Patches::of(params, system);
    let ny = system.domain.cells()[1];
    let height = f64::from(system.domain.size[1]);
    let mut seen = vec![(DVec3::ZERO, 0.0); patches.count()];
    for particle in &scene.state.particles {
        let cell = u32::try_from(scene.locate(system, particle.position).0).expect("cells fit in 32 bits");
        let [x, layer, z] = system.domain.cell_at(cell);
        for (wall, distance) in [(0, particle.position.y), (1, height - particle.position.y)] {
            if [layer, ny - 1 - layer][wall] < 2 {
                let relative = particle.velocity - wall_velocity(walls, wall);
                let (moment, weight) = &mut seen[patches.index(wall, x, z)];
                *moment += distance * DVec3::new(relative.x, 0.0, relative.z);
                *weight += distance * distance;
            }
        }
    }
    seen
}

/// The shear that the fluid beside each patch has had: a straight line through the wall's velocity at the wall, fitted by least
/// squares to the particles of the two layers of cells next to it, sum y (v - u_w) / sum y^2. Both sums are averaged over the past from zero
/// on, so that their ratio is that of the steps seen so far.
fn average(params: &WallGhosts, system: &System, scene: &mut Scene) {
    let patches = Patches::of(params, system);
    scene.wall_shear.resize(patches.count(), WallShear::default());
    scene.wall_seen.resize(patches.count(), (DVec3::ZERO, 0.0));
    let fresh = fresh(params, system);
    let patches = scene.wall_shear.iter_mut().zip(&scene.wall_seen).zip(patches.columns());
    for ((patch, &(moment, weight)), columns) in patches {
        patch.moment += fresh * (moment - patch.moment);
        patch.weight += fresh * (weight - patch.weight);
        let weight = patch.weight.max(FULL_ENOUGH * system.fluid.density * columns);
        patch.shear = if weight > 0.0 { patch.moment / weight } else { DVec3::ZERO };
    }
}

/// The ghosts of this step. On the grid moved by s the lowest layer
/// of cells lies in the wall up to the height s of the cell, the highest layer from there on.
fn ghosts(params: &WallGhosts, system: &System, scene: &Scene) -> Vec<WallGhost> {
    let Some(walls) = &system.domain.walls else { return Vec::new() };
    let draw = Draw::new(system.run.seed, Purpose::WallGhost, scene.state.step);
    let patches = Patches::of(params, system);
    let [nx, ny, nz] = system.domain.cells();
    let plane = scene.shift.y;
    let mut ghosts = Vec::new();
    for (wall, layer, from, to) in [(0, 0, 0.0, plane), (1, ny - 1, plane, 1.0)] {
        for (x, z) in (0..nz).flat_map(|z| (0..nx).map(move |x| (x, z))) {
            let continued = params.velocity == "continued";
            let shear = if continued { scene.wall_shear[patches.index(wall, x, z)].shear } else { DVec3::ZERO };
            let owner = system.domain.cell_index([x, layer, z]);
            for i in 0..poisson(draw, owner, system.fluid.density * (to - from)) {
                let (u, motion) = seven(draw.words(owner, i, 0));
                let place = DVec3::new(u[0], from + u[2] * (to - from), u[1]);
                let thermal = system.fluid.temperature.sqrt() * normals(motion);
                let mean = wall_velocity(walls, wall) - shear * (place.y - plane).abs();
                ghosts.push(WallGhost { wall, cell: owner as usize, offset: place - 0.5, velocity: mean + thermal });
            }
        }
    }
    ghosts
}
