//! Snapshots: totals, fields and samples computed on the GPU, copied to staging buffers, read without stopping the steps.

use super::buffers::Buffers;
use super::kernel::{Kernel, compile, groups};
use super::session::Session;
use super::{Gpu, GpuError};
use crate::buffers::{Buffer, Extent, MeasureSettings, Now, Sizes, find};
use crate::shader::{Module, Shared};
use crate::state::System;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex};

const SOURCE: &str = include_str!("../../shaders/measure/measure.wgsl");

/// Buffers copied with every snapshot.
const ALWAYS: &[&str] = &["squirmers", "steric", "fluid_force", "wall_impulses", "faults"];

/// What a snapshot takes of the fluid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    /// Totals over the fluid.
    pub totals: bool,
    /// Fields over blocks of this many cells along the edge, if any.
    pub block: Option<u32>,
    /// This share of the particles, if any.
    pub fraction: Option<f64>,
}

/// The kernels and buffers of one kind of snapshot.
pub struct Measurement {
    kernels: Vec<Kernel>,
    buffers: Buffers,
    /// Staging buffers that have been read and can be used again.
    ring: Ring,
    wanted: Wanted,
    /// Blocks per axis.
    pub blocks: [u32; 3],
    /// Particles taken.
    pub samples: u64,
}

type Ring = Arc<Mutex<Vec<wgpu::Buffer>>>;

/// A snapshot on its way to the host.
pub struct Reading {
    /// Steps done when it was taken.
    pub step: u64,
    parts: Vec<(&'static str, usize)>,
    readback: Readback,
    ring: Ring,
}

/// A staging buffer that is being mapped.
pub(super) struct Readback {
    buffer: wgpu::Buffer,
    state: Arc<AtomicU8>,
}

const WAITING: u8 = 0;
const READY: u8 = 1;
const FAILED: u8 = 2;

pub(super) fn staging(gpu: &Gpu, bytes: u64) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("staging"),
        size: bytes,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

impl Readback {
    /// Asks for the mapping of a buffer whose copy has been submitted.
    pub(super) fn map(buffer: wgpu::Buffer) -> Self {
        let state = Arc::new(AtomicU8::new(WAITING));
        let flag = state.clone();
        buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            flag.store(if result.is_ok() { READY } else { FAILED }, Ordering::Release);
        });
        Self { buffer, state }
    }

    pub(super) fn settled(&self) -> bool {
        self.state.load(Ordering::Acquire) != WAITING
    }

    /// The bytes where they lie, once they are there.
    fn view(&self) -> Option<wgpu::BufferView> {
        let ready = self.state.load(Ordering::Acquire) == READY;
        ready.then(|| self.buffer.slice(..).get_mapped_range().ok()).flatten()
    }

    /// The bytes, once they are there.
    pub(super) fn take(&self) -> Option<Vec<u8>> {
        self.view().map(|view| view.to_vec())
    }
}

impl Reading {
    /// Whether the bytes have arrived (or never will).
    #[must_use]
    pub fn settled(&self) -> bool {
        self.readback.settled()
    }

    /// The parts by name, not yet copied.
    ///
    /// # Errors
    /// If they never arrived.
    pub fn take(self) -> Result<Parts, GpuError> {
        let lost = || GpuError::Lost("a snapshot could not be read back".into());
        let view = Some(self.readback.view().ok_or_else(lost)?);
        Ok(Parts { step: self.step, view, parts: self.parts, buffer: self.readback.buffer, ring: self.ring })
    }
}

