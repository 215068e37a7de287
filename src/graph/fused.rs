//! The fused plan: the kernels of a step in an order of their own, neighbours over the same particles or cells joined into one.
//!
//! The collision of a step is applied together with the streaming of the next, so that a particle is read and written once per step.
//! Kernels in between run before or after the joint one as far as the buffers allow that they truly bind. Small ones are joined in the end
//! ([`small`]).

mod at_once;
mod item;

pub use item::{Item, Member};

use self::item::ROW;
use super::kernels::{APPLY, Use, places, reflected};
use super::{Plan, beside, in_turn, small};
use crate::buffers::{Extent, Gathering, Sizes, find};
use crate::shader::{Lanes, Module, Over, Part, Route, ShaderError, fuse};
use crate::stages::{Entry, Phase};
use crate::state::packed;

/// Stages of a plan as [`items`] wants them; all of them run, or only those that run in every step.
#[must_use]
pub fn stages(plan: &Plan, all: bool) -> Vec<(&'static Entry, u32, bool)> {
    let stage =
        |s: &super::PlannedStage| (s.entry, (s.entry.repetitions)(&s.values), all || (s.entry.every)(&s.values) == 1);
    plan.stages.iter().map(stage).collect()
}

/// Elements of every extent in a fused run of the plan whose sums over cells are made like this, or as suits a GPU.
#[must_use]
pub fn sizes(plan: &Plan, particles: u64, gathering: Option<Gathering>) -> Sizes {
    let sizes = packed::sizes(&plan.system, particles);
    let at_once = |sizes: Sizes| {
        let at_once = at_once::possible(&[stages(plan, true), stages(plan, false)], &sizes);
        Sizes { at_once, ..sizes }
    };
    if gathering == Some(Gathering::Chains) {
        let chains = waiting_in(plan, sizes);
        // Steps take turns with two chains by what is made ahead.
        let may = ahead(plan, &chains).is_ok_and(|ahead| !ahead.is_empty());
        return if may { at_once(chains) } else { chains };
    }
    let bricks = Sizes { room: packed::brick_room(&plan.system), ..sizes };
    // In handfuls, of which each brick's last may not be full.
    let bricks = Sizes { waiting: bricks.count(Extent::Bricks) + particles.div_ceil(bricks.handful()), ..bricks };
    if fit_for_bricks(plan, &bricks) { at_once(bricks) } else { waiting_in(plan, sizes) }
}

/// With particles that wait, if every step has one kernel that makes them wait: it empties the list of the next step.
fn waiting_in(plan: &Plan, sizes: Sizes) -> Sizes {
    let waiting = Sizes { waiting: sizes.particles, ..sizes };
    let lists = |items: Vec<Item>| items.iter().filter(|i| matches!(i, Item::Sifted(_))).count();
    let each_has_one = [true, false].into_iter().all(|all| {
        [(Occasion::First, 1), (Occasion::Next, 1), (Occasion::Last, 0)]
            .into_iter()
            .all(|(occasion, one)| items(&stages(plan, all), occasion, &waiting).is_ok_and(|items| lists(items) == one))
    });
    if each_has_one { waiting } else { sizes }
}

/// Whether every step has one kernel over particles, which brings them to their bricks or moves them on: the first ends with the sums
/// over cells, the last is the collision. Sums stay in the workgroup that makes them, and nobody else may look for particles in their row: there is
/// none in between.
fn fit_for_bricks(plan: &Plan, sizes: &Sizes) -> bool {
    let applies = |m: &&Member| plan.stages[m.stage].entry.kind == APPLY;
    let fit = |item: &Item| match item {
        Item::Bricks(_, Route::Held) => None,
        Item::Bricks(members, route) => {
            let tallies = members.last().is_some_and(|m| m.phase.entry == TALLY);
            let found = (members.iter().filter(applies).count(), tallies);
            Some(found == ((*route != Route::Enter).into(), *route != Route::Leave))
        }
        other => {
            let mut uses = other.members().iter().flat_map(|m| &m.uses);
            uses.any(|u| ROW.contains(&u.buffer.as_str())).then_some(false)
        }
    };
    [true, false].into_iter().all(|all| {
        [Occasion::First, Occasion::Next, Occasion::Last].into_iter().all(|occasion| {
            let stages = stages(plan, all);
            // What is wrong with them is said when they are to be used.
            items(&stages, occasion, sizes).map_or(true, |items| {
                let sums = |m: &Member| m.uses.iter().any(|u| u.buffer == "moments");
                let lost = items.iter().any(|i| !i.keeps("moments") && i.members().iter().any(sums));
                !lost && items.iter().filter_map(fit).collect::<Vec<_>>() == [true]
            })
        })
    })
}

