//! The command line: exit statuses, what is printed where, and that a wrong file starts and writes nothing.

use std::path::Path;
use std::process::{Command, Output, Stdio};

const GOOD: &str = "[run]\nsteps = 10\ndt = 0.1\n[box]\nsize = [8, 8, 8]\n\
    [[stage]]\nkind = \"stream\"\n[[stage]]\nkind = \"shift-grid\"\n[[stage]]\nkind = \"cell-reduce\"\n\
    [[stage]]\nkind = \"rotate\"\n[[stage]]\nkind = \"restore-thermostat\"\n\
    [[output]]\nrecord = [\"scalars\"]\nevery = 5\n";

/// Runs `squirm` in a folder that holds `f.toml`, and checks that it leaves nothing else there.
fn squirm(file: &str, arguments: &[&str]) -> (i32, String, String) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("f.toml"), file).expect("written");
    let Output { status, stdout, stderr } = command(folder.path(), arguments);
    assert_eq!(std::fs::read_dir(folder.path()).expect("still there").count(), 1, "something was written");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (status.code().expect("not killed"), text(stdout), text(stderr))
}

fn command(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_squirm"));
    command.current_dir(folder).args(arguments).env("NO_COLOR", "1").env("COLUMNS", "200").output().expect("it starts")
}

#[test]
fn check_prints_what_a_file_means() {
    let (code, out, err) = squirm(GOOD, &["check", "f.toml"]);
    assert_eq!((code, err.as_str()), (0, ""));
    for part in [
        "viscosity  eta",
        "(formula: ",
        "Schmidt number",
        "512 cells, 5 120 particles",
        "GPU ",
        "disk ",
        " for 3 checkpoints of ",
    ] {
        assert!(out.contains(part), "{part}: {out}");
    }
    let (_, out, _) = squirm(GOOD, &["check", "f.toml", "--set", "box.size=[16,8,8]"]);
    assert!(out.contains("1 024 cells"), "{out}");
}

#[test]
fn a_wrong_file_is_status_two_with_place_reason_and_remedy() {
    for command in [&["check", "f.toml"][..], &["run", "f.toml"], &["graph", "f.toml"]] {
        let (code, out, err) = squirm(&GOOD.replace("steps", "stpes"), command);
        assert_eq!((code, out.as_str()), (2, ""), "{err}");
        for part in ["f.toml:2:1", "no parameter `stpes`", "did you mean `steps`?", "lacks `steps`", "2 errors"] {
            assert!(err.contains(part), "{part}: {err}");
        }
        assert!(!err.contains('\u{1b}'), "colours in spite of NO_COLOR: {err}");
    }
    let (code, _, err) = squirm(GOOD, &["run", "f.toml", "--set", "run.steps=abc"]);
    assert!(code == 2 && err.contains("--set run.steps=abc:1:11"), "{err}");
}

#[test]
fn a_file_that_cannot_be_read_is_status_two() {
    let (code, _, err) = squirm(GOOD, &["check", "absent.toml"]);
    assert!(code == 2 && err.contains("absent.toml cannot be read"), "{err}");
    let (code, _, err) = squirm(GOOD, &["check", "f.toml", "absent.toml"]);
    assert!(code == 2, "{err}");
}

#[test]
fn what_a_run_cannot_start_from_is_status_two_and_writes_nothing() {
    for (arguments, part) in [
        (&["--adapter", "nonsense"][..], "no adapter is called or numbered `nonsense`; there are: 0 ("),
        (&["--adapter", ""], "--adapter"),
        (&["--out", "f.toml"], "f.toml is a file, not a directory"),
        (&["--set", "init.from=f.toml"], "f.toml:1: the header is"),
        (&["--set", "init.from=."], "cannot be read: "),
    ] {
        let (code, _, err) = squirm(GOOD, &[&["run", "f.toml"], arguments].concat());
        assert!(code == 2 && err.contains(part), "{arguments:?}: {code}: {err}");
    }
}

