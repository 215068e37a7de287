//! What must hold of the outputs: that each writes something, and that there is one.

use super::node::Node;
use crate::diag::Diagnostic;
use crate::graph::Output;
use crate::state::System;

/// Checks the outputs.
pub fn check(outputs: &[Output], system: &System, root: &Node, found: &mut Vec<Diagnostic>) {
    if outputs.is_empty() {
        found.push(
            Diagnostic::warning("there is no [[output]], so a run leaves nothing but its summary")
                .at(root.span, "nowhere in this file")
                .help("add [[output]] with record = [\"squirmers\", \"scalars\"] and every = 100"),
        );
    }
    for (index, output) in outputs.iter().enumerate() {
        one(output, &index.to_string(), system, root, found);
        slow(outputs, index, root, found);
    }
}

/// What is said about slow readers: something must be published, and the same for a topic wherever it is published.
fn slow(outputs: &[Output], index: usize, root: &Node, found: &mut Vec<Diagnostic>) {
    let output = &outputs[index];
    let number = index.to_string();
    let place = root.place(&["output", &number, "on_slow"]);
    if output.publish.is_empty() && output.on_slow != "drop" {
        found.push(
            Diagnostic::warning("`on_slow` is about readers of `publish`, but this output publishes nothing")
                .at(place, "no effect")
                .help("remove on_slow, or add publish"),
        );
    }
    let same = |other: &Output| (&other.on_slow, other.slow_limit) == (&output.on_slow, output.slow_limit);
    for (first, other) in outputs[..index].iter().enumerate().filter(|(_, other)| !same(other)) {
        if let Some(topic) = output.publish.iter().find(|topic| other.publish.contains(topic)) {
            found.push(
                Diagnostic::error(format!("two outputs publish {topic}, but treat its slow readers differently"))
                    .at(place, "one way here")
                    .at(root.place(&["output", &first.to_string(), "on_slow"]), "another here")
                    .help("give both the same on_slow and slow_limit"),
            );
        }
    }
}

fn one(output: &Output, index: &str, system: &System, root: &Node, found: &mut Vec<Diagnostic>) {
    let at = |key: &str| root.place(&["output", index, key]);
    let lists = [("publish", &output.publish), ("record", &output.record), ("csv", &output.csv)];
    if lists.iter().all(|(_, words)| words.is_empty()) {
        found.push(
            Diagnostic::warning("this output names nothing, so it writes nothing")
                .at(root.place(&["output", index]), "empty")
                .help("add record = [\"squirmers\", \"scalars\"], or publish or csv"),
        );
        return;
    }
    for (key, words) in lists {
        if system.species.is_empty() && words.iter().any(|w| w == "squirmers") {
            found.push(
                Diagnostic::warning(format!("`{key}` asks for squirmers, but there are none"))
                    .at(at(key), "nothing to write")
                    .help("remove \"squirmers\", or add a [[squirmers]]"),
            );
        }
        if output.fraction == 0.0 && words.iter().any(|w| w == "particles") {
            found.push(
                Diagnostic::warning(format!("`{key}` asks for particles, but takes none of them"))
                    .at(at("fraction"), "a share of zero")
                    .help("give a fraction above 0; 1 takes every particle"),
            );
        }
    }
    if output.every > system.run.steps {
        found.push(
            Diagnostic::warning(format!(
                "the run ends after {} steps: this output shows its start and nothing else",
                system.run.steps
            ))
            .at(at("every"), format!("every {} steps", output.every))
            .help("write more often, or run longer"),
        );
    }
}
