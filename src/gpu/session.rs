//! A run's buffers and kernels on an opened adapter, and the encoding of steps.

use super::kernel::{Buffers, Kernel};
use super::{Gpu, GpuError};
use crate::buffers::{Buffer, CATALOGUE, Life, Now, Sizes, SquirmerState};
use crate::graph::Plan;
use crate::stages::Phase;
use crate::state::{State, System, packed};
use std::collections::{HashMap, HashSet};

/// The kernels of one stage.
pub(super) struct StageKernels {
    kind: &'static str,
    every: u64,
    repetitions: u32,
    place: Vec<Kernel>,
    receive: Vec<Kernel>,
}

/// A run on a GPU.
pub struct Session {
    pub(super) gpu: Gpu,
    pub(super) system: System,
    pub(super) sizes: Sizes,
    pub(super) buffers: Buffers,
    stages: Vec<StageKernels>,
    timing: Option<Timing>,
    step: u64,
}

/// GPU time of one step, stage by stage.
#[derive(Debug, Clone, PartialEq)]
pub struct StepTime {
    /// Stage kinds in list order with their nanoseconds.
    pub stages: Vec<(&'static str, f64)>,
}

struct Timing {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    marks: u32,
}

fn storage(gpu: &Gpu, name: &str, bytes: u64, uniform: bool) -> wgpu::Buffer {
    let kind = if uniform { wgpu::BufferUsages::UNIFORM } else { wgpu::BufferUsages::STORAGE };
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(name),
        size: bytes,
        usage: kind | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}

impl Session {
    /// Builds buffers and kernels for a plan and uploads the state.
    ///
    /// # Errors
    /// If a buffer is too large, memory runs out, or a shader is not accepted.
    pub fn new(gpu: &Gpu, plan: &Plan, state: &State) -> Result<Self, GpuError> {
        Self::with_room(gpu, plan, state, 0)
    }

