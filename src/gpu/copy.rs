//! The bandwidth of a plain copy on an adapter, against which kernels are held.

use super::{Gpu, GpuError};
use std::time::{Duration, Instant};

const SOURCE: &str = include_str!("../../shaders/measure/copy.wgsl");

/// Invocations per workgroup (`GROUP` of the shader).
const GROUP: u64 = 256;

/// Largest buffer that is copied: far beyond any cache.
const LARGEST: u64 = 1 << 30;
/// The same on a CPU, whose caches are small and whose memory is slow.
const LARGEST_CPU: u64 = 64 << 20;

/// What a copy kernel reached.
#[derive(Debug, Clone)]
pub struct Copied {
    /// Length of the buffer that was copied.
    pub bytes: u64,
    /// Bytes read and written per second, batch by batch.
    pub rates: Vec<f64>,
}

/// Buffers, and kernels over them.
struct Copier {
    bytes: u64,
    fill: wgpu::ComputePipeline,
    copy: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

impl Gpu {
    /// Copies a buffer for about `time` in each of `batches` batches, after as much time to warm up.
    ///
    /// # Errors
    /// If memory runs out or the device was lost.
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn copy_bandwidth(&self, batches: usize, time: Duration) -> Result<Copied, GpuError> {
        let copier = Copier::new(self)?;
        self.wait_until_done(&copier.submit(self, Some(&copier.fill), 1))?;
        let (mut rounds, began) = (1, Instant::now());
        while began.elapsed() < time {
            let before = Instant::now();
            self.wait_until_done(&copier.submit(self, None, rounds))?;
            let enough = time.as_secs_f64() / before.elapsed().as_secs_f64().max(1e-6) * rounds as f64;
            rounds = (enough as usize).clamp(1, 2 * rounds);
        }
        let mut rates = Vec::new();
        for _ in 0..batches {
            let before = Instant::now();
            self.wait_until_done(&copier.submit(self, None, rounds))?;
            rates.push((2 * copier.bytes) as f64 * rounds as f64 / before.elapsed().as_secs_f64().max(1e-9));
        }
        Ok(Copied { bytes: copier.bytes, rates })
    }

    fn wait_until_done(&self, index: &wgpu::SubmissionIndex) -> Result<(), GpuError> {
        let wait = wgpu::PollType::Wait { submission_index: Some(index.clone()), timeout: None };
        self.device.poll(wait).map_err(|e| GpuError::Lost(e.to_string()))?;
        self.healthy()
    }
}

impl Copier {
    /// With buffers as large as the adapter binds and holds.
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let largest = if gpu.summary.kind == "CPU" { LARGEST_CPU } else { LARGEST };
        let mut bytes = largest.min(gpu.summary.largest_binding) / 16 * 16;
        let buffers = loop {
            let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
            let pair = ["from", "to"].map(|name| super::buffers::storage(gpu, name, bytes, false));
            if pollster::block_on(scope.pop()).is_none() {
                break pair;
            }
            if bytes <= 1 << 20 {
                return Err(GpuError::OutOfMemory { bytes: 2 * bytes, adapter: gpu.summary.name.clone() });
            }
            bytes = bytes / 32 * 16;
        };
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("copy"),
            source: wgpu::ShaderSource::Wgsl(SOURCE.into()),
        });
        let entry = |binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: false },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let entries = [entry(0), entry(1)];
        let layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("copy"), entries: &entries });
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("copy"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = |point| {
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(point),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let bound =
            |binding: u32| wgpu::BindGroupEntry { binding, resource: buffers[binding as usize].as_entire_binding() };
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("copy"),
            layout: &layout,
            entries: &[bound(0), bound(1)],
        });
        let (fill, copy) = (pipeline("fill"), pipeline("copy"));
        gpu.healthy()?;
        Ok(Self { bytes, fill, copy, group })
    }

    /// Submits a kernel first, if any, and then copies.
    fn submit(&self, gpu: &Gpu, first: Option<&wgpu::ComputePipeline>, copies: usize) -> wgpu::SubmissionIndex {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            let groups = u32::try_from((self.bytes / 16).div_ceil(GROUP)).expect("a buffer of at most 1 GiB");
            let x = groups.min(65_535);
            pass.set_bind_group(0, &self.group, &[]);
            for kernel in first.into_iter().chain(std::iter::repeat_n(&self.copy, copies)) {
                pass.set_pipeline(kernel);
                pass.dispatch_workgroups(x, groups.div_ceil(x), 1);
            }
        }
        gpu.queue.submit([encoder.finish()])
    }
}
