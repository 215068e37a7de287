//! The shaders' random numbers are the host's, bit for bit: a kernel that writes them where positions and velocities belong.

use crate::rig;
use squirm::buffers::Extent;
use squirm::graph::{Checkpoints, Plan, PlannedStage};
use squirm::math::rng::{Draw, Purpose};
use squirm::params::{Params, Values};
use squirm::stages::apply::{Apply, ApplySettings};
use squirm::stages::{Entry, Phase, Stage};
use squirm::state::scene::Scene;
use squirm::state::{State, System};

struct Dice;

static DICE: Entry = Entry::of::<Dice>();

impl Stage for Dice {
    const KIND: &'static str = "dice";
    const WGSL: &'static str = "
//!include dispatch
//!include rng
//!include particles-store
@group(0) @binding(0) var<uniform> system: SystemUniform;
@group(0) @binding(1) var<storage, read_write> particles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> velocities_yz: array<vec2<f32>>;
var<immediate> now: Now;

@compute @workgroup_size(WORKGROUP)
fn throw_dice(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = invocation(group, groups, lane);
    if i >= system.particle_count {
        return;
    }
    let key = vec4<u32>(system.seed_low, system.seed_high, PURPOSE_WALL_GHOST, now.step_high);
    var words = threefry(vec4<u32>(now.step_low, i, 5u, 1u), key);
    var u = uniforms(PURPOSE_WALL_GHOST, i, 5u, 1u);
    let three = vec3<u32>(i % 4u, (i + 1u) % 4u, (i + 2u) % 4u);
    let position = vec3<u32>(words[three.x], words[three.y], words[three.z]);
    store_particle(i, Particle(position, vec3<f32>(u[three.x], u[three.y], u[three.z])));
}
";
    const PHASES: &'static [Phase] = &[Phase { entry: "throw_dice", over: Extent::Particles }];
    type Params = Apply;
    type Uniform = ApplySettings;

    fn uniform(_: &Apply, _: &System) -> ApplySettings {
        ApplySettings::default()
    }

    fn reference(_: &Apply, _: &System, _: &mut Scene) {}
}

#[test]
fn random_numbers_are_the_hosts_bit_for_bit() {
    let mut system = rig::system([4, 4, 4]);
    system.run.seed = 0x1234_5678_9abc_def0;
    for step in [0, 9, (7 << 32) + 12] {
        let state = State { step, ..rig::fluid(&system, 5000) };
        let stages = vec![PlannedStage { entry: &DICE, values: Values::defaults(&Apply::fields()) }];
        let (name, outputs) = ("dice".into(), Vec::new());
        let plan = Plan {
            name,
            system: system.clone(),
            stages,
            outputs,
            analyzers: Vec::new(),
            checkpoints: Checkpoints::default(),
            resolved: String::new(),
        };
        let session = rig::session(&plan, &state);
        session.run_stage("dice", false).expect("the adapter runs it");
        let raw = session.raw().expect("readable particles");
        let draw = Draw::new(system.run.seed, Purpose::WallGhost, step);
        for i in 0..5000u32 {
            let (words, u) = (draw.words(i, 5, 1), draw.uniforms(i, 5, 1));
            for k in 0..3 {
                let (at, from) = (3 * i as usize + k, (i as usize + k) % 4);
                assert_eq!(raw.positions[at], words[from], "{step} {i}");
                assert_eq!(f64::from(raw.velocities[at]), u[from], "{step} {i}");
                assert!(u[from] > 0.0 && u[from] < 1.0);
            }
        }
    }
}
