//! Runs as processes: watched while they go, killed, stopped by signals, refused.

use super::{PATIENCE, Process, prepared, squirm};
use squirm::analyze::{Ending, Recording, Source};
use squirm::wire::Kind;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// Publishes and records often.
const OUTPUT: &str = r#"
[[output]]
record = ["squirmers", "scalars"]
publish = ["squirmers", "scalars"]
every = 2
"#;

/// Waits until a recording has this many bytes.
fn grown(path: &Path, bytes: u64) {
    let begun = Instant::now();
    while path.metadata().map_or(0, |m| m.len()) < bytes {
        assert!(begun.elapsed() < PATIENCE, "{} does not grow", path.display());
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn analyze(folder: &Path, name: &str, snapshots: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_squirm-analyze"));
    let out = format!("swim-{snapshots}");
    let arguments = ["swim", "--live", name, "--snapshots", snapshots, "--out", &out];
    command.current_dir(folder).args(arguments).output().expect("it starts")
}

/// Steps of the squirmers' snapshots in a recording, and how it ended.
fn steps(path: &Path) -> (Vec<u64>, Ending) {
    let mut steps = Vec::new();
    let ending = Recording::new(path).drive(&[Kind::Squirmers], &mut |s| {
        steps.push(s.header.step);
        Ok(ControlFlow::Continue(()))
    });
    (steps, ending.expect("readable"))
}

#[track_caller]
fn gapless(steps: &[u64]) {
    let expected: Vec<u64> = (0..steps.len() as u64).map(|i| 2 * i).collect();
    assert!(steps.len() > 2 && steps == expected, "{steps:?}");
}

#[test]
fn analyzers_come_and_go_and_a_killed_run_can_be_read() {
    let (folder, name) = prepared("come-and-go", OUTPUT);
    let run = Process::run(folder.path(), &name, "out");
    let recording = folder.path().join("out/run.mcap");
    grown(&recording, 20_000);
    let text = |o: &Output| String::from_utf8_lossy(&[&o.stdout[..], &o.stderr[..]].concat()).into_owned();
    let first = analyze(folder.path(), &name, "12");
    assert!(first.status.success() && text(&first).contains("12 snapshots"), "{}", text(&first));
    let arguments = ["swim", "--live", &name, "--out", "killed"];
    let analyzer = Process::of(env!("CARGO_BIN_EXE_squirm-analyze"), folder.path(), &arguments);
    std::thread::sleep(Duration::from_millis(500));
    analyzer.signal("-KILL");
    assert_eq!(analyzer.end().0, None, "it was killed while it watched");
    let again = analyze(folder.path(), &name, "8");
    assert!(again.status.success() && text(&again).contains("8 snapshots"), "{}", text(&again));
    run.signal("-KILL");
    assert_eq!(run.end().0, None);
    let (steps, ending) = steps(&recording);
    gapless(&steps);
    assert_eq!(ending.warnings.len(), 1, "it says that the end is missing");
    let late = analyze(folder.path(), &name, "5");
    assert!(!late.status.success() && text(&late).contains("no run named"), "{}", text(&late));
}

#[test]
fn a_signal_ends_a_run_with_complete_files() {
    for (signal, status) in [("-INT", 130), ("-TERM", 143)] {
        let (folder, name) = prepared(&format!("signal{status}"), OUTPUT);
        let run = Process::run(folder.path(), &name, "out");
        let recording = folder.path().join("out/run.mcap");
        grown(&recording, 20_000);
        run.signal(signal);
        let (code, _, said) = run.end();
        assert_eq!(code, Some(status), "{said}");
        let (steps, ending) = steps(&recording);
        gapless(&steps);
        assert_eq!(ending.warnings, Vec::<String>::new(), "the file is complete");
        let text = std::fs::read_to_string(folder.path().join("out/summary.json")).expect("a summary");
        let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(summary["stopped"], true);
        let done = summary["speed"]["steps"].as_u64().expect("a number");
        assert!(done - steps.last().expect("some") < 2, "{done} steps, but {steps:?}");
        assert!(text.contains(&format!("stopped after {done} of 100000000 steps")), "{text}");
    }
}

#[test]
fn a_directory_that_holds_a_run_is_refused_at_once() {
    let (folder, name) = prepared("occupied", OUTPUT);
    let refused = |out: &str, part: &str| {
        let (code, _, said) = squirm(folder.path(), &["run", &format!("{name}.toml"), "--out", out]);
        assert!(code == Some(2) && said.contains(part), "{said}");
    };
    std::fs::create_dir(folder.path().join("old")).expect("made");
    std::fs::write(folder.path().join("old/summary.json"), "{}").expect("written");
    refused("old", "holds a run already");
    refused(&format!("{name}.toml"), "is a file, not a directory");
    refused(&format!("{name}.toml/inside"), "is a file, not a directory");
    assert_eq!(std::fs::read_dir(folder.path().join("old")).expect("a folder").count(), 1);
}
