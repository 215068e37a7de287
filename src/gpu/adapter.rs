//! Adapters: what this machine has, which one a run uses, and opening it.

use super::GpuError;
use crate::buffers::Gathering;
use crate::shader::Lanes;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// One adapter, as `squirm adapters` lists it.
#[derive(Debug, Clone)]
pub struct AdapterSummary {
    /// Its number in the list.
    pub index: usize,
    /// Name that the driver gives.
    pub name: String,
    /// "GPU", "integrated GPU", "virtual GPU", "CPU" or "other".
    pub kind: &'static str,
    /// Driver and its version.
    pub driver: String,
    /// Vulkan, Metal or DX12.
    pub backend: String,
    /// Largest buffer that a kernel can bind, in bytes.
    pub largest_binding: u64,
    /// Largest buffer, in bytes.
    pub largest_buffer: u64,
    /// Buffers that a kernel can bind.
    pub most_bindings: u32,
    /// Whether everything that the kernels need is there.
    pub usable: bool,
}

impl AdapterSummary {
    /// Bytes of each part but the last of a buffer that is larger than what a kernel can bind: a power of two.
    #[must_use]
    pub fn part(&self) -> u64 {
        1 << self.largest_binding.max(16).ilog2()
    }

    /// How many parts a buffer of so many bytes has.
    #[must_use]
    pub fn parts(&self, bytes: u64) -> u64 {
        if bytes > self.largest_binding { bytes.div_ceil(self.part()) } else { 1 }
    }

    /// Whether a kernel may bind so many buffers.
    ///
    /// # Errors
    /// If it may not.
    pub fn can_bind(&self, kernel: &str, needed: u64) -> Result<(), GpuError> {
        if needed <= u64::from(self.most_bindings) {
            return Ok(());
        }
        let (kernel, adapter) = (kernel.to_owned(), self.name.clone());
        Err(GpuError::TooLarge { kernel, needed, part: self.part(), most: self.most_bindings, adapter })
    }
}

/// An opened adapter.
#[derive(Debug, Clone)]
pub struct Gpu {
    /// What it is.
    pub summary: AdapterSummary,
    /// How many invocations share the sums over one cell in the fused plan.
    pub lanes: Lanes,
    /// How the fused plan makes the sums over cells, where the plan is fit for it; `None`: as suits a GPU.
    pub gathering: Option<Gathering>,
    /// Up to how many bricks find room at once.
    pub few_bricks: u64,
    /// Shaders use whole numbers of 64 bits where they can; they compute the same without.
    pub wide: bool,
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) timestamps: bool,
    /// Buffers may be declared coherent.
    pub(super) coherent: bool,
    pub(super) failure: Arc<Mutex<Failure>>,
}

/// What the driver has complained about.
#[derive(Debug, Default)]
pub(super) struct Failure {
    first: Option<String>,
    lost: Option<String>,
}

const NEEDED: wgpu::Features = wgpu::Features::IMMEDIATES;

/// What neighbouring invocations need to add up their sums.
const SHARING: wgpu::Features = wgpu::Features::SUBGROUP;

/// What the invocations of a workgroup need to read what the others wrote; without it they have what the barrier gives.
const COHERENT: wgpu::Features = wgpu::Features::MEMORY_DECORATION_COHERENT;

/// What makes one operation of a product of two words.
const WIDE: wgpu::Features = wgpu::Features::SHADER_INT64;

fn timing_features() -> wgpu::Features {
    wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES
}

fn enumerate() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    // Kernels count their workgroups themselves, and not beyond what a dispatch may have.
    descriptor.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
    descriptor.backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    let instance = wgpu::Instance::new(descriptor);
    pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()))
}

fn summary(index: usize, adapter: &wgpu::Adapter) -> AdapterSummary {
    let (info, limits) = (adapter.get_info(), adapter.limits());
    let kind = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => "GPU",
        wgpu::DeviceType::IntegratedGpu => "integrated GPU",
        wgpu::DeviceType::VirtualGpu => "virtual GPU",
        wgpu::DeviceType::Cpu => "CPU",
        wgpu::DeviceType::Other => "other",
    };
    AdapterSummary {
        index,
        name: info.name,
        kind,
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        backend: info.backend.to_string(),
        largest_binding: limits.max_storage_buffer_binding_size,
        largest_buffer: limits.max_buffer_size,
        most_bindings: limits.max_storage_buffers_per_shader_stage.min(limits.max_bindings_per_bind_group),
        usable: adapter.features().contains(NEEDED),
    }
}

/// Every adapter of this machine.
#[must_use]
pub fn adapters() -> Vec<AdapterSummary> {
    enumerate().iter().enumerate().map(|(i, a)| summary(i, a)).collect()
}

fn rank(s: &AdapterSummary) -> usize {
    let order = ["GPU", "integrated GPU", "virtual GPU", "other", "CPU"];
    order.iter().position(|k| *k == s.kind).unwrap_or(order.len())
}

