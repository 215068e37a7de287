//! The fully resolved pipeline file: every value written out, in a form that reads back as the same plan.

use super::sections::{SECTIONS, STAGE};
use crate::params::{Params, Value, Values};
use crate::state::System;
use crate::{graph, params};
use std::fmt::Write;

/// Writes the file.
#[must_use]
pub fn write(
    name: &str,
    system: &System,
    stages: &[graph::PlannedStage],
    outputs: &[graph::Output],
    analyzers: &[graph::AnalyzerProgram],
    checkpoints: &graph::Checkpoints,
) -> String {
    let mut text = format!("# {name}: every value of the run, defaults and overrides included.\n");
    for section in SECTIONS {
        let header = section.header();
        let tables: Vec<Values> = match section.name {
            "run" => vec![system.run.to_values()],
            "box" => vec![system.domain.to_values()],
            "fluid" => vec![system.fluid.to_values()],
            "init" => vec![system.init.to_values()],
            "squirmers" => system.species.iter().map(Params::to_values).collect(),
            "checkpoint" => vec![checkpoints.to_values()],
            "output" => outputs.iter().map(Params::to_values).collect(),
            "analyzer" => analyzers.iter().map(Params::to_values).collect(),
            other => {
                debug_assert_eq!(other, STAGE);
                for stage in stages {
                    let _ = write!(text, "\n{header}\nkind = \"{}\"\n", stage.entry.kind);
                    table(&mut text, &stage.values);
                }
                continue;
            }
        };
        for values in tables.iter().filter(|v| v.iter().next().is_some()) {
            let _ = write!(text, "\n{header}\n");
            table(&mut text, values);
        }
    }
    text
}

fn table(text: &mut String, values: &Values) {
    for (key, value) in values.iter() {
        let _ = writeln!(text, "{key} = {}", toml_value(value));
    }
}

/// A value as TOML.
#[must_use]
pub fn toml_value(value: &params::Value) -> String {
    match value {
        Value::Float(x) => float(*x),
        Value::Integer(i) => i.to_string(),
        Value::Boolean(b) => b.to_string(),
        Value::Text(t) => text_value(t),
        Value::Vector(v) => list(v.iter().map(|x| float(*x))),
        Value::Counts(v) => list(v.iter().map(i64::to_string)),
        Value::Words(v) => list(v.iter().map(|w| text_value(w))),
        Value::Rows(rows) => {
            let rows = rows.iter().map(|row| format!("    {},\n", list(row.iter().map(|x| float(*x)))));
            format!("[\n{}]", rows.collect::<String>())
        }
        Value::Table(values) => {
            let pairs: Vec<String> = values.iter().map(|(k, v)| format!("{k} = {}", toml_value(v))).collect();
            format!("{{ {} }}", pairs.join(", "))
        }
    }
}

/// The shortest decimal that reads back as the same number, always with a point or an exponent.
fn float(x: f64) -> String {
    format!("{x:?}")
}

fn text_value(text: &str) -> String {
    toml::Value::String(text.to_string()).to_string()
}

fn list(items: impl Iterator<Item = String>) -> String {
    format!("[{}]", items.collect::<Vec<_>>().join(", "))
}
