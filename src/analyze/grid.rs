//! The blocks of a `fields` snapshot: where they are and how much of the box each covers.

use super::AnalyzeError;
use super::space::Space;
use crate::wire::{Fields, Header, Kind, Snapshot};
use glam::DVec3;

/// The grid of blocks, the same during a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    pub space: Space,
    /// Edge of a block in a.
    pub block: f64,
    /// Blocks along x, y and z.
    pub blocks: [usize; 3],
}

impl Grid {
    /// The grid of a snapshot of the fields.
    pub fn of(header: &Header) -> Self {
        Self { space: Space::of(header), block: header.block.into(), blocks: header.blocks.map(|n| n as usize) }
    }

    pub fn len(&self) -> usize {
        self.blocks.iter().product()
    }

    /// Place of a block in the list.
    pub fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.blocks[1] + y) * self.blocks[0] + x
    }

    /// Where a block of the list stands along each axis.
    pub fn at(&self, index: usize) -> [usize; 3] {
        [index % self.blocks[0], index / self.blocks[0] % self.blocks[1], index / (self.blocks[0] * self.blocks[1])]
    }

    /// Both ends of a block along an axis; the last one may be cut by the end of the box.
    pub fn ends(&self, axis: usize, i: usize) -> (f64, f64) {
        (i as f64 * self.block, ((i + 1) as f64 * self.block).min(self.space.edge[axis]))
    }

    /// Middle of a block along an axis.
    pub fn centre(&self, axis: usize, i: usize) -> f64 {
        let (low, high) = self.ends(axis, i);
        f64::midpoint(low, high)
    }

    /// Volume of a block that lies in the box, in a^3.
    pub fn volume(&self, place: [usize; 3]) -> f64 {
        (0..3).map(|k| self.ends(k, place[k])).map(|(low, high)| high - low).product()
    }
}

/// What a block holds.
#[derive(Debug, Clone, Copy)]
pub struct Held {
    /// Mass of the fluid in m.
    pub mass: f64,
    /// Its mean velocity.
    pub velocity: DVec3,
}

/// The fields of a snapshot, block by block.
#[derive(Debug, Clone)]
pub struct Fluid {
    pub grid: Grid,
    fields: Fields,
}

impl Fluid {
    /// Reads a snapshot of the fields; `before` is the grid of the earlier ones.
    pub fn read(snapshot: &Snapshot<'_>, before: &mut Option<Grid>) -> Result<Self, AnalyzeError> {
        let fields = Fields::decode(snapshot)?;
        let grid = Grid::of(&snapshot.header);
        if *before.get_or_insert(grid) != grid {
            return Err(AnalyzeError::changed());
        }
        if grid.len() == 0 || (0..3).any(|k| grid.ends(k, grid.blocks[k] - 1).0 >= grid.space.edge[k]) {
            return Err(AnalyzeError::nothing(Kind::Fields));
        }
        Ok(Self { grid, fields })
    }

    pub fn held(&self, place: [usize; 3]) -> Held {
        let index = self.grid.index(place);
        Held {
            mass: f64::from(self.fields.density[index]) * self.grid.volume(place),
            velocity: DVec3::from_array(self.fields.velocity[index].map(f64::from)),
        }
    }
}
