//! The report: Markdown with one table per case, and SVG charts beside it.

use crate::case::{Case, Row, Size, Trouble, Verdict};
use crate::record::Record;
use squirm::analyze::plot::{Chart, Curve, Scale};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

/// Writes README.md and the charts into `folder`. A case that was not measured is said to be missing.
pub fn write(folder: &Path, size: Size, cases: &[&Case], records: &[Record]) -> Result<(), Trouble> {
    std::fs::create_dir_all(folder)?;
    let mut text = head(size, cases, records);
    for case in cases {
        let of_case: Vec<&Record> = records.iter().filter(|r| r.case == case.name).collect();
        write!(text, "\n## {}\n\n{}\n\n", case.title, case.about.trim())?;
        if of_case.is_empty() {
            writeln!(text, "Not measured.")?;
            continue;
        }
        table(&mut text, size, &of_case)?;
        let missing: Vec<String> =
            (case.parts)(size).into_iter().map(|p| p.name).filter(|n| of_case.iter().all(|r| r.part != *n)).collect();
        if !missing.is_empty() {
            write!(text, "\nNot measured: {}.\n", missing.join(", "))?;
        }
        if !case.remarks.is_empty() {
            let misses = of_case.iter().flat_map(|r| &r.outcome.rows).any(|row| row.verdict(size) == Verdict::Miss);
            let what = if misses { "What misses" } else { "Remark" };
            write!(text, "\n{what}: {}\n", case.remarks)?;
        }
        for sheet in case.sheets {
            let curves = curves(&of_case, sheet.name);
            if curves.is_empty() {
                continue;
            }
            let scale = if sheet.logarithmic { Scale::Logarithmic } else { Scale::Linear };
            let (title, x, y) = (sheet.title.to_owned(), sheet.x.to_owned(), sheet.y.to_owned());
            let chart = Chart { title, x, y, scale, curves };
            std::fs::write(folder.join(format!("{}.svg", sheet.name)), chart.svg()?)?;
            write!(text, "\n![{}]({}.svg)\n", sheet.title, sheet.name)?;
        }
    }
    std::fs::write(folder.join("README.md"), text)?;
    Ok(())
}

/// The curves of a sheet; what parts call by one name is one curve.
fn curves(records: &[&Record], sheet: &str) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    for c in records.iter().flat_map(|r| &r.outcome.curves).filter(|c| c.sheet == sheet) {
        match curves.iter_mut().find(|known| known.name == c.name) {
            Some(known) => known.points.extend(&c.points),
            None => curves.push(Curve {
                name: c.name.clone(),
                points: c.points.clone(),
                guide: c.guide.clone(),
                guide_name: c.guide_name.clone(),
            }),
        }
    }
    curves
}

fn head(size: Size, cases: &[&Case], records: &[Record]) -> String {
    let set = |pick: fn(&Record) -> String| {
        let values: BTreeSet<String> = records.iter().map(pick).collect();
        values.into_iter().collect::<Vec<_>>().join("; ")
    };
    let rows: Vec<Verdict> = records.iter().flat_map(|r| &r.outcome.rows).map(|row| row.verdict(size)).collect();
    let count = |v: Verdict| rows.iter().filter(|r| **r == v).count();
    let command = match size {
        Size::Quick => "squirm-validate --quick",
        Size::Full => "squirm-validate --full",
    };
    let minutes = records.iter().map(|r| r.seconds).sum::<f64>() / 60.0;
    let measured = cases.iter().filter(|c| records.iter().any(|r| r.case == c.name)).count();
    format!(
        "# Validation\n\nWritten by `{command}`; do not edit. What is measured is held against theory and published results. One standard \
         error in brackets, from block averages or independent runs.\n\n\
         - Adapter: {} (driver {}); version {}; measured {}; {minutes:.0} minutes.\n\
         - {measured} of {} cases. {} rows pass, {} miss their tolerance, {} cannot be judged since their error is too large, {} only report what was seen.\n\n\
         A row passes if it differs from the expectation by no more than the tolerance{}.\n",
        set(|r| r.adapter.clone()),
        set(|r| r.driver.clone()),
        set(|r| r.version.clone()),
        set(|r| r.date.clone()),
        cases.len(),
        count(Verdict::Pass),
        count(Verdict::Miss),
        count(Verdict::Vague),
        count(Verdict::Seen),
        match size {
            Size::Quick => " and three standard errors",
            Size::Full => ", and its standard error is below a third of that",
        }
    )
}

fn table(text: &mut String, size: Size, records: &[&Record]) -> Result<(), Trouble> {
    writeln!(
        text,
        "| quantity | system | measured | expected | tolerance | verdict | source |\n|---|---|---|---|---|---|---|"
    )?;
    let rows = || records.iter().flat_map(|r| &r.outcome.rows);
    for row in rows() {
        let expected = row.expected.map_or_else(|| "-".to_owned(), |e| number(e, row.tolerance));
        let tolerance = row.expected.map_or_else(|| "-".to_owned(), |_| number(row.tolerance, row.tolerance));
        writeln!(
            text,
            "| {} | {} | {} | {expected} | {tolerance} | {} | {} |",
            row.quantity,
            row.setup,
            with_error(row),
            row.verdict(size).word(),
            row.source
        )?;
    }
    for row in rows().filter(|r| !r.note.is_empty()) {
        write!(text, "\n- {}, {}: {}", row.quantity, row.setup, row.note)?;
    }
    writeln!(text)?;
    Ok(())
}

/// A value with the digits that its error, or its tolerance, leaves meaningful: 0.961(7).
pub fn with_error(row: &Row) -> String {
    let (value, error) = (row.measured, row.error);
    if !(error.is_finite() && error > 0.0) {
        return number(value, row.tolerance.max(value.abs() * 1e-3));
    }
    #[allow(clippy::cast_possible_truncation)]
    let place = error.log10().floor() as i32;
    // Two digits of the error where the first is a one.
    let place = if error / 10f64.powi(place) < 2.0 { place - 1 } else { place };
    if place >= 0 {
        return format!("{value:.0}({error:.0})");
    }
    if value.abs().max(error) < 1e-3 {
        #[allow(clippy::cast_possible_truncation)]
        let power = value.abs().max(error).log10().floor() as i32;
        let scale = 10f64.powi(power);
        let digits = usize::try_from((power - place).max(0)).unwrap_or(0);
        return format!("{:.digits$}({:.0})e{power}", value / scale, error / 10f64.powi(place));
    }
    let digits = usize::try_from(-place).unwrap_or(0);
    format!("{value:.digits$}({:.0})", error / 10f64.powi(place))
}

/// A number with digits down to a hundredth of `step`.
fn number(value: f64, step: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e5).contains(&value.abs()) {
        return format!("{value:.2e}");
    }
    let digits = if step > 0.0 { (2.0 - step.log10().floor()).clamp(0.0, 6.0) } else { 4.0 };
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let text = format!("{value:.*}", digits as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
