//! The fused plan against the loose one: the same bits, whatever shares a kernel.

use crate::bench::*;
use crate::collision::{active_slit, continued};
use crate::rig;
use squirm::gpu::{Form, Session};
use squirm::graph::fused::{Item, Occasion, items};
use squirm::params::Value;
use squirm::stages;
use squirm::state::{State, System, packed};

type Change = (&'static str, &'static str, Value);

/// Everything that a run leaves behind, after 1, 8 and 20 steps.
fn left(
    system: &System,
    start: &State,
    kinds: &[&str],
    changes: &[Change],
    form: Form,
) -> Vec<(String, Vec<f32>, [glam::DVec3; 2])> {
    let plan = rig::plan(system, kinds, changes);
    let mut session = Session::formed(rig::gpu(), &plan, start, form).expect("a session");
    [1, 7, 12]
        .map(|steps| {
            session.advance(steps, false);
            assert_eq!(session.faults().expect("readable"), 0);
            let walls = packed::wall_impulses(&session.read("wall_impulses").expect("readable"));
            (session.raw().expect("readable").digest(), session.read("fluid_force").expect("readable"), walls)
        })
        .to_vec()
}

#[test]
fn both_forms_of_a_plan_leave_the_same_bits() {
    let mut gas_box = rig::system([9, 10, 33]);
    gas_box.fluid.acceleration = [0.01, 0.0, -0.02];
    let fluid = state(gas(&gas_box, 31, 30_000), Vec::new());
    let (slit, squirmers) = active_slit();
    let mode = |mode: &str, spin| -> Vec<Change> {
        vec![
            ("restore-thermostat", "mode", Value::Text(mode.into())),
            ("restore-thermostat", "angular_momentum", Value::Boolean(spin)),
        ]
    };
    let cases: [(&System, &State, &[&str], Vec<Change>); 6] = [
        (&gas_box, &fluid, rig::BULK, mode("energy", true)),
        (&gas_box, &fluid, rig::BULK, mode("thermostat", false)),
        (&gas_box, &fluid, &["stream", "shift-grid", "cell-reduce", "rotate", "apply"], Vec::new()),
        (&slit, &squirmers, rig::EVERYTHING, Vec::new()),
        (&slit, &squirmers, rig::EVERYTHING, continued().to_vec()),
        (&slit, &squirmers, rig::EVERYTHING, vec![("rotate", "grip", Value::Float(1.22))]),
    ];
    for (system, start, kinds, changes) in cases {
        let loose = left(system, start, kinds, &changes, Form::Loose);
        for every in [1, 7, 50] {
            let mut changes = changes.clone();
            changes.push(("sort-reorder", "every", Value::Integer(every)));
            assert_eq!(loose, left(system, start, kinds, &changes, Form::Fused), "{kinds:?} {changes:?}");
        }
        let unsorted: Vec<&str> = kinds.iter().copied().filter(|k| *k != "sort-reorder").collect();
        assert_eq!(loose, left(system, start, &unsorted, &changes, Form::Fused), "{unsorted:?} {changes:?}");
    }
}

/// Kinds that share a kernel, in order.
fn shared(kinds: &[&str], occasion: Occasion) -> Vec<Vec<&'static str>> {
    let stages: Vec<_> = kinds.iter().map(|k| (stages::find(k).expect("a stage"), 1, *k != "sort-reorder")).collect();
    let items = items(&stages, occasion).expect("valid");
    let joint = items.iter().filter(|i| matches!(i, Item::Joint(_)));
    joint.map(|i| i.members().iter().map(|m| stages[m.stage].0.kind).collect()).collect()
}

#[test]
fn what_shares_a_kernel() {
    let cells = vec!["cell-reduce", "rotate", "restore-thermostat"];
    assert_eq!(shared(rig::BULK, Occasion::Next), [vec!["apply", "stream", "cell-reduce"], cells.clone()]);
    assert_eq!(shared(rig::BULK, Occasion::First), [vec!["stream", "cell-reduce"], cells]);
    assert!(shared(rig::BULK, Occasion::Last).is_empty());
    // Ghosts add to the sums before they are used.
    let particles = vec!["apply", "stream", "squirmer-collide", "cell-reduce"];
    assert_eq!(shared(rig::EVERYTHING, Occasion::Next), [particles, vec!["rotate", "restore-thermostat"]]);
}
