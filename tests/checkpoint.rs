//! Runs that end early go on as if nothing had happened: bit by bit, with every frame once; what cannot go on is refused with a reason.
#![cfg(unix)]

use squirm::checkpoint::{CURRENT, PREVIOUS};
use squirm::gpu::{Form, Gpu, Session};
use std::path::Path;
use std::process::{Command, Output};

/// A fluid of which a step takes a moment; its checkpoints come at odd steps.
const FILE: &str = "run = { steps = 60, dt = 0.1 }\nbox = { size = [8, 8, 8] }\nfluid = { density = 4 }\n\
    stage = [{ kind = \"stream\" }, { kind = \"shift-grid\" }, { kind = \"cell-reduce\" }, { kind = \"rotate\" }, \
    { kind = \"restore-thermostat\" }]\n\
    output = [{ record = [\"scalars\"], csv = [\"scalars\"], every = 4 }]\ncheckpoint = { every = 7 }\n";

/// A folder with the file.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("f.toml"), FILE).expect("written");
    folder
}

/// `squirm run f.toml` with more arguments: status and what it said.
fn run(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_squirm"));
    let Output { status, stderr, .. } =
        command.current_dir(folder).args(["run", "f.toml"]).args(arguments).output().expect("it starts");
    (status.code().expect("not killed"), String::from_utf8(stderr).expect("UTF-8"))
}

#[track_caller]
fn good(folder: &Path, arguments: &[&str]) -> String {
    let (code, said) = run(folder, arguments);
    assert_eq!(code, 0, "{said}");
    said
}

#[track_caller]
fn refused(folder: &Path, arguments: &[&str], status: i32, parts: &[&str]) {
    let (code, said) = run(folder, arguments);
    assert_eq!(code, status, "{said}");
    for part in parts {
        assert!(said.contains(part), "{part}: {said}");
    }
}

fn summary(dir: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(dir.join("summary.json")).expect("a summary")).expect("JSON")
}

/// The step of a checkpoint.
fn step_of(checkpoint: &Path) -> u64 {
    let sections = squirm::checkpoint::decode(std::fs::read(checkpoint).expect("a checkpoint")).expect("whole");
    let note: serde_json::Value = serde_json::from_slice(sections.get("run").expect("there")).expect("JSON");
    note["step"].as_u64().expect("a number")
}

/// Steps of the recorded scalars, over all segments.
fn recorded(dir: &Path) -> Vec<u64> {
    use squirm::analyze::{Recording, Source};
    let mut steps = Vec::new();
    let ending = Recording::new(dir).drive(&[squirm::wire::Kind::Scalars], &mut |s| {
        steps.push(s.header.step);
        Ok(std::ops::ControlFlow::Continue(()))
    });
    assert_eq!(ending.expect("readable").warnings, [""; 0]);
    steps
}

/// State, and all that a run shows besides it, of a session.
fn shown(session: &Session) -> (String, Vec<Vec<u32>>, [glam::DVec3; 2]) {
    let read = |name: &str| session.read::<u32>(name).expect("readable");
    let there: Vec<&str> = session.buffers().map(|(name, _)| name).collect();
    let others = ["steric", "fluid_force", "impulses", "wall_shear", "wall_sums"].iter().filter(|n| there.contains(n));
    let walls = squirm::state::packed::wall_impulses(session.system(), &read("wall_impulses"));
    (session.raw().expect("readable").digest(), others.map(|n| read(n)).collect(), walls)
}

