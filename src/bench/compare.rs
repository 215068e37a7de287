//! Two reports side by side: what became slower by more than chance.

use super::report::{Measured, Report};
use std::fmt::Write;

/// Changes below this share are not called slower, whatever the spread.
const NOTICEABLE: f64 = 0.05;

/// How a report differs from an older one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Comparison {
    /// Cases, and kinds of output, that both have.
    pub common: usize,
    /// Names of those that became slower by more than their spread and 5 %.
    pub slower: Vec<String>,
    /// All of it for people.
    pub text: String,
}

/// Slower by more than the spread of either, and by more than [`NOTICEABLE`].
fn slower(before: &Measured, now: &Measured) -> bool {
    let (old, new) = (before.ns_per_particle_step, now.ns_per_particle_step);
    let more = new.median - old.median;
    more > old.width().max(new.width()) && more > NOTICEABLE * old.median
}

/// What has changed since `before`.
#[must_use]
pub fn compare(before: &Report, now: &Report) -> Comparison {
    let mut text = String::new();
    for (what, old, new) in [
        ("adapter", &before.adapter, &now.adapter),
        ("driver", &before.driver, &now.driver),
        ("version", &before.version, &now.version),
        ("plan", &before.plan, &now.plan),
    ] {
        if old != new {
            let _ = writeln!(text, "note: another {what}: before {old}, now {new}");
        }
    }
    let name = |m: &Measured| {
        let [x, y, z] = m.size;
        format!("{}, {x} x {y} x {z}", m.case)
    };
    let stages = now.cases.iter().flat_map(|c| c.stages.iter().map(|s| s.stage.chars().count() + 2));
    let width = now.cases.iter().map(|c| name(c).chars().count()).chain(stages).max().unwrap_or(0).max(4);
    let _ = writeln!(text, "{:<width$}  {:>10}  {:>10}  {:>8}", "case", "ns before", "ns now", "change");
    let (mut common, mut worse) = (0, Vec::new());
    for case in &now.cases {
        let label = name(case);
        let Some(old) = before.cases.iter().find(|m| m.case == case.case && m.size == case.size) else {
            let _ = writeln!(text, "{label:<width$}  {:>10}  {:>10.4}", "-", case.ns_per_particle_step.median);
            continue;
        };
        common += 1;
        let (was, is) = (old.ns_per_particle_step.median, case.ns_per_particle_step.median);
        let verdict = if slower(old, case) { "  slower" } else { "" };
        let _ = writeln!(text, "{label:<width$}  {was:>10.4}  {is:>10.4}  {:>8}{verdict}", change(was, is));
        if slower(old, case) {
            worse.push(label);
        }
        for stage in &case.stages {
            let known = old.stages.iter().find(|s| s.stage == stage.stage).and_then(|s| s.ns_per_particle_step);
            if let (Some(was), Some(is)) = (known, stage.ns_per_particle_step) {
                let label = format!("  {}", stage.stage);
                let _ = writeln!(text, "{label:<width$}  {was:>10.4}  {is:>10.4}  {:>8}", change(was, is));
            }
        }
    }
    for cost in &now.outputs {
        let old = before.outputs.iter().find(|o| o.case == cost.case && o.what == cost.what);
        if let Some(old) = old {
            common += 1;
            let (was, is) = (old.percent.median, cost.percent.median);
            let _ = writeln!(text, "{}: {}: {was:.1} % before, {is:.1} % now", cost.case, cost.what);
        }
    }
    let gone = |m: &&Measured| !now.cases.iter().any(|c| c.case == m.case && c.size == m.size);
    for case in before.cases.iter().filter(gone) {
        let _ = writeln!(text, "{}: not measured now", name(case));
    }
    Comparison { common, slower: worse, text }
}

fn change(was: f64, is: f64) -> String {
    if was > 0.0 { format!("{:+.1} %", 100.0 * (is / was - 1.0)) } else { "-".into() }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::bench::report::{CopyRate, Memory, StageCost};
    use crate::bench::statistics::Spread;

    /// A report with one case of this time and spread.
    pub fn report(ns: f64, width: f64) -> Report {
        let spread = Spread { median: ns, low: ns - width / 2.0, high: ns + width / 2.0 };
        let stage = StageCost {
            stage: "apply + stream".into(),
            launches: 1.0,
            share: Some(1.0),
            ns_per_particle_step: Some(ns),
            bytes_per_particle: 60.0,
            gb_per_s: Some(60.0 / ns),
            share_of_copy: Some(0.5),
        };
        let case = Measured {
            case: "energy".into(),
            what: "a fluid".into(),
            size: [100; 3],
            particles: 10_000_000,
            squirmers: 0,
            steps: 500,
            batch: 100,
            us_per_step: spread.times(1e4),
            ns_per_particle_step: spread,
            target: None,
            launches: 1.0,
            bytes_per_particle: 60.0,
            gb_per_s: 60.0 / ns,
            share_of_copy: 0.5,
            memory: Memory { bytes: 1_000_000_000, per_particle: 50.0, per_cell: 500.0, others: 100 },
            stages: vec![stage],
            notes: Vec::new(),
        };
        Report {
            version: "0.1.0".into(),
            adapter: "NVIDIA H100 80GB HBM3".into(),
            kind: "GPU".into(),
            driver: "NVIDIA 1".into(),
            plan: "fused".into(),
            copy: CopyRate { bytes: 1 << 30, gb_per_s: Spread { median: 2900.0, low: 2890.0, high: 2910.0 } },
            cases: vec![case],
            outputs: Vec::new(),
            skipped: Vec::new(),
        }
    }

    fn verdict(before: &Report, now: &Report) -> usize {
        compare(before, now).slower.len()
    }

    #[test]
    fn slower_is_more_than_the_spread_and_five_per_cent() {
        let old = report(0.08, 0.001);
        assert_eq!(verdict(&old, &old), 0);
        assert_eq!(verdict(&old, &report(0.083, 0.001)), 0);
        assert_eq!(verdict(&old, &report(0.085, 0.001)), 1);
        assert_eq!(verdict(&old, &report(0.085, 0.006)), 0);
        assert_eq!(verdict(&report(0.08, 0.006), &report(0.085, 0.001)), 0);
        assert_eq!(verdict(&report(0.16, 0.001), &old), 0);
    }

    #[test]
    fn the_text_has_cases_and_stages_in_per_cent() {
        let Comparison { common, text, .. } = compare(&report(0.08, 0.001), &report(0.1, 0.001));
        assert_eq!(common, 1);
        assert!(text.lines().any(|l| l.starts_with("energy, 100 x 100 x 100") && l.ends_with("+25.0 %  slower")));
        assert!(text.lines().any(|l| l.starts_with("  apply + stream ") && l.ends_with("+25.0 %")), "{text}");
    }

    #[test]
    fn other_sizes_and_other_adapters_are_named() {
        let (old, mut new) = (report(0.08, 0.001), report(0.2, 0.001));
        new.cases[0].size = [64; 3];
        "NVIDIA H200".clone_into(&mut new.adapter);
        let Comparison { common, slower, text } = compare(&old, &new);
        assert_eq!((common, slower.len()), (0, 0));
        assert!(text.contains("another adapter") && text.contains("100 x 100 x 100: not measured now"), "{text}");
    }

    #[test]
    fn a_report_reads_back_as_it_was_written() {
        let report = report(0.08, 0.001);
        assert_eq!(Report::parse(&report.json()), Ok(report));
        let error = Report::parse("{\n  \"version\": \"0.1.0\"\n}").unwrap_err();
        assert!(error.contains("missing field") && error.contains("line 3"), "{error}");
    }
}
