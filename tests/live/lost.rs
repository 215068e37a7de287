//! What was lost although it was not to be: the run says it in its summary, in its last line and with its status.

use super::{Process, listed, prepared, wait_until};
use std::process::Command;

/// The run waits for its analyzer, but not long.
const OUTPUT: &str = r#"
[[output]]
publish = ["squirmers"]
every = 1
on_slow = "block"
slow_limit = 0.3
[[analyzer]]
kind = "swim"
"#;

fn signal(signal: &str, process: u32) {
    assert!(Command::new("kill").args([signal, &process.to_string()]).status().expect("kill is there").success());
}

#[test]
fn an_analyzer_that_is_stopped_too_long_makes_the_status_3_and_the_last_line_says_why() {
    let (folder, name) = prepared("lost", OUTPUT);
    let mut arguments = vec!["run".to_owned(), format!("{name}.toml")];
    arguments.extend(["--out", "out", "--quiet", "--set", "run.steps=4000"].map(str::to_owned));
    let run = Process::start(folder.path(), &arguments.iter().map(String::as_str).collect::<Vec<_>>());
    let watched = || Some(listed(folder.path(), &name)?["subscribers"]["squirmers"] == 1).filter(|there| *there);
    wait_until("the analyzer does not attach", watched);
    let analyzer = super::analyzers::processes(&["swim", "--live", &name]);
    assert_eq!(analyzer.len(), 1);
    signal("-STOP", analyzer[0]);
    wait_until("the run waits for ever", || {
        let run = listed(folder.path(), &name)?;
        (run["dropped"].as_f64() > Some(0.0)).then_some(())
    });
    // While there are snapshots to come: a reader sees a gap by what follows it.
    signal("-CONT", analyzer[0]);
    let (code, _, said) = run.end();
    assert_eq!(code, Some(3), "{said}");
    let last = said.lines().last().expect("a line");
    let parts = ["data were lost: squirmers: ", " did not reach a reader", "the analyzer swim missed snapshots; see "];
    parts.iter().for_each(|part| assert!(last.contains(part), "{part}: {said}"));
    let text = std::fs::read_to_string(folder.path().join("out/summary.json")).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(summary["lost"].as_array().map(Vec::len), Some(2), "{summary}");
    assert!(summary["dropped"].as_u64() > Some(0), "{summary}");
    let log = std::fs::read_to_string(folder.path().join("out/swim.log")).expect("a log");
    assert!(log.contains("snapshots passed unseen"), "{log}");
}
