//! `squirm-validate`: its list, its exit statuses, negative controls, and that a suite goes on where it was.

use std::path::Path;
use std::process::{Command, Output};

/// Parts of a second or two each.
const PARTS: [&str; 2] = ["precision/flight-1000", "precision/range-10"];

/// Exit status, standard output and standard error.
fn validate(arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_squirm-validate"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).env("NO_COLOR", "1");
    if let Ok(adapter) = std::env::var("SQUIRM_ADAPTER") {
        command.args(["--adapter", &adapter]);
    }
    let Output { status, stdout, stderr } = command.output().expect("it starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (status.code().expect("not killed"), text(stdout), text(stderr))
}

fn text(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

#[test]
fn the_list_has_cases_parts_and_controls() {
    let (code, out, err) = validate(&["--list"]);
    assert_eq!((code, err.as_str()), (0, ""));
    for line in ["viscosity: ", "    precision/flight-1000\n", "    control long-step: "] {
        assert!(out.contains(line), "{line}: {out}");
    }
    let (_, full, _) = validate(&["--list", "--full"]);
    assert!(full.lines().count() > out.lines().count() + 20, "{full}");
    // Every case has a variant that it must notice, but for two that only report what is seen.
    let reports = |l: &str| l.starts_with("two-pullers:") || l.starts_with("clusters:");
    for block in full.split("\n").filter(|l| !l.starts_with(' ') && !l.is_empty() && !reports(l)) {
        let after = &full[full.find(block).expect("it is there") + block.len()..];
        let own: Vec<&str> = after.lines().skip(1).take_while(|l| l.starts_with(' ')).collect();
        assert!(own.iter().any(|l| l.starts_with("    control ")), "{block} has no control");
    }
}

#[test]
fn a_wrong_name_is_status_two_and_says_what_there_is() {
    for name in ["viscosty", "precision/flight-17"] {
        let (code, out, err) = validate(&[name]);
        assert_eq!((code, out.as_str()), (2, ""), "{err}");
        assert!(err.contains(&format!("there is no case `{name}`")) && err.contains("viscosity"), "{err}");
    }
}

/// What is measured is kept, what is kept is not measured again, and the report has every row of it.
#[test]
fn a_suite_goes_on_where_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let (data, report) = (folder.path().join("data"), folder.path().join("report"));
    let arguments = |parts: &[&'static str], more: &[&'static str]| {
        let paths =
            ["--data".to_owned(), data.display().to_string(), "--report".to_owned(), report.display().to_string()];
        parts.iter().chain(more).map(|a| (*a).to_owned()).chain(paths).collect::<Vec<String>>()
    };
    let run = |parts: &[&'static str], more: &[&'static str]| {
        let owned = arguments(parts, more);
        let (code, out, err) = validate(&owned.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!((code, err.as_str()), (0, ""), "{out}");
        out
    };
    // Time is up before the first part: nothing is measured, and that is no failure.
    let out = run(&PARTS, &["--for", "0"]);
    assert_eq!(out.matches("left for the next call").count(), PARTS.len(), "{out}");
    run(&PARTS[..1], &[]);
    let file = "precision.flight-1000.json";
    // Nothing but a mark in the file can tell whether the part is measured again.
    let marked = text(&data, file).replace("\"quantity\": \"unit of position / a\"", "\"quantity\": \"a mark\"");
    std::fs::write(data.join(file), &marked).expect("written");
    let out = run(&PARTS, &[]);
    assert!(out.contains("a mark") && out.contains("largest sum v, share of its range"), "{out}");
    assert_eq!(text(&data, file), marked);
    let written = text(&report, "README.md");
    for part in
        ["| a mark |", "| largest sum v, share of its range |", "- 1 of ", "Not measured.", "| pass |", "| seen |"]
    {
        assert!(written.contains(part), "{part}: {written}");
    }
    let out = run(&PARTS[..1], &["--again"]);
    assert!(out.contains("unit of position / a") && !out.contains("a mark"), "{out}");
}

#[test]
fn a_spoiled_variant_is_noticed() {
    let (code, out, err) = validate(&["precision", "--controls"]);
    assert_eq!((code, err.as_str()), (0, ""), "{out}");
    assert!(out.contains("precision: long-step") && out.contains("): noticed: relative error"), "{out}");
}
