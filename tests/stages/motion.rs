//! squirmer-move on the adapter against its f64 reference, and properties that hold in every bit.

use crate::rig;
use glam::{DQuat, DVec3};
use squirm::buffers::{Fault, SquirmerState};
use squirm::gpu::Session;
use squirm::params::Value;
use squirm::stages::squirmer_move::SquirmerMove;
use squirm::stages::{self, Stage};
use squirm::state::scene::Scene;
use squirm::state::start::{nearest_image, start};
use squirm::state::{Squirmer, State, System, packed};
use std::sync::{Mutex, MutexGuard, PoisonError};

const KIND: &str = "squirmer-move";

/// The tests of this file share one device: one at a time, so that none polls for another's readings.
fn alone() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A slit or a periodic box crowded with prolate, oblate and spherical bodies, some of them held.
fn crowd(walled: bool) -> (System, State) {
    let mut system = rig::system([30, 16, 40]);
    system.run.dt = 0.02;
    system.domain.walls = walled.then(rig::walls);
    system.fluid.temperature = 20.0;
    system.species = [(14, 4.0, 2.0), (14, 1.5, 3.0), (10, 2.0, 2.0), (4, 3.0, 2.0)]
        .map(|(count, along, across)| squirm::state::Species { count, ..rig::species(along, across, 0.1, 0.0) })
        .to_vec();
    system.species[3].held = true;
    let mut state = start(&system).expect("there is room");
    state.particles.clear();
    (system, state)
}

