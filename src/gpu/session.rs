//! A run's buffers and kernels on an opened adapter, and the encoding of steps.

use super::buffers::{Buffers, View};
use super::demand::Demand;
use super::fused::Fused;
use super::loose::Loose;
use super::{Gpu, GpuError};
use crate::buffers::{CATALOGUE, OVERLAYS, Sizes, SquirmerState};
use crate::graph::Plan;
use crate::graph::fused::Occasion;
use crate::state::{Particle, State, System, packed};

/// A run on a GPU.
pub struct Session {
    pub(super) gpu: Gpu,
    pub(super) system: System,
    pub(super) sizes: Sizes,
    pub(super) buffers: Buffers,
    steps: Steps,
    timing: Option<Timing>,
    step: u64,
}

/// How stages become kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Form {
    /// Every stage its own kernels.
    #[default]
    Loose,
    /// Neighbouring stages share kernels. The state is the same in every bit whenever steps have been submitted and done.
    Fused,
}

enum Steps {
    Loose(Loose),
    Fused(Fused),
}

/// GPU time of one step, stage by stage.
#[derive(Debug, Clone, PartialEq)]
pub struct StepTime {
    /// Kinds of stages, or of those that share a kernel, in the order in which they first run, with their nanoseconds.
    pub stages: Vec<(String, f64)>,
}

struct Timing {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    marks: u32,
}

impl Session {
    /// Builds buffers and kernels for a plan and uploads the state.
    ///
    /// # Errors
    /// If a buffer is too large, memory runs out, or a shader is not accepted.
    pub fn new(gpu: &Gpu, plan: &Plan, state: &State) -> Result<Self, GpuError> {
        Self::with_room(gpu, plan, state, (Form::Loose, 0))
    }

    /// The same in the form that is asked for.
    ///
    /// # Errors
    /// See [`Session::new`].
    pub fn formed(gpu: &Gpu, plan: &Plan, state: &State, form: Form) -> Result<Self, GpuError> {
        Self::with_room(gpu, plan, state, (form, 0))
    }

    /// The same with `room` bytes at the end of every buffer that no kernel may touch: what tests watch. Writes beyond a buffer's
    /// end are dropped without a word, so that a catalogue entry shorter than its use would go unnoticed. No buffer then lies in another's memory.
    ///
    /// # Errors
    /// See [`Session::new`].
    pub fn with_room(gpu: &Gpu, plan: &Plan, state: &State, (form, room): (Form, u64)) -> Result<Self, GpuError> {
        let (particles, velocities_yz) = packed::pack_particles(&plan.system.domain, &state.particles);
        let session = Self::empty(gpu, plan, (&particles, state.step), (form, room))?;
        session.write("particles", bytemuck::cast_slice(&particles));
        session.write("velocities_yz", bytemuck::cast_slice(&velocities_yz));
        session.write("squirmers", bytemuck::cast_slice(&packed::pack_squirmers(&session.system, &state.squirmers)));
        gpu.healthy()?;
        Ok(session)
    }

    /// Buffers and kernels for these particles at a step, with the settings in place, and all else zero.
    pub(super) fn empty(
        gpu: &Gpu,
        plan: &Plan,
        (particles, step): (&[[u32; 4]], u64),
        (form, room): (Form, u64),
    ) -> Result<Self, GpuError> {
        let count = particles.len() as u64;
        let demand = Demand::new(gpu, plan, count, form)?;
        let used = demand.used();
        let mut sizes = demand.sizes;
        if sizes.room > 0 {
            sizes.room = packed::brick_room_for(&plan.system, particles.iter().map(|p| [p[0], p[1], p[2]]));
        }
        let buffers = Buffers::create(gpu, &sizes, room, CATALOGUE.iter().filter(|b| used.contains(b.name)))?;
        let steps = match demand.fused {
            Some(ordered) => Steps::Fused(Fused::new(gpu, plan, ordered, &buffers, &sizes)?),
            None => Steps::Loose(Loose::new(gpu, plan, &demand.loose, &buffers, &sizes)?),
        };
        let marks = match &steps {
            Steps::Loose(loose) => loose.labels().len(),
            Steps::Fused(fused) => fused.longest(),
        };
        let session = Self {
            gpu: gpu.clone(),
            system: plan.system.clone(),
            sizes,
            buffers,
            steps,
            timing: gpu.timestamps.then(|| Timing::new(gpu, 1 + marks)),
            step,
        };
        session.write("species", bytemuck::cast_slice(&packed::pack_species(&session.system)));
        let uniform = packed::system_uniform(&session.system, &session.sizes);
        session.write("system", bytemuck::bytes_of(&uniform));
        Ok(session)
    }

