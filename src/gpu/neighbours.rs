//! Whether an adapter's subgroups are what kernels need in which neighbours share work.

use super::Gpu;
use super::measure::{Readback, staging};

const SOURCE: &str = include_str!("../../shaders/measure/neighbours.wgsl");

/// Invocations of the only workgroup (`GROUP` of the shader).
const GROUP: u32 = 64;

impl Gpu {
    /// Whether the invocations of a subgroup are neighbours in their workgroup, in order, and hand each other their values also after having
    /// gone different ways. Subgroups that may be of one size or another, or lie otherwise, would mix up particles.
    #[must_use]
    pub fn subgroups_are_neighbours(&self) -> bool {
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("neighbours"),
            source: wgpu::ShaderSource::Wgsl(SOURCE.into()),
        });
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("neighbours"),
            layout: None,
            module: &module,
            entry_point: Some("neighbours"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        let numbers: Vec<u32> = (0..GROUP).collect();
        let words = super::buffers::storage(self, "words", u64::from(GROUP) * 4, false);
        self.queue.write_buffer(&words, 0, bytemuck::cast_slice(&numbers));
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("neighbours"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: words.as_entire_binding() }],
        });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(1, 1, 1);
        }
        let found = staging(self, words.size());
        encoder.copy_buffer_to_buffer(&words, 0, &found, 0, words.size());
        self.queue.submit([encoder.finish()]);
        let readback = Readback::map(found);
        let done = self.device.poll(wgpu::PollType::wait_indefinitely()).is_ok() && self.healthy().is_ok();
        let all = |bytes: Vec<u8>| bytemuck::pod_collect_to_vec::<u8, u32>(&bytes).iter().all(|word| *word == 1);
        done && readback.take().is_some_and(all)
    }
}