#[test]
fn sessions_of_every_kind_go_on_bit_by_bit() {
    let gpu = Gpu::open(std::env::var("SQUIRM_ADAPTER").ok().as_deref()).expect("an adapter");
    let small = ["box.size=[12,8,12]", "squirmers.puller.count=2", "fluid.density=5"];
    let cases = [
        ("quickstart", &small[..], Form::Fused),
        ("quickstart", &small[..], Form::Loose),
        ("validation/conservation", &["box.size=[8,8,8]"][..], Form::Fused),
    ];
    for (name, smaller, form) in cases {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("pipelines/{name}.toml"));
        let text = std::fs::read_to_string(&path).expect("readable");
        let smaller: Vec<String> = smaller.iter().map(|s| (*s).to_owned()).collect();
        let loaded = squirm::config::load(name, &text, &smaller, path.parent().expect("a folder"));
        let plan = loaded.unwrap_or_else(|e| panic!("{e}")).plan;
        let start = squirm::state::start::start(&plan.system).expect("a start");
        let mut whole = Session::formed(&gpu, &plan, &start, form).expect("a session");
        whole.advance(3, false);
        let particles = whole.particles();
        let kept = whole.persistent().expect("readable");
        let buffers: Vec<(&str, &[u8])> = kept.iter().map(|(n, b)| (*n, b.as_slice())).collect();
        let mut part = Session::resumed(&gpu, &plan, (particles, 3), form, &buffers).expect("it goes on");
        for session in [&mut whole, &mut part] {
            session.advance(6, false);
            session.wait().expect("done");
        }
        assert_eq!(shown(&part), shown(&whole), "{name} {form:?}");
        if name == "quickstart" {
            continue;
        }
        // The comparison can fail: a run that loses one buffer ends elsewhere.
        let lame: Vec<(&str, Vec<u8>)> =
            kept.iter().map(|(n, b)| (*n, if *n == "velocities_yz" { vec![0; b.len()] } else { b.clone() })).collect();
        let lame: Vec<(&str, &[u8])> = lame.iter().map(|(n, b)| (*n, b.as_slice())).collect();
        let mut other = Session::resumed(&gpu, &plan, (particles, 3), form, &lame).expect("it goes on");
        other.advance(6, false);
        assert_ne!(shown(&other).0, shown(&whole).0);
        assert!(Session::resumed(&gpu, &plan, (particles + 1, 3), form, &buffers).is_err(), "another system");
        assert!(Session::resumed(&gpu, &plan, (particles, 3), form, &buffers[1..]).is_err(), "a buffer is missing");
    }
}