/// Whether an adapter of so many is meant: by its number, or by a part of its name if there is no such number. Names have digits, too.
fn meant(wanted: &str, adapter: &AdapterSummary, count: usize) -> bool {
    match wanted.parse::<usize>() {
        Ok(number) if number < count => adapter.index == number,
        _ => adapter.name.to_lowercase().contains(&wanted.to_lowercase()),
    }
}

/// Bricks that an H100 has room for at once, or as many as take no longer.
const FEW_BRICKS: u64 = 450;

impl Gpu {
    /// Opens the adapter whose number or part of whose name is `wanted`; without it the best: a GPU before a CPU.
    ///
    /// # Errors
    /// If there is none, none of this name, or it cannot be used.
    pub fn open(wanted: Option<&str>) -> Result<Self, GpuError> {
        let found = enumerate();
        let mut listed: Vec<_> = found.iter().enumerate().map(|(i, a)| (summary(i, a), a)).collect();
        if listed.is_empty() {
            return Err(GpuError::NoAdapter);
        }
        let present = listed.iter().map(|(s, _)| format!("{} ({})", s.index, s.name)).collect::<Vec<_>>().join(", ");
        if let Some(wanted) = wanted {
            listed.retain(|(s, _)| meant(wanted, s, found.len()));
        }
        listed.sort_by_key(|(s, _)| (!s.usable, rank(s)));
        let Some((chosen, adapter)) = listed.into_iter().next() else {
            return Err(GpuError::NoSuchAdapter { wanted: wanted.unwrap_or_default().to_owned(), present });
        };
        if !chosen.usable {
            return Err(GpuError::Lacking { adapter: chosen.name, feature: "immediates (push constants)" });
        }
        let timestamps = adapter.features().contains(timing_features());
        let shares = adapter.features().contains(SHARING) && adapter.get_info().subgroup_min_size >= 4;
        let coherent = adapter.features().contains(COHERENT);
        let wide = adapter.features().contains(WIDE);
        let optional = [(timestamps, timing_features()), (shares, SHARING), (coherent, COHERENT), (wide, WIDE)];
        let required_features =
            optional.iter().filter(|(there, _)| *there).fold(NEEDED, |all, (_, feature)| all | *feature);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("squirm"),
            required_features,
            required_limits: adapter.limits(),
            memory_hints: wgpu::MemoryHints::Performance,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| GpuError::Open { adapter: chosen.name.clone(), message: e.to_string() })?;
        let failure = Arc::new(Mutex::new(Failure::default()));
        let note = failure.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            record(&note, |f| &mut f.first, error.to_string())
        }));
        let note = failure.clone();
        device.set_device_lost_callback(move |reason, message| {
            record(&note, |f| &mut f.lost, format!("device lost ({reason:?}): {message}"));
        });
        // Atomics and barriers are slow on a CPU.
        let cpu = chosen.kind == "CPU";
        let gathering = cpu.then_some(Gathering::Chains);
        let lanes = Lanes::One;
        let few_bricks = FEW_BRICKS;
        let mut gpu =
            Self { summary: chosen, lanes, gathering, few_bricks, wide, device, queue, timestamps, coherent, failure };
        if shares && !cpu && gpu.subgroups_are_neighbours() {
            gpu.lanes = Lanes::Four;
        }
        Ok(gpu)
    }

    /// What the driver has complained about since the last call.
    ///
    /// # Errors
    /// If it has.
    pub fn healthy(&self) -> Result<(), GpuError> {
        let failed = |f: &Failure| f.first.is_some() || f.lost.is_some();
        if !self.failure.lock().is_ok_and(|f| failed(&f)) {
            return Ok(());
        }
        // That a device is lost is told after what fails because of it.
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: Some(Duration::from_secs(1)) };
        let _ = self.device.poll(wait);
        let Failure { first, lost } = self.failure.lock().map(|mut f| std::mem::take(&mut *f)).unwrap_or_default();
        Err(GpuError::Lost(lost.or(first).unwrap_or_default()))
    }
}

fn record(failure: &Mutex<Failure>, slot: fn(&mut Failure) -> &mut Option<String>, message: String) {
    if let Ok(mut failure) = failure.lock() {
        slot(&mut failure).get_or_insert(message);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_means_one_adapter_whatever_digits_names_have() {
        let named = |(index, name): (usize, &str)| AdapterSummary {
            index,
            name: name.into(),
            kind: "GPU",
            driver: String::new(),
            backend: String::new(),
            largest_binding: 0,
            largest_buffer: 0,
            most_bindings: 0,
            usable: true,
        };
        let all: Vec<_> =
            ["NVIDIA H100 80GB", "NVIDIA H100 80GB", "llvmpipe"].into_iter().enumerate().map(named).collect();
        let found = |wanted| all.iter().filter(|a| meant(wanted, a, all.len())).map(|a| a.index).collect::<Vec<_>>();
        for (wanted, expected) in
            [("0", vec![0]), ("1", vec![1]), ("h100", vec![0, 1]), ("80", vec![0, 1]), ("LLVM", vec![2]), ("3", vec![])]
        {
            assert_eq!(found(wanted), expected, "{wanted}");
        }
    }
}