    /// The same with `room` bytes at the end of every buffer that no kernel may touch: what tests watch. Writes beyond a buffer's
    /// end are dropped without a word, so that a catalogue entry shorter than its use would go unnoticed.
    ///
    /// # Errors
    /// See [`Session::new`].
    pub fn with_room(gpu: &Gpu, plan: &Plan, state: &State, room: u64) -> Result<Self, GpuError> {
        let sizes = packed::sizes(&plan.system, state.particles.len() as u64);
        let modules = plan.stages.iter().map(|s| s.entry.module()).collect::<Result<Vec<_>, _>>()?;
        let mut used: HashSet<String> = modules
            .iter()
            .flat_map(|m| {
                m.entry_points().flat_map(|e| m.bindings(e).iter().map(|b| b.name.clone())).collect::<Vec<_>>()
            })
            .collect();
        // A snapshot needs these whatever the stages use.
        for name in [
            "positions",
            "velocities",
            "squirmers",
            "species",
            "moments",
            "faults",
            "fluid_force",
            "steric",
            "wall_impulses",
        ] {
            used.insert(name.to_owned());
        }
        let buffers = create_buffers(gpu, &sizes, room, CATALOGUE.iter().filter(|b| used.contains(b.name)))?;
        let mut session = Self {
            gpu: gpu.clone(),
            system: plan.system.clone(),
            sizes,
            buffers,
            stages: Vec::new(),
            timing: None,
            step: state.step,
        };
        session.upload(state);
        for (stage, module) in plan.stages.iter().zip(&modules) {
            let compiled = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(stage.entry.kind),
                source: wgpu::ShaderSource::Wgsl(module.text.as_str().into()),
            });
            let bytes = (stage.entry.uniform)(&stage.values, &plan.system);
            let settings = storage(gpu, "settings", (bytes.len() as u64).next_multiple_of(16), true);
            gpu.queue.write_buffer(&settings, 0, &bytes);
            let kernels = |phases: &[Phase]| {
                phases
                    .iter()
                    .map(|p| {
                        Kernel::new(gpu, &compiled, module, (p.entry, p.over), (&session.buffers, &settings), &sizes)
                    })
                    .collect::<Result<Vec<_>, _>>()
            };
            let (place, receive) = (kernels(stage.entry.phases)?, kernels(stage.entry.receive)?);
            session.stages.push(StageKernels {
                kind: stage.entry.kind,
                every: (stage.entry.every)(&stage.values),
                repetitions: (stage.entry.repetitions)(&stage.values),
                place,
                receive,
            });
        }
        session.timing = session.gpu.timestamps.then(|| Timing::new(&session.gpu, &session.stages));
        gpu.healthy()?;
        Ok(session)
    }

    fn upload(&self, state: &State) {
        let (positions, velocities) = packed::pack_particles(&self.system.domain, &state.particles);
        self.write("positions", bytemuck::cast_slice(&positions));
        self.write("velocities", bytemuck::cast_slice(&velocities));
        self.write("squirmers", bytemuck::cast_slice(&packed::pack_squirmers(&self.system, &state.squirmers)));
        self.write("species", bytemuck::cast_slice(&packed::pack_species(&self.system)));
        let uniform = packed::system_uniform(&self.system, self.sizes.particles);
        self.write("system", bytemuck::bytes_of(&uniform));
    }

    /// Name of the adapter.
    #[must_use]
    pub fn adapter(&self) -> String {
        self.gpu.summary.name.clone()
    }

    /// Its driver.
    #[must_use]
    pub fn driver(&self) -> String {
        self.gpu.summary.driver.clone()
    }

    /// The physical system.
    #[must_use]
    pub fn system(&self) -> &System {
        &self.system
    }

    /// Fluid particles.
    #[must_use]
    pub fn particles(&self) -> u64 {
        self.sizes.particles
    }

    /// Lets finished copies be noticed, without waiting.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn poll(&self) -> Result<(), GpuError> {
        self.gpu.device.poll(wgpu::PollType::Poll).map_err(|e| GpuError::Lost(e.to_string()))?;
        self.gpu.healthy()
    }

    /// Names of the buffers that this run has, and the bytes that the catalogue gives them.
    pub fn buffers(&self) -> impl Iterator<Item = (&'static str, u64)> + '_ {
        CATALOGUE.iter().filter(|b| self.buffers.contains_key(b.name)).map(|b| (b.name, self.sizes.bytes(b)))
    }

    /// Steps done so far.
    #[must_use]
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Bytes of all buffers.
    #[must_use]
    pub fn memory(&self) -> u64 {
        self.buffers.values().map(wgpu::Buffer::size).sum()
    }

    /// Encodes and submits `steps` steps; does not wait for them. With `timed` the first one's stages are timed.
    pub fn advance(&mut self, steps: u64, timed: bool) -> Submission {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            for k in 0..steps {
                let timing = if timed && k == 0 { self.timing.as_ref() } else { None };
                self.encode_step(&mut pass, self.step + k, timing);
            }
        }
        let times = if timed { self.timing.as_ref().map(|t| t.resolve(&self.gpu, &mut encoder)) } else { None };
        self.step += steps;
        let index = self.gpu.queue.submit([encoder.finish()]);
        let times = times.map(super::measure::Readback::map);
        Submission { index, times }
    }

    fn encode_step(&self, pass: &mut wgpu::ComputePass<'_>, step: u64, timing: Option<&Timing>) {
        let mut mark = 0;
        let mut stamp = |pass: &mut wgpu::ComputePass<'_>| {
            if let Some(t) = timing {
                pass.write_timestamp(&t.queries, mark);
                mark += 1;
            }
        };
        stamp(pass);
        for stage in &self.stages {
            if step.is_multiple_of(stage.every) {
                for repetition in 0..stage.repetitions {
                    for kernel in &stage.place {
                        kernel.dispatch(pass, now(step, repetition));
                    }
                }
            }
            stamp(pass);
            if stage.kind == "apply" {
                for owner in &self.stages {
                    for kernel in &owner.receive {
                        kernel.dispatch(pass, now(step, 0));
                    }
                    stamp(pass);
                }
            }
        }
    }

    /// Runs one stage alone at the present step: what tests do.
    ///
    /// # Errors
    /// If the GPU refuses.
    pub fn run_stage(&self, kind: &str, receive: bool) -> Result<(), GpuError> {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            for stage in self.stages.iter().filter(|s| s.kind == kind) {
                let repetitions = if receive { 1 } else { stage.repetitions };
                for repetition in 0..repetitions {
                    for kernel in if receive { &stage.receive } else { &stage.place } {
                        kernel.dispatch(&mut pass, now(self.step, repetition));
                    }
                }
            }
        }
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.healthy()
    }

    /// Waits until everything submitted has been done.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| GpuError::Lost(e.to_string()))?;
        self.gpu.healthy()
    }

    /// Waits until one submission has been done.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn wait_for(&self, submission: &Submission) -> Result<(), GpuError> {
        let wait = wgpu::PollType::Wait { submission_index: Some(submission.index.clone()), timeout: None };
        self.gpu.device.poll(wait).map_err(|e| GpuError::Lost(e.to_string()))?;
        self.gpu.healthy()
    }

    /// The stages' times of a timed submission that has been done.
    #[must_use]
    pub fn times(&self, submission: &Submission) -> Option<StepTime> {
        let bytes = submission.times.as_ref()?.take()?;
        let stamps: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes);
        let period = f64::from(self.gpu.queue.get_timestamp_period());
        let mut stages: Vec<(&'static str, f64)> = self.stages.iter().map(|s| (s.kind, 0.0)).collect();
        let mut spans = stamps.windows(2).map(|w| w[1].saturating_sub(w[0]));
        #[allow(clippy::cast_precision_loss)]
        for i in 0..self.stages.len() {
            stages[i].1 += spans.next()? as f64 * period;
            if self.stages[i].kind == "apply" {
                for owner in &mut stages {
                    owner.1 += spans.next()? as f64 * period;
                }
            }
        }
        Some(StepTime { stages })
    }

    /// Overwrites the beginning of a buffer.
    pub fn write(&self, name: &str, bytes: &[u8]) {
        if !bytes.is_empty() {
            self.gpu.queue.write_buffer(&self.buffers[name], 0, bytes);
        }
    }

    /// The whole content of a buffer as 32-bit words; waits for the GPU.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn read<T: bytemuck::Pod>(&self, name: &str) -> Result<Vec<T>, GpuError> {
        let source = &self.buffers[name];
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let staging = super::measure::staging(&self.gpu, source.size());
        encoder.copy_buffer_to_buffer(source, 0, &staging, 0, source.size());
        self.gpu.queue.submit([encoder.finish()]);
        let readback = super::measure::Readback::map(staging);
        self.wait()?;
        // Another thread's poll may be the one that runs the callback.
        while !readback.settled() {
            self.poll()?;
        }
        let bytes = readback.take().ok_or_else(|| GpuError::Lost(format!("`{name}` could not be read back")))?;
        let whole = bytes.len() / size_of::<T>() * size_of::<T>();
        Ok(bytemuck::pod_collect_to_vec(&bytes[..whole]))
    }

    /// Positions, velocities and squirmers as the GPU has them; waits for it.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn raw(&self) -> Result<packed::Raw, GpuError> {
        let mut positions = self.read::<u32>("positions")?;
        let mut velocities = self.read::<f32>("velocities")?;
        let mut squirmers = self.read::<SquirmerState>("squirmers")?;
        // Buffers are never empty, and their length is rounded up.
        let particles = usize::try_from(self.sizes.particles).expect("particles fit in memory");
        positions.truncate(3 * particles);
        velocities.truncate(3 * particles);
        squirmers.truncate(self.system.squirmer_count() as usize);
        Ok(packed::Raw { step: self.step, positions, velocities, squirmers })
    }

    /// The state on the host; waits for the GPU.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn state(&self) -> Result<State, GpuError> {
        Ok(self.raw()?.state(&self.system))
    }

    /// The flags of `faults`; waits for the GPU.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn faults(&self) -> Result<u32, GpuError> {
        Ok(self.read::<u32>("faults")?[0])
    }
}

