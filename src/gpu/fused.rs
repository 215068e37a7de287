//! The fused plan on a GPU: see [`crate::graph::fused`] for the order of its kernels.

use super::buffers::{Buffers, View};
use super::kernel::{Kernel, compile, groups, settings};
use super::{Gpu, GpuError};
use crate::buffers::{Extent, Now, STEPS_AHEAD, Sizes};
use crate::graph::fused::{Item, Occasion, ahead, bricks, holds, items, joint, sifted, walked};
use crate::graph::kernels::APPLY;
use crate::graph::{Plan, beside, constants, in_turn, small};
use crate::shader::{Lanes, Module, Over, Route, settings_name};
use crate::stages::Entry;
use std::collections::HashMap;

/// A kernel with what it is, and what it shows as in timings.
struct Made {
    item: Item,
    kernel: Kernel,
    label: String,
}

/// The kernels of every order that a run needs.
pub(super) struct Fused {
    every: Vec<u64>,
    /// Index of the stage that applies the collision.
    apply: usize,
    made: Vec<Made>,
    orders: HashMap<(Occasion, u64), Vec<usize>>,
    /// What is done beforehand for the steps to come.
    ahead: Vec<usize>,
    /// Workgroups for particles that wait.
    held_groups: Option<View>,
}

/// What the orders of a plan dispatch, each once, with the modules that they come from.
pub(super) struct Ordered {
    orders: HashMap<(Occasion, u64), Vec<usize>>,
    ahead: Vec<usize>,
    every: Vec<u64>,
    lanes: Lanes,
    /// See [`holds`].
    holds: bool,
    pub(super) kernels: Vec<(Item, Module)>,
}

impl Ordered {
    /// Orders for every choice of the stages that do not run in each step.
    pub(super) fn new(gpu: &Gpu, plan: &Plan, sizes: &Sizes) -> Result<Self, GpuError> {
        let every: Vec<u64> = plan.stages.iter().map(|s| (s.entry.every)(&s.values)).collect();
        let occasional: u64 = every.iter().enumerate().map(|(i, n)| u64::from(*n > 1) << i).sum();
        let (lanes, holds) = (gpu.lanes, holds(plan, sizes, gpu.few_bricks));
        let mut ordered = Self { orders: HashMap::new(), ahead: Vec::new(), every, lanes, holds, kernels: Vec::new() };
        for member in ahead(plan, sizes)? {
            let stages = ordered.stages(plan, 0);
            let kernel = ordered.enter(Item::Alone(member), &stages, sizes)?;
            ordered.ahead.push(kernel);
        }
        let mut running = 0;
        loop {
            for occasion in [Occasion::First, Occasion::Next, Occasion::Last] {
                let stages = ordered.stages(plan, running);
                let order = items(&stages, occasion, sizes)?;
                let order =
                    order.into_iter().map(|item| ordered.enter(item, &stages, sizes)).collect::<Result<_, _>>()?;
                ordered.orders.insert((occasion, running), order);
            }
            // The next subset of the occasional stages.
            running = running.wrapping_sub(occasional) & occasional;
            if running == 0 {
                return Ok(ordered);
            }
        }
    }

    fn stages(&self, plan: &Plan, running: u64) -> Vec<(&'static Entry, u32, bool)> {
        let stage = |(i, s): (usize, &crate::graph::PlannedStage)| {
            (s.entry, (s.entry.repetitions)(&s.values), self.every[i] == 1 || running >> i & 1 == 1)
        };
        plan.stages.iter().enumerate().map(stage).collect()
    }

