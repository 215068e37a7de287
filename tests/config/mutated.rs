//! Mutated files never make the parser panic, and every error has a message; most have a place.

use super::{GOOD, with};
use proptest::prelude::*;

/// Pieces that are likely to meet a special case.
const PIECES: &[&str] = &[
    "",
    "\n",
    "=",
    "[",
    "]",
    "[[",
    "]]",
    "{",
    "}",
    "\"",
    "'",
    "nan",
    "-inf",
    "1e999",
    "99999999999999999999",
    "-1",
    "0",
    "true",
    "[]",
    "{}",
    "#",
    ".",
    "é",
    "\u{0}",
    "[[stage]]",
    "kind",
    "[run]",
    "seed",
    "apply",
    "1979-05-27",
    "0x",
    "_",
];

fn boundary(text: &str, at: usize) -> usize {
    text.floor_char_boundary(at % (text.len() + 1))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn of_the_file(cuts in prop::collection::vec((any::<usize>(), 0usize..40, 0..PIECES.len()), 1..6)) {
        let mut text = GOOD.to_owned();
        for (at, length, piece) in cuts {
            let start = boundary(&text, at);
            let end = text.floor_char_boundary((start + length).min(text.len())).max(start);
            text.replace_range(start..end, PIECES[piece]);
        }
        if let Err(failure) = with(&text, &[]) {
            prop_assert!(failure.diagnostics.iter().any(squirm::diag::Diagnostic::is_error));
            for d in &failure.diagnostics {
                prop_assert!(!d.message.is_empty() && d.help.is_some(), "{d:?}");
                prop_assert!(!d.labels.is_empty(), "{d:?}");
                for (span, _) in &d.labels {
                    let source = failure.sources.get(span.source).expect("a known source");
                    prop_assert!(source.text.get(span.start..span.end).is_some(), "{d:?}");
                }
            }
        }
    }

    #[test]
    fn of_an_override(key in "[a-z0-9_.\\-\"= ]{0,24}", value in "\\PC{0,12}") {
        let argument = format!("{key}={value}");
        if let Err(failure) = with(GOOD, &[&argument]) {
            prop_assert!(failure.diagnostics.iter().any(|d| !d.labels.is_empty()));
        }
    }
}
