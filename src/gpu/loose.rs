//! The loose plan: every stage its own kernels, in list order, with everything in memory in between.

use super::buffers::Buffers;
use super::kernel::{Kernel, groups, settings};
use super::{Gpu, GpuError};
use crate::buffers::{Now, Sizes};
use crate::graph::kernels::APPLY;
use crate::graph::{Plan, constants};
use crate::shader::Module;
use crate::stages::Phase;

/// The kernels of one stage.
struct StageKernels {
    kind: &'static str,
    every: u64,
    repetitions: u32,
    place: Vec<Kernel>,
    receive: Vec<Kernel>,
}

/// The kernels of all stages.
pub(super) struct Loose {
    stages: Vec<StageKernels>,
}

impl Loose {
    /// Compiles the stages' modules, which come in list order.
    pub(super) fn new(
        gpu: &Gpu,
        plan: &Plan,
        modules: &[Module],
        buffers: &Buffers,
        sizes: &Sizes,
    ) -> Result<Self, GpuError> {
        let constants = constants(plan);
        let mut stages = Vec::new();
        for (stage, module) in plan.stages.iter().zip(modules) {
            let module = &buffers.fit(module)?;
            let compiled = super::kernel::compile(gpu, stage.entry.kind, module);
            let uniform = settings(gpu, stage, plan);
            let kernels = |phases: &[Phase]| {
                let kernel = |p: &Phase| {
                    let groups = groups(sizes.count(p.over), p.over);
                    let own = |_: &str| uniform.clone();
                    Kernel::new(gpu, &compiled, module, (p.entry, groups), (buffers, &own), &constants)
                };
                phases.iter().map(kernel).collect::<Result<Vec<_>, _>>()
            };
            stages.push(StageKernels {
                kind: stage.entry.kind,
                every: (stage.entry.every)(&stage.values),
                repetitions: (stage.entry.repetitions)(&stage.values),
                place: kernels(stage.entry.phases)?,
                receive: kernels(stage.entry.receive)?,
            });
        }
        Ok(Self { stages })
    }

    /// One step; `stamp` is called before it and after each of [`Loose::labels`].
    pub(super) fn encode(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        step: u64,
        stamp: &mut dyn FnMut(&mut wgpu::ComputePass<'_>),
    ) {
        stamp(pass);
        for stage in &self.stages {
            if step.is_multiple_of(stage.every) {
                for repetition in 0..stage.repetitions {
                    stage.place.iter().for_each(|k| k.dispatch(pass, Now::at(step, repetition), (false, step)));
                }
            }
            stamp(pass);
            if stage.kind == APPLY {
                for owner in &self.stages {
                    owner.receive.iter().for_each(|k| k.dispatch(pass, Now::at(step, 0), (false, step)));
                    stamp(pass);
                }
            }
        }
    }

    /// What runs between two stamps of a step.
    pub(super) fn labels(&self) -> Vec<String> {
        let kinds = || self.stages.iter().map(|s| s.kind.to_owned());
        let owned = |kind: String| {
            let receivers: Vec<String> = if kind == APPLY { kinds().collect() } else { Vec::new() };
            std::iter::once(kind).chain(receivers)
        };
        kinds().flat_map(owned).collect()
    }

    /// One stage alone: what stands in its place, or what it receives.
    pub(super) fn encode_stage(&self, pass: &mut wgpu::ComputePass<'_>, kind: &str, receive: bool, step: u64) {
        for stage in self.stages.iter().filter(|s| s.kind == kind) {
            for repetition in 0..if receive { 1 } else { stage.repetitions } {
                let kernels = if receive { &stage.receive } else { &stage.place };
                kernels.iter().for_each(|k| k.dispatch(pass, Now::at(step, repetition), (false, step)));
            }
        }
    }
}
