//! One kernel that makes the sums and operators of a brick or cell, applies them and moves its particles on, where nothing has to happen between the
//! collision of a step and the motion of the next: particles are read from memory once in a step, and written once.

use super::{Item, Member, Occasion, Staged, TALLY, conflict, parted};
use crate::buffers::{Extent, Sizes};
use crate::graph::kernels::APPLY;
use crate::shader::{Route, ShaderError};

/// Whether all of these steps of a plan can be taken so, with the same collision.
pub(super) fn possible(steps: &[Vec<Staged>], sizes: &Sizes) -> bool {
    let sums = |stages: &[Staged]| collision(stages, sizes).ok().flatten();
    let found = |stages: &[Staged]| {
        let on = |occasion| items(stages, occasion, sizes).is_ok_and(|items| items.is_some());
        [Occasion::First, Occasion::Next, Occasion::Last].into_iter().all(on)
    };
    steps.iter().all(|stages| found(stages) && sums(stages) == sums(&steps[0]))
}

/// The order on an occasion; `None` if something has to happen in between.
///
/// # Errors
/// If the WGSL of a stage is not valid.
pub(super) fn items(stages: &[Staged], occasion: Occasion, sizes: &Sizes) -> Result<Option<Vec<Item>>, ShaderError> {
    let mut order = parted(stages, occasion, sizes)?;
    let Some(cells) = collision(stages, sizes)? else { return Ok(None) };
    if occasion == Occasion::Last {
        // What walls receive comes after it.
        let applies = |m: &Member| stages[m.stage].0.kind == APPLY;
        let leaving = order.iter().position(|item| {
            matches!(item, Item::Bricks(_, Route::Leave)) || matches!(item, Item::Alone(m) if applies(m))
        });
        let Some(leaving) = leaving.map(|k| order.remove(k)) else { return Ok(None) };
        order.insert(0, led_by(cells, leaving));
        return Ok(Some(order));
    }
    if order.pop() != Some(Item::Joint(cells.clone())) || order.iter().flat_map(Item::members).any(enters_bricks) {
        return Ok(None);
    }
    Ok(if occasion == Occasion::First { Some(order) } else { joined(order, &cells) })
}

/// Whether it moves particles that lie in chains, none of which waits.
fn moves_all(item: &Item) -> bool {
    matches!(item, Item::Joint(members) if members[0].phase.over == Extent::Particles)
}

/// Ghosts that enter bricks lie in those that the kernel would fill.
fn enters_bricks(member: &Member) -> bool {
    member.writes("brick_ghosts")
}

/// A kernel that moves particles, behind those over their cells.
fn led_by(cells: Vec<Member>, moving: Item) -> Item {
    let members = [&cells[..], moving.members()].concat();
    match moving {
        Item::Bricks(_, route) => Item::Bricks(members, route),
        _ => Item::Walked(members),
    }
}

/// The kernel over cells with which a step ends, if it makes their sums.
fn collision(stages: &[Staged], sizes: &Sizes) -> Result<Option<Vec<Member>>, ShaderError> {
    let last = parted(stages, Occasion::First, sizes)?.pop();
    Ok(match last {
        Some(Item::Joint(cells)) if cells[0].makes_sums() => Some(cells),
        _ => None,
    })
}

/// The collision of the step before as the beginning of the kernel that moves particles.
fn joined(order: Vec<Item>, cells: &[Member]) -> Option<Vec<Item>> {
    let late: Vec<Member> = cells.iter().map(|m| m.clone().after_the_shift()).collect();
    let (mut before, mut after) = (Vec::new(), Vec::new());
    let mut items = order.into_iter();
    for item in items.by_ref() {
        let conflicts = |others: &[Member]| item.members().iter().any(|m| others.iter().any(|o| conflict(m, o)));
        match item {
            moving if moves_all(&moving) || matches!(moving, Item::Bricks(_, Route::Stay | Route::Sift)) => {
                let moved = moving.members();
                let free = |m: &Member| !moved.iter().any(|o| conflict(m, o));
                // A kernel is told one step. Who comes to which brick is told apart.
                let told = |m: &Member| m.now && !m.late && m.phase.entry != TALLY;
                if !after.iter().flat_map(Item::members).all(free) || moved.iter().any(told) {
                    return None;
                }
                before.push(led_by(late, moving));
                before.extend(after);
                before.extend(items);
                return Some(before);
            }
            _ if !conflicts(&late) && !after.iter().any(|other: &Item| conflicts(other.members())) => before.push(item),
            // What needs the operators, and what the next collision needs, comes after it.
            Item::Alone(_) => after.push(item),
            _ => return None,
        }
    }
    None
}
