//! The fused plan against the loose one: the same bits, whatever shares a kernel.

use crate::bench::*;
use crate::collision::{active_slit, continued};
use crate::rig;
use squirm::buffers::{Extent, Gathering, Sizes};
use squirm::gpu::{Form, Session};
use squirm::graph::fused::{Item, Occasion, items};
use squirm::params::Value;
use squirm::shader::Lanes;
use squirm::stages;
use squirm::state::{State, System, packed};

type Change = (&'static str, &'static str, Value);

/// Everything that a run leaves behind, after 1, 8 and 20 steps.
fn left(
    system: &System,
    start: &State,
    kinds: &[&str],
    changes: &[Change],
    (form, lanes, gathering): (Form, Lanes, impl Into<Option<Gathering>>),
) -> Vec<(String, Vec<f32>, [glam::DVec3; 2])> {
    let plan = rig::plan(system, kinds, changes);
    let mut gpu = rig::gpu().clone();
    gpu.lanes = lanes;
    gpu.gathering = gathering.into();
    if lanes == Lanes::Four && gpu.gathering == Some(Gathering::Bricks) {
        // As where there are many.
        gpu.few_bricks = 0;
    }
    let mut session = Session::formed(&gpu, &plan, start, form).expect("a session");
    let bricks = form == Form::Fused && gpu.gathering != Some(Gathering::Chains);
    assert_eq!(session.sizes().gathering() == Gathering::Bricks, bricks);
    [1, 7, 12]
        .map(|steps| {
            session.advance(steps, false);
            assert_eq!(session.faults().expect("readable"), 0);
            let walls = packed::wall_impulses(system, &session.read("wall_impulses").expect("readable"));
            (session.raw().expect("readable").digest(), session.read("fluid_force").expect("readable"), walls)
        })
        .to_vec()
}

/// What is done ahead is done again before it runs out, and finds the step before it still there; also where the number of the step outgrows a word.
#[test]
fn long_submissions_leave_the_same_bits() {
    let system = rig::system([6, 5, 7]);
    let (mut slit, squirmers) = active_slit();
    let plans = [
        (rig::plan(&system, rig::BULK, &[]), state(gas(&system, 35, 2000), Vec::new())),
        (rig::plan(&slit, rig::EVERYTHING, &continued()), squirmers.clone()),
        (
            {
                slit.species.clear();
                let kinds: Vec<&str> = rig::EVERYTHING.iter().copied().filter(|k| !k.starts_with("squirmer")).collect();
                rig::plan(&slit, &kinds, &continued())
            },
            State { squirmers: Vec::new(), ..squirmers },
        ),
    ];
    for (plan, start) in plans {
        let start = State { step: (1 << 32) - 40, ..start };
        let digest = |form, gathering| {
            let mut gpu = rig::gpu().clone();
            gpu.gathering = Some(gathering);
            let mut session = Session::formed(&gpu, &plan, &start, form).expect("a session");
            // Once more in the first submission; the second begins elsewhere among what is kept.
            [70, 3].map(|steps| {
                session.advance(steps, false);
                assert_eq!(session.faults().expect("readable"), 0);
                session.raw().expect("readable").digest()
            })
        };
        let loose = digest(Form::Loose, Gathering::Chains);
        for gathering in [Gathering::Chains, Gathering::Bricks] {
            assert_eq!(digest(Form::Fused, gathering), loose, "{gathering:?}");
        }
    }
}

/// Where cells lie is told by products of 64 bits, in one operation or in several.
#[test]
fn wide_words_change_no_bit() {
    // Adapters without them have one way only; lavapipe, on which every change is tested, has them.
    assert!(rig::gpu().wide || rig::gpu().summary.kind != "CPU");
    let (slit, start) = active_slit();
    let plan = rig::plan(&slit, rig::EVERYTHING, &continued());
    let digest = |wide, form| {
        let mut gpu = rig::gpu().clone();
        gpu.wide = wide;
        let mut session = Session::formed(&gpu, &plan, &start, form).expect("a session");
        session.advance(5, false);
        assert_eq!(session.faults().expect("readable"), 0);
        session.raw().expect("readable").digest()
    };
    for form in [Form::Loose, Form::Fused] {
        assert_eq!(digest(true, form), digest(false, form), "{form:?}");
    }
}

