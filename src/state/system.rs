//! The physical system as the pipeline file declares it: sections written once, shared by every stage.

use crate::math::flow::SquirmerFlow;
use crate::math::spheroid::Spheroid;
use crate::math::surface::Slip;
use crate::params;

params! {
    /// The run: how long, with which time step and which random numbers.
    pub struct Run {
        /// Seed of every random number; two runs with one seed agree bit by bit on one adapter.
        pub seed: u64 = 1u64; "", Integer { min: 0, max: i64::MAX };
        /// Collision steps to do.
        pub steps: u64; "steps", Integer { min: 0, max: i64::MAX };
        /// Collision time step h: the time between two collisions.
        pub dt: f64; "tau", Float { min: 1e-6, max: 10.0 };
        /// Whether the run can be watched while it goes. With false nothing goes to shared memory, whatever outputs say.
        pub live: bool = true; "", Boolean;
    }
}

params! {
    /// The box: whole cells along x, y and z, periodic, or a slit between two walls across y.
    pub struct Domain {
        /// Number of cells along x, y and z; a cell has the edge a = 1.
        pub size: [u32; 3]; "a", Counts { len: 3, min: 2, max: 16384 };
        /// Two plane walls; without them the box is periodic in all directions.
        pub walls: Option<Walls>; "", Table { fields: <Walls as params::Params>::fields };
    }
}

params! {
    /// Two plane walls at y = 0 and y = L.
    pub struct Walls {
        /// The axis across the slit: walls exist only across y.
        pub axis: String = "y"; "", Choice(&["y"]);
        /// no-slip: the fluid sticks to the wall (bounce-back); slip: specular reflection.
        pub condition: String = "no-slip"; "", Choice(&["no-slip", "slip"]);
        /// Velocity of the wall at y = 0; its y component must be zero.
        pub velocity_low: [f64; 3] = [0.0; 3]; "sqrt(kT/m)", Vector { len: 3, min: -5.0, max: 5.0 };
        /// Velocity of the wall at y = L; its y component must be zero.
        pub velocity_high: [f64; 3] = [0.0; 3]; "sqrt(kT/m)", Vector { len: 3, min: -5.0, max: 5.0 };
    }
}

params! {
    /// The fluid: point particles of mass m = 1.
    pub struct Fluid {
        /// Mean number of particles per cell.
        pub density: f64 = 10.0; "m/a^3", Float { min: 0.0, max: 200.0 };
        /// Temperature of the start, of ghosts and of the thermostat.
        pub temperature: f64 = 1.0; "kT", Float { min: 1e-6, max: 1e6 };
        /// Body acceleration of the fluid; squirmers and ghosts do not feel it.
        pub acceleration: [f64; 3] = [0.0; 3]; "a/tau^2", Vector { len: 3, min: -1.0, max: 1.0 };
    }
}

params! {
    /// Semi-axes of a spheroid: prolate if along > across, oblate if along < across, else a sphere.
    pub struct SemiAxes {
        /// Semi-axis along the swimming axis e.
        pub along: f64; "a", Float { min: 0.5, max: 64.0 };
        /// The two semi-axes perpendicular to e.
        pub across: f64; "a", Float { min: 0.5, max: 64.0 };
    }
}

