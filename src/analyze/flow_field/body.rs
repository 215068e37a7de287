//! The mean flow around squirmers, in bins that go along and turn with them.

use crate::analyze::grid::{Fluid, Grid};
use crate::analyze::picture::Map;
use crate::analyze::statistics::Estimate;
use crate::analyze::stretches::Stretches;
use crate::analyze::table::Table;
use crate::wire::{SpeciesRow, Squirmers};
use glam::DVec3;

/// Quantities of a bin: mass, momentum along rho, along the azimuth e x rho, and along e.
const WIDTH: usize = 4;

/// Sums over the blocks around each squirmer of a species, by their distance rho from the axis and their height z along
/// it.
#[derive(Debug)]
pub struct Body {
    /// Semi-axes and name.
    pub species: SpeciesRow,
    /// Edge of a bin in a.
    bin: f64,
    /// Bins along rho; twice as many along z.
    bins: usize,
    /// Of the bins, then the squirmers and the sum of V.e.
    sums: Stretches,
}

/// A squirmer at one moment.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    pub centre: DVec3,
    pub axis: DVec3,
    /// Taken off the fluid's velocity.
    pub drift: DVec3,
}

impl Body {
    /// `reach` is the largest distance along rho and z.
    pub fn new(species: SpeciesRow, bin: f64, reach: f64) -> Self {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bins = ((reach / bin * (1.0 + 1e-12)) as usize).max(1);
        let sums = Stretches::new(2 * bins * bins * WIDTH + 2);
        Self { species, bin, bins, sums }
    }

    /// Enters the fluid around the squirmers of species number `species`.
    pub fn enter(&mut self, fluid: &Fluid, squirmers: &Squirmers, species: usize, relative: bool) {
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let end = 2 * self.bins * self.bins * WIDTH;
        let sums = self.sums.begin();
        for i in (0..squirmers.id.len()).filter(|i| squirmers.species[*i] as usize == species) {
            let (axis, velocity) = (vector(squirmers.axis[i]).normalize_or_zero(), vector(squirmers.velocity[i]));
            let drift = if relative { velocity } else { DVec3::ZERO };
            let pose = Pose { centre: vector(squirmers.position[i]), axis, drift };
            around(sums, fluid, &pose, &self.species, self.bin, self.bins);
            sums[end] += 1.0;
            sums[end + 1] += velocity.dot(axis);
        }
    }

    /// Squirmers seen, all snapshots together.
    pub fn seen(&self) -> f64 {
        self.sums.total(2 * self.bins * self.bins * WIDTH)
    }

    /// Mean of V.e.
    pub fn speed(&self) -> Estimate {
        let end = 2 * self.bins * self.bins * WIDTH;
        self.sums.ratio(end + 1, end)
    }

    /// Middle of a bin: rho and z.
    fn place(&self, cell: usize) -> (f64, f64) {
        let (row, column) = (cell / self.bins, cell % self.bins);
        ((column as f64 + 0.5) * self.bin, (row as f64 + 0.5 - self.bins as f64) * self.bin)
    }

    fn velocity(&self, cell: usize) -> [Estimate; 3] {
        [1, 2, 3].map(|k| self.sums.ratio(cell * WIDTH + k, cell * WIDTH))
    }

    /// Adds the bins in which there was fluid.
    pub fn rows(&self, table: &mut Table) {
        for cell in 0..2 * self.bins * self.bins {
            let mass = self.sums.total(cell * WIDTH);
            if mass > 0.0 {
                let (rho, z) = self.place(cell);
                let [radial, azimuthal, axial] = self.velocity(cell).map(Into::into);
                let name = crate::analyze::table::Cell::Text(&self.species.name);
                table.row(&[name, rho.into(), z.into(), radial, azimuthal, axial, mass.into()]);
            }
        }
    }

    /// The axis to the right, and rho to both sides.
    pub fn map(&self, relative: bool) -> Map {
        let n = self.bins;
        let flow = |cell: usize| {
            let (row, column) = (cell / (2 * n), cell % (2 * n));
            let (side, rho) = if row >= n { (1.0, row - n) } else { (-1.0, n - 1 - row) };
            let [radial, _, axial] = self.velocity(column * n + rho);
            (radial.mean.is_finite()).then_some([axial.mean, side * radial.mean])
        };
        let reach = n as f64 * self.bin;
        let of = if relative { ", relative to it" } else { "" };
        Map {
            title: format!("Mean flow around {}{of}", self.species.name),
            x: "z, along the swimming axis [a]".into(),
            y: "rho [a]".into(),
            colour: "speed [sqrt(kT/m)]".into(),
            ends: [-reach, reach, -reach, reach],
            cells: [2 * n, 2 * n],
            flow: (0..4 * n * n).map(flow).collect(),
            outlines: vec![[0.0, 0.0, self.species.along, self.species.across]],
        }
    }
}

/// Blocks along an axis whose middles are within `reach` of a place, each with its distance to the nearest image.
fn near(grid: &Grid, axis: usize, place: f64, reach: f64) -> Vec<(usize, f64)> {
    let unit = DVec3::AXES[axis];
    let distance = |i: usize| grid.space.nearest(unit * place, unit * grid.centre(axis, i))[axis];
    (0..grid.blocks[axis]).map(|i| (i, distance(i))).filter(|(_, d)| d.abs() < reach).collect()
}

/// Adds every block outside the body to the bin in which its middle lies.
fn around(sums: &mut [f64], fluid: &Fluid, pose: &Pose, species: &SpeciesRow, bin: f64, bins: usize) {
    let reach = bins as f64 * bin;
    // The corner of the cylinder is farther than its radius and its height.
    let corner = reach * std::f64::consts::SQRT_2;
    let [xs, ys, zs] = [0, 1, 2].map(|k| near(&fluid.grid, k, pose.centre[k], corner));
    for (k, z) in &zs {
        for (j, y) in &ys {
            for (i, x) in &xs {
                let r = DVec3::new(*x, *y, *z);
                let height = r.dot(pose.axis);
                let radial = r - height * pose.axis;
                let rho = radial.length();
                let inside = (rho / species.across).powi(2) + (height / species.along).powi(2) < 1.0;
                if inside || rho >= reach || height.abs() >= reach {
                    continue;
                }
                let held = fluid.held([*i, *j, *k]);
                let momentum = held.mass * (held.velocity - pose.drift);
                // On the axis no direction is outwards.
                let outwards = if rho > 0.0 { radial / rho } else { DVec3::ZERO };
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let (row, column) = (((height + reach) / bin) as usize, (rho / bin) as usize);
                let cell = (row.min(2 * bins - 1) * bins + column.min(bins - 1)) * WIDTH;
                let azimuth = pose.axis.cross(outwards);
                sums[cell] += held.mass;
                sums[cell + 1] += momentum.dot(outwards);
                sums[cell + 2] += momentum.dot(azimuth);
                sums[cell + 3] += momentum.dot(pose.axis);
            }
        }
    }
}
