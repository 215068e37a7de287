//! The kernels of one step in the order of execution, each with the buffers that it truly reads and writes.

use super::{Plan, PlannedStage};
use crate::shader::{Binding, Lanes, Members, Module, ShaderError};
use crate::stages::{Entry, Phase, REGISTRY};
use std::collections::{HashMap, hash_map};
use std::sync::{Mutex, PoisonError};

/// The stage at which the particles receive their cells' operators, and ghosts theirs.
pub const APPLY: &str = "apply";

/// How a kernel uses one buffer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Use {
    /// Name in the catalogue.
    pub buffer: String,
    /// Its former content matters.
    pub read: bool,
    /// Its content changes.
    pub write: bool,
    /// The same of its members, if it is an array of structs.
    pub members: Option<Members>,
}

impl Use {
    /// Of all that the buffer holds.
    #[must_use]
    pub fn whole(buffer: &str, read: bool, write: bool) -> Self {
        Self { buffer: buffer.to_owned(), read, write, members: None }
    }

    /// Whether one of two writes what the other uses.
    #[must_use]
    pub fn clashes(&self, other: &Self) -> bool {
        let apart = self.members.zip(other.members).is_some_and(|(a, b)| !a.clash(b));
        self.buffer == other.buffer && (self.write || other.write) && !apart
    }
}

/// One kernel of the step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kernel {
    /// Index of its stage in the list.
    pub stage: usize,
    /// Kind of its stage.
    pub kind: &'static str,
    /// Its entry point.
    pub entry: &'static str,
    /// Whether it belongs to what the stage does once the collision has been applied.
    pub receive: bool,
    /// Whether it runs in every step.
    pub every_step: bool,
    /// What it binds.
    pub uses: Vec<Use>,
}

/// The kernels of one step: the phases of each stage in list order; at `apply` also what the other stages receive.
/// A stage is its entry and whether it runs in every step.
///
/// # Errors
/// If the WGSL of a stage is not valid.
pub fn kernels(stages: &[(&'static Entry, bool)]) -> Result<Vec<Kernel>, ShaderError> {
    let mut list = Vec::new();
    for (index, (entry, _)) in stages.iter().enumerate() {
        push(&mut list, stages, index, entry.phases, false)?;
        if entry.kind == APPLY {
            for (other, (receiver, _)) in stages.iter().enumerate() {
                push(&mut list, stages, other, receiver.receive, true)?;
            }
        }
    }
    Ok(list)
}

fn push(
    list: &mut Vec<Kernel>,
    stages: &[(&'static Entry, bool)],
    stage: usize,
    phases: &'static [Phase],
    receive: bool,
) -> Result<(), ShaderError> {
    let (entry, every_step) = stages[stage];
    for phase in phases {
        let uses = uses(entry, phase.entry)?;
        list.push(Kernel { stage, kind: entry.kind, entry: phase.entry, receive, every_step, uses });
    }
    Ok(())
}

/// What the kernels of a plan may leave out: the values of the constants `override NAME` of its WGSL, 0 or 1.
#[must_use]
pub fn constants(plan: &Plan) -> [(&'static str, f64); 5] {
    let system = &plan.system;
    let yes = |b: bool| f64::from(u8::from(b));
    [
        ("WALLS", yes(system.domain.walls.is_some())),
        ("FORCE", yes(system.fluid.acceleration != [0.0; 3])),
        ("PLACES", yes(places(plan))),
        ("ENERGIES", yes(asked(plan, |s| (s.entry.energies)(&s.values)))),
        ("BINS", yes(super::sizes(system).bins > 0)),
    ]
}

/// Whether the collision uses the sums over positions in a cell.
#[must_use]
pub fn places(plan: &Plan) -> bool {
    asked(plan, |s| (s.entry.places)(&s.values))
}

/// Whether a stage asks for certain sums. Where no collision uses any, whoever reads them wants them whole.
fn asked(plan: &Plan, by: impl Fn(&PlannedStage) -> bool) -> bool {
    !plan.stages.iter().any(|s| s.entry.kind == APPLY) || plan.stages.iter().any(by)
}

/// What an entry point of a stage binds in the loose plan.
///
/// # Errors
/// If the WGSL of the stage is not valid.
pub fn uses(entry: &'static Entry, point: &'static str) -> Result<Vec<Use>, ShaderError> {
    Ok(reflected(entry, entry.wgsl, point)?.0)
}

/// What an entry point in a WGSL text of a stage binds, and whether it uses `now`. Modules are reflected once for the life of the program.
///
/// # Errors
/// If the WGSL of the stage is not valid.
pub fn reflected(
    entry: &'static Entry,
    wgsl: &'static str,
    point: &'static str,
) -> Result<(Vec<Use>, bool), ShaderError> {
    type Known = HashMap<&'static str, Vec<(String, Vec<Use>, bool)>>;
    static KNOWN: Mutex<Option<Known>> = Mutex::new(None);
    let mut guard = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let known = guard.get_or_insert_default();
    if let hash_map::Entry::Vacant(place) = known.entry(wgsl) {
        let module = entry.fused_module(wgsl, Lanes::One)?;
        let bound = |m: &Module, point: &str| {
            let bindings = m.bindings(point).iter();
            let used = |b: &Binding| Use { members: b.members, ..Use::whole(&b.name, b.access.read, b.access.write) };
            bindings.map(used).collect()
        };
        let points = module.entry_points().map(|p| (p.to_owned(), bound(&module, p), module.uses_now(p))).collect();
        place.insert(points);
    }
    let points = &known[wgsl];
    let found = points.iter().find(|(name, ..)| name == point);
    Ok(found.map(|(_, uses, now)| (uses.clone(), *now)).unwrap_or_default())
}

/// Kinds of stages that compute this buffer anew: the first of their kernels to bind it writes it without reading.
#[must_use]
pub fn makers(buffer: &str) -> Vec<&'static str> {
    let makes = |entry: &&'static Entry| {
        let mut uses = entry.phases.iter().filter_map(|p| uses(entry, p.entry).ok()).flatten();
        uses.find(|u| u.buffer == buffer).is_some_and(|u| u.write && !u.read)
    };
    REGISTRY.iter().filter(makes).map(|e| e.kind).collect()
}