#[test]
fn a_run_that_may_not_fit_on_the_disk_is_told_and_begins() {
    let folder = prepared();
    let immense =
        ["run.steps=1000000000000", "output.0.record=[\"particles\"]", "output.0.fraction=1.0", "output.0.every=1"];
    let mut arguments = vec!["--out", "immense", "--walltime", "1"];
    arguments.extend(immense.iter().flat_map(|o| ["--set", o]));
    let said = good(folder.path(), &arguments);
    for part in ["this run may need ", " for outputs before compression, ", " for checkpoints), which has ", " free"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert!(!good(folder.path(), &["--out", "small"]).contains("this run may need"));
}

#[test]
fn the_same_command_goes_on_to_a_later_end_and_then_says_that_it_is_finished() {
    let folder = prepared();
    let at = |dir: &str| folder.path().join(dir);
    good(folder.path(), &["--out", "whole", "--quiet"]);
    good(folder.path(), &["--set", "run.steps=29", "--quiet"]);
    assert_eq!(summary(&at("runs/f"))["speed"]["steps"], 29);
    let said = good(folder.path(), &[]);
    assert!(said.contains("going on after 29 steps"), "{said}");
    let (whole, parts) = (summary(&at("whole")), summary(&at("runs/f")));
    for key in ["digest", "temperature", "books", "snapshots", "stopped"] {
        assert_eq!(whole[key], parts[key], "{key}");
    }
    assert_eq!(recorded(&at("runs/f")), (0..=60).step_by(4).collect::<Vec<_>>());
    assert_eq!(recorded(&at("runs/f")), recorded(&at("whole")));
    let table = |dir: &str| std::fs::read(at(dir).join("scalars.csv")).expect("a table");
    assert!(table("whole") == table("runs/f"));
    assert!(at("runs/f/run.0001.mcap").exists());
    let said = good(folder.path(), &[]);
    assert!(said.contains("runs/f is finished: 60 steps are done; raise run.steps"), "{said}");
    // Another configuration begins elsewhere by itself, but not where it is told to.
    good(folder.path(), &["--set", "fluid.density=3", "--quiet"]);
    assert_eq!(summary(&at("runs/f-2"))["speed"]["steps"], 60);
    let differs = ["--set", "fluid.density=3", "--set", "stage.rotate.angle=90", "--out", "runs/f"];
    let parts =
        ["another configuration", "fluid.density was 4.0, now it is 3.0", ".angle (rotate) was 130.0, now it is 90.0"];
    refused(folder.path(), &differs, 2, &parts);
    refused(folder.path(), &["--plan", "loose", "--out", "runs/f"], 2, &["--plan was fused, now it is loose"]);
    refused(folder.path(), &["--fresh", "--out", "runs/f"], 2, &["--fresh never overwrites"]);
    good(folder.path(), &["--fresh", "--quiet"]);
    assert_eq!(summary(&at("runs/f-3"))["digest"], whole["digest"]);
}

#[test]
fn what_lacks_its_checkpoint_or_its_recording_is_refused() {
    let folder = prepared();
    let dir = folder.path().join("d");
    let arguments = ["--out", "d", "--quiet"];
    good(folder.path(), &[&arguments[..], &["--set", "run.steps=29"]].concat());
    // Of step 28, unless the disk was still busy with the one before when it was due.
    let before = step_of(&dir.join(PREVIOUS));
    assert!(before > 0 && before <= 28 && before.is_multiple_of(7), "{before}");
    let kept: Vec<(&str, Vec<u8>)> =
        [CURRENT, PREVIOUS, "run.mcap"].map(|n| (n, std::fs::read(dir.join(n)).expect("there"))).to_vec();
    let put_back = || kept.iter().for_each(|(n, bytes)| std::fs::write(dir.join(n), bytes).expect("written"));
    std::fs::write(dir.join("run.mcap"), &kept[2].1[..2000]).expect("cut");
    refused(folder.path(), &arguments, 1, &["run.mcap has", "whole messages, but had 8 at the checkpoint"]);
    put_back();
    std::fs::write(dir.join(CURRENT), &kept[0].1[..100]).expect("cut");
    std::fs::write(dir.join(PREVIOUS), "").expect("cut");
    refused(
        folder.path(),
        &arguments,
        1,
        &["run.checkpoint: it should have", "run.checkpoint.previous: it should have"],
    );
    put_back();
    std::fs::write(dir.join(CURRENT), &kept[0].1[..100]).expect("cut");
    let said = good(folder.path(), &["--out", "d"]);
    assert!(said.contains("was not used: it should have"), "{said}");
    assert!(said.contains(&format!("going on after {before} steps")), "{before}: {said}");
    assert!(dir.join("run.checkpoint.damaged").exists(), "it was put aside");
    assert_eq!(recorded(&dir), (0..=60).step_by(4).collect::<Vec<_>>());
    std::fs::remove_file(dir.join(CURRENT)).expect("removed");
    std::fs::remove_file(dir.join(PREVIOUS)).expect("removed");
    refused(folder.path(), &arguments, 2, &["holds a run already, and no checkpoint"]);
    let off = ["--set", "checkpoint.enabled=false", "--out", "off", "--quiet"];
    good(folder.path(), &off);
    assert!(!folder.path().join("off").join(CURRENT).exists());
    refused(folder.path(), &off, 2, &["holds a run already, and no checkpoint"]);
}

#[test]
fn faults_stop_a_run_with_their_place_and_the_checkpoint_is_from_before() {
    let folder = prepared();
    let dir = folder.path().join("d");
    for (what, parts) in [
        ("nan@33", &["step 34: in cell-reduce, cell (", ") of the shifted grid, particle ", "is not a number"][..]),
        ("infinity@33", &["step 34: in cell-reduce, cell ("]),
        ("lost@33", &["the GPU was lost or refused work: device lost"]),
    ] {
        refused(folder.path(), &["--out", "d", "--inject", what], 1, parts);
        // The last is of step 28, unless the disk was still busy with one before.
        let step = step_of(&dir.join(CURRENT));
        assert!(step > 0 && step <= 28 && step.is_multiple_of(7), "{what}: {step}");
        let steps = recorded(&dir);
        assert!(steps.len() >= 8 && steps.windows(2).all(|w| w[1] == w[0] + 4), "{what}: {steps:?}");
        std::fs::remove_dir_all(&dir).expect("removed");
    }
    good(folder.path(), &["--out", "whole", "--quiet"]);
    // Not where a checkpoint is due, which would find it.
    refused(folder.path(), &["--out", "d", "--inject", "nan@36"], 1, &["step 37"]);
    good(folder.path(), &["--out", "d", "--quiet"]);
    assert_eq!(
        summary(&dir)["digest"],
        summary(&folder.path().join("whole"))["digest"],
        "it goes on without the fault"
    );
}

#[test]
fn time_that_is_up_ends_a_run_with_a_checkpoint() {
    let folder = prepared();
    let dir = folder.path().join("d");
    let long = ["--out", "d", "--quiet", "--set", "run.steps=1000000000"];
    good(folder.path(), &[&long[..], &["--walltime", "0:05"]].concat());
    let summary = summary(&dir);
    assert_eq!(summary["stopped"], true);
    let done = summary["speed"]["steps"].as_u64().expect("a number");
    let said = good(folder.path(), &["--out", "d", "--set", &format!("run.steps={}", done + 3)]);
    assert!(said.contains(&format!("going on after {done} steps")), "{said}");
    refused(folder.path(), &[&long[..], &["--walltime", "soon"]].concat(), 2, &["--walltime"]);
}

/// Killed between its last checkpoint and its summary: all steps are done, but its outputs are not closed.
#[test]
fn a_run_that_lacks_only_its_summary_is_closed_by_the_same_command() {
    let folder = prepared();
    good(folder.path(), &["--out", "d"]);
    let dir = folder.path().join("d");
    let (whole, frames) = (summary(&dir), recorded(&dir));
    refused(folder.path(), &["--out", "d"], 0, &["is finished: 60 steps are done"]);
    let path = dir.join("summary.json");
    let stopped = std::fs::read_to_string(&path).expect("a summary").replace("\"stopped\": false", "\"stopped\": true");
    for unfinished in [None, Some(stopped.as_str()), Some("{")] {
        std::fs::remove_file(&path).expect("removed");
        unfinished.into_iter().for_each(|text| std::fs::write(&path, text).expect("written"));
        let said = good(folder.path(), &["--out", "d"]);
        assert!(said.contains("going on after 60 steps"), "{said}");
        assert_eq!((&summary(&dir)["digest"], recorded(&dir)), (&whole["digest"], frames.clone()));
        assert_eq!(summary(&dir)["stopped"], false);
    }
    refused(folder.path(), &["--out", "d"], 0, &["is finished: 60 steps are done"]);
}

#[test]
fn a_directory_that_is_in_use_or_cannot_be_written_is_refused() {
    let folder = prepared();
    std::fs::create_dir(folder.path().join("used")).expect("made");
    let lock = std::fs::File::open(folder.path().join("used")).expect("a directory");
    lock.try_lock().expect("free");
    refused(folder.path(), &["--out", "used"], 1, &["another process is running in used"]);
    refused(folder.path(), &["--out", "/proc/squirm"], 1, &["cannot create /proc/squirm"]);
}

/// The short forms of the fault suite; each prints what it counted.
fn suite(arguments: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_squirm-faults")).args(arguments).output().expect("it starts");
    let text = String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned();
    println!("{text}");
    assert!(output.status.success(), "{text}");
}

#[test]
fn killed_runs_lose_nothing() {
    suite(&["kill", "--count", "10"]);
}

#[test]
fn damaged_checkpoints_are_refused() {
    suite(&["checkpoints", "--count", "200"]);
}

#[test]
fn damaged_recordings_give_what_was_written_or_nothing() {
    suite(&["recordings", "--count", "100"]);
}

#[test]
fn signals_end_runs_in_order() {
    suite(&["signals", "--count", "3"]);
}

#[test]
fn full_disks_leave_what_was_written() {
    suite(&["disk", "--count", "2"]);
}