/// The entry point that brings particles to where their cells find them.
const TALLY: &str = "tally";

/// The entry point that makes the sums over all cells.
const GATHER: &str = "gather";

/// Buffers that a run of the plan binds, some of them more than once.
///
/// # Errors
/// If the WGSL of a stage is not valid.
pub fn bound(plan: &Plan, sizes: &Sizes) -> Result<Vec<String>, ShaderError> {
    let mut names = Vec::new();
    for all in [true, false] {
        for occasion in [Occasion::First, Occasion::Next, Occasion::Last] {
            for item in items(&stages(plan, all), occasion, sizes)? {
                let own = item.uses();
                let bound = item.members().iter().flat_map(|m| &m.uses).filter(|u| !item.keeps(&u.buffer));
                names.extend(bound.chain(&own).map(|u| u.buffer.clone()));
            }
        }
    }
    for m in ahead(plan, sizes)? {
        names.extend(m.uses.into_iter().map(|u| u.buffer));
    }
    if names.iter().any(|name| name == "shifts") {
        names.retain(|name| !SHIFTS.contains(&name.as_str()));
    }
    Ok(names)
}

/// What kernels are given as the shift of their step and of the one before: places in `shifts`.
pub const SHIFTS: [&str; 2] = ["shift", "shift_before"];

/// Kernels that do something beforehand for the steps to come.
///
/// # Errors
/// If the WGSL of a stage is not valid.
pub fn ahead(plan: &Plan, sizes: &Sizes) -> Result<Vec<Member>, ShaderError> {
    let mut list = Vec::new();
    for (stage, planned) in plan.stages.iter().enumerate() {
        let Some(fused) = planned.entry.otherwise(sizes.gathering()) else { continue };
        for phase in fused.ahead {
            list.push(member(planned.entry, stage, (*phase, fused.text(phase.entry)), (false, 0))?);
        }
    }
    Ok(list)
}

/// Which part of a run an order is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Occasion {
    /// A step that follows a snapshot: the collision before it has been applied.
    First,
    /// A step that applies the collision of the step before.
    Next,
    /// Before a snapshot: only applies the last collision.
    Last,
}

