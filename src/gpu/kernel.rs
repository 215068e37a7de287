//! Kernels: one entry point of a stage's module with its pipeline, its buffers and its size.

use super::buffers::{Buffers, View, storage};
use super::{Gpu, GpuError};
use crate::buffers::{Extent, Now, STEPS_AHEAD};
use crate::graph::fused::SHIFTS;
use crate::graph::{Plan, PlannedStage};
use crate::shader::compose::widened;
use crate::shader::{Binding, Module};

/// Invocations per workgroup of every kernel that has one invocation per element (`shaders/lib/dispatch.wgsl`).
const WORKGROUP: u64 = 64;

/// What WGSL declares whose workgroup memory the driver need not clear.
const CLEARED: &str = "const CLEARS_WORKGROUP_MEMORY: bool = true;";

/// A stage's own uniform.
pub(super) fn settings(gpu: &Gpu, stage: &PlannedStage, plan: &Plan) -> wgpu::Buffer {
    let bytes = (stage.entry.uniform)(&stage.values, &plan.system);
    let uniform = storage(gpu, "settings", (bytes.len() as u64).next_multiple_of(16), true);
    gpu.queue.write_buffer(&uniform, 0, &bytes);
    uniform
}

/// A module for the adapter.
#[allow(unsafe_code)]
pub(super) fn compile(gpu: &Gpu, label: &str, module: &Module) -> wgpu::ShaderModule {
    let text = if gpu.coherent { module.text.clone() } else { module.text.replace("@coherent ", "") };
    let text = if gpu.wide { widened(&text) } else { text };
    let descriptor = wgpu::ShaderModuleDescriptor { label: Some(label), source: wgpu::ShaderSource::Wgsl(text.into()) };
    // A counter in every loop would keep compilers from unrolling short ones, and a comparison before every access to workgroup memory takes 8 % of
    // the time of a step.
    let checks = wgpu::ShaderRuntimeChecks {
        force_loop_bounding: false,
        bounds_checks: false,
        ..wgpu::ShaderRuntimeChecks::checked()
    };
    // SAFETY: every loop of the shaders ends: they count up to a bound, or follow a chain of which each entry is older than the one before. Every
    // index is below the length of what it is for, whatever particles hold: numbers of particles, squirmers and cells are compared with how
    // many there are, cells of any position are in the grid, and places in a brick are compared with its room.
    unsafe { gpu.device.create_shader_module_trusted(descriptor, checks) }
}

pub(super) struct Kernel {
    pipeline: wgpu::ComputePipeline,
    /// As it is, and where what comes next has changed places with what is.
    bind_groups: [wgpu::BindGroup; 2],
    groups: [u32; 2],
    /// By how many steps the shifts that it binds are older than the step, in the order of its bindings.
    shifts: Vec<u64>,
}

/// Workgroups along x and y for `count` invocations: at most 65,535 along either, and none missing.
pub(super) fn groups(count: u64, over: Extent) -> [u32; 2] {
    let needed = if over == Extent::One { count } else { count.div_ceil(WORKGROUP) };
    let x = needed.min(65_535);
    let y = if x == 0 { 0 } else { needed.div_ceil(x) };
    let small = |n: u64| u32::try_from(n).expect("a dispatch dimension fits in 32 bits");
    [small(x), small(y)]
}

/// The buffer that changes places with this one: `NAME_next` with `NAME`.
fn other_side(name: &str) -> String {
    name.strip_suffix("_next").map_or_else(|| format!("{name}_next"), str::to_owned)
}

/// Where the shift that a binding asks for lies in `shifts`, if there is such: by how many steps it is older than the step.
fn age(binding: &Binding, buffers: &Buffers) -> Option<u64> {
    let found = SHIFTS.iter().position(|name| *name == binding.name).filter(|_| buffers.has("shifts"));
    found.map(|age| age as u64)
}

/// Bytes from the shift of one step to that of the next, and of one.
const SHIFT_BYTES: (u64, u64) = (256, 16);

fn layout_entry(binding: &Binding, moving: bool) -> wgpu::BindGroupLayoutEntry {
    let ty = if binding.uniform {
        wgpu::BufferBindingType::Uniform
    } else {
        wgpu::BufferBindingType::Storage { read_only: !binding.writable }
    };
    wgpu::BindGroupLayoutEntry {
        binding: binding.binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: moving, min_binding_size: None },
        count: None,
    }
}