    /// Replaces all particles, as many as there are, by others.
    pub fn write_particles(&self, particles: &[Particle]) {
        let (particles, velocities_yz) = packed::pack_particles(&self.system.domain, particles);
        self.write("particles", bytemuck::cast_slice(&particles));
        self.write("velocities_yz", bytemuck::cast_slice(&velocities_yz));
    }

    /// Elements of every extent.
    #[must_use]
    pub fn sizes(&self) -> &Sizes {
        &self.sizes
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
        CATALOGUE.iter().filter(|b| self.buffers.has(b.name)).map(|b| (b.name, self.sizes.bytes(b)))
    }

    /// Steps done so far.
    #[must_use]
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Bytes of all buffers.
    #[must_use]
    pub fn memory(&self) -> u64 {
        self.buffers.all_bytes()
    }

    /// Encodes and submits `steps` steps; does not wait for them. With `watched` faults are brought back, and one step is timed: the first,
    /// or in the fused form the second, if there is one, since it is like those that follow.
    pub fn advance(&mut self, steps: u64, watched: bool) -> Submission {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let (first, one) = match self.steps {
            Steps::Loose(_) => (self.step, steps > 0),
            Steps::Fused(_) => (self.step + 1, steps > 1),
        };
        let timing = self.timing.as_ref().filter(|_| watched && one);
        if let Steps::Fused(fused) = &self.steps {
            fused.empty_lists(&self.gpu, &self.buffers);
        }
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            for step in self.step..self.step + steps {
                self.encode_step(&mut pass, step, timing.filter(|_| step == first));
            }
            if let (Steps::Fused(fused), 1..) = (&self.steps, steps) {
                fused.encode(&mut pass, (Occasion::Last, self.step + steps - 1, steps), &mut |_| {});
            }
        }
        self.bring_home(&mut encoder, steps);
        let labels = timing.map(|_| match &self.steps {
            Steps::Loose(loose) => loose.labels(),
            Steps::Fused(fused) => fused.labels(Occasion::Next, first),
        });
        let times = timing.map(|t| t.resolve(&self.gpu, &mut encoder));
        let faults = watched.then(|| {
            let [faults] = self.buffers.of("faults") else { unreachable!("it has eight words") };
            let staging = super::measure::staging(&self.gpu, faults.bytes());
            faults.copy(&mut encoder, (&staging, 0));
            staging
        });
        self.step += steps;
        let index = self.gpu.queue.submit([encoder.finish()]);
        let times = times.map(super::measure::Readback::map);
        Submission { index, times: times.zip(labels), faults: faults.map(super::measure::Readback::map) }
    }

    /// After an even number of steps particles come back to where they are not looked for: they left the bricks that lie there.
    fn bring_home(&self, encoder: &mut wgpu::CommandEncoder, steps: u64) {
        let [home, other] = &OVERLAYS;
        for (to, from) in home.guests.iter().zip(other.guests) {
            if steps > 0 && steps.is_multiple_of(2) && self.buffers.has(from) {
                self.buffers.copy(encoder, from, to);
            }
        }
    }

    fn encode_step(&self, pass: &mut wgpu::ComputePass<'_>, step: u64, timing: Option<&Timing>) {
        let mut mark = 0;
        let mut stamp = |pass: &mut wgpu::ComputePass<'_>| {
            if let Some(t) = timing {
                pass.write_timestamp(&t.queries, mark);
                mark += 1;
            }
        };
        match &self.steps {
            Steps::Loose(loose) => loose.encode(pass, step, &mut stamp),
            Steps::Fused(fused) => {
                let occasion = if step == self.step { Occasion::First } else { Occasion::Next };
                fused.encode(pass, (occasion, step, step - self.step), &mut stamp);
            }
        }
    }

    /// Runs one stage alone at the present step: what tests do. Only the loose form has such.
    ///
    /// # Errors
    /// If the GPU refuses.
    pub fn run_stage(&self, kind: &str, receive: bool) -> Result<(), GpuError> {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if let Steps::Loose(loose) = &self.steps {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            loose.encode_stage(&mut pass, kind, receive, self.step);
        }
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.healthy()
    }

    /// Goes on at another step: what tests of single stages do.
    pub fn go_to(&mut self, step: u64) {
        self.step = step;
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
    #[allow(clippy::cast_precision_loss)]
    pub fn times(&self, submission: &Submission) -> Option<StepTime> {
        let (readback, labels) = submission.times.as_ref()?;
        let stamps: Vec<u64> = bytemuck::pod_collect_to_vec(&readback.take()?);
        let period = f64::from(self.gpu.queue.get_timestamp_period());
        let mut stages: Vec<(String, f64)> = Vec::new();
        for (label, span) in labels.iter().zip(stamps.windows(2)) {
            let time = span[1].saturating_sub(span[0]) as f64 * period;
            match stages.iter_mut().find(|(known, _)| known == label) {
                Some((_, sum)) => *sum += time,
                None => stages.push((label.clone(), time)),
            }
        }
        Some(StepTime { stages })
    }

    /// What `faults` held after a submission that was watched and has been done.
    ///
    /// # Errors
    /// If it was not read back.
    pub fn found(&self, submission: &Submission) -> Result<Vec<u32>, GpuError> {
        let bytes = submission.faults.as_ref().and_then(super::measure::Readback::take);
        bytes
            .map(|b| bytemuck::pod_collect_to_vec(&b))
            .ok_or_else(|| GpuError::Lost("`faults` was not read back".into()))
    }

    /// Overwrites the beginning of a buffer.
    pub fn write(&self, name: &str, bytes: &[u8]) {
        self.write_at(name, 0, bytes);
    }

    /// Overwrites a part of a buffer that begins so many bytes behind its start; both are multiples of 4.
    pub fn write_at(&self, name: &str, offset: u64, bytes: &[u8]) {
        if !bytes.is_empty() {
            self.buffers.write(&self.gpu, name, offset, bytes);
        }
    }

    /// The whole content of a buffer as 32-bit words; waits for the GPU.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn read<T: bytemuck::Pod>(&self, name: &str) -> Result<Vec<T>, GpuError> {
        let mut bytes = Vec::new();
        for part in self.buffers.of(name) {
            let content = self.part(part)?;
            bytes.extend(content.ok_or_else(|| GpuError::Lost(format!("`{name}` could not be read back")))?);
        }
        let whole = bytes.len() / size_of::<T>() * size_of::<T>();
        Ok(bytemuck::pod_collect_to_vec(&bytes[..whole]))
    }

    /// The bytes of a buffer, unless they cannot be had; waits for the GPU.
    fn part(&self, source: &View) -> Result<Option<Vec<u8>>, GpuError> {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let staging = super::measure::staging(&self.gpu, source.bytes());
        source.copy(&mut encoder, (&staging, 0));
        self.gpu.queue.submit([encoder.finish()]);
        let readback = super::measure::Readback::map(staging);
        self.wait()?;
        // Another thread's poll may be the one that runs the callback.
        while !readback.settled() {
            self.poll()?;
        }
        Ok(readback.take())
    }

    /// Positions, velocities and squirmers as the GPU has them; waits for it.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn raw(&self) -> Result<packed::Raw, GpuError> {
        let mut particles = self.read::<[u32; 4]>("particles")?;
        let mut velocities_yz = self.read::<[f32; 2]>("velocities_yz")?;
        let mut squirmers = self.read::<SquirmerState>("squirmers")?;
        // Buffers are never empty, and their length is rounded up.
        let count = usize::try_from(self.sizes.particles).expect("particles fit in memory");
        particles.truncate(count);
        velocities_yz.truncate(count);
        squirmers.truncate(self.system.squirmer_count() as usize);
        Ok(packed::Raw::new(self.step, &particles, &velocities_yz, squirmers))
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
    times: Option<(super::measure::Readback, Vec<String>)>,
    faults: Option<super::measure::Readback>,
}

impl Timing {
    fn new(gpu: &Gpu, marks: usize) -> Self {
        let marks = u32::try_from(marks).expect("stages are few");
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
