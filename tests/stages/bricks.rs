//! Bricks: two of them share a room, the row of all particles and the ghosts of squirmers lie where bricks have been.

use crate::bench::*;
use crate::fused::crowded;
use crate::rig;
use glam::DVec3;
use squirm::buffers::{Fault, Gathering};
use squirm::gpu::{Form, Gpu, Session};
use squirm::graph::Plan;
use squirm::state::packed::brick_room;
use squirm::state::{Particle, Squirmer, State, System};

fn gpu() -> Gpu {
    let mut gpu = rig::gpu().clone();
    gpu.gathering = Some(Gathering::Bricks);
    gpu
}

/// The row of all particles is in its place after any number of steps, wherever the bricks lie that it comes from, and also where it has memory of
/// its own.
#[test]
fn the_row_is_where_it_is_looked_for() {
    let system = rig::system([9, 10, 33]);
    let start = state(gas(&system, 34, 30_000), Vec::new());
    let plan = rig::plan(&system, rig::BULK, &[]);
    let session = |form, room| Session::with_room(&gpu(), &plan, &start, (form, room)).expect("a session");
    let (mut loose, mut lodging, mut apart) =
        (session(Form::Loose, 0), session(Form::Fused, 0), session(Form::Fused, 64));
    let row = 30_000 * 24;
    let bricks = lodging.buffers().filter(|(name, _)| name.starts_with("bricks_")).map(|(_, n)| n).sum::<u64>();
    assert!(apart.memory() > lodging.memory() + 2 * row && lodging.memory() < bricks + row, "{}", lodging.memory());
    let mut digests = Vec::new();
    for steps in [1, 2, 3, 4, 0, 2, 1] {
        for session in [&mut loose, &mut lodging, &mut apart] {
            session.advance(steps, false);
            assert_eq!(session.faults().expect("readable"), 0);
        }
        let digest = loose.raw().expect("readable").digest();
        assert_eq!(lodging.raw().expect("readable").digest(), digest, "{steps}");
        assert_eq!(apart.raw().expect("readable").digest(), digest, "{steps}");
        digests.push(digest);
    }
    digests.dedup();
    assert_eq!(digests.len(), 6, "no steps change nothing, all others everything");
}

/// A stage that reads the row of all particles between two collisions finds none in bricks: its plan does without.
#[test]
fn who_looks_for_particles_in_their_row_keeps_them_there() {
    let system = rig::system([9, 10, 33]);
    let mut plan = rig::plan(&system, rig::BULK, &[]);
    let room = |plan: &Plan| squirm::graph::fused::sizes(plan, 30_000, Some(Gathering::Bricks)).room;
    assert!(room(&plan) > 0);
    let sorts = plan.stages.iter().position(|s| s.entry.kind == "sort-reorder").expect("a stage");
    plan.stages[sorts].entry =
        Box::leak(Box::new(squirm::stages::Entry { bricked: None, ..*plan.stages[sorts].entry }));
    assert_eq!(room(&plan), 0);
}

/// A brick that fills up beyond its room stops the run; a session that begins with such a crowd has room for it.
#[test]
fn a_crowd_beyond_the_room_of_a_brick_is_a_fault() {
    let system = rig::system([9, 10, 33]);
    let even = state(gas(&system, 32, 30_000), Vec::new());
    let crowd = crowded(&system, 30_000, (40, 90));
    let plan = rig::plan(&system, rig::BULK, &[]);
    let faults = |start: &State, then: &State| {
        let mut session = Session::formed(&gpu(), &plan, start, Form::Fused).expect("a session");
        session.write_particles(&then.particles);
        session.advance(2, false);
        session.faults().expect("readable")
    };
    assert_eq!(faults(&even, &even), 0);
    assert_eq!(faults(&crowd, &crowd), 0);
    assert_ne!(faults(&even, &crowd) & Fault::Room as u32, 0);
}

/// 4 x 4 x 4 bricks of which two neighbours along x, numbers 0 and 1, hold so many particles, wherever the grid begins,
/// and the middle of the box, far from them, the rest.
fn filled((first, second): (usize, usize)) -> (System, State) {
    let system = rig::system([16, 16, 16]);
    let mut particles = gas(&system, 35, 16_000);
    for (i, p) in particles.iter_mut().enumerate() {
        let share = p.position / 16.0;
        if i < first + second {
            let corner = if i < first { DVec3::ZERO } else { 4.0 * DVec3::X };
            p.position = corner + DVec3::splat(0.1) + 2.8 * share;
            p.velocity *= 0.01;
        } else {
            p.position.z = 7.0 + 6.0 * share.z;
        }
    }
    (system, state(particles, Vec::new()))
}