params! {
    /// A species of squirmers: neutrally buoyant spheroids with a slip velocity on their surface.
    pub struct Species {
        /// Name in outputs and messages.
        pub name: String = "squirmer"; "", Text;
        /// How many.
        pub count: u32; "", Integer { min: 1, max: 1_000_000 };
        /// Shape.
        pub semi_axes: SemiAxes; "a", Table { fields: <SemiAxes as params::Params>::fields };
        /// How far outside the semi-axes the surface lies off which the fluid bounces and that ghosts fill. The fluid sticks to
        /// a surface about 0.12 a inside that one, so that the default puts it where it is meant; 0 is the published model.
        pub offset: f64 = 0.12; "a", Float { min: 0.0, max: 0.5 };
        /// Strength of the swimming mode: u = -B1 (1 + beta zeta) (e_zeta . e) e_zeta; positive swims along e.
        pub b1: f64 = 0.0; "sqrt(kT/m)", Float { min: -1.0, max: 1.0 };
        /// Active stress: negative pusher, zero neutral, positive puller.
        pub beta: f64 = 0.0; "", Float { min: -100.0, max: 100.0 };
        /// Rotlet dipole C2: slip u = C2 zeta (rho/across) about e, odd along the axis.
        pub rotlet: f64 = 0.0; "sqrt(kT/m)", Float { min: -1.0, max: 1.0 };
        /// A passive body: no slip velocity; b1, beta and rotlet must be left out.
        pub passive: bool = false; "", Boolean;
        /// Constant force on each squirmer, in the lab frame. Nothing balances it: in a periodic box give the fluid the
        /// opposite one by `acceleration`.
        pub force: [f64; 3] = [0.0; 3]; "kT/a", Vector { len: 3, min: -1e4, max: 1e4 };
        /// Held in place: neither moves nor turns, and the force on it is recorded.
        pub held: bool = false; "", Boolean;
        /// random: without overlap; lattice: evenly spaced, along x; listed: as given in `poses`.
        pub start: String = "random"; "", Choice(&["random", "lattice", "listed"]);
        /// With start = "listed": one row x, y, z, ex, ey, ez per squirmer.
        pub poses: Option<Vec<[f64; 6]>>; "a", Rows { len: 6 };
    }
}

params! {
    /// Where the start comes from.
    pub struct Init {
        /// A table x,y,z,vx,vy,vz of fluid particles (CSV with a header), instead of a random fluid.
        pub from: Option<String>; "", Text;
    }
}

/// Cells along each edge of a brick, within which cells are numbered one after the other.
pub const BRICK: u32 = 4;

/// The validated physical system: what every stage is told.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// Seed, steps, time step.
    pub run: Run,
    /// Box and walls.
    pub domain: Domain,
    /// Fluid.
    pub fluid: Fluid,
    /// Squirmers, species by species.
    pub species: Vec<Species>,
    /// Start.
    pub init: Init,
}

impl Domain {
    /// Collision cells along each axis: one more across a slit, since the shifted grid must cover both walls.
    #[must_use]
    pub fn cells(&self) -> [u32; 3] {
        let [x, y, z] = self.size;
        [x, if self.walls.is_some() { y + 1 } else { y }, z]
    }

    /// Number of a cell: cells are counted brick by brick, so that neighbours in space are mostly neighbours in memory, x fastest
    /// among the bricks and inside them. Bricks at the end of the grid may reach beyond it.
    #[must_use]
    pub fn cell_index(&self, cell: [u32; 3]) -> u32 {
        let [nx, ny, _] = self.bricks();
        let [x, y, z] = cell.map(|c| c / BRICK);
        let [u, v, w] = cell.map(|c| c % BRICK);
        ((z * ny + y) * nx + x) * BRICK.pow(3) + (w * BRICK + v) * BRICK + u
    }

    /// The cell of this number; it may lie beyond the grid.
    #[must_use]
    pub fn cell_at(&self, index: u32) -> [u32; 3] {
        let [nx, ny, _] = self.bricks();
        let (brick, within) = (index / BRICK.pow(3), index % BRICK.pow(3));
        let corner = [brick % nx, brick / nx % ny, brick / nx / ny];
        let place = [within % BRICK, within / BRICK % BRICK, within / BRICK / BRICK];
        std::array::from_fn(|k| corner[k] * BRICK + place[k])
    }

    /// Numbers that cells can have: those of all bricks.
    #[must_use]
    pub fn cell_count(&self) -> u64 {
        self.bricks().iter().map(|n| u64::from(n * BRICK)).product()
    }

    fn bricks(&self) -> [u32; 3] {
        self.cells().map(|n| n.div_ceil(BRICK))
    }

