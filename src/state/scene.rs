//! One MPC step on the host in f64: what the stages' references read and write.

use super::{State, System};
pub use crate::math::linear::outer;
use glam::{DMat3, DQuat, DVec3};

/// Sums over one cell's particles; x is relative to the cell's centre. (23 numbers.)
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// Particles, ghosts included.
    pub count: f64,
    /// Ghosts.
    pub ghosts: f64,
    /// sum v.
    pub v: DVec3,
    /// sum |v|^2.
    pub energy: f64,
    /// sum x.
    pub x: DVec3,
    /// sum x x^T.
    pub xx: DMat3,
    /// sum x v^T: entry (row i, column j) is sum x_i v_j.
    pub xv: DMat3,
}

impl Default for Moments {
    fn default() -> Self {
        // A matrix of glam is the identity by default.
        let (xx, xv) = (DMat3::ZERO, DMat3::ZERO);
        Self { count: 0.0, ghosts: 0.0, v: DVec3::ZERO, energy: 0.0, x: DVec3::ZERO, xx, xv }
    }
}

impl Moments {
    /// Adds one particle at `x` from the cell's centre with velocity `v`.
    pub fn add(&mut self, x: DVec3, v: DVec3) {
        self.count += 1.0;
        self.v += v;
        self.energy += v.length_squared();
        self.x += x;
        self.xx += outer(x, x);
        self.xv += outer(x, v);
    }

    /// Adds one ghost of a wall or a squirmer.
    pub fn add_ghost(&mut self, x: DVec3, v: DVec3) {
        self.add(x, v);
        self.ghosts += 1.0;
    }
}

/// The collision of one cell as an affine map: v' = b + A v + W x x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Operator {
    /// A.
    pub a: DMat3,
    /// W.
    pub w: DVec3,
    /// b.
    pub b: DVec3,
}

impl Default for Operator {
    fn default() -> Self {
        Self { a: DMat3::IDENTITY, w: DVec3::ZERO, b: DVec3::ZERO }
    }
}

impl Operator {
    /// The velocity after the collision of a particle at `x` from the cell's centre.
    #[must_use]
    pub fn apply(&self, x: DVec3, v: DVec3) -> DVec3 {
        self.b + self.a * v + self.w.cross(x)
    }
}

/// How one squirmer moved in the current step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Centre at the beginning of the step.
    pub position: DVec3,
    /// Orientation at the beginning of the step.
    pub orientation: DQuat,
    /// Mean velocity over the step: V of the surface velocity.
    pub drift: DVec3,
    /// Mean angular velocity over the step: Omega of the surface velocity.
    pub spin: DVec3,
}

/// Force and torque about the centre.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Load {
    /// Force in kT/a, or momentum.
    pub force: DVec3,
    /// Torque in kT, or angular momentum.
    pub torque: DVec3,
}

/// The fluid beside one patch of a wall, y being the distance from the wall; averages over the past.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WallShear {
    /// sum y (v - u_w), tangential components.
    pub moment: DVec3,
    /// sum y^2 in a^2.
    pub weight: f64,
    /// Gradient of the fluid's tangential velocity along the inward normal, in 1/tau.
    pub shear: DVec3,
}

/// A virtual particle behind a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallGhost {
    /// 0 low, 1 high.
    pub wall: usize,
    /// Its cell.
    pub cell: usize,
    /// From the cell's centre.
    pub offset: DVec3,
    /// Before the collision.
    pub velocity: DVec3,
}

/// Everything a step has computed so far.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scene {
    /// Particles and squirmers.
    pub state: State,
    /// Grid shift in a; cell = floor(position + shift), wrapped on periodic axes.
    pub shift: DVec3,
    /// Per number of a cell, see [`super::Domain::cell_index`].
    pub moments: Vec<Moments>,
    /// Per cell.
    pub operators: Vec<Operator>,
    /// Per squirmer: the current step's motion.
    pub motions: Vec<Motion>,
    /// Per squirmer: steric force and torque.
    pub steric: Vec<Load>,
    /// Per squirmer: momentum and angular momentum that the fluid handed over in the current step.
    pub loads: Vec<Load>,
    /// Per squirmer: velocity V + ... that is added to its ghosts (linear, angular).
    pub ghost_motion: Vec<(DVec3, DVec3)>,
    /// Momentum handed to the walls at y = 0 and y = L since the start.
    pub wall_impulses: [DVec3; 2],
    /// Behind both walls in the current step.
    pub wall_ghosts: Vec<WallGhost>,
    /// Per patch of the walls: sum y (v - u_w) and sum y^2 of the fluid beside it in the last step that the stage has seen.
    pub wall_seen: Vec<(DVec3, f64)>,
    /// Per patch of the walls, x fastest, then z, then the wall: carried from step to step.
    pub wall_shear: Vec<WallShear>,
}

impl Scene {
    /// Index of the collision cell that holds `position`, and the offset from its centre.
    #[must_use]
    pub fn locate(&self, system: &System, position: DVec3) -> (usize, DVec3) {
        let cells = system.domain.cells();
        let shifted = position + self.shift;
        let mut cell = [0; 3];
        let mut offset = DVec3::ZERO;
        for axis in 0..3 {
            let floor = shifted[axis].floor();
            offset[axis] = shifted[axis] - floor - 0.5;
            #[allow(clippy::cast_possible_truncation)]
            let whole = (floor as i64).rem_euclid(i64::from(cells[axis]));
            cell[axis] = u32::try_from(whole).expect("a remainder is not negative");
        }
        (system.domain.cell_index(cell) as usize, offset)
    }

    /// Numbers that cells can have.
    #[must_use]
    pub fn cell_count(system: &System) -> usize {
        usize::try_from(system.domain.cell_count()).expect("cells fit in memory")
    }
}
