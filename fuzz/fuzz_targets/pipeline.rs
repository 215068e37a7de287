//! Any text as a pipeline file: checking ends with a plan that means something, or with errors that have a place and help.
#![no_main]

use libfuzzer_sys::fuzz_target;
use squirm::config::{load, meaning};
use squirm::diag::Diagnostic;
use std::path::Path;

fuzz_target!(|text: &str| {
    let (found, sources) = match load("f.toml", text, &[], Path::new("/nowhere")) {
        Ok(loaded) => {
            assert!(!meaning(&loaded).to_string().is_empty());
            (loaded.warnings, loaded.sources)
        }
        Err(failure) => {
            assert!(failure.diagnostics.iter().any(Diagnostic::is_error));
            (failure.diagnostics, failure.sources)
        }
    };
    for diagnostic in &found {
        assert!(!diagnostic.message.is_empty() && diagnostic.help.is_some(), "{diagnostic:?}");
        assert!(!diagnostic.labels.is_empty(), "{diagnostic:?}");
        for (span, _) in &diagnostic.labels {
            let source = sources.get(span.source).expect("a known source");
            assert!(source.text.get(span.start..span.end).is_some(), "{diagnostic:?}");
        }
    }
});
