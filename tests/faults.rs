//! Cases of `squirm-faults` with a few trials each: nothing may be lost. Signals and full disks are in tests/checkpoint.rs, stopped readers
//! in tests/live.
#![cfg(target_os = "linux")]

use std::process::{Command, Output};

fn case(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_squirm-faults"));
    command.args(arguments).args(["--squirm", env!("CARGO_BIN_EXE_squirm")]).output().expect("it starts")
}

/// Runs a case; what it prints must be a table in which every claim holds.
#[track_caller]
fn holds(arguments: &[&str]) -> String {
    let output = case(arguments);
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{out}{err}");
    assert!(out.starts_with("| claim | held | figures |\n"), "{out}");
    out.into_owned()
}

#[test]
fn killed_runs_go_on() {
    holds(&["kill", "--count", "1"]);
}

#[test]
fn damaged_checkpoints_are_refused() {
    holds(&["checkpoints", "--count", "4"]);
}

#[test]
fn damaged_recordings_are_noticed() {
    holds(&["recordings", "--count", "2"]);
}

/// Its claims are about tenths of a second, for which a busy machine may stop anyone: once is borne.
#[test]
fn killed_readers_stop_nobody() {
    let arguments = ["readers", "--count", "1"];
    if !case(&arguments).status.success() {
        holds(&arguments);
    }
}

#[test]
fn too_little_shared_memory_is_an_error_or_done_without() {
    holds(&["memory"]);
}

#[test]
fn changed_pipeline_files_are_checked_to_the_end() {
    let out = holds(&["pipelines", "--count", "1000"]);
    assert!(out.contains("| 1000/1000 |"), "{out}");
}

/// A table in which something fails makes the status 1: a program that is no squirm loses everything.
#[test]
fn a_case_that_finds_a_loss_says_so() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_squirm-faults"));
    let output = command.args(["signals", "--count", "1", "--squirm", "/bin/true"]).output().expect("it starts");
    let out = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.code() == Some(1) && out.contains("| 0/1 |") && out.contains("FAILED"), "{out}");
}
