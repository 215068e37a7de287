//! What a step asks of memory: the kernels that it launches, and the bytes that each must move if it reads and writes every buffer once.

use super::Plan;
use super::fused::{self, Item};
use super::kernels::{APPLY, Use, uses};
use crate::buffers::{Extent, Life, OVERLAYS, Sizes, find};
use crate::shader::ShaderError;
use crate::stages::Phase;

/// What the kernels with one label in timings do in a step, on average.
#[derive(Debug, Clone, PartialEq)]
pub struct Work {
    /// What they show as in timings.
    pub label: String,
    /// Kernels launched.
    pub launches: f64,
    /// Bytes per fluid particle that they must move.
    pub bytes: f64,
}

/// Bytes per particle that a kernel moves of one buffer: all of it, or as much as it has invocations for.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn moved(used: &Use, over: Extent, sizes: &Sizes) -> f64 {
    let Some(buffer) = find(&used.buffer).filter(|b| !matches!(b.life, Life::Setting)) else { return 0.0 };
    let cells = if over == Extent::SquirmerColumns { sizes.box_edge } else { 1 };
    let few = matches!(over, Extent::WallCells | Extent::SquirmerGhosts | Extent::SquirmerColumns);
    let whole = match buffer.extent {
        // Of particles or of ghosts.
        Extent::Links if over == Extent::SquirmerGhosts => sizes.count(over),
        Extent::Rooms if OVERLAYS[1].hosts.contains(&buffer.name) && !used.write => sizes.count(Extent::SquirmerGhosts),
        Extent::Links | Extent::Rooms => sizes.particles,
        // They are few, and count as nothing but the particles moved.
        Extent::Waiting => 0,
        extent => sizes.count(extent),
    };
    let elements = if few { whole.min(sizes.count(over) * cells) } else { whole };
    let ways = u64::from(used.read) + u64::from(used.write);
    (elements * ways * buffer.words as u64 * 4) as f64 / sizes.particles.max(1) as f64
}

/// Bytes per particle that a kernel of the fused plan moves.
#[must_use]
pub fn of_item(item: &Item, sizes: &Sizes) -> f64 {
    let of = |uses: &[Use], over| uses.iter().map(|u| moved(u, over, sizes)).sum::<f64>();
    match item {
        Item::InTurn(members) | Item::Small(members) | Item::Beside(members) => {
            members.iter().map(|m| of(&m.uses, m.phase.over)).sum()
        }
        _ => of(&item.uses(), item.over()),
    }
}

/// Every how many steps the stages of a plan run that do not run in each; the longest of these times. Where particles lie brick by brick some of
/// them have nothing to do.
#[must_use]
pub fn period(plan: &Plan, sizes: &Sizes) -> u64 {
    let works = |s: &&super::PlannedStage| {
        s.entry.phases.iter().any(|p| !s.entry.fused_phases(*p, sizes.gathering()).is_empty())
    };
    plan.stages.iter().filter(works).map(|s| (s.entry.every)(&s.values)).max().unwrap_or(1).max(1)
}

/// The work of an average step of the loose plan, stage by stage.
///
/// # Errors
/// If the WGSL of a stage is not valid.
#[allow(clippy::cast_precision_loss)]
pub fn loose(plan: &Plan, sizes: &Sizes) -> Result<Vec<Work>, ShaderError> {
    let mut work = Vec::new();
    let received = plan.stages.iter().any(|s| s.entry.kind == APPLY);
    for stage in &plan.stages {
        let entry = stage.entry;
        let times = f64::from((entry.repetitions)(&stage.values)) / (entry.every)(&stage.values).max(1) as f64;
        let late = if received { entry.receive } else { &[] };
        let place = entry.phases.iter().map(|p| (p, times));
        for (phase, times) in place.chain(late.iter().map(|p| (p, 1.0))) {
            let Phase { entry: point, over } = *phase;
            let bytes = uses(entry, point)?.iter().map(|u| moved(u, over, sizes)).sum::<f64>();
            add(&mut work, entry.kind, (sizes.count(over) > 0).then_some((times, times * bytes)));
        }
    }
    Ok(work)
}

/// The work of an average step of the fused plan that applies the collision of the step before, kernel by kernel.
///
/// # Errors
/// If the WGSL of a stage is not valid.
#[allow(clippy::cast_precision_loss)]
pub fn fused(plan: &Plan, sizes: &Sizes) -> Result<Vec<Work>, ShaderError> {
    let mut work = Vec::new();
    let rare = 1.0 / period(plan, sizes) as f64;
    for (all, weight) in [(false, 1.0 - rare), (true, rare)] {
        let stages = fused::stages(plan, all);
        for item in fused::items(&stages, fused::Occasion::Next, sizes)? {
            let there = sizes.count(item.over()) > 0 && weight > 0.0;
            let label = item.label(|stage| stages[stage].0.kind);
            add(&mut work, &label, there.then(|| (weight, weight * of_item(&item, sizes))));
        }
    }
    Ok(work)
}

fn add(work: &mut Vec<Work>, label: &str, more: Option<(f64, f64)>) {
    let Some((launches, bytes)) = more else { return };
    match work.iter_mut().find(|w| w.label == label) {
        Some(known) => (known.launches, known.bytes) = (known.launches + launches, known.bytes + bytes),
        None => work.push(Work { label: label.to_owned(), launches, bytes }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_the_elements_that_a_kernel_has() {
        let sizes = Sizes { particles: 1000, cells: 100, wall_cells: 20, ..Sizes::default() };
        let used = |name: &str, read, write| Use::whole(name, read, write);
        let bytes = |name, read, write, over| moved(&used(name, read, write), over, &sizes);
        assert_eq!(bytes("particles", true, true, Extent::Particles), 32.0);
        assert_eq!(bytes("operators", true, false, Extent::Particles), 6.4);
        // Only the cells at the walls.
        assert_eq!(bytes("moments", true, true, Extent::WallCells), 2.0 * 20.0 * 96.0 / 1000.0);
        assert_eq!(bytes("places", true, false, Extent::Scans), 0.4);
        assert_eq!(bytes("system", true, false, Extent::Cells), 0.0);
        // Of the bricks that come next the sums read the ghosts there, and those who move write everybody.
        let sizes = Sizes { squirmers: 2, ghost_stride: 64, room: 100, ..sizes };
        let bytes = |read, write| moved(&used("bricks_xy_next", read, write), Extent::Cells, &sizes);
        assert_eq!((bytes(true, false), bytes(false, true)), (1.024, 8.0));
    }
}