/// A session whose bricks have room for an even fluid, with other particles in it.
fn entered(plan: &Plan, then: &State) -> Session {
    let even = state(gas(&plan.system, 36, 16_000), Vec::new());
    let session = Session::formed(&gpu(), plan, &even, Form::Fused).expect("a session");
    assert_eq!(session.sizes().room, 1584);
    session.write_particles(&then.particles);
    session
}

/// Everything outside of the two bricks, in an order that only depends on it.
fn outside(session: &Session) -> Vec<[u64; 6]> {
    let inside = |p: &Particle| p.position.x < 8.0 && p.position.y < 4.0 && p.position.z < 4.0;
    let words = |p: &Particle| [p.position, p.velocity].map(|v| v.to_array().map(f64::to_bits)).concat();
    let particles = session.state().expect("readable").particles;
    let mut found: Vec<[u64; 6]> =
        particles.iter().filter(|p| !inside(p)).map(|p| words(p).try_into().expect("six")).collect();
    found.sort_unstable();
    found
}

#[test]
fn two_bricks_share_a_room() {
    // One may take what the other leaves, be it number 0, which begins the room, or number 1, which ends it.
    for counts in [(1500, 0), (0, 1500), (792, 792), (1584, 0), (0, 1584), (84, 1500)] {
        let (system, start) = filled(counts);
        let plan = rig::plan(&system, rig::BULK, &[]);
        let (mut fused, mut loose) = (entered(&plan, &start), rig::session(&plan, &start));
        loose.write_particles(&start.particles);
        for steps in [1, 4] {
            fused.advance(steps, false);
            loose.advance(steps, false);
            assert_eq!(fused.faults().expect("readable"), 0, "{counts:?}");
            let digests = [&fused, &loose].map(|s| s.raw().expect("readable").digest());
            assert_eq!(digests[0], digests[1], "{counts:?}");
        }
    }
}

#[test]
fn two_bricks_that_meet_are_a_fault_and_leave_others_alone() {
    // None of them has more than the room by itself, but for the last two.
    for counts in [(793, 792), (792, 793), (900, 900), (1584, 1), (1, 1584), (1585, 0), (0, 1700)] {
        let (system, start) = filled(counts);
        let plan = rig::plan(&system, rig::BULK, &[]);
        let (mut fused, mut loose) = (entered(&plan, &start), rig::session(&plan, &start));
        fused.advance(1, false);
        loose.advance(1, false);
        assert_eq!(fused.faults().expect("readable"), Fault::Room as u32, "{counts:?}");
        let (found, expected) = (outside(&fused), outside(&loose));
        assert!(expected.len() == 16_000 - counts.0 - counts.1, "{counts:?}: {}", expected.len());
        assert!(expected.iter().all(|p| found.binary_search(p).is_ok()), "{counts:?}");
    }
}

/// Sums are over the cells of a brick, faults name the cells of the box.
#[test]
fn a_fault_names_the_cell_that_the_loose_plan_names() {
    let system = rig::system([9, 10, 11]);
    let plan = rig::plan(&system, rig::BULK, &[]);
    for place in [DVec3::new(0.5, 0.5, 0.5), DVec3::new(7.3, 5.2, 9.8), DVec3::new(4.1, 8.7, 3.3)] {
        let mut particles = gas(&system, 5, 9000);
        particles[700] = Particle { position: place, velocity: DVec3::new(13.0, 0.0, 0.0) };
        let start = state(particles, Vec::new());
        let [loose, fused] = [Form::Loose, Form::Fused].map(|form| {
            let mut session = Session::formed(&gpu(), &plan, &start, form).expect("a session");
            session.advance(1, false);
            let words: Vec<u32> = session.read("faults").expect("readable");
            // Flags, site and cell; that it is which particle bricks do not know.
            [words[0], words[1], words[2]]
        });
        assert_eq!(loose[0], Fault::Speed as u32);
        assert!(loose[2] > 0 && loose == fused, "{loose:?} {fused:?}");
    }
}