/// On a CPU cells move their particles on when they have made their sums, whether it is sorted in the step or not; nobody does who has something to do
/// in between, or no shifts made ahead by which steps take turns with two chains.
#[test]
fn cells_of_a_fluid_on_a_cpu_walk_their_chains_once_more() {
    let system = rig::system([6, 5, 7]);
    let unshifted: Vec<&str> = rig::BULK.iter().copied().filter(|k| *k != "shift-grid").collect();
    let (slit, _) = active_slit();
    for (system, kinds, walked) in
        [(&system, rig::BULK, true), (&system, &unshifted[..], false), (&slit, rig::EVERYTHING, false)]
    {
        let plan = rig::plan(system, kinds, &[]);
        let sizes = squirm::graph::fused::sizes(&plan, 2000, Some(Gathering::Chains));
        assert_eq!((sizes.gathering(), sizes.at_once), (Gathering::Chains, walked), "{kinds:?}");
        for all in [true, false] {
            let stages = squirm::graph::fused::stages(&plan, all);
            let next = items(&stages, Occasion::Next, &sizes).expect("valid");
            let found = next.iter().filter(|item| matches!(item, Item::Walked(_))).count();
            assert_eq!(found, usize::from(walked), "{kinds:?}");
            let row = next.iter().filter(|item| matches!(item, Item::Joint(m) if m[0].phase.over == Extent::Particles));
            assert!(!walked || row.count() == 0);
            assert!(!walked || all || next.len() == 1, "{next:?}");
        }
    }
}

/// Or the tests below with four lanes say nothing.
#[test]
fn the_subgroups_of_this_adapter_are_neighbours() {
    assert!(rig::gpu().subgroups_are_neighbours());
}

#[test]
fn both_forms_of_a_plan_leave_the_same_bits() {
    let mut gas_box = rig::system([9, 10, 33]);
    gas_box.fluid.acceleration = [0.01, 0.0, -0.02];
    let fluid = state(gas(&gas_box, 31, 30_000), Vec::new());
    let (slit, squirmers) = active_slit();
    let slit_of_fluid = System { species: Vec::new(), ..slit.clone() };
    let alone = squirm::state::start::start(&slit_of_fluid).expect("a start");
    let mode = |mode: &str, spin| -> Vec<Change> {
        vec![
            ("restore-thermostat", "mode", Value::Text(mode.into())),
            ("restore-thermostat", "angular_momentum", Value::Boolean(spin)),
        ]
    };
    let in_slit: Vec<&str> = rig::EVERYTHING.iter().copied().filter(|k| !k.starts_with("squirmer")).collect();
    let published: Vec<Change> = vec![
        ("squirmer-fill", "ghosts", Value::Text("published".into())),
        ("squirmer-fill", "slip", Value::Text("constant".into())),
    ];
    let cases: [(&System, &State, &[&str], Vec<Change>); 9] = [
        (&slit_of_fluid, &alone, &in_slit, continued().to_vec()),
        (&gas_box, &fluid, rig::BULK, mode("energy", true)),
        (&gas_box, &fluid, rig::BULK, mode("thermostat", false)),
        (&gas_box, &fluid, &["stream", "shift-grid", "cell-reduce", "rotate", "apply"], Vec::new()),
        (&slit, &squirmers, rig::EVERYTHING, Vec::new()),
        (&slit, &squirmers, rig::EVERYTHING, continued().to_vec()),
        (&slit, &squirmers, rig::EVERYTHING, mode("thermostat", false)),
        (&slit, &squirmers, rig::EVERYTHING, published),
        (&slit, &squirmers, rig::EVERYTHING, vec![("rotate", "grip", Value::Float(1.22))]),
    ];
    for (system, start, kinds, changes) in cases {
        let loose = left(system, start, kinds, &changes, (Form::Loose, Lanes::One, Gathering::Chains));
        for (every, lanes, gathering) in [
            (1, Lanes::Four, Some(Gathering::Chains)),
            (7, Lanes::One, Some(Gathering::Chains)),
            (50, Lanes::Four, Some(Gathering::Chains)),
            (50, Lanes::Four, Some(Gathering::Bricks)),
            (3, Lanes::One, Some(Gathering::Bricks)),
            // As a GPU chooses.
            (7, Lanes::Four, None),
        ] {
            let mut changes = changes.clone();
            changes.push(("sort-reorder", "every", Value::Integer(every)));
            assert_eq!(
                loose,
                left(system, start, kinds, &changes, (Form::Fused, lanes, gathering)),
                "{kinds:?} {changes:?}"
            );
        }
        let unsorted: Vec<&str> = kinds.iter().copied().filter(|k| *k != "sort-reorder").collect();
        let fused = left(system, start, &unsorted, &changes, (Form::Fused, Lanes::One, Gathering::Chains));
        assert_eq!(loose, fused, "{unsorted:?} {changes:?}");
    }
}

