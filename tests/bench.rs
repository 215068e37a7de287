//! `squirm bench`: what it measures and writes, the comparison of two reports, and its errors.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// Runs `squirm bench` in the folder of the repository: exit status, standard output, standard error.
fn bench(arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_squirm"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).arg("bench").args(arguments);
    let Output { status, stdout, stderr } =
        command.env("NO_COLOR", "1").env("COLUMNS", "200").output().expect("it starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (status.code().expect("not killed"), text(stdout), text(stderr))
}

fn number(value: &Value, pointer: &str) -> f64 {
    value.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("{pointer}: {value}"))
}

/// A tiny run as JSON.
fn tiny(more: &[&str]) -> (Value, String) {
    let file = ["pipelines/bulk.toml", "--set", "box.size=[8,8,8]", "--steps", "20", "--json", "-"];
    let (code, out, err) = bench(&[&file[..], more].concat());
    assert_eq!(code, 0, "{err}");
    (serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {out}")), out)
}

#[test]
fn the_list_has_every_case_with_its_target() {
    let (code, out, err) = bench(&["--list"]);
    assert_eq!((code, err.as_str()), (0, ""));
    for case in squirm::bench::CASES {
        assert!(out.lines().any(|l| l.starts_with(case.name)), "{}: {out}", case.name);
    }
    assert!(out.contains("at most 0.05 ns per fluid particle and step") && out.contains("1.3 times a step of crowd-1"));
}

#[test]
fn a_tiny_run_has_times_launches_bandwidths_and_memory() {
    let (report, _) = tiny(&[]);
    assert!(number(&report, "/copy/gb_per_s/median") > 0.0);
    let case = &report["cases"][0];
    assert_eq!((case["case"].as_str(), case["particles"].as_u64()), (Some("bulk"), Some(5120)));
    assert_eq!((case["steps"].as_u64(), case["batch"].as_u64()), (Some(20), Some(4)));
    for positive in ["/gb_per_s", "/share_of_copy", "/memory/per_particle", "/memory/per_cell", "/bytes_per_particle"] {
        assert!(number(case, positive) > 0.0, "{positive}");
    }
    let [low, median, high] = ["low", "median", "high"].map(|s| number(case, &format!("/ns_per_particle_step/{s}")));
    assert!(0.0 < low && low <= median && median <= high, "{low} {median} {high}");
    assert!((number(case, "/us_per_step/median") * 1000.0 / 5120.0 / median - 1.0).abs() < 1e-9);
    let stages = case["stages"].as_array().expect("a list");
    let sum = |what: &str| stages.iter().map(|s| number(s, what)).sum::<f64>();
    assert!(stages.len() >= 3 && (sum("/launches") - number(case, "/launches")).abs() < 1e-9, "{stages:?}");
    assert!((sum("/share") - 1.0).abs() < 1e-9, "kernels without a time, or times without a kernel: {stages:?}");
    assert!((sum("/ns_per_particle_step") / median - 1.0).abs() < 1e-9, "{stages:?}");
}

#[test]
fn the_loose_plan_has_every_stage_and_a_sort_in_fifty_steps() {
    let (report, _) = tiny(&["--plan", "loose"]);
    let stages = report["cases"][0]["stages"].as_array().expect("a list");
    let of = |kind: &str| stages.iter().find(|s| s["stage"] == kind).unwrap_or_else(|| panic!("{kind}: {stages:?}"));
    assert_eq!(number(of("stream"), "/launches"), 1.0);
    let sort = squirm::stages::find("sort-reorder").expect("a stage").phases.len();
    assert!((number(of("sort-reorder"), "/launches") * 50.0 - sort as f64).abs() < 1e-9);
    assert!((stages.iter().map(|s| number(s, "/share")).sum::<f64>() - 1.0).abs() < 1e-9, "{stages:?}");
}

/// Multiplies every time in a report.
fn doctored(report: &Value, factor: f64) -> String {
    let mut report = report.clone();
    for what in ["us_per_step", "ns_per_particle_step"] {
        for which in ["low", "median", "high"] {
            let value = &mut report["cases"][0][what][which];
            *value = (value.as_f64().expect("a number") * factor).into();
        }
    }
    report.to_string()
}

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).to_string_lossy().into_owned()
}

