//! `squirm stages`: every stage and parameter, from the same descriptions that parsing uses.

use super::{WRONG_USAGE, print, render};
use squirm::config::{SECTIONS, STAGE, accepts, is_required, toml_value};
use squirm::diag::{Diagnostic, Sources, suggestion};
use squirm::params::{Field, Kind};
use squirm::stages::{Entry, REGISTRY, find};
use std::fmt::Write;
use std::process::ExitCode;

/// Width of a line of text.
const WIDTH: usize = 100;

/// Documents one kind, every kind, or (`all`) every section and kind.
pub fn stages(kind: Option<&str>) -> ExitCode {
    let mut text = String::new();
    match kind {
        None => REGISTRY.iter().for_each(|e| stage(&mut text, e)),
        Some("all") => {
            for section in SECTIONS.iter().filter(|s| s.name != STAGE) {
                let _ = writeln!(text, "{}", section.header());
                paragraph(&mut text, (section.summary)(), 4);
                fields(&mut text, &(section.fields)(), 4);
                text.push('\n');
            }
            REGISTRY.iter().for_each(|e| stage(&mut text, e));
        }
        Some(kind) => {
            let Some(entry) = find(kind) else {
                let error = Diagnostic::error(format!("there is no kind of stage \"{kind}\""));
                let error = error.help(suggestion(kind, REGISTRY.iter().map(|e| e.kind)));
                render::all(&[error], &Sources::default());
                return ExitCode::from(WRONG_USAGE);
            };
            stage(&mut text, entry);
        }
    }
    print(&text)
}

fn stage(text: &mut String, entry: &Entry) {
    let _ = writeln!(text, "{}", entry.kind);
    paragraph(text, (entry.summary)(), 4);
    if !entry.after.is_empty() {
        let _ = writeln!(text, "    Stands after {}.", entry.after.join(", "));
    }
    fields(text, &(entry.fields)(), 4);
    text.push('\n');
}

fn fields(text: &mut String, list: &[Field], indent: usize) {
    for field in list {
        let margin = " ".repeat(indent);
        let default = match &field.default {
            Some(value) => format!("default {}", toml_value(value)),
            None if is_required(field) => "required".into(),
            None => "optional".into(),
        };
        let _ = writeln!(text, "\n{margin}{}: {}; {default}", field.name, accepts(field));
        paragraph(text, field.doc, indent + 4);
        if let Kind::Table { fields: inner } = field.kind {
            fields(text, &inner(), indent + 4);
        }
    }
}

/// Words in lines of at most [`WIDTH`] characters.
fn paragraph(text: &mut String, words: &str, indent: usize) {
    let mut column = 0;
    for word in words.split_whitespace() {
        let length = word.chars().count();
        if column > 0 && column + 1 + length > WIDTH {
            text.push('\n');
            column = 0;
        }
        let space = if column == 0 { " ".repeat(indent) } else { " ".into() };
        column += space.len() + length;
        let _ = write!(text, "{space}{word}");
    }
    text.push('\n');
}