/// So many that no workgroup has room for all: what an invocation does in turn for one of them, with and without bins.
#[test]
fn many_squirmers_leave_the_same_bits() {
    let mut system = rig::system([28, 27, 29]);
    system.fluid.density = 8.0;
    let kinds: Vec<&str> = rig::EVERYTHING.iter().copied().filter(|k| *k != "wall-ghosts").collect();
    for (count, gathering) in [(280, Gathering::Chains), (1040, Gathering::Bricks)] {
        system.species = vec![squirm::state::Species { count, ..rig::species(1.3, 0.9, 0.1, -1.0) }];
        assert_eq!(squirm::graph::sizes(&system).bins > 0, count > packed::FEW_SQUIRMERS);
        let start = squirm::state::start::start(&system).expect("a start");
        let loose = left(&system, &start, &kinds, &[], (Form::Loose, Lanes::One, Gathering::Chains));
        assert_eq!(loose, left(&system, &start, &kinds, &[], (Form::Fused, Lanes::One, gathering)), "{count}");
    }
}

/// A gas of which `crowds` cells hold `each` particles more, and the others the rest of `count`.
pub fn crowded(system: &System, count: u32, (crowds, each): (usize, usize)) -> State {
    let mut particles = gas(system, 32, count);
    for (i, particle) in particles.iter_mut().take(crowds * each).enumerate() {
        let cell = i / each;
        let corner = glam::DVec3::new((cell % 9) as f64, (cell / 9 % 10) as f64, (cell / 90) as f64);
        particle.position = corner + particle.position.fract();
    }
    state(particles, Vec::new())
}

#[test]
fn crowded_cells_lose_nobody() {
    let system = rig::system([9, 10, 33]);
    let start = crowded(&system, 30_000, (40, 90));
    let loose = left(&system, &start, rig::BULK, &[], (Form::Loose, Lanes::One, Gathering::Chains));
    for gathering in [Gathering::Chains, Gathering::Bricks] {
        let fused = left(&system, &start, rig::BULK, &[], (Form::Fused, Lanes::One, gathering));
        assert_eq!(loose, fused, "{gathering:?}");
    }
}