    fn enter(&mut self, item: Item, stages: &[(&'static Entry, u32, bool)], sizes: &Sizes) -> Result<usize, GpuError> {
        if let Some(known) = self.kernels.iter().position(|(i, _)| *i == item) {
            return Ok(known);
        }
        let module = match &item {
            Item::Joint(members) => joint(members, stages, self.lanes)?,
            Item::Sifted(members) => sifted(members, Over::Sifted, stages)?,
            Item::Held(members) => sifted(members, Over::Held, stages)?,
            Item::Walked(members) => walked(members, stages)?,
            Item::Bricks(members, route) => bricks(members, *route, stages, (self.lanes, self.holds))?,
            Item::Alone(m) => stages[m.stage].0.fused_module(&m.text(), item.lanes(self.lanes, sizes))?,
            Item::InTurn(members) => in_turn::module(members, stages)?,
            Item::Small(members) => small::module(members, stages, sizes)?,
            Item::Beside(members) => beside::module(members, stages, self.lanes, sizes)?,
        };
        self.kernels.push((item, module));
        Ok(self.kernels.len() - 1)
    }
}

impl Fused {
    /// Compiles what the orders dispatch.
    pub(super) fn new(
        gpu: &Gpu,
        plan: &Plan,
        ordered: Ordered,
        buffers: &Buffers,
        sizes: &Sizes,
    ) -> Result<Self, GpuError> {
        let uniforms: Vec<(String, wgpu::Buffer)> =
            plan.stages.iter().map(|s| (settings_name(s.entry.kind), settings(gpu, s, plan))).collect();
        let constants = [&constants(plan)[..], &[("HANDFUL", sizes.handful() as f64)]].concat();
        let mut made = Vec::new();
        for (item, module) in ordered.kernels {
            let members = item.members();
            let own = settings_name(plan.stages[members[0].stage].entry.kind);
            let find = |name: &str| {
                let name = if name == "settings" { own.as_str() } else { name };
                uniforms.iter().find(|(n, _)| n == name).map(|(_, b)| b.clone()).expect("every stage has its uniform")
            };
            let over = item.over();
            let groups = match item {
                Item::Small(_) => [1, 1],
                Item::Beside(ref members) => {
                    groups(64 * beside::workgroups(members, ordered.lanes, sizes), Extent::Particles)
                }
                _ => groups(sizes.count(over) * item.lanes(ordered.lanes, sizes).count(), over),
            };
            let (point, label) = (item.point(), item.label(|stage| plan.stages[stage].entry.kind));
            let module = buffers.fit(&module)?;
            let compiled = compile(gpu, &label, &module);
            let lanes = [("BRICK_LANES", f64::from(item.brick_lanes(ordered.holds)))];
            let constants = [&constants[..], &lanes].concat();
            let kernel = Kernel::new(gpu, &compiled, &module, (point, groups), (buffers, &find), &constants)?;
            made.push(Made { item, kernel, label });
        }
        let held_groups = buffers.get("held_groups").map(|parts| parts[0].clone());
        let apply = plan.stages.iter().position(|s| s.entry.kind == APPLY).unwrap_or(plan.stages.len());
        Ok(Self { every: ordered.every, apply, made, orders: ordered.orders, ahead: ordered.ahead, held_groups })
    }

    /// Before a submission: nobody waits for a kernel of its own. Within one a step empties the list of the next.
    pub(super) fn empty_lists(&self, gpu: &Gpu, buffers: &Buffers) {
        if self.held_groups.is_some() {
            // Workgroups along x, y and z, and how many wait, in even steps and in odd ones.
            buffers.write(gpu, "held_groups", 0, bytemuck::cast_slice(&[[0u32, 1, 1, 0]; 2]));
        }
    }

    fn order(&self, occasion: Occasion, step: u64) -> &[usize] {
        // What follows the collision is the step's before, once that comes with the next.
        let of = |i: usize| if occasion == Occasion::Next && i > self.apply { step - 1 } else { step };
        let runs = |(i, n): (usize, &u64)| u64::from(*n > 1 && of(i).is_multiple_of(*n)) << i;
        &self.orders[&(occasion, self.every.iter().enumerate().map(runs).sum())]
    }

    /// The kernels of a step on an occasion, the `since`th since the particles left their row; `stamp` is called before it and after each
    /// of [`Fused::labels`].
    pub(super) fn encode(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        (occasion, step, since): (Occasion, u64, u64),
        stamp: &mut dyn FnMut(&mut wgpu::ComputePass<'_>),
    ) {
        if occasion != Occasion::Last && since.is_multiple_of(STEPS_AHEAD) {
            self.ahead.iter().for_each(|k| self.made[*k].kernel.dispatch(pass, Now::at(step, 0), (false, step)));
        }
        stamp(pass);
        let mut side = since % 2 == 1;
        for k in self.order(occasion, step) {
            let made = &self.made[*k];
            let members = made.item.members();
            let member = members.iter().find(|m| m.now).unwrap_or(&members[0]);
            // Lists of who waits go by the step, and nothing there draws random numbers of the one before, unless cells make their operators first.
            let lists = match &made.item {
                Item::Sifted(_) | Item::Held(_) | Item::Bricks(_, Route::Held) => true,
                Item::Bricks(members, Route::Sift) => members[0].phase.over == Extent::Particles,
                _ => false,
            };
            let now = Now::at(if member.late && !lists { step - 1 } else { step }, member.repetition);
            match (&made.item, &self.held_groups) {
                (Item::Held(_) | Item::Bricks(_, Route::Held), Some(groups)) => {
                    made.kernel.dispatch_as_told(pass, now, (side, step), (groups, 16 * (step % 2)));
                }
                _ => made.kernel.dispatch(pass, now, (side, step)),
            }
            side ^= made.item.turns();
            stamp(pass);
        }
    }

    /// What runs between two stamps of a step.
    pub(super) fn labels(&self, occasion: Occasion, step: u64) -> Vec<String> {
        self.order(occasion, step).iter().map(|k| self.made[*k].label.clone()).collect()
    }

    /// Most kernels that a step can have.
    pub(super) fn longest(&self) -> usize {
        self.orders.values().map(Vec::len).max().unwrap_or(0)
    }
}