fn session(system: &System, squirmers: &[Squirmer], changes: &[(&str, &'static str, Value)]) -> Session {
    let state = State { step: 0, particles: Vec::new(), squirmers: squirmers.to_vec() };
    rig::session(&rig::plan(system, &[KIND], changes), &state)
}

fn advance(session: &mut Session, steps: u64) -> Vec<SquirmerState> {
    session.advance(steps, false);
    session.wait().expect("the device answers");
    assert_eq!(session.faults().expect("faults are readable"), 0);
    session.read("squirmers").expect("squirmers are readable")
}

fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

fn mass(system: &System, s: &Squirmer) -> f64 {
    f64::from(system.species[s.species].ghosts(&system.fluid))
}

/// Advances by single steps and compares each with the reference; gives the number of squirmers that felt a force.
fn follows_the_reference(system: &System, state: State, substeps: i64, steps: u32) -> usize {
    let changes = [(KIND, "substeps", Value::Integer(substeps))];
    let mut session = session(system, &state.squirmers, &changes);
    let entry = stages::find(KIND).expect("the stage is registered");
    let mut scene = Scene { state, ..Scene::default() };
    let values = &rig::plan(system, &[KIND], &changes).stages[0].values;
    let mut touched = 0;
    for _ in 0..steps {
        // Each step starts from the adapter's own state: otherwise collisions would magnify rounding without bound.
        let before: Vec<SquirmerState> = session.read("squirmers").expect("squirmers are readable");
        scene.state.squirmers = packed::unpack_squirmers(system, &before);
        let after = advance(&mut session, 1);
        (entry.reference)(values, system, &mut scene);
        let steric: Vec<f32> = session.read("steric").expect("forces are readable");
        for (i, (found, wanted)) in after.iter().zip(&scene.state.squirmers).enumerate() {
            let load = &scene.steric[i];
            touched += usize::from(load.force != DVec3::ZERO);
            // The gap is known to about 16 ulp of a distance of 8 a, 8e-6 a; the force has the slope 456 epsilon/sigma^2 < 1e4
            // at contact and ten times that in the deepest overlaps here. Kicks take this times h, torques an arm of 4 a.
            let force = 0.1 + 2e-3 * load.force.length();
            let words = &steric[8 * i..8 * i + 8];
            assert!((vector([words[0], words[1], words[2]]) - load.force).length() < force, "{load:?} {words:?}");
            assert!(
                (vector([words[4], words[5], words[6]]) - load.torque).length() < 4.0 * force,
                "{load:?} {words:?}"
            );
            let m = mass(system, wanted);
            assert!((vector(found.velocity) - wanted.velocity).length() < force * system.run.dt / m + 1e-6);
            let turn = (vector(found.angular_momentum) - wanted.angular_momentum).length();
            assert!(turn < 4.0 * force * system.run.dt + 1e-6 * wanted.angular_momentum.length(), "{turn}");
            let position = packed::unpack_position(&system.domain, found.position);
            assert!(nearest_image(&system.domain, position - wanted.position).length() < 1e-6);
            let orientation = DQuat::from_array(found.orientation.map(f64::from));
            assert!(orientation.dot(wanted.orientation) > 1.0 - 1e-6);
            let motion = &scene.motions[i];
            assert!((vector(found.drift) - motion.drift).length() < force * system.run.dt / m + 1e-6);
            assert!((vector(found.spin) - motion.spin).length() < 1e-4, "{:?} {}", found.spin, motion.spin);
            assert_eq!(found.position_before, before[i].position);
            assert_eq!(found.orientation_before, before[i].orientation);
            if system.species[wanted.species].held {
                assert_eq!((found.position, found.drift, found.velocity), (before[i].position, [0.0; 3], [0.0; 3]));
            }
        }
    }
    touched
}

#[test]
fn crowds_move_as_in_the_reference() {
    let _turn = alone();
    for (walled, substeps) in [(false, 1), (true, 3)] {
        let (system, state) = crowd(walled);
        let touched = follows_the_reference(&system, state, substeps, 100);
        assert!(touched > 200, "{touched}");
    }
}

/// One large sphere in a box, `touching` small ones at its surface and as many a little farther off, all within reach of its size, and
/// `others` elsewhere.
fn besieged(touching: u32, others: u32) -> (System, State) {
    let mut system = rig::system([64, 64, 64]);
    system.run.dt = 0.01;
    let centre = DVec3::new(62.0, 31.0, 3.0);
    let mut places = vec![centre];
    for (radius, shell) in [(7.25, 0), (9.9, 1)] {
        // Evenly over the sphere: turned by the golden angle from one to the next.
        let point = |k: u32| {
            let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(touching);
            let angle = 2.399_963_229_728_653 * f64::from(k) + f64::from(shell);
            DVec3::new((1.0 - z * z).sqrt() * angle.cos(), (1.0 - z * z).sqrt() * angle.sin(), z)
        };
        places.extend((0..touching).map(|k| centre + radius * point(k)));
    }
    for i in 0.. {
        let place = 64.0 * crate::bench::random(81, i).0;
        let apart = |p: &DVec3| nearest_image(&system.domain, *p - place).length();
        if places.len() as u32 == 1 + 2 * touching + others {
            break;
        }
        if apart(&centre) > 12.0 && places.iter().all(|p| apart(p) > 1.7) {
            places.push(place);
        }
    }
    let wrapped = |p: DVec3| squirm::state::start::wrap(&system.domain, p);
    let squirmers: Vec<Squirmer> = places
        .iter()
        .enumerate()
        .map(|(k, p)| Squirmer { species: usize::from(k > 0), ..crate::bench::squirmer(wrapped(*p)) })
        .collect();
    let small = squirm::state::Species { count: 2 * touching + others, ..rig::species(1.0, 1.0, 0.1, 0.0) };
    system.species = vec![rig::species(6.0, 6.0, 0.1, 0.0), small];
    (system, State { step: 0, particles: Vec::new(), squirmers })
}

/// More partners within reach than invocations look for them, and as many contacts as may be.
#[test]
fn many_squirmers_around_one_move_as_in_the_reference() {
    let _turn = alone();
    for others in [0, packed::FEW_SQUIRMERS] {
        let (system, state) = besieged(60, others);
        assert_eq!(packed::bins(&system)[0], if others == 0 { 0 } else { 4 });
        let touched = follows_the_reference(&system, state, 1, 3);
        assert!(touched >= 3 * 60, "{touched}");
    }
}

/// One contact more than the sums are made for is a fault, however far its partners are spread over invocations.
#[test]
fn too_many_contacts_are_a_fault() {
    let _turn = alone();
    for (touching, fault) in [(64, 0), (65, Fault::Steric as u32)] {
        let (system, state) = besieged(touching, 0);
        let mut session = session(&system, &state.squirmers, &[]);
        session.advance(1, false);
        assert_eq!(session.faults().expect("faults are readable"), fault, "{touching}");
    }
}

/// Both partners of a pair compute it alike, so in a periodic box the fixed-point forces cancel exactly.
#[test]
fn action_equals_reaction_in_every_bit() {
    let _turn = alone();
    let (system, state) = crowd(false);
    let plan = rig::plan(&system, &[KIND], &[]);
    let params = <SquirmerMove as squirm::params::Params>::from_values(&plan.stages[0].values);
    let scale = SquirmerMove::uniform(&params, &system).force_scale;
    let mut session = session(&system, &state.squirmers, &[]);
    let mut loaded = 0;
    for _ in 0..50 {
        advance(&mut session, 1);
        let steric: Vec<f32> = session.read("steric").expect("forces are readable");
        for axis in 0..3 {
            let units: Vec<f64> = steric.iter().skip(axis).step_by(8).map(|f| f64::from(f * scale)).collect();
            assert!(units.iter().all(|u| u.fract() == 0.0));
            assert_eq!(units.iter().sum::<f64>(), 0.0);
            loaded += units.iter().filter(|u| **u != 0.0).count();
        }
    }
    assert!(loaded > 100, "{loaded}");
}

#[test]
fn two_runs_agree_in_every_bit() {
    let _turn = alone();
    let (system, state) = crowd(true);
    let run = || advance(&mut session(&system, &state.squirmers, &[]), 200);
    assert_eq!(bytemuck::cast_slice::<_, u8>(&run()), bytemuck::cast_slice::<_, u8>(&run()));
}

/// A step of a tenth of a coordinate unit is not lost, and crossings of the box are counted.
#[test]
fn slow_and_fast_centres_arrive() {
    let _turn = alone();
    let mut system = rig::system([32, 32, 32]);
    system.run.dt = 0.125;
    system.species = vec![rig::species(2.0, 2.0, 0.0, 0.0)];
    let unit = 32.0 / 4_294_967_296.0;
    let squirmer = Squirmer {
        species: 0,
        position: DVec3::splat(16.0),
        orientation: DQuat::IDENTITY,
        velocity: DVec3::new(0.8 * unit, -0.8 * unit, -32.0),
        angular_momentum: DVec3::ZERO,
    };
    let mut session = session(&system, &[squirmer], &[]);
    let end = advance(&mut session, 1000)[0];
    // 1000 steps of a tenth of a unit, and of 4 cells down: 125 turns of the box.
    let half = 1u32 << 31;
    assert!((i64::from(end.position[0]) - i64::from(half) - 100).abs() <= 1, "{:?}", end.position);
    assert!((i64::from(end.position[1]) - i64::from(half) + 100).abs() <= 1, "{:?}", end.position);
    assert_eq!((end.position[2], end.image), (half, [0, 0, -125]));
}