/// In one step, past several bricks, around a box of three bricks, two and one, of which the last are cut.
#[test]
fn particles_that_fly_far_find_their_bricks() {
    let mut system = rig::system([11, 7, 4]);
    system.run.dt = 1.5;
    let start = state(gas(&system, 33, 2_500), Vec::new());
    let fastest = start.particles.iter().map(|p| p.velocity.abs().max_element()).fold(0.0, f64::max);
    assert!(fastest * system.run.dt > 5.0, "{fastest}");
    let loose = left(&system, &start, rig::BULK, &[], (Form::Loose, Lanes::One, Gathering::Chains));
    assert_eq!(loose, left(&system, &start, rig::BULK, &[], (Form::Fused, Lanes::One, Gathering::Bricks)));
}

/// Bodies at one place have more ghosts in a cell than its list has room for, which is 16.
#[test]
fn crowded_cells_lose_no_ghost() {
    let (system, mut start) = active_slit();
    let centre = start.squirmers[2].position;
    start.squirmers.iter_mut().for_each(|s| s.position = centre);
    let kinds = ["stream", "shift-grid", "cell-reduce", "wall-ghosts", "squirmer-fill", "rotate", "apply"];
    let loose = left(&system, &start, &kinds, &[], (Form::Loose, Lanes::One, Gathering::Chains));
    for lanes in [Lanes::One, Lanes::Four] {
        assert_eq!(loose, left(&system, &start, &kinds, &[], (Form::Fused, lanes, Gathering::Chains)), "{lanes:?}");
    }
    let mut bench = Bench::new(&system, &start, &kinds, &[]);
    bench.run_all(&kinds[..5]);
    let ghosts = bench.moments().iter().map(|m| m.ghosts).fold(0.0, f64::max);
    assert!(ghosts > 30.0, "{ghosts}");
}

/// The plan of these stages, and their kinds; everything in it that shares a workgroup or a dispatch is valid WGSL.
fn planned(kinds: &[&str], occasion: Occasion, sizes: &Sizes) -> (Vec<&'static str>, Vec<Item>) {
    let stages: Vec<_> = kinds.iter().map(|k| (stages::find(k).expect("a stage"), 1, *k != "sort-reorder")).collect();
    let items = items(&stages, occasion, sizes).expect("valid");
    for item in items.iter().filter(|i| matches!(i, Item::Small(_))) {
        squirm::graph::small::module(item.members(), &stages, sizes).expect("valid");
    }
    for item in items.iter().filter(|i| matches!(i, Item::InTurn(_))) {
        squirm::graph::in_turn::module(item.members(), &stages).expect("valid");
    }
    for (item, lanes) in
        items.iter().filter(|i| matches!(i, Item::Beside(_))).zip([Lanes::One, Lanes::Four].iter().cycle())
    {
        squirm::graph::beside::module(item.members(), &stages, *lanes, sizes).expect("valid");
    }
    (stages.iter().map(|s| s.0.kind).collect(), items)
}

/// Everything that a slit with this many squirmers has.
fn slit_of(squirmers: u64) -> Sizes {
    let bins = if squirmers > u64::from(packed::FEW_SQUIRMERS) { 64 } else { 0 };
    Sizes { particles: 1000, cells: 100, wall_cells: 40, wall_patches: 4, squirmers, bins, ..FEW_GHOSTS }
}

const FEW_GHOSTS: Sizes = Sizes {
    particles: 0,
    cells: 0,
    wall_cells: 0,
    wall_patches: 0,
    squirmers: 0,
    species: 1,
    ghost_stride: 64,
    box_edge: 8,
    bins: 0,
    waiting: 1000,
    room: 0,
    at_once: false,
    coarse: 0,
    samples: 0,
};

/// Kinds that share a kernel over particles or cells, in order.
fn shared(kinds: &[&str], occasion: Occasion) -> Vec<Vec<&'static str>> {
    let (kinds, items) = planned(kinds, occasion, &slit_of(6));
    let joint = items.iter().filter(|i| matches!(i, Item::Joint(_) | Item::Sifted(_)));
    joint.map(|i| i.members().iter().map(|m| kinds[m.stage]).collect()).collect()
}

