//! Analyzers of a pipeline file: started with the run, killed and started again, given up, ended with a report.

use super::{Process, prepared, squirm, wait_for, wait_until};
use squirm::analyze::{Limits, Live, Source};
use squirm::wire::Kind;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

const SWIM: &str = r#"
[[output]]
publish = ["squirmers", "scalars"]
every = 2
on_slow = "block"
slow_limit = 30
[[analyzer]]
kind = "swim"
"#;

/// Processes whose command line has all these words.
pub fn processes(words: &[&str]) -> Vec<u32> {
    let all = std::fs::read_dir("/proc").expect("Linux").filter_map(Result::ok);
    let numbers = all.filter_map(|e| e.file_name().to_str()?.parse().ok());
    let has = |id: &u32| {
        let line = std::fs::read(format!("/proc/{id}/cmdline")).unwrap_or_default();
        let line = String::from_utf8_lossy(&line).into_owned();
        words.iter().all(|w| line.split('\0').any(|part| part == *w))
    };
    numbers.filter(has).collect()
}

#[test]
fn an_analyzer_sees_the_whole_run_and_writes_its_report() {
    let (folder, name) = prepared("whole", SWIM);
    let (code, _, said) =
        squirm(folder.path(), &["run", &format!("{name}.toml"), "--out", "out", "--set", "run.steps=400"]);
    assert_eq!(code, Some(0), "{said}");
    let log = std::fs::read_to_string(folder.path().join("out/swim.log")).expect("a log");
    // The start and every second step: none is missing, for the run waits for its analyzer.
    assert!(log.contains("201 snapshots; "), "{log}");
    assert!(log.lines().next().is_some_and(|l| l.contains(&format!("squirm-analyze swim --live {name}"))), "{log}");
    let files = std::fs::read_dir(folder.path().join("out/swim")).expect("a folder").count();
    assert!(files > 1, "{files}");
}

/// Longest time between two snapshots, as a reader that is always quick sees it.
fn longest_pause(run: &str, duration: Duration) -> (Duration, u64) {
    let (mut last, mut longest) = (None::<Instant>, Duration::ZERO);
    let limits = Limits { duration: Some(duration), ..Limits::default() };
    let ending = Live::new(run, limits).drive(&[Kind::Scalars], &mut |_| {
        longest = last.map_or(longest, |last| longest.max(last.elapsed()));
        last = Some(Instant::now());
        Ok(ControlFlow::Continue(()))
    });
    (longest, ending.expect("it goes on").snapshots)
}

#[test]
fn an_analyzer_that_is_killed_ten_times_is_started_again_and_the_run_goes_on() {
    let (folder, name) = prepared("kills", &SWIM.replace("\"block\"", "\"drop\""));
    let run = Process::run(folder.path(), &name, "out");
    wait_for(folder.path(), &name);
    let before = longest_pause(&name, Duration::from_secs(3));
    let watched = name.clone();
    let reader = std::thread::spawn(move || longest_pause(&watched, Duration::from_secs(9)));
    for kill in 0..10 {
        let id = wait_until(&format!("no analyzer after {kill} kills"), || {
            processes(&["swim", "--live", &name]).first().copied()
        });
        let status = Command::new("kill").args(["-KILL", &id.to_string()]).status().expect("kill is there");
        assert!(status.success());
        wait_until("a killed process stays", || processes(&["swim", &name]).iter().all(|p| *p != id).then_some(()));
    }
    let during = reader.join().expect("no panic");
    eprintln!("longest pause between two snapshots: {:?} with 10 kills, {:?} without", during.0, before.0);
    assert!(during.1 > 0 && during.0 < Duration::from_secs(5), "{during:?}, before: {before:?}");
    wait_until("no analyzer after the last kill", || processes(&["swim", "--live", &name]).first().copied());
    run.signal("-TERM");
    let (code, _, said) = run.end();
    assert_eq!(code, Some(143), "{said}");
    assert_eq!(said.matches("is started again").count(), 10, "{said}");
    assert_eq!(processes(&["swim", &name]), Vec::<u32>::new(), "nobody is left");
}

fn own(folder: &Path, script: &str) -> String {
    let program = folder.join("mine.sh");
    std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).expect("written");
    format!("[[analyzer]]\ncommand = [\"sh\", \"{}\", \"{{run}}\"]\nout = \"mine\"\n", program.display())
}

#[test]
fn a_program_of_the_users_own_gets_name_and_folder_and_is_given_up_if_it_never_works() {
    let folder = tempfile::tempdir().expect("a folder");
    let analyzers = own(folder.path(), "echo run $1, $SQUIRM_RUN, ${SQUIRM_OUT##*/}\nexit 3");
    let (other, name) = prepared("own", &analyzers);
    let run = Process::run(other.path(), &name, "out");
    let log = other.path().join("out/mine.log");
    let line = format!("run {name}, {name}, mine");
    let count = || std::fs::read_to_string(&log).map_or(0, |text| text.matches(&line).count());
    wait_until("it is not started 11 times", || (count() == 11).then_some(()));
    std::thread::sleep(Duration::from_millis(1500));
    assert_eq!(count(), 11, "then it is given up");
    run.signal("-INT");
    let (code, _, said) = run.end();
    assert_eq!(code, Some(130));
    assert!(said.contains("11 times within a minute: the run goes on without it"), "{said}");
}

#[test]
fn a_program_that_does_not_end_is_ended() {
    let folder = tempfile::tempdir().expect("a folder");
    let analyzers = own(folder.path(), "trap '' TERM\nwhile true; do sleep 0.1; done");
    let (other, name) = prepared("stays", &analyzers);
    let run = Process::run(other.path(), &name, "out");
    wait_for(other.path(), &name);
    run.signal("-TERM");
    let begun = Instant::now();
    let (code, _, said) = run.end();
    assert_eq!(code, Some(143), "{said}");
    assert!(said.contains("did not end and was killed"), "{said}");
    assert!(begun.elapsed() < Duration::from_secs(30), "{:?}", begun.elapsed());
}
