//! What a stage is: the trait that each stage file implements, and its type-erased form in the registry.

use crate::buffers::{Extent, Gathering};
use crate::params::{Field, Params, Values};
use crate::shader::{Lanes, Module, Rare, ShaderError, Shared};
use crate::state::System;
use crate::state::scene::Scene;

/// One kernel of a stage: an entry point of its WGSL file and what it has one invocation for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Phase {
    /// Entry point.
    pub entry: &'static str,
    /// One invocation for each element of this extent.
    pub over: Extent,
}

/// What a stage does otherwise in the fused plan.
#[derive(Debug, Clone, Copy)]
pub struct Fused {
    /// Texts of files in `shaders/fused`.
    pub wgsl: &'static [&'static str],
    /// Kernels that do beforehand what does not depend on the state, for as many steps as [`crate::buffers::STEPS_AHEAD`] at a time.
    pub ahead: &'static [Phase],
    /// Entry points of [`Stage::WGSL`], each with the kernels that run instead of it, with the same result; all others run as they are.
    pub instead: &'static [(&'static str, &'static [Phase])],
}

impl Fused {
    /// The text that has this entry point, or the last.
    #[must_use]
    pub fn text(&self, point: &str) -> &'static str {
        let has = |wgsl: &&&str| wgsl.contains(&format!("fn {point}("));
        self.wgsl.iter().find(has).or(self.wgsl.last()).copied().unwrap_or_default()
    }
}

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gravity {
    /// The run may go on.
    Warning,
    /// The run must not start.
    Error,
}

/// Something a stage's check has to say of its parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// How bad.
    pub gravity: Gravity,
    /// The parameter it is about; empty for the stage as a whole.
    pub field: &'static str,
    /// What is wrong and why.
    pub message: String,
    /// What to do.
    pub help: String,
}

/// A stage of the step. `PHASES` run where the stage stands in the list; `RECEIVE` phases run after the particles have received
/// their cells' operators, for a stage whose own (ghost) particles take part in the collision.
pub trait Stage: 'static {
    /// Its name in pipeline files, drawings and timings; also the stem of its files.
    const KIND: &'static str;
    /// Text of `shaders/stages/KIND.wgsl`.
    const WGSL: &'static str;
    /// Kernels that run at the stage's place.
    const PHASES: &'static [Phase];
    /// Kernels that run once the collision has been applied.
    const RECEIVE: &'static [Phase] = &[];
    /// What the stage does otherwise in the fused plan.
    const FUSED: Option<Fused> = None;
    /// The same where particles lie brick by brick ([`Gathering::Bricks`]), if it then does something else.
    const BRICKED: Option<Fused> = None;
    /// Entry points over particles or cells that the fused plan may join with others over the same, each with the function that does
    /// its work for one of them: `fn(i: u32, p: Particle) -> Particle`, `fn(cell: u32) -> Sums` for the first over cells, else
    /// `fn(cell: u32, m: Moments, o: Operator) -> Operator`, or `fn(cell: u32)` if it leaves the operator alone. Where particles lie in bricks,
    /// `fn(cell: u32, s: Sums) -> Sums` adds to the sums of a cell, and `fn(brick: u32, lane: u32)` is its whole workgroup's work before that.
    const EACH: &'static [(&'static str, &'static str)] = &[];
    /// Entry points of [`Stage::EACH`] over particles that do much for a few of them and little for the others.
    const RARE: &'static [Rare] = &[];
    /// Entry points that share the work for one element among several invocations where the adapter is better at that: their WGSL takes
    /// the number from `LANES`, which is 1 in the loose plan.
    const SHARED: &'static [&'static str] = &[];
    /// Entry points of which an invocation uses, of what any of them in any stage writes, only what belongs to its own element.
    const OWN: &'static [&'static str] = &[];
    /// Kinds that, where present, must stand before this stage in the list.
    const AFTER: &'static [&'static str] = &[];
    /// Its parameters in the pipeline file.
    type Params: Params;
    /// The uniform its kernels bind as `settings`.
    type Uniform: Shared;

    /// How often the whole of `PHASES` repeats within one step.
    fn repetitions(_params: &Self::Params) -> u32 {
        1
    }
    /// Every how many steps the stage runs.
    fn every(_params: &Self::Params) -> u64 {
        1
    }
    /// Whether the stage uses the sums over the positions in a cell, not only over velocities.
    fn places(_params: &Self::Params) -> bool {
        false
    }
    /// Whether the stage uses the energy of a cell.
    fn energies(_params: &Self::Params) -> bool {
        false
    }
    /// What is wrong with the parameters in this system, beyond the ranges of single fields.
    fn check(_params: &Self::Params, _system: &System) -> Vec<Finding> {
        Vec::new()
    }
    /// The uniform.
    fn uniform(params: &Self::Params, system: &System) -> Self::Uniform;
    /// The stage in f64, as a textbook has it; shares no code with the shader.
    fn reference(params: &Self::Params, system: &System, scene: &mut Scene);
    /// What the stage does in f64 once the collision has been applied (its `RECEIVE` phases).
    fn reference_receive(_params: &Self::Params, _system: &System, _scene: &mut Scene) {}
}

