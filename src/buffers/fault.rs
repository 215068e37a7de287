//! What kernels write into `faults`: what went wrong, and where in the step it was seen (shaders/lib/fault.wgsl).

/// What can go wrong inside a kernel: a bit of the first word of `faults`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Fault {
    /// A particle is faster than the moment sums allow.
    Speed = 1,
    /// A cell holds more contributions than the moment sums allow.
    Count = 2,
    /// A sum of squared speeds has wrapped.
    Energy = 4,
    /// A steric force, or its sum, left the range of its fixed point.
    Steric = 8,
    /// An impulse left the range of its fixed point.
    Impulse = 16,
    /// More than seven squirmers are near one cell.
    Crowded = 32,
    /// A particle was still inside a squirmer after all its hits and was pushed out.
    Stuck = 64,
    /// A velocity is not a number.
    Nan = 128,
    /// More particles are in a brick of 4 x 4 x 4 cells than it has room for.
    Room = 256,
}

impl Fault {
    /// Every fault.
    pub const ALL: &'static [Self] = &[
        Self::Speed,
        Self::Count,
        Self::Energy,
        Self::Steric,
        Self::Impulse,
        Self::Crowded,
        Self::Stuck,
        Self::Nan,
        Self::Room,
    ];
}

/// Where in a step a fault was seen: word 1 of `faults`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Site {
    /// The sums over the cells.
    CellReduce = 1,
    /// What those sums betray.
    Rotate = 2,
    /// Ghosts behind walls.
    WallGhosts = 3,
    /// Ghosts in squirmers.
    SquirmerFill = 4,
    /// Motion of squirmers.
    SquirmerMove = 5,
    /// Hits on squirmers.
    SquirmerCollide = 6,
    /// The sums of a snapshot.
    Snapshot = 7,
}

impl Site {
    /// Every place.
    pub const ALL: &'static [Self] = &[
        Self::CellReduce,
        Self::Rotate,
        Self::WallGhosts,
        Self::SquirmerFill,
        Self::SquirmerMove,
        Self::SquirmerCollide,
        Self::Snapshot,
    ];

    /// The stage, or "snapshot".
    #[must_use]
    pub fn stage(self) -> &'static str {
        match self {
            Self::CellReduce => "cell-reduce",
            Self::Rotate => "rotate",
            Self::WallGhosts => "wall-ghosts",
            Self::SquirmerFill => "squirmer-fill",
            Self::SquirmerMove => "squirmer-move",
            Self::SquirmerCollide => "squirmer-collide",
            Self::Snapshot => "snapshot",
        }
    }

    /// What the owner that it names is.
    #[must_use]
    pub fn owner(self) -> &'static str {
        match self {
            Self::CellReduce | Self::Rotate | Self::Snapshot => "particle",
            Self::WallGhosts | Self::SquirmerFill | Self::SquirmerMove | Self::SquirmerCollide => "squirmer",
        }
    }
}