#[test]
fn what_shares_a_kernel() {
    let cells = vec!["cell-reduce", "rotate", "restore-thermostat"];
    assert_eq!(shared(rig::BULK, Occasion::Next), [vec!["apply", "stream", "cell-reduce"], cells.clone()]);
    assert_eq!(shared(rig::BULK, Occasion::First), [vec!["stream", "cell-reduce"], cells]);
    assert!(shared(rig::BULK, Occasion::Last).is_empty());
    // Ghosts add to the sums before they are used. The map of squirmers is emptied where cells are at work anyway.
    let particles = vec!["apply", "stream", "squirmer-collide", "cell-reduce"];
    let cells = vec!["rotate", "restore-thermostat", "squirmer-collide"];
    assert_eq!(shared(rig::EVERYTHING, Occasion::Next), [particles, cells]);
}

/// Who meets a wall or a squirmer waits, and begins there anew.
#[test]
fn the_few_have_a_kernel_of_their_own() {
    let particles = ["apply", "stream", "squirmer-collide", "cell-reduce"];
    let kinds_of = |item: &Item, kinds: &[&'static str]| -> Vec<&'static str> {
        item.members().iter().map(|m| kinds[m.stage]).collect()
    };
    let (kinds, items) = planned(rig::EVERYTHING, Occasion::Next, &slit_of(6));
    let at = items.iter().position(|i| matches!(i, Item::Sifted(_))).expect("a sifted kernel");
    assert_eq!(kinds_of(&items[at], &kinds), particles);
    assert!(matches!(&items[at + 1], Item::Held(_)));
    assert_eq!(kinds_of(&items[at + 1], &kinds), particles[1..]);
    // Without walls they fly freely first.
    let (kinds, items) = planned(rig::EVERYTHING, Occasion::Next, &Sizes { wall_cells: 0, ..slit_of(6) });
    let held = items.iter().find(|i| matches!(i, Item::Held(_))).expect("they wait for a kernel");
    assert_eq!(kinds_of(held, &kinds), particles[2..]);
    // Without squirmers either, nobody waits.
    let (_, items) = planned(rig::BULK, Occasion::Next, &Sizes { wall_cells: 0, squirmers: 0, ..slit_of(0) });
    assert!(!items.iter().any(|i| matches!(i, Item::Sifted(_) | Item::Held(_))));
}

/// In bricks the sums are made where they are used, with the ghosts; sorting is needless.
#[test]
fn bricks_gather_last_and_are_not_sorted() {
    let sizes = Sizes { cells: 6400, room: 864, ..slit_of(6) };
    let (_, items) = planned(rig::EVERYTHING, Occasion::Next, &sizes);
    let entries = |i: &Item| i.members().iter().map(|m| m.phase.entry).collect::<Vec<_>>();
    let bricks: Vec<_> = items.iter().filter(|i| matches!(i, Item::Bricks(..))).map(entries).collect();
    assert_eq!(bricks, [vec!["apply", "stream", "collide", "tally"], vec!["stream", "collide", "tally"]]);
    assert_eq!(
        entries(items.last().expect("kernels")),
        ["gather", "observe_bricks", "fill_cells", "rotate", "restore", "clear_map"]
    );
    assert!(items.iter().flat_map(entries).all(|e| e != "scatter" && e != "count"));
}

/// Without squirmers nothing lies between a collision and the next motion: both are one kernel, which needs the shift of either step.
#[test]
fn a_fluid_alone_collides_and_moves_in_one_kernel() {
    let entries = |i: &Item| i.members().iter().map(|m| m.phase.entry).collect::<Vec<_>>();
    let collision = ["gather", "rotate", "restore"];
    let motion = ["stream", "tally"];
    let both = [&collision[..], &["apply"], &motion].concat();
    let sizes = Sizes { cells: 6400, room: 864, at_once: true, wall_cells: 0, ..slit_of(0) };
    let order = |occasion, sizes| planned(rig::BULK, occasion, sizes).1;
    assert_eq!(order(Occasion::First, &sizes).iter().map(entries).collect::<Vec<_>>(), [motion.to_vec()]);
    let next = order(Occasion::Next, &sizes);
    assert_eq!(next.iter().map(entries).collect::<Vec<_>>(), std::slice::from_ref(&both));
    assert_eq!(
        order(Occasion::Last, &sizes).iter().map(entries).collect::<Vec<_>>(),
        [[&collision[..], &["apply"]].concat()]
    );
    let shifts = |i: &Item| {
        let names = |m: &squirm::graph::fused::Member| m.uses.iter().map(|u| u.buffer.clone()).collect::<Vec<_>>();
        i.members().iter().map(|m| names(m).into_iter().find(|n| n.starts_with("shift"))).collect::<Vec<_>>()
    };
    let before = Some("shift_before".to_owned());
    assert_eq!(shifts(&next[0]), [&before, &None, &None, &before, &None, &Some("shift".to_owned())].map(Clone::clone));
    // Walls are filled in it, and receive after it.
    let walled = Sizes { wall_cells: slit_of(0).wall_cells, ..sizes };
    let in_slit: Vec<&str> = rig::EVERYTHING.iter().copied().filter(|k| !k.starts_with("squirmer")).collect();
    let next = planned(&in_slit, Occasion::Next, &walled).1;
    let both = [&["gather", "observe_bricks", "fill_cells"][..], &both[1..]].concat();
    let expected = [both, vec!["receive"], vec!["draw_behind"], motion.to_vec()];
    assert_eq!(next.iter().map(entries).collect::<Vec<_>>(), expected);
    assert_eq!(shifts(&next[0])[1], before);
    assert!(next[0].members()[1].text().contains("shift_before["));
}

/// Squirmers move by what their ghosts received.
#[test]
fn squirmers_come_between_a_collision_and_the_next_motion() {
    let (slit, start) = active_slit();
    let at_once = |system: &System, kinds: &[&str]| {
        let plan = rig::plan(system, kinds, &[]);
        squirm::graph::fused::sizes(&plan, start.particles.len() as u64, Some(Gathering::Bricks)).at_once
    };
    assert!(!at_once(&slit, rig::EVERYTHING));
    // Nor where particles do not meet them, but cells hold their ghosts.
    let unmet: Vec<&str> = rig::EVERYTHING.iter().copied().filter(|k| *k != "squirmer-collide").collect();
    assert!(!at_once(&slit, &unmet));
    let run = |form| left(&slit, &start, &unmet, &[], (form, Lanes::One, Gathering::Bricks));
    assert_eq!(run(Form::Loose), run(Form::Fused));
    let in_slit: Vec<&str> = rig::EVERYTHING.iter().copied().filter(|k| !k.starts_with("squirmer")).collect();
    assert!(at_once(&System { species: Vec::new(), ..slit }, &in_slit));
    assert!(at_once(&rig::system([9, 10, 33]), rig::BULK));
}

/// Entry points that share a workgroup, in order.
fn small(kinds: &[&str], squirmers: u64) -> Vec<Vec<&'static str>> {
    let (_, items) = planned(kinds, Occasion::Next, &slit_of(squirmers));
    let small = items.iter().filter(|i| matches!(i, Item::Small(_)));
    small.map(|i| i.members().iter().map(|m| m.phase.entry).collect()).collect()
}