/// A batch of steps that the GPU is working on.
pub struct Submission {
    index: wgpu::SubmissionIndex,
    times: Option<super::measure::Readback>,
}

fn now(step: u64, repetition: u32) -> Now {
    #[allow(clippy::cast_possible_truncation)]
    Now { step_low: step as u32, step_high: (step >> 32) as u32, repetition, pad: 0 }
}

impl Timing {
    fn new(gpu: &Gpu, stages: &[StageKernels]) -> Self {
        let applies = stages.iter().filter(|s| s.kind == "apply").count();
        let marks = u32::try_from(1 + stages.len() * (1 + applies)).expect("stages are few");
        let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("stage times"),
            ty: wgpu::QueryType::Timestamp,
            count: marks,
        });
        let resolved = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("stage times"),
            size: u64::from(marks) * 8,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Self { queries, resolved, marks }
    }

    fn resolve(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) -> wgpu::Buffer {
        encoder.resolve_query_set(&self.queries, 0..self.marks, &self.resolved, 0);
        let staging = super::measure::staging(gpu, self.resolved.size());
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &staging, 0, self.resolved.size());
        staging
    }
}

/// Creates buffers, refusing what the adapter cannot bind or hold.
pub(super) fn create_buffers<'a>(
    gpu: &Gpu,
    sizes: &Sizes,
    room: u64,
    wanted: impl Iterator<Item = &'a Buffer>,
) -> Result<Buffers, GpuError> {
    let wanted: Vec<&Buffer> = wanted.filter(|b| b.name != "settings").collect();
    let limit = gpu.summary.largest_binding;
    let adapter = || gpu.summary.name.clone();
    for buffer in &wanted {
        let bytes = sizes.bytes(buffer) + room;
        if bytes > limit {
            let name = CATALOGUE.iter().find(|b| b.name == buffer.name).map_or("buffer", |b| b.name);
            return Err(GpuError::TooLarge { buffer: name, bytes, limit, adapter: adapter() });
        }
    }
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let mut buffers: Buffers = HashMap::new();
    for buffer in &wanted {
        let uniform = buffer.life == Life::Setting && buffer.name == "system";
        buffers
            .insert(buffer.name, storage(gpu, buffer.name, (sizes.bytes(buffer) + room).next_multiple_of(16), uniform));
    }
    if pollster::block_on(scope.pop()).is_some() {
        let bytes = wanted.iter().map(|b| sizes.bytes(b)).sum();
        return Err(GpuError::OutOfMemory { bytes, adapter: adapter() });
    }
    gpu.healthy()?;
    Ok(buffers)
}
