//! The fused plan: the kernels of a step in an order of their own, neighbours over the same particles or cells joined into one.
//!
//! The collision of a step is applied together with the streaming of the next, so that a particle is read and written once per step.
//! Kernels in between run before or after the joint one as far as the buffers allow that they truly bind. Small ones are joined in the end
//! ([`small`]).

use super::kernels::{APPLY, Use, places, reflected};
use super::{Plan, small};
use crate::buffers::{Extent, Sizes};
use crate::shader::{ENTRY, Lanes, Module, Over, Part, ShaderError, fuse};
use crate::stages::{Entry, Phase};
use crate::state::packed;

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
    fn writes(&self, buffer: &str) -> bool {
        self.uses.iter().any(|u| u.buffer == buffer && u.write)
    }

    fn makes_sums(&self) -> bool {
        self.writes("moments")
    }
}

/// What the fused plan dispatches.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Item {
    /// A kernel of a stage as it is.
    Alone(Member),
    /// Several kernels in one, over particles or over cells.
    Joint(Vec<Member>),
    /// Small kernels that one workgroup does one after the other.
    Small(Vec<Member>),
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
                Some(known) => known.write |= used.write,
                None => uses.push(used.clone()),
            }
        }
        if matches!(self, Item::Joint(_)) && members.len() > 1 && members[0].makes_sums() {
            uses.retain(|u| u.buffer != "moments");
        }
        uses
    }

    /// What it shows as in timings; `kind` names a stage.
    #[must_use]
    pub fn label(&self, kind: impl Fn(usize) -> &'static str) -> String {
        match self {
            Item::Joint(members) | Item::Small(members) if members.len() > 1 => {
                let mut kinds: Vec<&str> = members.iter().map(|m| kind(m.stage)).collect();
                let mut seen = std::collections::HashSet::new();
                kinds.retain(|kind| seen.insert(*kind));
                kinds.join(" + ")
            }
            _ => format!("{} {}", kind(self.members()[0].stage), self.point()),
        }
    }

    /// The entry point of its kernel.
    #[must_use]
    pub fn point(&self) -> &'static str {
        if matches!(self, Item::Joint(_) | Item::Small(_)) { ENTRY } else { self.members()[0].phase.entry }
    }

    /// Invocations for each of its elements. What cells share is the work for the ghosts of squirmers: where most have none, four invocations
    /// that find that out cost more than sharing gains.
    #[must_use]
    pub fn lanes(&self, adapter: Lanes, sizes: &Sizes) -> Lanes {
        let first = &self.members()[0];
        let idle = first.phase.over == Extent::Cells && 2 * sizes.count(Extent::SquirmerGhosts) < sizes.cells;
        if first.shared && !idle { adapter } else { Lanes::One }
    }

    /// The kernels in it.
    #[must_use]
    pub fn members(&self) -> &[Member] {
        match self {
            Item::Alone(member) => std::slice::from_ref(member),
            Item::Joint(members) | Item::Small(members) => members,
        }
    }
}

/// Stages of a plan as [`items`] wants them; all of them run, or only those that run in every step.
#[must_use]
pub fn stages(plan: &Plan, all: bool) -> Vec<(&'static Entry, u32, bool)> {
    let stage =
        |s: &super::PlannedStage| (s.entry, (s.entry.repetitions)(&s.values), all || (s.entry.every)(&s.values) == 1);
    plan.stages.iter().map(stage).collect()
}

/// Elements of every extent in a fused run of the plan; `pairs`: the adapter is good at adding 64-bit integers.
#[must_use]
pub fn sizes(plan: &Plan, particles: u64, pairs: bool) -> Sizes {
    let sizes = packed::sizes(&plan.system, particles);
    Sizes { pairs: if pairs && !places(plan) { sizes.cells } else { 0 }, ..sizes }
}