/// A stage of a fused step: its entry, how often it repeats within the step, and whether it runs in this one.
type Staged = (&'static Entry, u32, bool);

/// The order of kernels on an occasion. Kernels over nothing are left out.
///
/// # Errors
/// If the WGSL of a stage is not valid.
pub fn items(stages: &[Staged], occasion: Occasion, sizes: &Sizes) -> Result<Vec<Item>, ShaderError> {
    let items = match sizes.at_once {
        true => at_once::items(stages, occasion, sizes)?.expect("it was found to be possible"),
        false => parted(stages, occasion, sizes)?,
    };
    let items = match sizes.gathering() {
        // The ghosts behind walls go beside what takes longer than that.
        Gathering::Bricks => in_turn::joined(items, sizes),
        Gathering::Chains => items,
    };
    Ok(small::joined(in_turn::joined(beside::joined(items, sizes), sizes), sizes))
}

/// The order in which the sums over cells have kernels of their own.
fn parted(stages: &[Staged], occasion: Occasion, sizes: &Sizes) -> Result<Vec<Item>, ShaderError> {
    let apply = stages.iter().position(|(entry, ..)| entry.kind == APPLY).unwrap_or(stages.len());
    let mut list = Vec::new();
    let gathering = sizes.gathering();
    if occasion != Occasion::First && apply < stages.len() {
        let late = occasion == Occasion::Next;
        push(&mut list, stages, (apply, gathering), late)?;
        for (stage, (entry, ..)) in stages.iter().enumerate() {
            enter(&mut list, entry, (stage, gathering), entry.receive, (late, 0))?;
        }
        for stage in apply + 1..stages.len() {
            push(&mut list, stages, (stage, gathering), late)?;
        }
    }
    if occasion != Occasion::Last {
        for stage in 0..apply {
            push(&mut list, stages, (stage, gathering), false)?;
        }
    }
    list.retain(|m| sizes.count(m.phase.over) > 0);
    for member in &mut list {
        let waits = gathering == Gathering::Bricks || sizes.waiting > 0;
        member.rare = member.rare.filter(|r| waits && sizes.count(r.of) > 0);
    }
    if gathering == Gathering::Bricks {
        gather_last(&mut list, stages);
    }
    let route = (gathering == Gathering::Bricks).then_some(match occasion {
        Occasion::First => Route::Enter,
        Occasion::Next => Route::Stay,
        Occasion::Last => Route::Leave,
    });
    Ok(arranged(postponed(list, stages), stages, route))
}

/// Bricks add up their sums, ghosts included, where these are used: right before the first operators are made.
fn gather_last(list: &mut Vec<Member>, stages: &[Staged]) {
    let Some(from) = list.iter().position(|m| m.phase.entry == GATHER) else { return };
    let (gathering, mut rest): (Vec<Member>, Vec<Member>) =
        list.drain(from..).partition(|m| m.phase.entry == GATHER || part(m, stages).between());
    let to = rest.iter().position(|m| m.writes("operators")).unwrap_or(rest.len());
    rest.splice(to..to, gathering);
    list.append(&mut rest);
}

/// What is aside of the collision goes as far to the end as its buffers allow: there it may join those who need its cells.
fn postponed(mut list: Vec<Member>, stages: &[(&'static Entry, u32, bool)]) -> Vec<Member> {
    for at in (0..list.len()).rev().filter(|k| part(&list[*k], stages).aside()).collect::<Vec<_>>() {
        let member = list.remove(at);
        let stop = list[at..].iter().position(|later| conflict(&member, later));
        list.insert(stop.map_or(list.len(), |k| at + k), member);
    }
    list
}

fn push(
    list: &mut Vec<Member>,
    stages: &[(&'static Entry, u32, bool)],
    (stage, gathering): (usize, Gathering),
    late: bool,
) -> Result<(), ShaderError> {
    let (entry, repetitions, runs) = stages[stage];
    for repetition in 0..if runs { repetitions } else { 0 } {
        enter(list, entry, (stage, gathering), entry.phases, (late, repetition))?;
    }
    Ok(())
}

fn enter(
    list: &mut Vec<Member>,
    entry: &'static Entry,
    (stage, gathering): (usize, Gathering),
    phases: &[Phase],
    (late, repetition): (bool, u32),
) -> Result<(), ShaderError> {
    for place in phases.iter().flat_map(|p| entry.fused_phases(*p, gathering)) {
        list.push(member(entry, stage, place, (late, repetition))?);
    }
    Ok(())
}

fn member(
    entry: &'static Entry,
    stage: usize,
    (phase, wgsl): (Phase, &'static str),
    (late, repetition): (bool, u32),
) -> Result<Member, ShaderError> {
    let (mut uses, now) = reflected(entry, wgsl, phase.entry)?;
    // What those who move write to come next is read under its other name.
    let next = |u: &Use| {
        let name = u.buffer.strip_suffix("_next").filter(|name| u.write && find(name).is_some())?;
        Some(Use::whole(name, false, true))
    };
    let moves = phase.over == Extent::Particles;
    let turned: Vec<Use> = uses.iter().filter(|_| moves).filter_map(next).collect();
    uses.extend(turned);
    let (shared, own) = (entry.shared.contains(&phase.entry), entry.own.contains(&phase.entry));
    let rare = entry.rarely(phase.entry);
    let mut member = Member { stage, phase, wgsl, shared, own, rare, late, repetition, uses, now };
    if given(entry, &member).between() {
        // Where the kernel has them.
        member.uses.push(Use::whole("moments", true, true));
    }
    // By then the grid has been moved.
    Ok(if late { member.after_the_shift() } else { member })
}

/// What a step only ever adds to, in any order.
const ADDED: [&str; 2] = ["faults", "wall_impulses"];

/// One of them writes what the other uses.
pub(super) fn conflict(a: &Member, b: &Member) -> bool {
    let clash = |x: &Use, y: &Use| x.clashes(y) && !ADDED.contains(&x.buffer.as_str());
    a.uses.iter().any(|x| b.uses.iter().any(|y| clash(x, y)))
}

fn arranged(list: Vec<Member>, stages: &[(&'static Entry, u32, bool)], route: Option<Route>) -> Vec<Item> {
    let leads = |m: &Member| stages[m.stage].0.function(m.phase.entry).is_some() && !part(m, stages).aside();
    let joins = |m: &Member, group: &[Member]| {
        leads(m) || part(m, stages).aside() && group.iter().any(|g| g.writes("operators"))
    };
    let mut items = Vec::new();
    let mut rest = list;
    while let Some(first) = rest.iter().position(leads) {
        let later = rest.split_off(first + 1);
        let mut group = vec![rest.pop().expect("it was found")];
        items.extend(rest.into_iter().map(Item::Alone));
        let (mut hoisted, mut deferred) = (Vec::new(), Vec::new());
        for member in later {
            let free = !deferred.iter().any(|d| conflict(d, &member));
            if free && joins(&member, &group) && member.phase.over == group[0].phase.over {
                group.push(member);
            } else if free && !part(&member, stages).aside() && !group.iter().any(|g| conflict(g, &member)) {
                hoisted.push(member);
            } else {
                deferred.push(member);
            }
        }
        items.extend(hoisted.into_iter().map(Item::Alone));
        // The sums stay in registers only if nobody else asks for them.
        let made = group.len() > 1 && group[0].makes_sums();
        if made && deferred.iter().any(|d| d.uses.iter().any(|u| u.buffer == "moments")) {
            deferred.splice(0..0, group.drain(1..));
        }
        let alone = group.len() == 1 && !group[0].late;
        match route {
            Some(route) if group[0].phase.over == Extent::Particles => items.extend(in_bricks(group, route)),
            None if group.iter().any(|m| m.rare.is_some()) => items.extend(in_a_row(group)),
            _ if alone => items.push(Item::Alone(group.remove(0))),
            _ => items.push(Item::Joint(group)),
        }
        rest = deferred;
    }
    items.extend(rest.into_iter().map(Item::Alone));
    items
}

/// The kernel that moves particles brick by brick, and a second one for the few of members that are rare.
fn in_bricks(members: Vec<Member>, route: Route) -> Vec<Item> {
    match members.iter().position(|m| m.rare.is_some()) {
        Some(k) if route == Route::Stay => {
            let held = members[k..].iter().map(|m| Member { rare: None, ..m.clone() }).collect();
            vec![Item::Bricks(members, Route::Sift), Item::Bricks(held, Route::Held)]
        }
        _ => vec![Item::Bricks(members, route)],
    }
}

/// The kernel of joint members over particles, and a second one for the few of members that are rare.
fn in_a_row(members: Vec<Member>) -> [Item; 2] {
    let waited = members.iter().skip_while(|m| m.rare.is_none()).map(|m| Member { rare: None, ..m.clone() }).collect();
    [Item::Sifted(members), Item::Held(waited)]
}

fn part(m: &Member, stages: &[(&'static Entry, u32, bool)]) -> Part<'static> {
    given(stages[m.stage].0, m)
}

fn given(entry: &'static Entry, m: &Member) -> Part<'static> {
    Part {
        kind: entry.kind,
        wgsl: m.wgsl,
        settings: entry.uniform_wgsl,
        function: entry.function(m.phase.entry).unwrap_or_default(),
        rare: m.rare,
        late: m.late,
    }
}

/// The kernel of members over particles, those that wait or those that waited.
///
/// # Errors
/// If their functions do not fit together as WGSL.
pub fn sifted(members: &[Member], over: Over, stages: &[(&'static Entry, u32, bool)]) -> Result<Module, ShaderError> {
    fuse(&members.iter().map(|m| part(m, stages)).collect::<Vec<_>>(), over, Lanes::One)
}

/// The kernel of members that move particles brick by brick; see [`holds`].
///
/// # Errors
/// If their functions do not fit together as WGSL.
pub fn bricks(
    members: &[Member],
    route: Route,
    stages: &[Staged],
    (lanes, holds): (Lanes, bool),
) -> Result<Module, ShaderError> {
    let mut parts: Vec<Part<'_>> = members.iter().map(|m| part(m, stages)).collect();
    if route == Route::Leave {
        // It declares what bricks are.
        let declares = |wgsl: &str| wgsl.contains("//!include bricks\n");
        let mut texts = stages.iter().filter_map(|(entry, ..)| Some((entry, entry.bricked?.text(TALLY))));
        let tally = texts.find(|(_, wgsl)| declares(wgsl));
        parts.extend(tally.map(|(entry, wgsl)| Part {
            kind: entry.kind,
            wgsl,
            settings: entry.uniform_wgsl,
            function: "",
            rare: None,
            late: false,
        }));
    }
    let cells = over_cells(members);
    let kept = cells > 0 && received(stages)?;
    let hold = cells > 0 && route != Route::Leave && holds;
    fuse(&parts, Over::Bricks { route, cells, kept, hold }, lanes)
}

/// Whether a kernel that makes operators keeps the particles at hand that it moves on by them. On a GPU it does if the collision uses no sums over
/// positions, so that there are registers for both, or if there are so few bricks that all find room at once: then fetching particles again is only
/// waited for.
#[must_use]
pub fn holds(plan: &Plan, sizes: &Sizes, few_bricks: u64) -> bool {
    !places(plan) || sizes.bricks() <= few_bricks
}

/// So many of the first members are over cells.
fn over_cells(members: &[Member]) -> usize {
    members.iter().take_while(|m| m.phase.over == Extent::Cells).count()
}

/// Whether a stage asks for the operators of cells once they have been applied.
fn received(stages: &[Staged]) -> Result<bool, ShaderError> {
    let receives = |(entry, ..): &Staged| -> Result<bool, ShaderError> {
        let uses: Result<Vec<_>, _> = entry.receive.iter().map(|p| reflected(entry, entry.wgsl, p.entry)).collect();
        Ok(uses?.iter().flat_map(|(uses, _)| uses).any(|u| u.buffer == "operators"))
    };
    Ok(stages.iter().map(receives).collect::<Result<Vec<bool>, _>>()?.contains(&true))
}

/// The kernel of members by which cells make their sums and operators, and move their particles on.
///
/// # Errors
/// If their functions do not fit together as WGSL.
pub fn walked(members: &[Member], stages: &[Staged]) -> Result<Module, ShaderError> {
    let parts: Vec<Part<'_>> = members.iter().map(|m| part(m, stages)).collect();
    let over = Over::Walked { cells: over_cells(members), kept: received(stages)? };
    fuse(&parts, over, Lanes::One)
}

/// The kernel of joint members.
///
/// # Errors
/// If their functions do not fit together as WGSL.
pub fn joint(members: &[Member], stages: &[Staged], lanes: Lanes) -> Result<Module, ShaderError> {
    let parts: Vec<Part<'_>> = members.iter().map(|m| part(m, stages)).collect();
    let operators = |m: &Member| m.uses.iter().any(|u| u.buffer == "operators" && u.read);
    let bricked = members[0].makes_sums() && members[0].uses.iter().any(|u| u.buffer == "bricks_xy");
    let over = if bricked {
        let first = members[1..].iter().zip(&parts[1..]).find(|(_, part)| !part.between());
        Over::BrickCells { operators: first.is_some_and(|(m, _)| operators(m)) }
    } else if members[0].phase.over == Extent::Particles {
        Over::Particles
    } else {
        let sums = members[0].makes_sums();
        let first = &members[usize::from(sums)];
        Over::Cells { sums, operators: operators(first) }
    };
    fuse(&parts, over, lanes)
}
