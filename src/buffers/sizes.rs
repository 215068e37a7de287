//! How many elements each extent has in one run.

use super::{Buffer, Extent};

/// How the sums over the particles of a cell are made in the fused plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Gathering {
    /// Each cell chains its particles and walks the chain: what suits a CPU.
    #[default]
    Chains,
    /// Particles lie brick by brick; a workgroup adds up the sums of its brick's cells, and moves its particles on.
    Bricks,
}

/// Invocations of a workgroup that works on a brick.
pub const BRICK_LANES: u32 = 192;

/// The same of one that makes operators and fetches the particles again that it moves.
pub const FEWER_BRICK_LANES: u32 = 128;

/// How many elements each extent has in one run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sizes {
    /// Fluid particles.
    pub particles: u64,
    /// Collision cells.
    pub cells: u64,
    /// Cells in the two layers at the walls, filled up to whole tiles; 0 without walls.
    pub wall_cells: u64,
    /// Smallest patches of the two walls; 0 without walls.
    pub wall_patches: u64,
    /// Squirmers.
    pub squirmers: u64,
    /// Species.
    pub species: u64,
    /// Largest number of ghosts in one squirmer, rounded up to a multiple of 64.
    pub ghost_stride: u64,
    /// Cells along the edge of the largest box around a squirmer.
    pub box_edge: u64,
    /// Bins of the pair search; 0 where squirmers are few.
    pub bins: u64,
    /// Particles, or handfuls of a brick, that may wait for a kernel of their own: all, or 0 where none does.
    pub waiting: u64,
    /// Particles that two bricks have room for together, where particles lie brick by brick; else 0.
    pub room: u64,
    /// One kernel makes the sums and operators of a brick or cell and moves its particles on.
    pub at_once: bool,
    /// Blocks of a snapshot's fields.
    pub coarse: u64,
    /// Fluid particles that a snapshot takes.
    pub samples: u64,
}

impl Sizes {
    /// Elements of an extent.
    #[must_use]
    pub fn count(&self, extent: Extent) -> u64 {
        match extent {
            Extent::One => 1,
            Extent::Particles => self.particles,
            Extent::Cells => self.cells,
            Extent::Steps => super::STEPS_AHEAD + 1,
            Extent::WallCells => self.wall_cells,
            Extent::WallPatches => self.wall_patches,
            Extent::Squirmers => self.squirmers,
            Extent::Species => self.species,
            Extent::SquirmerGhosts => self.squirmers * self.ghost_stride,
            Extent::SquirmerColumns => self.squirmers * self.box_edge.pow(2),
            Extent::SquirmerParts => self.squirmers * Self::parts(self.squirmers),
            Extent::Bins => self.bins,
            Extent::Binned => self.squirmers * self.bins.min(1),
            Extent::Blocks => self.cells.div_ceil(1024),
            Extent::Scans => self.cells.div_ceil(1024) * 64,
            // Particles lie in chains only where there are no bricks.
            Extent::Links => {
                let particles = if self.room > 0 { 0 } else { self.particles };
                particles.max(self.squirmers * self.ghost_stride)
            }
            Extent::Waiting => self.waiting,
            Extent::Bricks => self.bricks(),
            Extent::Rooms => self.bricks() / 2 * self.room,
            Extent::Coarse => self.coarse,
            Extent::Samples => self.samples,
        }
    }

    /// Bricks of 64 cells, where particles lie brick by brick; else 0. The last may have nothing but a partner with which it shares a room.
    #[must_use]
    pub fn bricks(&self) -> u64 {
        if self.room > 0 { self.cells.div_ceil(64).next_multiple_of(2) } else { 0 }
    }

    /// Places of a brick to which an entry of the list of those who wait may refer: a power of two, so large that three entries for each of a
    /// brick's invocations are enough for all that its room may hold.
    #[must_use]
    pub fn handful(&self) -> u64 {
        self.room.div_ceil(3 * u64::from(FEWER_BRICK_LANES)).next_power_of_two().clamp(8, 64)
    }

    /// How the sums over cells are made with these elements.
    #[must_use]
    pub fn gathering(&self) -> Gathering {
        if self.room > 0 { Gathering::Bricks } else { Gathering::Chains }
    }

    /// Invocations that share the search for a squirmer's partners: one for each of few squirmers, and two at least, one per wall.
    #[must_use]
    pub fn parts(squirmers: u64) -> u64 {
        squirmers.next_power_of_two().clamp(2, 64)
    }

    /// Bytes of a buffer; at least 16, since an empty binding is not allowed.
    #[must_use]
    pub fn bytes(&self, buffer: &Buffer) -> u64 {
        (self.count(buffer.extent) * buffer.words as u64 * 4).max(16)
    }
}
