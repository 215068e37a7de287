//! What the fused plan dispatches: kernels of stages, alone or several in one.

use crate::buffers::{BRICK_LANES, Extent, FEWER_BRICK_LANES, OVERLAYS, Sizes};
use crate::graph::kernels::Use;
use crate::shader::{ENTRY, Lanes, Rare, Route, after_the_shift};
use crate::stages::Phase;
use std::borrow::Cow;

/// One kernel of a stage as the fused plan runs it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Member {
    /// Index of its stage in the list.
    pub stage: usize,
    /// Its entry point and extent.
    pub phase: Phase,
    /// The WGSL text that has the entry point.
    pub wgsl: &'static str,
    /// Several invocations may share each of its elements.
    pub shared: bool,
    /// See [`crate::stages::Stage::OWN`].
    pub own: bool,
    /// It does much for a few particles only, and there may be such.
    pub rare: Option<Rare>,
    /// It belongs to the step before: its random numbers and its repetition are that step's.
    pub late: bool,
    /// Which repetition of the stage it belongs to.
    pub repetition: u32,
    /// What it binds, under the names that it has here.
    pub uses: Vec<Use>,
    /// It uses `now`.
    pub now: bool,
}

impl Member {
    pub(super) fn writes(&self, buffer: &str) -> bool {
        self.uses.iter().any(|u| u.buffer == buffer && u.write)
    }

    pub(in crate::graph) fn asks_for(&self, buffer: &str) -> bool {
        self.uses.iter().any(|u| u.buffer == buffer)
    }

    pub(super) fn makes_sums(&self) -> bool {
        self.writes("moments")
    }

    /// Its text, with the names that it has here.
    #[must_use]
    pub fn text(&self) -> Cow<'static, str> {
        if self.asks_for("shift_before") { after_the_shift(self.wgsl).into() } else { self.wgsl.into() }
    }

    /// The same as a part of the step before, once the grid has been moved.
    pub(super) fn after_the_shift(mut self) -> Self {
        self.uses.iter_mut().filter(|u| u.buffer == "shift").for_each(|u| "shift_before".clone_into(&mut u.buffer));
        self.late = true;
        self
    }
}

/// What the fused plan dispatches.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Item {
    /// A kernel of a stage as it is.
    Alone(Member),
    /// Several kernels in one, over particles or over cells.
    Joint(Vec<Member>),
    /// The same over particles, but the few of members that are rare wait.
    Sifted(Vec<Member>),
    /// The same for particles that waited.
    Held(Vec<Member>),
    /// The same over particles that lie brick by brick, or come there or go.
    Bricks(Vec<Member>, Route),
    /// Those over cells, which make their sums, and then those over particles for each of a cell's, which it finds by its chain.
    Walked(Vec<Member>),
    /// Kernels over the same elements that an invocation does one after the other for its own.
    InTurn(Vec<Member>),
    /// Small kernels that one workgroup does one after the other.
    Small(Vec<Member>),
    /// Kernels that have nothing to do with each other: some workgroups do one, some the next.
    Beside(Vec<Member>),
}

impl Item {
    /// What it reads and writes. Members that share a kernel hand particles, sums and operators on in registers.
    #[must_use]
    pub fn uses(&self) -> Vec<Use> {
        let mut uses: Vec<Use> = Vec::new();
        let members = self.members();
        for used in members.iter().flat_map(|m| &m.uses) {
            match uses.iter_mut().find(|u| u.buffer == used.buffer) {
                // Read only if the first to use it reads it.
                Some(known) => {
                    known.write |= used.write;
                    known.members = None;
                }
                None => uses.push(used.clone()),
            }
        }
        match self {
            Item::Joint(_) | Item::Walked(_) => uses.retain(|u| !self.keeps(&u.buffer)),
            Item::Bricks(_, route) => {
                uses.retain(|u| !self.keeps(&u.buffer));
                moved_in_bricks(&mut uses, *route);
                if *route == Route::Sift {
                    uses.extend(waiting(true));
                }
            }
            Item::Sifted(_) => uses.extend(waiting(true)),
            // They are few, and count among all before.
            Item::Held(_) => uses.retain(|u| !ROW.contains(&u.buffer.as_str())),
            _ => {}
        }
        uses
    }

    /// Whether what its members hand on in this buffer stays in registers or in the workgroup.
    #[must_use]
    pub fn keeps(&self, buffer: &str) -> bool {
        match self {
            Item::Joint(members) => members.len() > 1 && members[0].makes_sums() && buffer == "moments",
            Item::Walked(_) => ["moments", "operators"].contains(&buffer),
            // It has no ghosts of squirmers, either.
            Item::Bricks(members, _) => {
                members[0].makes_sums() && ["moments", "operators", "brick_ghosts"].contains(&buffer)
            }
            _ => false,
        }
    }