/// A stage without its types: what parsing, planning, drawing and running need.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// See [`Stage::KIND`].
    pub kind: &'static str,
    /// See [`Stage::WGSL`].
    pub wgsl: &'static str,
    /// See [`Stage::PHASES`].
    pub phases: &'static [Phase],
    /// See [`Stage::RECEIVE`].
    pub receive: &'static [Phase],
    /// See [`Stage::FUSED`].
    pub fused: Option<Fused>,
    /// See [`Stage::BRICKED`].
    pub bricked: Option<Fused>,
    /// See [`Stage::EACH`].
    pub each: &'static [(&'static str, &'static str)],
    /// See [`Stage::RARE`].
    pub rare: &'static [Rare],
    /// See [`Stage::SHARED`].
    pub shared: &'static [&'static str],
    /// See [`Stage::OWN`].
    pub own: &'static [&'static str],
    /// See [`Stage::AFTER`].
    pub after: &'static [&'static str],
    /// Doc comment of the parameters: what the stage does.
    pub summary: fn() -> &'static str,
    /// Parameters.
    pub fields: fn() -> Vec<Field>,
    /// See [`Stage::repetitions`].
    pub repetitions: fn(&Values) -> u32,
    /// See [`Stage::every`].
    pub every: fn(&Values) -> u64,
    /// See [`Stage::places`].
    pub places: fn(&Values) -> bool,
    /// See [`Stage::energies`].
    pub energies: fn(&Values) -> bool,
    /// See [`Stage::check`].
    pub check: fn(&Values, &System) -> Vec<Finding>,
    /// Bytes of the uniform.
    pub uniform: fn(&Values, &System) -> Vec<u8>,
    /// WGSL declaration of the uniform's struct.
    pub uniform_wgsl: &'static str,
    /// Names and byte offsets of the uniform's fields.
    pub uniform_offsets: fn() -> Vec<(&'static str, usize)>,
    /// See [`Stage::reference`].
    pub reference: fn(&Values, &System, &mut Scene),
    /// See [`Stage::reference_receive`].
    pub reference_receive: fn(&Values, &System, &mut Scene),
}

impl Entry {
    /// The entry of a stage.
    #[must_use]
    pub const fn of<S: Stage>() -> Self {
        Self {
            kind: S::KIND,
            wgsl: S::WGSL,
            phases: S::PHASES,
            receive: S::RECEIVE,
            fused: S::FUSED,
            bricked: S::BRICKED,
            each: S::EACH,
            rare: S::RARE,
            shared: S::SHARED,
            own: S::OWN,
            after: S::AFTER,
            summary: S::Params::summary,
            fields: S::Params::fields,
            repetitions: |v| S::repetitions(&S::Params::from_values(v)),
            every: |v| S::every(&S::Params::from_values(v)),
            places: |v| S::places(&S::Params::from_values(v)),
            energies: |v| S::energies(&S::Params::from_values(v)),
            check: |v, s| S::check(&S::Params::from_values(v), s),
            uniform: |v, s| bytemuck::bytes_of(&S::uniform(&S::Params::from_values(v), s)).to_vec(),
            uniform_wgsl: S::Uniform::WGSL,
            uniform_offsets: S::Uniform::offsets,
            reference: |v, s, scene| S::reference(&S::Params::from_values(v), s, scene),
            reference_receive: |v, s, scene| S::reference_receive(&S::Params::from_values(v), s, scene),
        }
    }

    /// The function that does the work of this entry point for one particle or cell, if it has one.
    #[must_use]
    pub fn function(&self, point: &str) -> Option<&'static str> {
        self.each.iter().find(|(entry, _)| *entry == point).map(|(_, function)| *function)
    }

    /// What this entry point does for a few particles only, if it is so.
    #[must_use]
    pub fn rarely(&self, point: &str) -> Option<Rare> {
        self.rare.iter().find(|r| r.entry == point).copied()
    }

    /// What the stage does otherwise in the fused plan.
    #[must_use]
    pub fn otherwise(&self, gathering: Gathering) -> Option<Fused> {
        let own = match gathering {
            Gathering::Chains => None,
            Gathering::Bricks => self.bricked,
        };
        own.or(self.fused)
    }

    /// The kernels that the fused plan runs for a phase, each with the WGSL that has it.
    #[must_use]
    pub fn fused_phases(&self, phase: Phase, gathering: Gathering) -> Vec<(Phase, &'static str)> {
        let instead = |f: Fused| {
            let (_, phases) = f.instead.iter().find(|(entry, _)| *entry == phase.entry)?;
            Some(phases.iter().map(|p| (*p, f.text(p.entry))).collect())
        };
        self.otherwise(gathering).and_then(instead).unwrap_or_else(|| vec![(phase, self.wgsl)])
    }

    /// A WGSL text of the stage, composed for the fused plan, validated and reflected.
    ///
    /// # Errors
    /// See [`Entry::module`].
    pub fn fused_module(&self, wgsl: &str, lanes: Lanes) -> Result<Module, ShaderError> {
        Module::new(self.kind, &lanes.chosen(wgsl), self.uniform_wgsl)
    }

    /// The stage's WGSL, composed, validated and reflected.
    ///
    /// # Errors
    /// If it is not valid WGSL or binds something that the catalogue of buffers does not have.
    pub fn module(&self) -> Result<Module, ShaderError> {
        Module::new(self.kind, self.wgsl, self.uniform_wgsl)
    }
}
