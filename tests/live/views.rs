//! What `ps`, `tap` and `top` say of a run that is going, of one that ends, and of none.

use super::{Process, listed, prepared, squirm, wait_for};
use serde_json::Value;

const OUTPUT: &str = r#"
[[output]]
publish = ["squirmers", "scalars", "fields", "particles"]
every = 5
"#;

#[test]
fn a_run_is_listed_tapped_and_watched_to_its_end() {
    let (folder, name) = prepared("views", OUTPUT);
    let dir = folder.path();
    let run = Process::run(dir, &name, "out");
    let row = wait_for(dir, &name);
    assert_eq!((row["pid"].as_u64(), row["steps"].as_u64()), (Some(u64::from(run.0.id())), Some(100_000_000)));
    assert!(row["folder"].as_str().is_some_and(|f| f.ends_with("/out")), "{row}");
    assert_eq!(row["subscribers"]["fields"], 0);
    let table = squirm(dir, &["ps"]).1;
    let line = table.lines().find(|l| l.starts_with(&name)).unwrap_or_else(|| panic!("{table}"));
    assert!(line.contains("squirmers (0), scalars (0), fields (0), particles (0)"), "{table}");

    let tap = |topic: &str, more: &[&str]| {
        let (code, out, err) = squirm(dir, &[&["tap", &name, topic, "--count", "2", "--for", "60"], more].concat());
        assert_eq!(code, Some(0), "{topic}: {err}");
        out
    };
    let parts = [
        ("squirmers", "swimmer"),
        ("scalars", "sqrt(kT/m)"),
        ("fields", "5 x 4 x 4 blocks with edges of 2 a"),
        ("particles", "... and"),
        ("status", "running"),
    ];
    for (topic, part) in parts {
        let out = tap(topic, &[]);
        assert_eq!(out.matches(&format!("{topic}  step ")).count(), 2, "{out}");
        assert!(out.contains(part), "{out}");
        for line in tap(topic, &["--json"]).lines() {
            let object: Value = serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"));
            assert_eq!(object["topic"], topic);
            assert!(object["columns"].as_object().is_some_and(|c| c.len() > 1), "{line}");
        }
    }
    let first = tap("squirmers", &["--json"]);
    let object: Value = serde_json::from_str(first.lines().next().expect("a line")).expect("JSON");
    assert_eq!(object["columns"]["species.name"], serde_json::json!(["swimmer"]));
    assert_eq!(object["columns"]["axis"][0].as_array().map(Vec::len), Some(3));

    let top = Process::start(dir, &["top", &name]);
    std::thread::sleep(std::time::Duration::from_millis(2500));
    run.signal("-INT");
    assert_eq!(run.end().0, Some(130));
    let (code, out, err) = top.end();
    assert_eq!(code, Some(0), "{err}");
    assert!(err.contains("no terminal: one line a second"), "{err}");
    assert!(out.contains(&format!("{name}: step ")) && out.contains(" of 100000000 ("), "{out}");
    assert!(out.lines().last().is_some_and(|l| l.starts_with("the run has ended after ")), "{out}");
    assert_eq!(listed(dir, &name), None);
}

#[test]
fn a_run_that_is_killed_is_told_from_one_that_ends() {
    let (folder, name) = prepared("dies", "");
    let run = Process::run(folder.path(), &name, "out");
    let row = wait_for(folder.path(), &name);
    assert_eq!(row["subscribers"], serde_json::json!({}), "it publishes nothing and is listed all the same");
    let top = Process::start(folder.path(), &["top", &name]);
    std::thread::sleep(std::time::Duration::from_millis(1500));
    run.signal("-KILL");
    assert_eq!(run.end().0, None);
    let (code, _, err) = top.end();
    assert!(code == Some(1) && err.contains("the run has died after "), "{code:?} {err}");
    assert_eq!(listed(folder.path(), &name), None);
}

#[test]
fn a_second_run_of_the_same_name_gets_a_number() {
    let (folder, name) = prepared("twice", OUTPUT);
    let first = Process::run(folder.path(), &name, "out");
    wait_for(folder.path(), &name);
    let second = Process::run(folder.path(), &name, "other");
    let number = format!("{name}-2");
    let row = wait_for(folder.path(), &number);
    assert_eq!(row["pid"].as_u64(), Some(u64::from(second.0.id())));
    let tapped = squirm(folder.path(), &["tap", &number, "scalars", "--count", "1"]);
    assert_eq!(tapped.0, Some(0), "{}", tapped.2);
    second.signal("-TERM");
    let (code, _, said) = second.end();
    assert!(code == Some(143) && said.contains(&format!("squirm top {number}")), "{said}");
    assert!(listed(folder.path(), &name).is_some(), "the first one goes on undisturbed");
    first.signal("-INT");
    assert_eq!(first.end().0, Some(130));
}

#[test]
fn what_is_wrong_is_said() {
    let (folder, name) = prepared("absent", "");
    let dir = folder.path();
    let (code, _, err) = squirm(dir, &["tap", &name, "scalar"]);
    assert!(
        code == Some(2) && err.contains("[possible values: squirmers, scalars, fields, particles, status]"),
        "{err}"
    );
    let (code, _, err) = squirm(dir, &["tap", &name, "scalars"]);
    assert!(code == Some(1) && err.contains(&format!("no run named `{name}` publishes scalars here")), "{err}");
    let (code, _, err) = squirm(dir, &["top", &name]);
    assert!(code == Some(1) && err.contains(&format!("no run named `{name}` is going here")), "{err}");
    let (code, _, err) = squirm(dir, &["tap", &name, "scalars", "--for", "-1"]);
    assert!(code == Some(2) && err.contains("--for"), "{err}");
}

#[test]
fn a_run_that_is_not_to_be_watched_is_not_seen() {
    let (folder, name) = prepared("hidden", OUTPUT);
    let file = format!("{name}.toml");
    let run = Process::start(folder.path(), &["run", &file, "--out", "out", "--set", "run.live=false"]);
    super::wait_until("no folder", || folder.path().join("out/pipeline.toml").exists().then_some(()));
    std::thread::sleep(std::time::Duration::from_millis(500));
    assert_eq!(listed(folder.path(), &name), None);
    run.signal("-INT");
    let (code, _, err) = run.end();
    assert!(code == Some(130) && !err.contains("squirm top"), "{err}");
}