/// The raw content of a snapshot, which any thread may look at; the staging buffer can be used again once this is dropped.
pub struct Parts {
    /// Steps done when it was taken.
    pub step: u64,
    /// Here until the end.
    view: Option<wgpu::BufferView>,
    parts: Vec<(&'static str, usize)>,
    buffer: wgpu::Buffer,
    ring: Ring,
}

impl Drop for Parts {
    fn drop(&mut self) {
        // What is looked at cannot be unmapped.
        self.view = None;
        self.buffer.unmap();
        if let Ok(mut ring) = self.ring.lock() {
            ring.push(self.buffer.clone());
        }
    }
}

impl Parts {
    /// One buffer's content; empty if the snapshot did not take it.
    #[must_use]
    pub fn get<T: bytemuck::Pod>(&self, name: &str) -> Vec<T> {
        let Some(view) = &self.view else { return Vec::new() };
        let mut offset = 0;
        for (part, bytes) in &self.parts {
            if *part == name {
                let whole = bytes / size_of::<T>() * size_of::<T>();
                return bytemuck::pod_collect_to_vec(&view[offset..offset + whole]);
            }
            offset += bytes;
        }
        Vec::new()
    }
}

impl Measurement {
    /// Builds the kernels for one kind of snapshot of a session.
    ///
    /// # Errors
    /// If a buffer is too large, memory runs out, or the shader is not accepted.
    pub fn new(session: &Session, wanted: Wanted) -> Result<Self, GpuError> {
        let edge = wanted.block.unwrap_or(1);
        let blocks = session.system.domain.size.map(|n| n.div_ceil(edge));
        let (stride, samples) = sampling(session.sizes.particles, wanted.fraction);
        let sizes = Sizes {
            coarse: if wanted.block.is_some() { blocks.iter().map(|n| u64::from(*n)).product() } else { 0 },
            samples,
            ..session.sizes
        };
        let settings = MeasureSettings {
            blocks,
            edge,
            stride,
            samples: u32::try_from(samples).expect("samples fit in 32 bits"),
            scale: total_scale(&session.system),
            pad: 0,
        };
        let own: Vec<&'static Buffer> = ["totals", "fields", "samples"].iter().filter_map(|n| find(n)).collect();
        let gpu = &session.gpu;
        let mut buffers = Buffers::create(gpu, &sizes, 0, own.into_iter())?;
        buffers.share(&session.buffers);
        let module = buffers.fit(&Module::new("measure", SOURCE, MeasureSettings::WGSL)?)?;
        let compiled = compile(gpu, "measure", &module);
        let uniform = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("settings"),
            size: size_of::<MeasureSettings>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        gpu.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&settings));
        let mut phases = Vec::new();
        if wanted.totals || wanted.block.is_some() {
            phases.extend([("clear", Extent::Cells), ("reduce", Extent::Particles)]);
        }
        if wanted.totals {
            phases.extend([("clear_totals", Extent::One), ("total", Extent::Cells)]);
        }
        phases.extend([("coarsen", Extent::Coarse), ("sample", Extent::Samples)]);
        // Nobody asks for sums over positions.
        let constants = [("PLACES", 0.0)];
        let kernels = phases
            .iter()
            .map(|(entry, over)| {
                let groups = groups(sizes.count(*over), *over);
                Kernel::new(gpu, &compiled, &module, (entry, groups), (&buffers, &|_| uniform.clone()), &constants)
            })
            .collect::<Result<Vec<_>, _>>()?;
        let measurement = Self { kernels, buffers, ring: Ring::default(), wanted, blocks, samples };
        let (bytes, most) = (measurement.bytes(), gpu.summary.largest_buffer);
        if bytes > most {
            return Err(GpuError::LargeSnapshot { bytes, most, adapter: gpu.summary.name.clone() });
        }
        Ok(measurement)
    }

    /// What is copied to the host.
    fn names(&self) -> Vec<&'static str> {
        let mut names: Vec<&'static str> = ALWAYS.to_vec();
        if self.wanted.totals {
            names.push("totals");
        }
        if self.wanted.block.is_some() {
            names.push("fields");
        }
        if self.samples > 0 {
            names.push("samples");
        }
        names
    }

    fn bytes(&self) -> u64 {
        self.names().iter().map(|n| self.buffers.bytes(n)).sum()
    }

    /// Measures and copies after the steps submitted so far; does not wait.
    #[must_use]
    pub fn take(&self, session: &Session) -> Reading {
        let gpu = &session.gpu;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            for kernel in &self.kernels {
                kernel.dispatch(&mut pass, Now::default(), (false, 0));
            }
        }
        let used = self.ring.lock().ok().and_then(|mut ring| ring.pop());
        let target = used.unwrap_or_else(|| staging(gpu, self.bytes()));
        let mut offset = 0;
        let mut parts = Vec::new();
        for name in self.names() {
            for source in self.buffers.of(name) {
                source.copy(&mut encoder, (&target, offset));
                offset += source.bytes();
            }
            parts.push((name, usize::try_from(self.buffers.bytes(name)).expect("staging fits in memory")));
        }
        gpu.queue.submit([encoder.finish()]);
        Reading { step: session.step(), parts, readback: Readback::map(target), ring: self.ring.clone() }
    }

    /// The scale by which the wide sums of `totals` are multiplied.
    #[must_use]
    pub fn scale(system: &System) -> f64 {
        f64::from(total_scale(system))
    }
}

/// Every how manieth particle is taken, and how many that makes.
fn sampling(particles: u64, fraction: Option<f64>) -> (u32, u64) {
    let Some(fraction) = fraction.filter(|f| *f > 0.0) else { return (1, 0) };
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let stride = (1.0 / fraction).round().max(1.0) as u32;
    (stride, particles.div_ceil(u64::from(stride)))
}

/// A cell's sum of squared speeds stays below 2^12 thermal units (its own fixed point): 2^18 keeps it below 2^30.
#[allow(clippy::cast_possible_truncation)]
fn total_scale(system: &System) -> f32 {
    let scales = crate::math::fixed::Scales::new(system.fluid.density, system.fluid.temperature);
    (scales.energy / 4.0) as f32
}
