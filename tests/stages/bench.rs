//! A stage's two forms side by side: the adapter's buffers decoded in f64, and the reference's scene begun from the same words.

use crate::rig;
use glam::{DMat3, DQuat, DVec3};
use squirm::buffers::SquirmerState;
use squirm::gpu::Session;
use squirm::graph::Plan;
use squirm::math::draws::normals;
use squirm::math::fixed::Scales;
use squirm::math::rng::{Draw, Purpose};
use squirm::params::Value;
use squirm::state::scene::{Load, Moments, Motion, Operator, Scene, WallShear};
use squirm::state::{Particle, Squirmer, State, System, packed};

/// Half a unit in the last place of a number near 1: the relative error of one f32 rounding.
pub const ROUNDING: f64 = 1.0 / 16_777_216.0;

/// Error of sines, cosines and of logarithms near 1 on adapters: 2^-20 or better where measured (Vulkan itself promises 2^-11
/// and 2^-21 only), and a few of them together.
pub const TRANSCENDENTAL: f64 = 1.0 / 262_144.0;

/// A parameter other than its default: stage, name, value.
pub type Change = (&'static str, &'static str, Value);

/// One run on the adapter and the scene of its reference.
pub struct Bench {
    pub plan: Plan,
    pub session: Session,
    pub scene: Scene,
    bound: Vec<String>,
}

impl Bench {
    /// Both begin with the words that the adapter was given.
    pub fn new(system: &System, state: &State, kinds: &[&str], changes: &[Change]) -> Self {
        let plan = rig::plan(system, kinds, changes);
        let session = rig::session(&plan, state);
        let mut bound = Vec::new();
        for stage in &plan.stages {
            let module = stage.entry.module().expect("a module");
            for entry_point in module.entry_points() {
                bound.extend(module.bindings(entry_point).iter().map(|b| b.name.clone()));
            }
        }
        let mut scene = Scene::default();
        scene.state.step = state.step;
        let mut bench = Self { plan, session, scene, bound };
        bench.adopt();
        bench
    }

    pub fn system(&self) -> &System {
        &self.plan.system
    }

    /// The stage at its place: on the adapter and by its reference.
    pub fn run(&mut self, kind: &str) {
        self.session.run_stage(kind, false).expect("the adapter runs it");
        let stage = self.plan.stages.iter().find(|s| s.entry.kind == kind).expect("a stage of the plan");
        (stage.entry.reference)(&stage.values, &self.plan.system, &mut self.scene);
    }

    /// What the stage does after the collision, in both forms.
    pub fn receive(&mut self, kind: &str) {
        self.session.run_stage(kind, true).expect("the adapter runs it");
        let stage = self.plan.stages.iter().find(|s| s.entry.kind == kind).expect("a stage of the plan");
        (stage.entry.reference_receive)(&stage.values, &self.plan.system, &mut self.scene);
    }

    /// The stages in turn, the scene taking over the adapter's results after each.
    pub fn run_all(&mut self, kinds: &[&str]) {
        for kind in kinds {
            self.session.run_stage(kind, false).expect("the adapter runs it");
        }
        self.adopt();
    }

    fn binds(&self, name: &str) -> bool {
        self.bound.iter().any(|b| b == name)
    }

    /// The scene becomes what the adapter has, so that the next stage is compared alone.
    pub fn adopt(&mut self) {
        self.scene.state = State { step: self.scene.state.step, ..self.state() };
        self.scene.motions = self.motions();
        self.scene.wall_impulses = self.wall_impulses();
        if self.binds("shift") {
            self.scene.shift = self.shift();
        }
        if self.binds("moments") {
            self.scene.moments = self.moments();
        }
        if self.binds("operators") {
            self.scene.operators = self.operators();
        }
        if self.binds("ghost_motion") {
            self.scene.ghost_motion = self.ghost_motion();
        }
        if self.binds("wall_shear") {
            let before = self.scene.state.step.wrapping_sub(1);
            self.scene.wall_shear = self.wall_shear(before);
            self.scene.wall_seen = self.wall_seen(before);
        }
        self.scene.loads = self.loads();
    }

    pub fn words(&self, name: &str) -> Vec<u32> {
        self.session.read(name).expect("a readable buffer")
    }

    pub fn floats(&self, name: &str) -> Vec<f64> {
        self.session.read::<f32>(name).expect("a readable buffer").into_iter().map(f64::from).collect()
    }

    pub fn faults(&self) -> u32 {
        self.session.faults().expect("readable faults")
    }

    pub fn state(&self) -> State {
        self.session.state().expect("a readable state")
    }

    fn squirmer_states(&self) -> Vec<SquirmerState> {
        let mut states = self.session.read::<SquirmerState>("squirmers").expect("readable squirmers");
        states.truncate(self.system().squirmer_count() as usize);
        states
    }

