//! The buffers of a run: each of them one, or in several parts where it is larger than what a kernel can bind.

use super::layout::{Layout, Place};
use super::{Gpu, GpuError};
use crate::buffers::{Buffer, Sizes};
use crate::shader::{Module, split};
use std::collections::HashMap;

/// Bytes of a buffer up to which what a kernel writes may be a uniform of others. Of longer ones than every adapter allows a part may.
const UNIFORM: u64 = 32 << 10;

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

/// Where a part of an array lies: so many bytes of a buffer from some place on.
#[derive(Debug, Clone)]
pub(super) struct View {
    buffer: wgpu::Buffer,
    offset: u64,
    bytes: u64,
}

impl View {
    /// All of a buffer.
    pub fn whole(buffer: wgpu::Buffer) -> Self {
        let bytes = buffer.size();
        Self { buffer, offset: 0, bytes }
    }

    /// Its bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The first bytes of it.
    pub fn first(&self, bytes: u64) -> Self {
        Self { bytes, ..self.clone() }
    }

    /// What a bind group is told.
    pub fn binding(&self) -> wgpu::BufferBinding<'_> {
        wgpu::BufferBinding { buffer: &self.buffer, offset: self.offset, size: wgpu::BufferSize::new(self.bytes) }
    }

    /// The buffer, and where in it the view's byte of this number is.
    pub fn at(&self, byte: u64) -> (&wgpu::Buffer, u64) {
        (&self.buffer, self.offset + byte)
    }

    /// Asks for a copy of all of it to some place of another buffer.
    pub fn copy(&self, encoder: &mut wgpu::CommandEncoder, (target, place): (&wgpu::Buffer, u64)) {
        encoder.copy_buffer_to_buffer(&self.buffer, self.offset, target, place, self.bytes);
    }
}

/// Buffers by name, each with its parts: all but the last have [`Buffers::part`] bytes.
pub(super) struct Buffers {
    parts: HashMap<&'static str, Vec<View>>,
    part: u64,
    /// Of all the memory that was asked for.
    bytes: u64,
}

impl Buffers {
    /// Creates buffers, with `room` bytes more each, refusing what the adapter cannot hold. With any room none lies in another's memory.
    pub fn create(
        gpu: &Gpu,
        sizes: &Sizes,
        room: u64,
        wanted: impl Iterator<Item = &'static Buffer>,
    ) -> Result<Self, GpuError> {
        let wanted: Vec<&Buffer> = wanted.filter(|b| b.name != "settings").collect();
        let align = gpu.device.limits().min_storage_buffer_offset_alignment.max(16).into();
        let layout = Layout::new(&wanted, (sizes, room), (&gpu.summary, align));
        let bytes = layout.bytes();
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let made = |(name, bytes): &(&str, u64)| storage(gpu, name, *bytes, *name == "system");
        let blocks: Vec<wgpu::Buffer> = layout.blocks.iter().map(made).collect();
        if pollster::block_on(scope.pop()).is_some() {
            return Err(GpuError::OutOfMemory { bytes, adapter: gpu.summary.name.clone() });
        }
        gpu.healthy()?;
        let view = |p: Place| View { buffer: blocks[p.block].clone(), offset: p.offset, bytes: p.bytes };
        let parts = layout.arrays.into_iter().map(|(name, places)| (name, places.into_iter().map(view).collect()));
        Ok(Self { parts: parts.collect(), part: gpu.summary.part(), bytes })
    }

    /// The parts of a buffer, if it is there.
    pub fn get(&self, name: &str) -> Option<&[View]> {
        self.parts.get(name).map(Vec::as_slice)
    }

    /// The parts of a buffer that must be there.
    pub fn of(&self, name: &str) -> &[View] {
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
        self.of(name).iter().map(View::bytes).sum()
    }

    /// Bytes of memory that were asked for.
    pub fn all_bytes(&self) -> u64 {
        self.bytes
    }

    /// Asks for a copy of all of a buffer to another of its size.
    pub fn copy(&self, encoder: &mut wgpu::CommandEncoder, from: &str, to: &str) {
        for (source, target) in self.of(from).iter().zip(self.of(to)) {
            source.copy(encoder, target.at(0));
        }
    }

    /// Overwrites a part of a buffer that begins so many bytes behind its start.
    pub fn write(&self, gpu: &Gpu, name: &str, offset: u64, bytes: &[u8]) {
        let parts = self.of(name);
        let (mut begin, end) = (offset, offset + bytes.len() as u64);
        for (k, part) in parts.iter().enumerate() {
            let first = k as u64 * self.part;
            let to = end.min(first + part.bytes());
            if begin < to {
                let slice = |at: u64| usize::try_from(at - offset).expect("content fits in memory");
                let (buffer, place) = part.at(begin - first);
                gpu.queue.write_buffer(buffer, place, &bytes[slice(begin)..slice(to)]);
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