#[test]
fn what_became_slower_is_status_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let [now, old, wrong] = ["now.json", "old.json", "wrong.json"].map(|name| path(folder.path(), name));
    let (mut report, _) = tiny(&[]);
    // The noise of a busy machine must not decide.
    for what in ["us_per_step", "ns_per_particle_step"] {
        let median = report["cases"][0][what]["median"].clone();
        (report["cases"][0][what]["low"], report["cases"][0][what]["high"]) = (median.clone(), median);
    }
    std::fs::write(&now, report.to_string()).expect("written");
    let (code, out, err) = bench(&["--from", &now, "--against", &now]);
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("a step") && out.contains("+0.0 %") && !out.contains("slower"), "{out}");
    std::fs::write(&old, doctored(&report, 0.5)).expect("written");
    let (code, out, _) = bench(&["--from", &now, "--against", &old]);
    assert!(code == 1 && out.contains("+100.0 %  slower"), "{code}: {out}");
    assert_eq!(bench(&["--from", &old, "--against", &now]).0, 0);
    let (code, out, err) = bench(&["--from", &now, "--json", "-", "--against", &old]);
    assert!(code == 1 && err.contains("slower by more than its spread") && out.starts_with('{'), "{code}: {err}");
    // Measured anew, against a report so slow that the noise of a busy machine does not matter.
    std::fs::write(&old, doctored(&report, 1000.0)).expect("written");
    let set = ["pipelines/bulk.toml", "--set", "box.size=[8,8,8]", "--steps", "20"];
    let (code, out, err) = bench(&[&set[..], &["--against", &old]].concat());
    let faster = ["  -9", "-100.0 %"].iter().any(|change| out.contains(change));
    assert!(code == 0 && faster, "{code}: {out}{err}");
    let mut other = report.clone();
    other["cases"][0]["case"] = "another".into();
    std::fs::write(&wrong, other.to_string()).expect("written");
    let (code, _, err) = bench(&["--from", &now, "--against", &wrong]);
    assert!(code == 2 && err.contains("no case was measured both"), "{err}");
}

#[test]
fn wrong_arguments_are_status_two_before_anything_is_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    let broken = path(folder.path(), "broken.json");
    std::fs::write(&broken, "{\n  \"version\": 1,\n").expect("written");
    let nowhere = path(folder.path(), "absent/new.json");
    for (arguments, part) in [
        (&["enrgy"][..], "did you mean `energy`?"),
        (&["absent.toml"], "absent.toml cannot be read"),
        (&["energy", "--against", &broken], "broken.json is no report of a benchmark"),
        (&["energy", "--against", "absent.json"], "absent.json cannot be read"),
        (&["energy", "--json", &nowhere], "there is no folder"),
        (&["energy", "--adapter", "nonsense"], "no adapter is called or numbered `nonsense`"),
        (&["energy", "--set", "run.stpes=1"], "no parameter `stpes`"),
        (&["energy", "--size", "0"], "above 0"),
        (&["energy", "--steps", "0"], "--steps"),
    ] {
        let (code, out, err) = bench(arguments);
        assert!(code == 2 && err.contains(part), "{arguments:?}: {code}: {err}");
        assert_eq!(out, "", "{arguments:?}");
    }
}

#[test]
fn every_case_is_a_plan_without_errors() {
    for case in squirm::bench::CASES {
        for (particles, cpu) in [(None, false), (None, true), (Some(1.3e8), false)] {
            let (file, text) = case.file;
            let overrides = case.overrides(particles, cpu);
            let loaded = squirm::config::load(file, text, &overrides, Path::new(""));
            let loaded = loaded.unwrap_or_else(|failure| panic!("{} {overrides:?}: {failure}", case.name));
            let system = &loaded.plan.system;
            match (case.name, particles) {
                ("small", _) => assert!((loaded.particles as f64 / 1e5 - 1.0).abs() < 0.1, "{}", loaded.particles),
                ("crowd-3700", _) => {
                    let bodies: f64 = system.species.iter().map(|s| f64::from(s.count) * s.spheroid().volume()).sum();
                    assert!((bodies / system.domain.volume() - 0.1).abs() < 0.005, "{bodies}");
                }
                ("energy" | "slit", Some(wanted)) => {
                    assert!((loaded.particles as f64 / wanted - 1.0).abs() < 0.02, "{}", loaded.particles);
                }
                _ => {}
            }
        }
    }
}

#[test]
fn an_adapter_that_is_too_small_says_so_at_the_size_of_the_box() {
    let (code, out, err) = bench(&["slit", "--set", "box.size=[500,500,500]", "--set", "fluid.density=0.1"]);
    if out.contains("llvmpipe") {
        assert!(err.contains("binds 32 at most") && err.contains("--set box.size"), "{err}");
        assert_eq!(code, 2, "{err}");
    } else {
        // A GPU can bind what these 125 million cells need.
        assert_eq!(code, 0, "{err}");
    }
}
