//! Pipeline files: what they mean, and what is said about wrong ones.

mod analyzers;
mod errors;
mod order;
mod overrides;
mod resolved;
mod shipped;
mod start;

use squirm::config::{Failure, Loaded, load};
use std::path::Path;

/// A file without errors or warnings; tests change one thing in it. Line numbers in the tests refer to it.
pub const GOOD: &str = r#"[run]
seed = 3
steps = 100
dt = 0.05

[box]
size = [24, 20, 24]
walls = { axis = "y", condition = "no-slip" }

[fluid]
density = 10
temperature = 1.0

[[squirmers]]
name = "puller"
count = 2
semi_axes = { along = 4.0, across = 2.0 }
b1 = 0.1
beta = 1.0
start = "random"

[[stage]]
kind = "squirmer-move"
[[stage]]
kind = "stream"
[[stage]]
kind = "squirmer-collide"
[[stage]]
kind = "shift-grid"
[[stage]]
kind = "sort-reorder"
every = 50
[[stage]]
kind = "cell-reduce"
[[stage]]
kind = "wall-ghosts"
[[stage]]
kind = "squirmer-fill"
[[stage]]
kind = "rotate"
angle = 130
[[stage]]
kind = "restore-thermostat"

[[output]]
record = ["squirmers", "scalars"]
every = 20
"#;

/// [`GOOD`] with replacements; each must change something.
pub fn changed(changes: &[(&str, &str)]) -> String {
    changes.iter().fold(GOOD.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "the test's own text lacks {from:?}");
        text.replacen(from, to, 1)
    })
}

/// Loads with overrides.
pub fn with(text: &str, overrides: &[&str]) -> Result<Loaded, Failure> {
    let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    load("f.toml", text, &overrides, Path::new(""))
}

/// Loads a text that must be valid.
pub fn good(text: &str) -> Loaded {
    with(text, &[]).unwrap_or_else(|failure| panic!("{failure}"))
}

/// Every diagnostic as one line of plain text, whether the file loads or not.
pub fn lines(text: &str, overrides: &[&str]) -> Vec<String> {
    match with(text, overrides) {
        Ok(loaded) => loaded.warnings.iter().map(|d| d.plain(&loaded.sources)).collect(),
        Err(failure) => failure.diagnostics.iter().map(|d| d.plain(&failure.sources)).collect(),
    }
}

/// The only diagnostic of [`GOOD`] with replacements.
pub fn only(changes: &[(&str, &str)]) -> String {
    let found = lines(&changed(changes), &[]);
    assert_eq!(found.len(), 1, "{found:#?}");
    found.into_iter().next().expect("there is one")
}

/// Checks that the only diagnostic begins with a place and contains every part.
#[track_caller]
pub fn says(changes: &[(&str, &str)], place: &str, parts: &[&str]) {
    let line = only(changes);
    assert!(line.starts_with(&format!("f.toml:{place}: ")), "expected {place}: {line}");
    for part in parts {
        assert!(line.contains(part), "expected {part:?} in: {line}");
    }
}

#[test]
fn the_good_file_is_good() {
    assert_eq!(lines(GOOD, &[]), Vec::<String>::new());
}