/// Buffers that a run of the plan binds, some of them more than once.
///
/// # Errors
/// If the WGSL of a stage is not valid.
pub fn bound(plan: &Plan, sizes: &Sizes) -> Result<Vec<String>, ShaderError> {
    let mut names = Vec::new();
    for all in [true, false] {
        for occasion in [Occasion::First, Occasion::Next, Occasion::Last] {
            for item in items(&stages(plan, all), occasion, sizes)? {
                names.extend(item.members().iter().flat_map(|m| &m.uses).map(|u| u.buffer.clone()));
            }
        }
    }
    Ok(names)
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

/// The order of kernels on an occasion; a stage is its entry, how often it repeats within a step, and whether it runs in this step.
/// Kernels over nothing are left out.
///
/// # Errors
/// If the WGSL of a stage is not valid.
pub fn items(
    stages: &[(&'static Entry, u32, bool)],
    occasion: Occasion,
    sizes: &Sizes,
) -> Result<Vec<Item>, ShaderError> {
    let apply = stages.iter().position(|(entry, ..)| entry.kind == APPLY).unwrap_or(stages.len());
    let mut list = Vec::new();
    let pairs = sizes.pairs > 0;
    if occasion == Occasion::Next {
        for (stage, (entry, ..)) in stages.iter().enumerate() {
            let Some(fused) = entry.otherwise(pairs) else { continue };
            for phase in fused.preface {
                list.push(member(entry, stage, (*phase, fused.wgsl), (false, 0))?);
            }
        }
    }
    if occasion != Occasion::First && apply < stages.len() {
        let late = occasion == Occasion::Next;
        push(&mut list, stages, (apply, pairs), late)?;
        for (stage, (entry, ..)) in stages.iter().enumerate() {
            enter(&mut list, entry, (stage, pairs), entry.receive, (late, 0))?;
        }
        for stage in apply + 1..stages.len() {
            push(&mut list, stages, (stage, pairs), late)?;
        }
    }
    if occasion != Occasion::Last {
        for stage in 0..apply {
            push(&mut list, stages, (stage, pairs), false)?;
        }
    }
    list.retain(|m| sizes.count(m.phase.over) > 0);
    Ok(small::joined(arranged(postponed(list, stages), stages), sizes))
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
    (stage, pairs): (usize, bool),
    late: bool,
) -> Result<(), ShaderError> {
    let (entry, repetitions, runs) = stages[stage];
    for repetition in 0..if runs { repetitions } else { 0 } {
        enter(list, entry, (stage, pairs), entry.phases, (late, repetition))?;
    }
    Ok(())
}

fn enter(
    list: &mut Vec<Member>,
    entry: &'static Entry,
    (stage, pairs): (usize, bool),
    phases: &[Phase],
    (late, repetition): (bool, u32),
) -> Result<(), ShaderError> {
    for place in phases.iter().flat_map(|p| entry.fused_phases(*p, pairs)) {
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
    if late && entry.kind == APPLY {
        // By then the grid has been moved.
        uses.iter_mut().filter(|u| u.buffer == "shift").for_each(|u| "shift_before".clone_into(&mut u.buffer));
    }
    let shared = entry.shared.contains(&phase.entry);
    Ok(Member { stage, phase, wgsl, shared, late, repetition, uses, now })
}

/// One of them writes what the other uses. Faults are flags that are only ever added.
pub(super) fn conflict(a: &Member, b: &Member) -> bool {
    a.uses.iter().any(|x| b.uses.iter().any(|y| x.buffer == y.buffer && (x.write || y.write) && x.buffer != "faults"))
}

fn arranged(list: Vec<Member>, stages: &[(&'static Entry, u32, bool)]) -> Vec<Item> {
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
        items.push(if alone { Item::Alone(group.remove(0)) } else { Item::Joint(group) });
        rest = deferred;
    }
    items.extend(rest.into_iter().map(Item::Alone));
    items
}

fn part(m: &Member, stages: &[(&'static Entry, u32, bool)]) -> Part<'static> {
    let entry = stages[m.stage].0;
    Part {
        kind: entry.kind,
        wgsl: m.wgsl,
        settings: entry.uniform_wgsl,
        function: entry.function(m.phase.entry).unwrap_or_default(),
        late: m.late,
    }
}

/// The kernel of joint members.
///
/// # Errors
/// If their functions do not fit together as WGSL.
pub fn joint(members: &[Member], stages: &[(&'static Entry, u32, bool)]) -> Result<Module, ShaderError> {
    let parts: Vec<Part<'_>> = members.iter().map(|m| part(m, stages)).collect();
    let over = if members[0].phase.over == Extent::Particles {
        Over::Particles
    } else {
        let sums = members[0].makes_sums();
        let first = &members[usize::from(sums)];
        Over::Cells { sums, operators: first.uses.iter().any(|u| u.buffer == "operators" && u.read) }
    };
    fuse(&parts, over)
}