/// Bodies at one place: so many ghosts in few bricks. They share rooms as particles do, but not with these.
#[test]
fn ghosts_share_rooms_of_their_own() {
    let kinds = [
        "squirmer-move",
        "stream",
        "squirmer-collide",
        "shift-grid",
        "cell-reduce",
        "squirmer-fill",
        "rotate",
        "apply",
    ];
    let run = |count: u32, form| {
        let mut system = rig::system([16, 16, 16]);
        system.species = vec![squirm::state::Species { count, ..rig::species(3.0, 3.0, 0.1, 0.0) }];
        let body = Squirmer { species: 0, ..squirmer(DVec3::new(6.0, 6.0, 6.0)) };
        let start = state(gas(&system, 37, 40_000), vec![body; count as usize]);
        let plan = rig::plan(&system, &kinds, &[]);
        let mut session = Session::formed(&gpu(), &plan, &start, form).expect("a session");
        session.advance(3, false);
        let faults = session.faults().expect("readable");
        let force: Vec<u32> = session.read("fluid_force").expect("readable");
        // What two bricks have room for goes by the volume of the bodies, not by where they are.
        let roomy = session.sizes().room == brick_room(&system);
        (faults, session.raw().expect("readable").digest(), force, roomy)
    };
    // Two fill a brick with ghosts on top of its particles, which have no place to lose to them.
    for count in [1, 2] {
        let (loose, fused) = (run(count, Form::Loose), run(count, Form::Fused));
        // Bodies at one place push each other hard.
        assert_eq!((loose.0 & Fault::Room as u32, fused.0, fused.3), (0, loose.0, true));
        assert!(loose.1 == fused.1 && loose.2 == fused.2, "{count}");
    }
    assert_ne!(run(12, Form::Fused).0 & Fault::Room as u32, 0);
    assert_eq!(run(12, Form::Loose).0 & Fault::Room as u32, 0);
}

/// Particles in a thin slit that fly so far that most meet a wall, and two squirmers so near to all of a small box that any particle may meet either: they wait
/// in handfuls of eight, or of more where bricks have room for many, and then in more of these than a brick has invocations.
#[test]
fn all_may_wait_however_many_there_are() {
    let squirmers = ["squirmer-move", "stream", "squirmer-collide", "shift-grid", "cell-reduce", "rotate", "apply"];
    let walls = ["stream", "shift-grid", "cell-reduce", "rotate", "restore-thermostat", "apply"];
    let cases: [(&[&str], f64, f64, u64); 3] =
        [(&squirmers, 1.0, 20.0, 8), (&squirmers, 1.0, 60.0, 32), (&walls, 4.0, 20.0, 8)];
    for (kinds, dt, density, handful) in cases {
        let mut system = rig::system(if kinds == walls { [8, 4, 24] } else { [9, 8, 12] });
        system.fluid.density = density;
        system.run.dt = dt;
        let count = (density * 768.0) as u32;
        let (mut particles, mut bodies) = (gas(&system, 38, count), Vec::new());
        if kinds == walls {
            system.domain.walls = Some(rig::walls());
            // All in every other brick: two share a room.
            for p in &mut particles {
                p.position.x *= 3.0 / 8.0;
                p.velocity.x *= 0.01;
            }
        } else {
            system.species = vec![squirm::state::Species { count: 2, ..rig::species(1.5, 1.5, 0.1, 0.0) }];
            bodies.extend([3.0, 9.0].map(|z| Squirmer { species: 0, ..squirmer(DVec3::new(4.0, 4.0, z)) }));
        }
        let start = state(particles, bodies);
        let plan = rig::plan(&system, kinds, &[("rotate", "angle", squirm::params::Value::Float(120.0))]);
        let run = |form| {
            let mut gpu = gpu();
            gpu.few_bricks = 0;
            let mut session = Session::formed(&gpu, &plan, &start, form).expect("a session");
            session.advance(2, false);
            // One of the two lists is empty.
            let listed = |words: Vec<u32>| u64::from(words[3] + words[7]) * session.sizes().handful();
            let listed = (form == Form::Fused).then(|| listed(session.read("held_groups").expect("readable")));
            let (faults, raw) = (session.faults().expect("readable"), session.raw().expect("readable"));
            (faults, raw.digest(), listed, session.sizes().handful())
        };
        let (loose, fused) = (run(Form::Loose), run(Form::Fused));
        assert_eq!((loose.0 & !(Fault::Stuck as u32), fused.0, fused.3), (0, loose.0, handful));
        assert_eq!(loose.1, fused.1, "{density}");
        // Most of some bricks, and handfuls are full but for the last of each brick.
        let (listed, count) = (fused.2.expect("a list"), u64::from(count));
        assert!(listed > count / 3 && listed < count + 18 * handful, "{listed} of {count}");
    }
}