#[test]
fn a_reader_that_has_gone_is_no_failure() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("f.toml"), GOOD).expect("written");
    let mut command = Command::new(env!("CARGO_BIN_EXE_squirm"));
    command.current_dir(folder.path()).args(["run", "f.toml", "--out", "run"]);
    let mut run = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    drop((run.stdout.take(), run.stderr.take()));
    assert!(run.wait().expect("a child").success());
    assert!(folder.path().join("run/summary.json").exists());
}

#[test]
fn usage_errors_are_status_two() {
    assert_eq!(squirm(GOOD, &["chekc"]).0, 2);
    assert_eq!(squirm(GOOD, &["check"]).0, 2);
    let (code, _, err) = squirm(GOOD, &["stages", "rotat"]);
    assert!(code == 2 && err.contains("did you mean `rotate`?"), "{err}");
}

#[test]
fn graphs_are_drawn_in_three_ways() {
    let (code, out, _) = squirm(GOOD, &["graph", "f.toml"]);
    assert!(code == 0 && out.lines().any(|l| l.starts_with("rotate ")), "{out}");
    assert!(squirm(GOOD, &["graph", "f.toml", "--format", "dot"]).1.starts_with("digraph \"f\" {"));
    assert!(squirm(GOOD, &["graph", "f.toml", "--format", "mermaid"]).1.starts_with("flowchart LR"));
}

#[test]
fn stages_document_parameters_with_unit_range_and_default() {
    let (code, out, _) = squirm(GOOD, &["stages", "rotate"]);
    assert_eq!(code, 0);
    assert!(out.contains("angle: a number from 0 to 180, in degree; default 130.0"), "{out}");
    let (_, all, _) = squirm(GOOD, &["stages"]);
    let (_, sections, _) = squirm(GOOD, &["stages", "all"]);
    for entry in squirm::stages::REGISTRY {
        assert!(all.lines().any(|l| l == entry.kind), "{}", entry.kind);
    }
    assert!(
        sections.contains("[[squirmers]]") && sections.contains("semi_axes: a table with along, across"),
        "{sections}"
    );
    assert!(sections.ends_with(&all));
}

#[test]
fn schema_and_completions_are_printed() {
    let (code, out, _) = squirm(GOOD, &["schema"]);
    assert_eq!((code, out), (0, squirm::config::schema()));
    let (code, out, _) = squirm(GOOD, &["completions", "bash"]);
    assert!(code == 0 && out.contains("_squirm()"), "{out}");
}

#[test]
fn very_many_errors_are_cut_short_and_very_long_lines_are_not_drawn() {
    let many = GOOD.to_owned() + &"[[squirmers]]\n".repeat(400);
    let (code, _, err) = squirm(&many, &["check", "f.toml"]);
    assert!(code == 2 && err.contains("\nand ") && err.contains(" more\n"), "{err}");
    assert!(err.len() < 100_000, "{} bytes", err.len());
    // A column beyond 65,535 cannot be drawn.
    let long = GOOD.replace("[8, 8, 8]", &format!("[8, 8, {} 8]", "1,".repeat(50_000)));
    let (code, _, err) = squirm(&long, &["check", "f.toml"]);
    assert!(code == 2 && err.contains("f.toml:5:8: error: "), "{err}");
}

/// A particle that the sums do not hold is the table's fault: it is told by its row, before anything is written.
#[test]
fn a_start_that_is_too_fast_is_status_two() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("f.toml", &format!("init = {{ from = \"p.csv\" }}\n{GOOD}"));
    write("p.csv", "x,y,z,vx,vy,vz\n1,2,3,0,0,0\n1,2,3,50,0,0\n");
    let output = command(folder.path(), &["run", "f.toml"]);
    let err = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(2), "{err}");
    assert!(err.contains("p.csv:3: the speed 50 is above 12") && !folder.path().join("runs").exists(), "{err}");
}