impl Kernel {
    /// The kernel of `entry_point`; the uniforms `settings...` come by name beside the buffers.
    pub(super) fn new(
        gpu: &Gpu,
        compiled: &wgpu::ShaderModule,
        module: &Module,
        (entry_point, groups): (&str, [u32; 2]),
        (buffers, settings): (&Buffers, &dyn Fn(&str) -> wgpu::Buffer),
        constants: &[(&str, f64)],
    ) -> Result<Self, GpuError> {
        let constants: Vec<(&str, f64)> =
            constants.iter().copied().filter(|(name, _)| module.text.contains(&format!("override {name}:"))).collect();
        let bindings = module.bindings(entry_point);
        gpu.summary.can_bind(entry_point, bindings.iter().filter(|b| !b.uniform).count() as u64)?;
        let entries: Vec<_> = bindings.iter().map(|b| layout_entry(b, age(b, buffers).is_some())).collect();
        let layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(entry_point), entries: &entries });
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(entry_point),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: u32::try_from(size_of::<Now>()).expect("small"),
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry_point),
            layout: Some(&pipeline_layout),
            module: compiled,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &constants,
                zero_initialize_workgroup_memory: !module.text.contains(CLEARED),
            },
            cache: None,
        });
        let bind_group = |turned: bool| {
            let buffer = |b: &Binding| {
                if b.name.starts_with("settings") {
                    return View::whole(settings(&b.name));
                }
                if age(b, buffers).is_some() {
                    return buffers.of("shifts")[0].first(SHIFT_BYTES.1);
                }
                let other = other_side(&b.name);
                let parts = buffers.get(&other).filter(|_| turned).unwrap_or_else(|| buffers.of(&b.name));
                parts[b.part as usize].clone()
            };
            let found: Vec<View> = bindings.iter().map(buffer).collect();
            let bound: Vec<_> = bindings
                .iter()
                .zip(&found)
                .map(|(b, view)| wgpu::BindGroupEntry {
                    binding: b.binding,
                    resource: wgpu::BindingResource::Buffer(view.binding()),
                })
                .collect();
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(entry_point),
                layout: &layout,
                entries: &bound,
            })
        };
        let bind_groups = [bind_group(false), bind_group(true)];
        gpu.healthy()?;
        let shifts = bindings.iter().filter_map(|b| age(b, buffers)).collect();
        Ok(Self { pipeline, bind_groups, groups, shifts })
    }

    /// Adds the kernel to a pass in a step; `turned`: what comes next and what is have changed places.
    pub(super) fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, now: Now, (turned, step): (bool, u64)) {
        let [x, y] = self.groups;
        if x == 0 || y == 0 {
            return;
        }
        self.set(pass, now, (turned, step));
        pass.dispatch_workgroups(x, y, 1);
    }

    #[allow(clippy::cast_possible_truncation)]
    fn set(&self, pass: &mut wgpu::ComputePass<'_>, now: Now, (turned, step): (bool, u64)) {
        let mut places = [0; SHIFTS.len()];
        for (place, age) in places.iter_mut().zip(&self.shifts) {
            *place = (step.wrapping_sub(*age) % (STEPS_AHEAD + 1) * SHIFT_BYTES.0) as u32;
        }
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_groups[usize::from(turned)], &places[..self.shifts.len()]);
        pass.set_immediates(0, bytemuck::bytes_of(&now));
    }
}

impl Kernel {
    /// Adds the kernel to a pass, with as many workgroups as three words at this place of a buffer say by then.
    pub(super) fn dispatch_as_told(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        now: Now,
        (turned, step): (bool, u64),
        (groups, place): (&View, u64),
    ) {
        self.set(pass, now, (turned, step));
        let (buffer, place) = groups.at(place);
        pass.dispatch_workgroups_indirect(buffer, place);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_dispatches_spread_over_two_dimensions() {
        assert_eq!(groups(1, Extent::One), [1, 1]);
        assert_eq!(groups(0, Extent::Cells), [0, 0]);
        assert_eq!(groups(65, Extent::Cells), [2, 1]);
        for count in [64 * 65_535, 64 * 65_535 + 1, 130_000_000, 4_000_000_000] {
            let [x, y] = groups(count, Extent::Particles);
            assert!(x <= 65_535 && y <= 65_535);
            assert!(u64::from(x) * u64::from(y) * WORKGROUP >= count);
        }
    }
}