    fn motions(&self) -> Vec<Motion> {
        let motion = |s: SquirmerState| Motion {
            position: packed::unpack_position(&self.system().domain, s.position_before),
            orientation: DQuat::from_array(s.orientation_before.map(f64::from)).normalize(),
            drift: DVec3::from_array(s.drift.map(f64::from)),
            spin: DVec3::from_array(s.spin.map(f64::from)),
        };
        self.squirmer_states().into_iter().map(motion).collect()
    }

    /// Gives the squirmers poses at the beginning of the step, and mean velocities over it.
    pub fn set_motions(&mut self, motions: &[Motion]) {
        let mut states = self.squirmer_states();
        for (state, motion) in states.iter_mut().zip(motions) {
            #[allow(clippy::cast_possible_truncation)]
            let single = |v: DVec3| v.to_array().map(|c| c as f32);
            state.position_before = packed::pack_position(&self.system().domain, motion.position);
            #[allow(clippy::cast_possible_truncation)]
            let orientation = motion.orientation.to_array().map(|c| c as f32);
            state.orientation_before = orientation;
            (state.drift, state.spin) = (single(motion.drift), single(motion.spin));
        }
        self.session.write("squirmers", bytemuck::cast_slice(&states));
        self.adopt();
    }

    pub fn shift(&self) -> DVec3 {
        let words = self.words("shift");
        let period = self.system().domain.period();
        let turn = |axis: usize| f64::from(words[axis]) / 4_294_967_296.0 * f64::from(period[axis]);
        DVec3::new(turn(0), turn(1), turn(2))
    }

    pub fn moments(&self) -> Vec<Moments> {
        let scales = Scales::new(self.system().fluid.density, self.system().fluid.temperature);
        self.words("moments").chunks_exact(24).map(|w| decode_moments(&scales, w)).collect()
    }

    pub fn operators(&self) -> Vec<Operator> {
        let operator = |w: &[f64]| Operator {
            a: DMat3::from_cols(DVec3::from_slice(w), DVec3::from_slice(&w[4..]), DVec3::from_slice(&w[8..]))
                .transpose(),
            w: DVec3::new(w[3], w[7], w[11]),
            b: DVec3::from_slice(&w[12..]),
        };
        self.floats("operators").chunks_exact(16).map(operator).collect()
    }

    pub fn ghost_motion(&self) -> Vec<(DVec3, DVec3)> {
        let motion = |w: &[f64]| (DVec3::from_slice(w), DVec3::from_slice(&w[4..]));
        let count = self.system().squirmer_count() as usize;
        self.floats("ghost_motion").chunks_exact(8).take(count).map(motion).collect()
    }

    /// Of every patch that the buffer has room for: the averages that a step left; the shear that follows from them is in no buffer.
    pub fn wall_shear(&self, step: u64) -> Vec<WallShear> {
        let of_step = |w: &[f64]| w[3 * (step % 2) as usize..][..3].to_vec();
        let patch = |w: Vec<f64>| WallShear { moment: DVec3::new(w[0], 0.0, w[1]), weight: w[2], shear: DVec3::ZERO };
        self.floats("wall_shear").chunks_exact(6).map(of_step).map(patch).collect()
    }

    /// The same sums of one step.
    pub fn wall_seen(&self, step: u64) -> Vec<(DVec3, f64)> {
        let fluid = &self.system().fluid;
        let scales = Scales::new(fluid.density, fluid.temperature);
        let wide = |w: &[u32]| (i64::from(w[1] as i32) << 32 | i64::from(w[0])) as f64;
        let patch = |w: &[u32]| {
            let w = &w[6 * (step % 2) as usize..][..6];
            let moment = DVec3::new(wide(w), 0.0, wide(&w[2..])) * 64.0 / scales.mixed;
            (moment, wide(&w[4..]) * 32.0 / scales.second)
        };
        self.words("wall_sums").chunks_exact(12).map(patch).collect()
    }

    /// Goes on at the next step.
    pub fn next_step(&mut self) {
        self.scene.state.step += 1;
        self.session.go_to(self.scene.state.step);
    }

    /// Momentum and angular momentum that the fluid handed to each squirmer in this step.
    pub fn loads(&self) -> Vec<Load> {
        let dt = self.system().run.dt;
        let load = |w: &[f64]| Load { force: DVec3::from_slice(w) * dt, torque: DVec3::from_slice(&w[4..]) * dt };
        let count = self.system().squirmer_count() as usize;
        self.floats("fluid_force").chunks_exact(8).take(count).map(load).collect()
    }

    /// Momentum that the low and the high wall received.
    pub fn wall_impulses(&self) -> [DVec3; 2] {
        packed::wall_impulses(self.system(), &self.words("wall_impulses"))
    }
}

