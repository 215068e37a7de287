//! The resolved file: complete, and it reads back as the same plan.

use super::{GOOD, changed, good, with};
use squirm::graph::Plan;

fn same(a: &Plan, b: &Plan) {
    assert_eq!(a.system, b.system);
    assert_eq!(a.outputs, b.outputs);
    let stages = |p: &Plan| p.stages.iter().map(|s| (s.entry.kind, s.values.clone())).collect::<Vec<_>>();
    assert_eq!(stages(a), stages(b));
    assert_eq!(a.resolved, b.resolved);
}

#[test]
fn it_reads_back_as_the_same_plan() {
    let poses = "start = \"listed\"\nposes = [[5, 5.5, 5, 1, 0, 0], [12, 10, 12, 0.1, 0.2, 0.3]]\nheld = true";
    let odd = changed(&[("start = \"random\"", poses), ("\"puller\"", "'a \"b\" \\ c'"), ("dt = 0.05", "dt = 1e-2")]);
    for text in [GOOD.to_owned(), odd] {
        let first = good(&text).plan;
        same(&first, &good(&first.resolved).plan);
    }
}

#[test]
fn it_holds_defaults_and_overrides() {
    let plan = with(GOOD, &["run.steps=7777"]).unwrap_or_else(|f| panic!("{f}")).plan;
    for line in ["steps = 7777", "velocity_low = [0.0, 0.0, 0.0]", "fraction = 0.1", "kind = \"apply\"", "rotlet = 0.0"]
    {
        assert!(plan.resolved.contains(line), "{line} is not in:\n{}", plan.resolved);
    }
}
