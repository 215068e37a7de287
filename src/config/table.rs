//! The table of fluid particles that a run may start from: that it exists and that every row is a particle in the box.

use super::node::Node;
use crate::diag::{Diagnostic, Span};
use crate::state::System;
use crate::state::start::speed_problem;
use glam::DVec3;

/// The header that the table must have.
pub const COLUMNS: [&str; 6] = ["x", "y", "z", "vx", "vy", "vz"];

/// Rows with errors that are reported one by one.
const SHOWN: usize = 10;

/// Fluid particles of the start: the rows of the table if there is one; `None` after an error.
pub fn rows(system: &System, root: &Node, found: &mut Vec<Diagnostic>) -> Option<u64> {
    let Some(path) = &system.init.from else { return Some(system.particle_count()) };
    let span = root.place(&["init", "from"]);
    let columns = COLUMNS.join(",");
    let mut reader = match csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(path) {
        Ok(reader) => reader,
        Err(error) => {
            found.push(
                Diagnostic::error(format!("the start `{path}` cannot be read: {error}"))
                    .at(span, "named here")
                    .help("give the path of a CSV file, from the folder of the pipeline file"),
            );
            return None;
        }
    };
    let header = match reader.headers() {
        Ok(header) => header.iter().map(str::to_owned).collect::<Vec<_>>(),
        Err(error) => {
            let reason = match error.kind() {
                csv::ErrorKind::Io(e) => e.to_string(),
                _ => "it is no UTF-8 text".into(),
            };
            found.push(
                Diagnostic::error(format!("the start `{path}` cannot be read: {reason}"))
                    .at(span, "named here")
                    .help(format!("give the path of a CSV file that begins with `{columns}`")),
            );
            return None;
        }
    };
    if header != COLUMNS {
        found.push(
            Diagnostic::error(format!("{path}:1: the header is `{}`, but must be `{columns}`", header.join(",")))
                .at(span, "named here")
                .help(format!("write `{columns}` as the first line: positions in a, velocities in sqrt(kT/m)")),
        );
        return None;
    }
    let (mut count, mut wrong) = (0, 0);
    let mut record = csv::StringRecord::new();
    loop {
        let (line, problem) = match reader.read_record(&mut record) {
            Ok(false) => break,
            Ok(true) => (record.position().map_or(0, csv::Position::line), row_problem(&record, system)),
            Err(error) => (error.position().map_or(0, csv::Position::line), Some(row_error(&error))),
        };
        count += 1;
        if let Some(problem) = problem {
            wrong += 1;
            if wrong <= SHOWN {
                found.push(row_diagnostic(path, line, &problem, span));
            }
        }
    }
    if wrong > SHOWN {
        let message = format!("{path}: {} more rows are wrong", wrong - SHOWN);
        found.push(Diagnostic::error(message).at(span, "named here").help("correct the rows reported first"));
    }
    if count == 0 {
        found.push(
            Diagnostic::error(format!("{path}: the table has no row")).at(span, "named here").help("give it particles"),
        );
    }
    (wrong == 0 && count > 0).then_some(count)
}

fn row_diagnostic(path: &str, line: u64, problem: &str, span: Span) -> Diagnostic {
    Diagnostic::error(format!("{path}:{line}: {problem}"))
        .at(span, "named here")
        .help("each row is one particle: six finite numbers, the position inside the box, the velocity in sqrt(kT/m)")
}

fn row_error(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { len, .. } => format!("the row has {len} values, but must have 6"),
        _ => error.to_string(),
    }
}

fn row_problem(record: &csv::StringRecord, system: &System) -> Option<String> {
    let mut numbers = [0.0; 6];
    for (i, text) in record.iter().enumerate() {
        let name = COLUMNS[i];
        let Ok(value) = text.parse::<f64>() else { return Some(format!("`{text}` in column {name} is not a number")) };
        if !value.is_finite() {
            return Some(format!("`{text}` in column {name} is not finite"));
        }
        if i < 3 && !(0.0..f64::from(system.domain.size[i])).contains(&value) {
            return Some(format!("{name} = {value} lies outside the box, 0 <= {name} < {}", system.domain.size[i]));
        }
        numbers[i] = value;
    }
    speed_problem(DVec3::from_slice(&numbers[3..]), system)
}
