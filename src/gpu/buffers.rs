//! The buffers of a run: each of them one, or in several parts where it is larger than what a kernel can bind.

use super::{Gpu, GpuError};
use crate::buffers::{Buffer, Life, Sizes};
use crate::shader::{Module, split};
use std::collections::HashMap;

/// Bytes up to which what a kernel writes may be a uniform of others: what every adapter allows.
const UNIFORM: u64 = 16 << 10;

/// A buffer of this many bytes.
pub(super) fn storage(gpu: &Gpu, name: &str, bytes: u64, uniform: bool) -> wgpu::Buffer {
    let kind = match (uniform, bytes) {
        (true, _) => wgpu::BufferUsages::UNIFORM,
        (false, ..=UNIFORM) => wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::UNIFORM,
        (false, _) => wgpu::BufferUsages::STORAGE,
    };
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(name),
        size: bytes,
        usage: kind | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::INDIRECT,
        mapped_at_creation: false,
    })
}

/// Buffers by name, each with its parts: all but the last have [`Buffers::part`] bytes.
pub(super) struct Buffers {
    parts: HashMap<&'static str, Vec<wgpu::Buffer>>,
    part: u64,
}

impl Buffers {
    /// Creates buffers, with `room` bytes more each, refusing what the adapter cannot hold.
    pub fn create<'a>(
        gpu: &Gpu,
        sizes: &Sizes,
        room: u64,
        wanted: impl Iterator<Item = &'a Buffer>,
    ) -> Result<Self, GpuError> {
        let wanted: Vec<&Buffer> = wanted.filter(|b| b.name != "settings").collect();
        let part = gpu.summary.part();
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let mut parts = HashMap::new();
        for buffer in &wanted {
            let uniform = buffer.life == Life::Setting && buffer.name == "system";
            let bytes = (sizes.bytes(buffer) + room).next_multiple_of(16);
            let most = if gpu.summary.parts(bytes) > 1 { part } else { bytes };
            let lengths = (0..gpu.summary.parts(bytes)).map(|k| most.min(bytes - k * most));
            let made: Vec<_> = lengths.map(|length| storage(gpu, buffer.name, length, uniform)).collect();
            parts.insert(buffer.name, made);
        }
        if pollster::block_on(scope.pop()).is_some() {
            let bytes = wanted.iter().map(|b| sizes.bytes(b)).sum();
            return Err(GpuError::OutOfMemory { bytes, adapter: gpu.summary.name.clone() });
        }
        gpu.healthy()?;
        Ok(Self { parts, part })
    }

    /// The parts of a buffer, if it is there.
    pub fn get(&self, name: &str) -> Option<&[wgpu::Buffer]> {
        self.parts.get(name).map(Vec::as_slice)
    }

    /// The parts of a buffer that must be there.
    pub fn of(&self, name: &str) -> &[wgpu::Buffer] {
        &self.parts[name]
    }

    /// Whether a buffer is there.
    pub fn has(&self, name: &str) -> bool {
        self.parts.contains_key(name)
    }

    /// Takes in those of another, too.
    pub fn share(&mut self, other: &Self) {
        self.parts.extend(other.parts.iter().map(|(name, parts)| (*name, parts.clone())));
    }

    /// Bytes of one buffer.
    pub fn bytes(&self, name: &str) -> u64 {
        self.of(name).iter().map(wgpu::Buffer::size).sum()
    }

    /// Bytes of all.
    pub fn all_bytes(&self) -> u64 {
        self.parts.values().flatten().map(wgpu::Buffer::size).sum()
    }

    /// Overwrites a part of a buffer that begins so many bytes behind its start.
    pub fn write(&self, gpu: &Gpu, name: &str, offset: u64, bytes: &[u8]) {
        let parts = self.of(name);
        let (mut begin, end) = (offset, offset + bytes.len() as u64);
        for (k, part) in parts.iter().enumerate() {
            let first = k as u64 * self.part;
            let to = end.min(first + part.size());
            if begin < to {
                let slice = |at: u64| usize::try_from(at - offset).expect("content fits in memory");
                gpu.queue.write_buffer(part, begin - first, &bytes[slice(begin)..slice(to)]);
                begin = to;
                if begin < end {
                    // What waits to be copied takes memory of the host.
                    gpu.queue.submit([]);
                }
            }
        }
    }

    /// The module with as many bindings for each array as that has parts.
    pub fn fit(&self, module: &Module) -> Result<Module, GpuError> {
        let parts = |name: &str| self.get(name).map_or(1, |parts| u32::try_from(parts.len()).expect("parts are few"));
        Ok(split(module, parts, self.part)?)
    }
}
