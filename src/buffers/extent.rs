//! What there may be many of in a run.

/// What a buffer has one element for, and what a kernel has one invocation for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Extent {
    /// A single element.
    One,
    /// Fluid particles.
    Particles,
    /// Collision cells.
    Cells,
    /// Steps for which something is made beforehand: [`super::STEPS_AHEAD`], and the one before them.
    Steps,
    /// Cells cut by a wall: two layers, each filled up to whole tiles of [`super::WALL_TILE`] cells along either edge.
    WallCells,
    /// Patches of the walls over which the shear is averaged, at their smallest: [`super::SMALLEST_PATCH`] cells along either edge.
    WallPatches,
    /// Squirmers.
    Squirmers,
    /// Squirmer species.
    Species,
    /// Ghosts inside squirmers: squirmers times the largest ghost number, rounded up to whole workgroups of 64.
    SquirmerGhosts,
    /// Columns of cells in the boxes around squirmers: squirmers times one face of the largest box.
    SquirmerColumns,
    /// Invocations that look for the partners of squirmers: [`super::Sizes::parts`] for each.
    SquirmerParts,
    /// Bins of the squirmers' pair search; none where the squirmers are few.
    Bins,
    /// Squirmers that are sorted into bins: all, or none where they are few.
    Binned,
    /// Blocks of 1024 cells in a prefix sum.
    Blocks,
    /// 64 for each block, as many as make one workgroup each: a prefix sum over the cells of the block.
    Scans,
    /// Links of chains: one for each particle or ghost, whichever are more.
    Links,
    /// Fluid particles, or bricks with some, that wait for a kernel of their own: room for all, though they are few.
    Waiting,
    /// Bricks of 4 x 4 x 4 cells, where particles lie brick by brick.
    Bricks,
    /// Room for particles in all bricks.
    Rooms,
    /// Blocks over which a snapshot averages its fields.
    Coarse,
    /// Fluid particles that a snapshot takes.
    Samples,
}
