//! Arrays that are larger than what a kernel can bind lie in several buffers, and nothing else changes.

use crate::bench::{gas, state};
use crate::collision::{active_slit, continued};
use crate::rig;
use squirm::buffers::Gathering;
use squirm::gpu::measure::Wanted;
use squirm::gpu::{Form, Gpu, GpuError, Measurement, Session};
use squirm::graph::Plan;
use squirm::state::State;

/// The adapter, as if it could bind no more than so many bytes in one piece.
fn narrow(gathering: Gathering, largest_binding: u64) -> Gpu {
    let mut gpu = rig::gpu().clone();
    gpu.gathering = Some(gathering);
    gpu.summary.largest_binding = largest_binding;
    gpu
}

/// The same, as if no buffer could be larger than five times that either.
fn small(gathering: Gathering, largest_binding: u64) -> Gpu {
    let mut gpu = narrow(gathering, largest_binding);
    gpu.summary.largest_buffer = 5 * largest_binding;
    gpu
}

/// What a run leaves behind, and what a snapshot of all of its fluid says.
fn left(gpu: &Gpu, plan: &Plan, start: &State, form: Form) -> (String, Vec<f32>, Vec<[u32; 6]>) {
    let mut session = Session::formed(gpu, plan, start, form).expect("a session");
    let all = Wanted { totals: true, block: Some(2), fraction: Some(1.0) };
    let measurement = Measurement::new(&session, all).expect("a measurement");
    for steps in [1, 4] {
        session.advance(steps, false);
    }
    // On in another, from what a checkpoint has.
    let kept = session.persistent().expect("readable");
    let kept: Vec<(&str, &[u8])> = kept.iter().map(|(name, bytes)| (*name, bytes.as_slice())).collect();
    let mut session = Session::resumed(gpu, plan, (session.particles(), 5), form, &kept).expect("resumed");
    session.advance(3, false);
    let reading = measurement.take(&session);
    session.wait().expect("done");
    assert_eq!(session.faults().expect("readable"), 0);
    let parts = reading.take().expect("there");
    // Where particles lie in their row depends on which came first.
    let mut samples: Vec<[u32; 6]> = parts.get::<u32>("samples").as_chunks().0.to_vec();
    samples.sort_unstable();
    (session.raw().expect("readable").digest(), parts.get("fields"), samples)
}

fn same_in_parts(plan: &Plan, start: &State, (form, gathering): (Form, Gathering), largest: u64, expected: &[&str]) {
    let whole = narrow(gathering, rig::gpu().summary.largest_binding);
    let session = Session::formed(&whole, plan, start, form).expect("a session");
    for name in expected {
        let bytes = session.buffers().find(|(n, _)| n == name).expect("it is there").1;
        assert!(bytes > largest, "`{name}` has {bytes} bytes only");
    }
    let one = left(&whole, plan, start, form);
    let mut adapters = vec![narrow(gathering, largest)];
    if gathering == Gathering::Bricks {
        // Neither of the two sets lies in one piece, and the row in both.
        adapters.push(small(gathering, largest));
    }
    for parts in adapters {
        let most = parts.summary.largest_buffer;
        assert!(one == left(&parts, plan, start, form), "{form:?} {gathering:?} {largest} {most}");
    }
    assert!(one.1.iter().any(|n| *n > 0.0) && one.2.len() == start.particles.len());
}

#[test]
fn runs_in_parts_leave_the_same_bits() {
    let gas_box = rig::system([9, 10, 33]);
    let fluid = state(gas(&gas_box, 31, 30_000), Vec::new());
    let plan = rig::plan(&gas_box, rig::BULK, &[]);
    let row = ["particles", "velocities_yz"];
    same_in_parts(
        &plan,
        &fluid,
        (Form::Loose, Gathering::Chains),
        150_000,
        &[&row[..], &["moments", "particles_sorted"]].concat(),
    );
    same_in_parts(&plan, &fluid, (Form::Fused, Gathering::Chains), 110_000, &[&row[..], &["links"]].concat());
    let bricks = ["particles", "bricks_xy", "bricks_zu_next", "bricks_vw"];
    same_in_parts(&plan, &fluid, (Form::Fused, Gathering::Bricks), 300_000, &bricks);
    let (slit, squirmers) = active_slit();
    let plan = rig::plan(&slit, rig::EVERYTHING, &continued());
    let cases = [
        ((Form::Loose, Gathering::Chains), 140_000, &["particles", "moments"][..]),
        ((Form::Fused, Gathering::Chains), 140_000, &["particles", "moments"]),
        ((Form::Fused, Gathering::Bricks), 270_000, &["particles", "bricks_xy", "bricks_vw_next"]),
    ];
    for (how, largest, expected) in cases {
        same_in_parts(&plan, &squirmers, how, largest, expected);
    }
}

#[test]
fn more_parts_than_a_kernel_can_bind_are_refused() {
    let system = rig::system([9, 10, 33]);
    let start = state(gas(&system, 31, 30_000), Vec::new());
    let plan = rig::plan(&system, rig::BULK, &[]);
    let mut gpu = narrow(Gathering::Bricks, 60_000);
    gpu.summary.most_bindings = 20;
    let refused = Session::formed(&gpu, &plan, &start, Form::Fused).map(drop).expect_err("too many parts");
    assert!(matches!(&refused, GpuError::TooLarge { needed: 21.., part: 32_768, most: 20, .. }), "{refused:?}");
    // The same is known before there are particles; the plan has as many as lie here.
    let before = Session::fits(&gpu, &plan, Form::Fused).expect_err("too many parts");
    assert!(matches!(&before, GpuError::TooLarge { needed: 21.., .. }), "{before:?}");
    Session::fits(rig::gpu(), &plan, Form::Fused).expect("it fits in one piece");
    let said = refused.to_string();
    assert!(said.starts_with("kernel `") && said.contains("binds 20 at most: make the box smaller"), "{said}");
}
