//! The mean flow in the lab frame: a layer of blocks, or the average along an axis.

use crate::analyze::AnalyzeError;
use crate::analyze::grid::{Fluid, Grid};
use crate::analyze::picture::Map;
use crate::analyze::statistics::Estimate;
use crate::analyze::stretches::Stretches;
use crate::analyze::table::Table;

/// Mass and momentum on a plane across an axis.
#[derive(Debug)]
pub struct Lab {
    /// The axis along which the fluid is looked at.
    across: usize,
    /// The layer that is looked at; all of them if there is none.
    at: Option<f64>,
    /// Of every block of the plane: mass, momentum along x, y and z.
    sums: Stretches,
}

/// Horizontal and vertical axis of the plane across an axis: x is to the right where it lies in the plane.
fn plane(across: usize) -> [usize; 2] {
    [[2, 1], [0, 2], [0, 1]][across]
}

const NAMES: [&str; 3] = ["x", "y", "z"];

impl Lab {
    pub fn new(across: usize, at: Option<f64>) -> Self {
        Self { across, at, sums: Stretches::default() }
    }

    /// Layers of blocks that count.
    fn layers(&self, grid: &Grid) -> Result<std::ops::Range<usize>, AnalyzeError> {
        let (axis, edge) = (self.across, grid.space.edge[self.across]);
        match self.at {
            None => Ok(0..grid.blocks[axis]),
            Some(at) if (0.0..edge).contains(&at) => {
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let layer = (at / grid.block) as usize;
                Ok(layer..layer + 1)
            }
            Some(at) => Err(AnalyzeError::TooLittle(format!(
                "at = {at} a lies outside the box, whose edge along {} is {edge} a",
                NAMES[axis]
            ))),
        }
    }

    pub fn enter(&mut self, fluid: &Fluid) -> Result<(), AnalyzeError> {
        let grid = &fluid.grid;
        let [h, v] = plane(self.across);
        if self.sums.snapshots() == 0 {
            self.sums = Stretches::new(4 * grid.blocks[h] * grid.blocks[v]);
        }
        let layers = self.layers(grid)?;
        let sums = self.sums.begin();
        for index in 0..grid.len() {
            let place = grid.at(index);
            if layers.contains(&place[self.across]) {
                let held = fluid.held(place);
                let momentum = held.mass * held.velocity;
                let cell = 4 * (place[v] * grid.blocks[h] + place[h]);
                for (k, value) in [held.mass, momentum.x, momentum.y, momentum.z].into_iter().enumerate() {
                    sums[cell + k] += value;
                }
            }
        }
        Ok(())
    }

    pub fn snapshots(&self) -> u64 {
        self.sums.snapshots()
    }

    fn velocity(&self, cell: usize) -> [Estimate; 3] {
        [1, 2, 3].map(|k| self.sums.ratio(4 * cell + k, 4 * cell))
    }

    pub fn csv(&self, grid: &Grid) -> Result<String, AnalyzeError> {
        let [h, v] = plane(self.across);
        let layers = self.layers(grid)?;
        let depth = grid.ends(self.across, layers.end - 1).1 - grid.ends(self.across, layers.start).0;
        let velocity = NAMES.map(|k| format!("v_{k} [sqrt(kT/m)],error")).join(",");
        let mut table = Table::new(&format!("{} [a],{} [a],density [m/a^3],error,{velocity}", NAMES[h], NAMES[v]));
        for (j, i) in (0..grid.blocks[v]).flat_map(|j| (0..grid.blocks[h]).map(move |i| (j, i))) {
            let cell = j * grid.blocks[h] + i;
            let (width, height) = (grid.ends(h, i), grid.ends(v, j));
            let volume = (width.1 - width.0) * (height.1 - height.0) * depth;
            let mass = self.sums.mean(4 * cell);
            let density = Estimate { mean: mass.mean / volume, error: mass.error / volume };
            let [x, y, z] = self.velocity(cell).map(Into::into);
            table.row(&[grid.centre(h, i).into(), grid.centre(v, j).into(), density.into(), x, y, z]);
        }
        Ok(table.finish())
    }

    pub fn map(&self, grid: &Grid) -> Map {
        let [h, v] = plane(self.across);
        let flow = |cell: usize| {
            let velocity = self.velocity(cell);
            let found = [velocity[h].mean, velocity[v].mean];
            found.iter().all(|c| c.is_finite()).then_some(found)
        };
        let title = match self.at {
            None => format!("Mean flow, averaged along {}", NAMES[self.across]),
            Some(at) => format!("Mean flow at {} = {at} a", NAMES[self.across]),
        };
        Map {
            title,
            x: format!("{} [a]", NAMES[h]),
            y: format!("{} [a]", NAMES[v]),
            colour: "speed in the plane [sqrt(kT/m)]".into(),
            // Blocks that the end of the box cuts are drawn whole.
            ends: [0.0, grid.blocks[h] as f64 * grid.block, 0.0, grid.blocks[v] as f64 * grid.block],
            cells: [grid.blocks[h], grid.blocks[v]],
            flow: (0..grid.blocks[h] * grid.blocks[v]).map(flow).collect(),
            outlines: Vec::new(),
        }
    }
}