    /// What it shows as in timings; `kind` names a stage.
    #[must_use]
    pub fn label(&self, kind: impl Fn(usize) -> &'static str) -> String {
        match self {
            Item::Joint(members)
            | Item::Sifted(members)
            | Item::Held(members)
            | Item::Bricks(members, _)
            | Item::Walked(members)
            | Item::InTurn(members)
            | Item::Small(members)
                if members.len() > 1 =>
            {
                let mut kinds: Vec<&str> = members.iter().map(|m| kind(m.stage)).collect();
                let mut seen = std::collections::HashSet::new();
                kinds.retain(|kind| seen.insert(*kind));
                kinds.join(" + ")
            }
            Item::Beside(members) => {
                let names: Vec<String> =
                    members.iter().map(|m| format!("{} {}", kind(m.stage), m.phase.entry)).collect();
                names.join(" | ")
            }
            _ => format!("{} {}", kind(self.members()[0].stage), self.point()),
        }
    }

    /// The entry point of its kernel.
    #[must_use]
    pub fn point(&self) -> &'static str {
        if matches!(self, Item::Alone(_)) { self.members()[0].phase.entry } else { ENTRY }
    }

    /// Invocations for each of its elements. What cells share is the work for the ghosts of squirmers: where most have none, four invocations
    /// that find that out cost more than sharing gains. Of cells at walls there may be enough to keep a GPU busy with one invocation for each, which then
    /// share the ghosts of more cells, and more evenly.
    #[must_use]
    pub fn lanes(&self, adapter: Lanes, sizes: &Sizes) -> Lanes {
        const ENOUGH: u64 = 10_000;
        let first = &self.members()[0];
        let idle = match first.phase.over {
            Extent::Cells => 2 * sizes.count(Extent::SquirmerGhosts) < sizes.cells,
            Extent::WallCells => sizes.count(Extent::WallCells) > ENOUGH,
            _ => false,
        };
        if first.shared && !idle { adapter } else { Lanes::One }
    }

    /// Invocations for a brick; see [`super::holds`]. On an H100 a kernel that makes operators and fetches the particles again that it moves is done soonest
    /// with fewer.
    #[must_use]
    pub fn brick_lanes(&self, holds: bool) -> u32 {
        let stays = matches!(self, Item::Bricks(members, Route::Stay | Route::Sift) if members[0].makes_sums());
        if stays && !holds { FEWER_BRICK_LANES } else { BRICK_LANES }
    }

    /// The kernels in it.
    #[must_use]
    pub fn members(&self) -> &[Member] {
        match self {
            Item::Alone(member) => std::slice::from_ref(member),
            Item::Joint(members)
            | Item::Sifted(members)
            | Item::Held(members)
            | Item::Bricks(members, _)
            | Item::Walked(members)
            | Item::InTurn(members)
            | Item::Small(members)
            | Item::Beside(members) => members,
        }
    }

    /// What it has an invocation for; bricks have a workgroup for 64 cells.
    #[must_use]
    pub fn over(&self) -> Extent {
        match self {
            Item::Bricks(_, route) if *route != Route::Enter => Extent::Cells,
            _ => self.members()[0].phase.over,
        }
    }

    /// After it the particles lie where they were to come next.
    #[must_use]
    pub fn turns(&self) -> bool {
        matches!(self, Item::Bricks(_, Route::Enter | Route::Stay | Route::Held))
    }
}

/// The row of all particles.
pub(super) const ROW: [&str; 2] = OVERLAYS[0].guests;

/// The list of those who wait for the next kernel.
fn waiting(write: bool) -> [Use; 2] {
    ["held", "held_groups"].map(|name| Use::whole(name, !write, write))
}

/// What of the particles kernels over bricks read and write, in place of the row of all.
fn moved_in_bricks(uses: &mut Vec<Use>, route: Route) {
    let back = OVERLAYS[1].guests;
    let bricks = ["bricks_xy", "bricks_zu", "bricks_vw", "brick_counts"];
    let next = ["bricks_xy_next", "bricks_zu_next", "bricks_vw_next", "brick_counts_next"];
    uses.retain(|u| ![&ROW[..], &bricks, &next].concat().contains(&u.buffer.as_str()));
    let mut add = |names: &[&str], read, write| {
        uses.extend(names.iter().map(|name| Use::whole(name, read, write)));
    };
    match route {
        Route::Enter => add(&ROW, true, false),
        // They are few, and count among all before.
        Route::Held => return,
        _ => add(&bricks, true, false),
    }
    match route {
        Route::Leave => add(&back, false, true),
        _ => add(&next, false, true),
    }
}
