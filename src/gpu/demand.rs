//! What a run asks of an adapter: its kernels and the sizes of its buffers, known before it has particles.

use super::fused::Ordered;
use super::session::{Form, Session};
use super::{Gpu, GpuError};
use crate::buffers::{Sizes, find};
use crate::graph::fused::SHIFTS;
use crate::graph::{self, Plan};
use crate::shader::Module;
use crate::state::packed;
use std::collections::HashSet;

pub(super) struct Demand {
    pub(super) sizes: Sizes,
    /// Of the stages, in the loose form.
    pub(super) loose: Vec<Module>,
    /// In the fused form.
    pub(super) fused: Option<Ordered>,
}

impl Demand {
    /// Of a plan with so many particles.
    pub(super) fn new(gpu: &Gpu, plan: &Plan, count: u64, form: Form) -> Result<Self, GpuError> {
        let sizes = match form {
            Form::Loose => packed::sizes(&plan.system, count),
            Form::Fused => graph::fused::sizes(plan, count, gpu.gathering),
        };
        let (loose, fused) = match form {
            Form::Loose => (plan.stages.iter().map(|s| s.entry.module()).collect::<Result<Vec<_>, _>>()?, None),
            Form::Fused => (Vec::new(), Some(Ordered::new(gpu, plan, &sizes)?)),
        };
        Ok(Self { sizes, loose, fused })
    }

    fn modules(&self) -> impl Iterator<Item = &Module> {
        let fused = self.fused.iter().flat_map(|o| o.kernels.iter().map(|(_, module)| module));
        self.loose.iter().chain(fused)
    }

    /// Names of the buffers that the kernels bind and snapshots read.
    pub(super) fn used(&self) -> HashSet<String> {
        let bound = self.modules().flat_map(|m| m.entry_points().flat_map(|e| m.bindings(e)).map(|b| b.name.clone()));
        let mut used: HashSet<String> = bound.chain(graph::SHOWN.map(str::to_owned)).collect();
        if used.contains("shifts") {
            used.retain(|name| !SHIFTS.contains(&name.as_str()));
        }
        used
    }
}

impl Session {
    /// Whether the kernels of a plan can bind its buffers on an adapter: to be asked before millions of particles are placed in vain.
    ///
    /// # Errors
    /// If they cannot, or a shader is not accepted.
    pub fn fits(gpu: &Gpu, plan: &Plan, form: Form) -> Result<(), GpuError> {
        let demand = Demand::new(gpu, plan, plan.system.particle_count(), form)?;
        let parts = |name: &str| find(name).map_or(1, |b| gpu.summary.parts(demand.sizes.bytes(b)));
        for module in demand.modules() {
            for entry in module.entry_points() {
                let bound = module.bindings(entry).iter().filter(|b| !b.uniform);
                gpu.summary.can_bind(entry, bound.map(|b| parts(&b.name)).sum())?;
            }
        }
        Ok(())
    }
}