    /// Length of one turn of the u32 coordinate along each axis. Across a slit it is 2 L, so that differences of
    /// two coordinates never wrap and the walls' inside is the half-turn with the top bit clear.
    #[must_use]
    pub fn period(&self) -> [u32; 3] {
        let [x, y, z] = self.size;
        [x, if self.walls.is_some() { 2 * y } else { y }, z]
    }

    /// Volume between the walls, in a^3.
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.size.iter().map(|n| f64::from(*n)).product()
    }
}

impl Species {
    /// The nominal shape: that of steric forces and of theory.
    #[must_use]
    pub fn spheroid(&self) -> Spheroid {
        Spheroid { along: self.semi_axes.along, across: self.semi_axes.across }
    }

    /// The shape that keeps the fluid out, slips along it and is filled with ghosts: both semi-axes longer by `offset`.
    #[must_use]
    pub fn hull(&self) -> Spheroid {
        self.spheroid().grown(self.offset)
    }

    /// Strengths of the slip along the hull: such that the hull swims as fast as the nominal body would in Stokes flow, with the
    /// same stresslet, and with the same rotlet dipole (as for spheres, whose r^-3 field it scales with the volume).
    #[must_use]
    pub fn hull_slip(&self) -> Slip {
        let (shape, hull) = (self.spheroid(), self.hull());
        let stresslet = |shape: Spheroid| SquirmerFlow::new(shape, 0.0, 1.0).far_field();
        let b1 = self.b1 * shape.swim_speed(1.0) / hull.swim_speed(1.0);
        Slip {
            b1,
            b2: self.b1 * self.beta * stresslet(shape) / stresslet(hull),
            rotlet: self.rotlet * shape.volume() / hull.volume(),
        }
    }

    /// Ghost particles inside one squirmer, N_g = round(gamma V) of its hull; its mass is M = m N_g.
    #[must_use]
    pub fn ghosts(&self, fluid: &Fluid) -> u32 {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let n = (fluid.density * self.hull().volume()).round() as u32;
        n.max(1)
    }
}

impl System {
    /// Squirmers of all species together.
    #[must_use]
    pub fn squirmer_count(&self) -> u32 {
        self.species.iter().map(|s| s.count).sum()
    }

    /// Species index of every squirmer in order.
    pub fn squirmer_species(&self) -> impl Iterator<Item = usize> + '_ {
        self.species.iter().enumerate().flat_map(|(i, s)| std::iter::repeat_n(i, s.count as usize))
    }

    /// Volume open to the fluid, in a^3.
    #[must_use]
    pub fn fluid_volume(&self) -> f64 {
        let bodies: f64 = self.species.iter().map(|s| f64::from(s.count) * s.hull().volume()).sum();
        self.domain.volume() - bodies
    }

    /// Fluid particles of a random start.
    #[must_use]
    pub fn particle_count(&self) -> u64 {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let n = (self.fluid.density * self.fluid_volume()).round().max(0.0) as u64;
        n
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{Params, Values};

    #[test]
    fn every_cell_has_a_number_of_its_own() {
        let walls = Some(Walls::from_values(&Values::defaults(&Walls::fields())));
        let domain = Domain { size: [9, 10, 5], walls };
        // 3 x 3 x 2 bricks; across the slit there are 11 cells.
        assert_eq!(domain.cell_count(), 18 * 64);
        let mut seen = vec![false; 18 * 64];
        for x in 0..9 {
            for (y, z) in (0..11).flat_map(|y| (0..5).map(move |z| (y, z))) {
                let index = domain.cell_index([x, y, z]);
                assert_eq!(domain.cell_at(index), [x, y, z]);
                assert!(!std::mem::replace(&mut seen[index as usize], true));
            }
        }
        assert_eq!(domain.cell_index([3, 0, 0]), 3);
        assert_eq!(domain.cell_index([4, 0, 0]), 64);
        assert_eq!(domain.cell_index([0, 1, 1]), 20);
        assert_eq!(domain.cell_index([0, 4, 4]), 64 * (3 * 3 + 3));
    }
}