#[allow(clippy::cast_possible_wrap)]
fn decode_moments(scales: &Scales, words: &[u32]) -> Moments {
    let vector = |from: usize| DVec3::from_array([0, 1, 2].map(|k| f64::from(words[from + k] as i32)));
    let (diagonal, mixed) = (vector(9) / scales.second, vector(12) / scales.second);
    let rows = [15, 18, 21].map(|from| vector(from) / scales.mixed);
    Moments {
        count: f64::from(words[0] % (1 << scales.coarse_bit)),
        ghosts: f64::from(words[5]),
        v: vector(1) / scales.velocity,
        energy: f64::from(words[4]) / scales.energy,
        x: vector(6) / scales.position,
        xx: DMat3::from_cols(
            DVec3::new(diagonal.x, mixed.x, mixed.y),
            DVec3::new(mixed.x, diagonal.y, mixed.z),
            DVec3::new(mixed.y, mixed.z, diagonal.z),
        ),
        xv: DMat3::from_cols(rows[0], rows[1], rows[2]).transpose(),
    }
}

/// Largest error of the sums of one cell against `wanted`: each contribution is rounded to a whole unit (half a unit), after at
/// most four f32 roundings of the summand, whose sum Cauchy and Schwarz bound with |x| <= 1/2; `speed` is the error of each
/// velocity and `place` that of each position. In units of what is allowed: at most 1.
pub fn excess(system: &System, found: &Moments, wanted: &Moments, speed: f64, place: f64) -> f64 {
    let scales = Scales::new(system.fluid.density, system.fluid.temperature);
    let (n, q) = (wanted.count, wanted.energy);
    let all = (n * q).sqrt();
    let allowed = |scale: f64, sum: f64, inexact: f64| 1e-12 + 0.5 * n / scale + 4.0 * ROUNDING * sum + inexact;
    let largest = |m: DMat3| m.to_cols_array().into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    [
        (found.count - n).abs() / 0.5,
        (found.ghosts - wanted.ghosts).abs() / 0.5,
        (found.v - wanted.v).abs().max_element() / allowed(scales.velocity, all, n * speed),
        (found.energy - q).abs() / allowed(scales.energy, q, 2.0 * all * speed + n * speed * speed),
        (found.x - wanted.x).abs().max_element() / allowed(scales.position, 0.5 * n, n * place),
        largest(found.xx - wanted.xx) / allowed(scales.second, 0.25 * n, n * place),
        largest(found.xv - wanted.xv) / allowed(scales.mixed, 0.5 * all, 0.5 * n * speed + all * place),
    ]
    .into_iter()
    .fold(0.0, f64::max)
}

/// Reproducible uniform numbers and normals: the i-th of set `set`.
pub fn random(set: u32, i: u32) -> (DVec3, DVec3) {
    let draw = Draw::new(99, Purpose::Start, 0);
    let u = draw.uniforms(set, i, 0);
    (DVec3::new(u[0], u[1], u[2]), normals(draw.uniforms(set, i, 1)))
}

/// `count` particles uniform in the box.
pub fn gas(system: &System, set: u32, count: u32) -> Vec<Particle> {
    let size = DVec3::from_array(system.domain.size.map(f64::from));
    let speed = system.fluid.temperature.sqrt();
    let particle = |i| {
        let (u, n) = random(set, i);
        Particle { position: u * size, velocity: speed * n }
    };
    (0..count).map(particle).collect()
}

/// A squirmer of the first species at rest with its axis along z.
pub fn squirmer(position: DVec3) -> Squirmer {
    Squirmer {
        species: 0,
        position,
        orientation: DQuat::IDENTITY,
        velocity: DVec3::ZERO,
        angular_momentum: DVec3::ZERO,
    }
}

/// From the centre of a squirmer in units of its semi-axes: 1 on the surface.
pub fn depth(system: &System, squirmer: &Squirmer, point: DVec3) -> f64 {
    let shape = &system.species[squirmer.species].semi_axes;
    let arm = squirm::state::start::nearest_image(&system.domain, point - squirmer.position);
    (squirmer.orientation.inverse() * arm / DVec3::new(shape.across, shape.across, shape.along)).length()
}

pub fn state(particles: Vec<Particle>, squirmers: Vec<Squirmer>) -> State {
    State { step: 3, particles, squirmers }
}

pub fn momentum(particles: &[Particle]) -> DVec3 {
    particles.iter().map(|p| p.velocity).sum()
}

pub fn mass(system: &System, squirmer: &Squirmer) -> f64 {
    f64::from(system.species[squirmer.species].ghosts(&system.fluid))
}

/// The median and the largest of some numbers.
pub fn median_and_largest(mut values: Vec<f64>) -> (f64, f64) {
    assert!(values.iter().all(|v| v.is_finite()), "{values:?}");
    values.sort_by(f64::total_cmp);
    (values[values.len() / 2], *values.last().expect("some values"))
}
