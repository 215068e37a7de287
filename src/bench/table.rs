//! Reports as tables for people.

use super::report::{Measured, OutputCost, Report, StageCost};
use std::fmt::Write;

/// Bytes in the largest unit that keeps the number above one.
#[allow(clippy::cast_precision_loss)]
fn bytes(count: u64) -> String {
    let units = ["B", "kB", "MB", "GB"];
    let (mut value, mut unit) = (count as f64, 0);
    while value >= 1000.0 && unit + 1 < units.len() {
        value /= 1000.0;
        unit += 1;
    }
    if unit == 0 { format!("{count} B") } else { format!("{value:.2} {}", units[unit]) }
}

/// A number with about three digits that mean something.
fn digits(value: f64) -> String {
    match value {
        v if v >= 100.0 => format!("{v:.0}"),
        v if v >= 10.0 => format!("{v:.1}"),
        v if v >= 1.0 => format!("{v:.2}"),
        v => format!("{v:.4}"),
    }
}

/// What was measured on, and what kernels are held against.
#[must_use]
pub fn header(report: &Report) -> String {
    let rate = report.copy.gb_per_s;
    format!(
        "squirm {}, {} plan, {} ({})\na copy of {} reads and writes {} GB/s ({} to {})\n\
         shares of kernels come from timestamps, which slow the steps that have them; ns are these shares of the time of steps \
         without\nbytes: per particle, if a kernel reads and writes each of its buffers once\n",
        report.version,
        report.plan,
        report.adapter,
        report.driver,
        bytes(report.copy.bytes),
        digits(rate.median),
        digits(rate.low),
        digits(rate.high)
    )
}

/// A case; with its target if those apply to the adapter.
#[must_use]
pub fn case(case: &Measured, targets: bool) -> String {
    let mut text = String::new();
    let [x, y, z] = case.size;
    let _ = writeln!(text, "{}: {}", case.case, case.what);
    let squirmers = match case.squirmers {
        0 => String::new(),
        1 => ", 1 squirmer".into(),
        n => format!(", {n} squirmers"),
    };
    let (steps, batch, particles) = (case.steps, case.batch, case.particles);
    let _ = writeln!(
        text,
        "  {x} x {y} x {z} cells, {particles} particles{squirmers}; {steps} steps in batches of {batch}"
    );
    let width = case.stages.iter().map(|s| s.stage.chars().count()).max().unwrap_or(0).max(6);
    let _ = writeln!(
        text,
        "  {:<width$}  {:>8}  {:>8}  {:>7}  {:>7}  {:>6}  {:>7}",
        "kernel", "launches", "ns", "share", "bytes", "GB/s", "of copy"
    );
    let total = StageCost {
        stage: "a step".into(),
        launches: case.launches,
        share: None,
        ns_per_particle_step: Some(case.ns_per_particle_step.median),
        bytes_per_particle: case.bytes_per_particle,
        gb_per_s: Some(case.gb_per_s),
        share_of_copy: Some(case.share_of_copy),
    };
    for stage in case.stages.iter().chain([&total]) {
        row(&mut text, stage, width);
    }
    let (ns, us) = (case.ns_per_particle_step, case.us_per_step);
    let _ = writeln!(
        text,
        "  {} ns per particle and step (80 % of batches: {} to {}), {} us per step",
        digits(ns.median),
        digits(ns.low),
        digits(ns.high),
        digits(us.median)
    );
    if let Some(target) = case.target.as_ref().filter(|_| targets) {
        let measured = target.measured.map_or("not measured".into(), |measured| {
            let verdict = if measured <= target.at_most { "met" } else { "missed" };
            format!("{}, {verdict}", digits(measured))
        });
        let _ = writeln!(text, "  target {} {}: {measured}", target.at_most, target.unit);
    } else if let Some((target, measured)) = case.target.as_ref().and_then(|t| Some((t, t.measured?))) {
        // Without its target a figure in other units is still worth a line.
        if (measured - ns.median).abs() > 1e-12 && (measured - us.median).abs() > 1e-12 {
            let _ = writeln!(text, "  {} {}", digits(measured), target.unit);
        }
    }
    let m = &case.memory;
    let _ = writeln!(
        text,
        "  memory {}: {} bytes per particle, {} per cell, {} beside",
        bytes(m.bytes),
        digits(m.per_particle),
        digits(m.per_cell),
        bytes(m.others)
    );
    for note in &case.notes {
        let _ = writeln!(text, "  note: {note}");
    }
    text
}

fn row(text: &mut String, stage: &StageCost, width: usize) {
    let shown = |value: Option<f64>, show: fn(f64) -> String| value.map_or_else(|| "-".into(), show);
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let _ = writeln!(
        text,
        "  {:<width$}  {:>8}  {:>8}  {:>7}  {:>7.2}  {:>6}  {:>7}",
        stage.stage,
        format!("{:.2}", stage.launches).trim_end_matches('0').trim_end_matches('.'),
        shown(stage.ns_per_particle_step, digits),
        stage.share.map(percent).unwrap_or_default(),
        stage.bytes_per_particle,
        shown(stage.gb_per_s, |rate| format!("{rate:.1}")),
        shown(stage.share_of_copy, percent),
    );
}

/// What an output costs; with its target if those apply to the adapter.
#[must_use]
pub fn output(cost: &OutputCost, targets: bool) -> String {
    let p = cost.percent;
    let target = match (targets, p.median <= cost.at_most) {
        (false, _) => String::new(),
        (true, met) => format!("; target {} %: {}", cost.at_most, if met { "met" } else { "missed" }),
    };
    format!("  {:+.1} % ({:+.1} to {:+.1}) for {}, {} steps{target}\n", p.median, p.low, p.high, cost.what, cost.steps)
}

#[cfg(test)]
mod tests {
    use super::super::compare::tests::report;
    use super::super::report::Target;
    use super::*;

    #[test]
    fn a_target_stands_beside_what_was_measured_only_where_it_applies() {
        let mut report = report(0.08, 0.001);
        let unit = "ns per fluid particle and step".to_owned();
        report.cases[0].target = Some(Target { unit, at_most: 0.05, measured: Some(0.08) });
        let text = case(&report.cases[0], report.has_targets());
        assert!(text.contains("target 0.05 ns per fluid particle and step: 0.0800, missed"), "{text}");
        assert!(!case(&report.cases[0], false).contains("target"));
    }

    #[test]
    fn columns_are_aligned() {
        let text = case(&report(0.08, 0.001).cases[0], true);
        let lines: Vec<&str> = text.lines().skip(2).take(3).collect();
        assert!(lines.iter().all(|l| l.len() == lines[0].len()), "{text}");
        assert!(lines[2].starts_with("  a step") && lines[2].contains("750.0"), "{text}");
    }

    #[test]
    fn numbers_are_readable() {
        assert_eq!([0.0801, 1.234, 25.04, 153.2].map(digits), ["0.0801", "1.23", "25.0", "153"]);
        assert_eq!((bytes(12), bytes(1 << 30)), ("12 B".into(), "1.07 GB".into()));
    }
}
