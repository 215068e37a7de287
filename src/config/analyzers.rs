//! What must hold of the analyzers that are started with a run: something to start, and topics that some output publishes.

use super::node::Node;
use crate::analyze::kinds;
use crate::diag::{Diagnostic, Span};
use crate::graph::{AnalyzerProgram, Output};
use crate::state::System;
use std::path::Path;

/// Checks the analyzers.
pub fn check(
    analyzers: &[AnalyzerProgram],
    outputs: &[Output],
    system: &System,
    root: &Node,
    found: &mut Vec<Diagnostic>,
) {
    for (index, analyzer) in analyzers.iter().enumerate() {
        let number = index.to_string();
        let at = |key: &str| root.place(&["analyzer", &number, key]);
        let whole = root.place(&["analyzer", &number]);
        match (&analyzer.kind, &analyzer.command) {
            (Some(kind), None) => topics(kind, outputs, at("kind"), found),
            (None, Some(words)) => program(words, at("command"), found),
            (Some(_), Some(_)) => found.push(
                Diagnostic::error("an analyzer has a kind or a command, not both")
                    .at(at("command"), "a program of your own")
                    .at(at("kind"), "one of squirm-analyze")
                    .help("remove one of the two, or write two [[analyzer]]"),
            ),
            (None, None) => found.push(
                Diagnostic::error("an analyzer needs a kind or a command, or there is nothing to start")
                    .at(whole, "neither here")
                    .help(format!("add kind = \"{}\", or command = [\"./my-program\"]", kinds::KINDS[0].name)),
            ),
        }
        if analyzer.folder().trim().is_empty() {
            found.push(
                Diagnostic::error("this analyzer has nowhere to write")
                    .at(at("out"), "names no folder")
                    .help("write out = \"my-results\", or leave it out"),
            );
        }
        if let Some(first) = analyzers[..index].iter().position(|a| a.folder() == analyzer.folder()) {
            let other = first.to_string();
            found.push(
                Diagnostic::error(format!("two analyzers would write into the folder `{}`", analyzer.folder()))
                    .at(whole, "again here")
                    .at(root.place(&["analyzer", &other]), "first here")
                    .help("give one of them out = \"another-folder\""),
            );
        }
        if !system.run.live {
            found.push(
                Diagnostic::warning("this analyzer is not started, since the run is not to be watched")
                    .at(whole, "would find nothing")
                    .at(root.place(&["run", "live"]), "live = false")
                    .help("remove live = false under [run]"),
            );
        }
    }
}

fn topics(kind: &str, outputs: &[Output], span: Span, found: &mut Vec<Diagnostic>) {
    let Some(entry) = kinds::find(kind) else { return };
    for topic in entry.topics.iter().map(|t| t.topic()) {
        if outputs.iter().all(|o| o.publish.iter().all(|p| p != topic)) {
            found.push(
                Diagnostic::error(format!("the analyzer `{kind}` reads {topic}, but no output publishes them"))
                    .at(span, format!("needs {topic}"))
                    .help(format!("add publish = [\"{topic}\"] to an [[output]]")),
            );
        }
    }
}

fn program(words: &[String], span: Span, found: &mut Vec<Diagnostic>) {
    let Some(name) = words.first().filter(|w| !w.is_empty()) else {
        found.push(
            Diagnostic::error("the command of this analyzer names no program")
                .at(span, "empty")
                .help("write command = [\"./my-program\", \"argument\"]"),
        );
        return;
    };
    let found_at = |path: &Path| path.is_file();
    let exists = if name.contains('/') {
        found_at(Path::new(name))
    } else {
        std::env::var_os("PATH").is_some_and(|all| std::env::split_paths(&all).any(|dir| found_at(&dir.join(name))))
    };
    if !exists {
        found.push(
            Diagnostic::warning(format!("the program `{name}` cannot be found here"))
                .at(span, "its first word")
                .help("give its path from the folder in which squirm is started, or put it on the PATH"),
        );
    }
}
