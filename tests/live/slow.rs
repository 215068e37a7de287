//! A stopped reader of a run whose output says what happens then.

use super::{Process, prepared, wait_for};
use squirm::analyze::{Recording, Source};
use squirm::wire::Kind;
use std::ops::ControlFlow;

fn output(on_slow: &str) -> String {
    let both = "publish = [\"scalars\"]\nrecord = [\"scalars\"]\nevery = 1\nslow_limit = 0.5\n";
    format!("[[output]]\n{both}on_slow = \"{on_slow}\"\n")
}

/// Steps in the recording; it must be complete.
#[track_caller]
fn recorded(folder: &std::path::Path) -> u64 {
    let mut steps = Vec::new();
    let ending = Recording::new(&folder.join("out/run.mcap")).drive(&[Kind::Scalars], &mut |s| {
        steps.push(s.header.step);
        Ok(ControlFlow::Continue(()))
    });
    assert_eq!(ending.expect("readable").warnings, Vec::<String>::new());
    assert!(steps.iter().zip(0..).all(|(a, b)| *a == b), "{steps:?}");
    steps.len() as u64
}

/// A `squirm tap` that has attached to the scalars of a run.
fn tapped(folder: &std::path::Path, name: &str, more: &[&str]) -> Process {
    let tap = Process::start(folder, &[&["tap", name, "scalars"], more].concat());
    super::wait_until("nobody taps", || {
        let row = super::listed(folder, name)?;
        (row["subscribers"]["scalars"] == 1).then_some(())
    });
    tap
}

#[test]
fn abort_ends_the_run_with_a_complete_recording() {
    let (folder, name) = prepared("abort", &output("abort"));
    let run = Process::run(folder.path(), &name, "out");
    wait_for(folder.path(), &name);
    let tap = tapped(folder.path(), &name, &[]);
    tap.signal("-STOP");
    let (code, _, said) = run.end();
    assert!(code == Some(1) && said.contains("a reader of scalars took no snapshot for 0.5 s"), "{said}");
    assert!(recorded(folder.path()) > 1);
}

#[test]
fn block_goes_on_without_a_stopped_reader_and_loses_nothing_of_the_recording() {
    let (folder, name) = prepared("block", &output("block"));
    let run = Process::run(folder.path(), &name, "out");
    wait_for(folder.path(), &name);
    let tap = tapped(folder.path(), &name, &[]);
    tap.signal("-STOP");
    let stopped_at = wait_for(folder.path(), &name)["step"].as_u64().expect("a number");
    super::wait_until("the run hangs on a stopped reader", || {
        let step = super::listed(folder.path(), &name)?["step"].as_u64()?;
        (step > stopped_at + 20).then_some(())
    });
    run.signal("-INT");
    let (code, _, said) = run.end();
    assert!(code == Some(130) && said.contains("goes on without it until it has caught up"), "{said}");
    assert!(recorded(folder.path()) > stopped_at + 20);
}

/// What Ctrl-Z and fg do to it.
#[test]
fn a_reader_that_was_stopped_goes_on_and_sees_the_gap() {
    // So seldom that the reader is seen in the list before it has all, however fast the run is.
    let (folder, name) = prepared("goes-on", &output("drop").replace("every = 1\n", "every = 50\n"));
    let run = Process::run(folder.path(), &name, "out");
    wait_for(folder.path(), &name);
    let tap = tapped(folder.path(), &name, &["--json", "--count", "50"]);
    for _ in 0..3 {
        tap.signal("-STOP");
        std::thread::sleep(std::time::Duration::from_millis(200));
        tap.signal("-CONT");
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    let (code, out, said) = tap.end();
    assert_eq!((code, out.lines().count()), (Some(0), 50), "{said}");
    run.signal("-INT");
    assert_eq!(run.end().0, Some(130));
}

/// A topic that is silent does not keep its reader from ending.
#[test]
fn a_tap_ends_at_ctrl_c_also_while_nothing_comes() {
    let rare = "[[output]]\npublish = [\"scalars\"]\nevery = 1000000000\n";
    let (folder, name) = prepared("silent", rare);
    let run = Process::run(folder.path(), &name, "out");
    wait_for(folder.path(), &name);
    let tap = tapped(folder.path(), &name, &[]);
    std::thread::sleep(std::time::Duration::from_millis(300));
    tap.signal("-INT");
    let (code, _, said) = tap.end();
    assert_eq!((code, said.as_str()), (Some(130), ""));
    run.signal("-INT");
    assert_eq!(run.end().0, Some(130));
}