#[test]
fn what_shares_a_workgroup() {
    assert!(small(rig::BULK, 0).is_empty());
    assert_eq!(small(rig::EVERYTHING, 6), [["absorb", "drift_first", "force", "kick_drift"]]);
    // 64 invocations for each of 33 squirmers are many; squirmers are from 257 on.
    assert_eq!(small(rig::EVERYTHING, 32), small(rig::EVERYTHING, 6));
    assert_eq!(small(rig::EVERYTHING, 33), [["absorb", "drift_first"]]);
    assert_eq!(small(rig::EVERYTHING, 256), small(rig::EVERYTHING, 33));
    assert!(small(rig::EVERYTHING, 257).is_empty() && small(rig::EVERYTHING, 1025).is_empty());
    // Kernels over nothing are none.
    let (_, items) = planned(rig::EVERYTHING, Occasion::Next, &slit_of(6));
    assert!(items.iter().flat_map(Item::members).all(|m| !m.phase.entry.contains("bins")));
}

/// What uses nothing that the other writes shares a dispatch; a step has no more of them than the longest of its chains.
#[test]
fn what_is_side_by_side() {
    let beside = |sizes: &Sizes| {
        let (_, items) = planned(rig::EVERYTHING, Occasion::Next, sizes);
        let entries = |i: &Item| i.members().iter().map(|m| m.phase.entry).collect::<Vec<_>>();
        let found: Vec<_> = items.iter().filter(|i| matches!(i, Item::Beside(_))).map(entries).collect();
        (items.len(), found)
    };
    let received = ["receive", "receive", "clear_sums"];
    let (count, found) = beside(&slit_of(6));
    let filled = [&["mark_map", "draw"][..], &["absorb", "gather"], &["prepare", "observe", "tally"]];
    assert_eq!(found, [&[&received[..]], &filled[..]].concat());
    assert_eq!(count, 10);
    // Sums in bricks have workgroups of their own size.
    let bricks = Sizes { cells: 6400, room: 864, ..slit_of(6) };
    assert_eq!(beside(&bricks), (8, vec![received.to_vec(), vec!["mark_map", "draw_behind", "draw"]]));
    // Of more squirmers than one workgroup moves the forces take so long that the ghosts behind walls are drawn meanwhile.
    let more = beside(&Sizes { squirmers: 300, ..bricks });
    assert_eq!(more.1[1], ["force", "draw_behind"]);
    assert!(beside(&Sizes { wall_cells: 0, squirmers: 0, ..slit_of(0) }).1.is_empty());
}

/// Squirmers of which there are too many for one workgroup are moved by as few kernels as the forces between them allow.
#[test]
fn what_an_invocation_does_in_turn() {
    let in_turn = |kinds: &[&str], sizes: &Sizes| {
        let (_, items) = planned(kinds, Occasion::Next, sizes);
        let entries = |i: &Item| i.members().iter().map(|m| m.phase.entry).collect::<Vec<_>>();
        items.iter().filter(|i| matches!(i, Item::InTurn(_))).map(entries).collect::<Vec<_>>()
    };
    assert!(in_turn(rig::EVERYTHING, &slit_of(256)).is_empty());
    assert_eq!(in_turn(rig::EVERYTHING, &slit_of(257)), [["absorb", "drift_first"]]);
    let bricks = |squirmers| Sizes { cells: 6400, room: 864, wall_cells: 0, wall_patches: 0, ..slit_of(squirmers) };
    let free: Vec<&str> = rig::EVERYTHING.iter().copied().filter(|k| *k != "wall-ghosts").collect();
    // With bins.
    let found = in_turn(&free, &bricks(2000));
    assert_eq!(found, [&["absorb", "drift_first", "fill_bins"][..], &["absorb", "prepare"]]);
}

/// Every substep is told its number.
#[test]
fn substeps_share_no_workgroup() {
    let stages = [(stages::find("squirmer-move").expect("a stage"), 3, true)];
    let items = items(&stages, Occasion::First, &slit_of(6)).expect("valid");
    let entries = |i: &Item| i.members().iter().map(|m| (m.phase.entry, m.repetition)).collect::<Vec<_>>();
    let substep = |k| ["drift_first", "force", "kick_drift"].map(|entry| (entry, k)).to_vec();
    assert_eq!(items.iter().map(entries).collect::<Vec<_>>(), [0, 1, 2].map(substep));
}
