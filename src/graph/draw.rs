//! Drawings of a plan: stages, their kernels, and the buffers that flow between them.

use super::fused::{Item, Member};
use super::kernels::{Kernel, Use};
use super::traffic;
use crate::buffers::{Extent, STEPS_AHEAD, Sizes};
use crate::stages::Entry;
use std::fmt::Write;

/// Settings that every kernel may bind, and the flags that every kernel may raise; drawings leave them out.
const BACKGROUND: [&str; 4] = ["system", "settings", "species", "faults"];

/// Buffers a kernel uses that a drawing shows, with how: `r`, `w`, or `+` for both.
fn shown(kernel: &Kernel) -> impl Iterator<Item = (&str, char)> {
    kernel.uses.iter().filter(|u| !BACKGROUND.contains(&u.buffer.as_str())).map(|u| {
        let how = match (u.read, u.write) {
            (true, true) => '+',
            (false, true) => 'w',
            _ => 'r',
        };
        (u.buffer.as_str(), how)
    })
}

/// Buffers in the order of their first use.
fn columns(kernels: &[Kernel]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in kernels.iter().flat_map(shown) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// A table for the terminal: a row for each kernel, a column for each buffer, named above it.
#[must_use]
pub fn terminal(kernels: &[Kernel]) -> String {
    let names = columns(kernels);
    let label = |k: &Kernel, first: bool| {
        let stage = if first { k.kind } else { "" };
        let when = if k.receive { format!("{} (after apply)", k.entry) } else { k.entry.to_owned() };
        (stage.to_owned(), when)
    };
    let heads: Vec<(String, String)> = kernels
        .iter()
        .enumerate()
        .map(|(i, k)| {
            let same = i > 0 && kernels[i - 1].stage == k.stage && kernels[i - 1].receive == k.receive;
            label(k, !same)
        })
        .collect();
    let width = |pick: fn(&(String, String)) -> &String| heads.iter().map(|h| pick(h).len()).max().unwrap_or(0);
    let (stages, entries) = (width(|h| &h.0), width(|h| &h.1));
    let mut text = String::from("r reads, w writes, + reads and writes; a step runs from top to bottom\n\n");
    let margin = " ".repeat(stages + entries + 4);
    for (i, name) in names.iter().enumerate() {
        let _ = writeln!(text, "{margin}{}┌ {name}", "│ ".repeat(i));
    }
    for (kernel, (stage, entry)) in kernels.iter().zip(&heads) {
        let _ = write!(text, "{stage:<stages$}  {entry:<entries$}  ");
        let mut row = String::new();
        for name in &names {
            row.push(shown(kernel).find(|(n, _)| n == name).map_or('·', |(_, how)| how));
            row.push(' ');
        }
        let _ = writeln!(text, "{}", row.trim_end());
    }
    text
}

/// A row of the table of the fused plan: a name, what it uses, and what it has invocations for.
type Row = (String, Vec<Use>, Extent);

fn rows(item: &Item, stages: &[(&'static Entry, u32, bool)]) -> Vec<Row> {
    let point = |m: &Member| format!("{} {}", stages[m.stage].0.kind, m.phase.entry);
    let members = item.members();
    let several = match item {
        Item::InTurn(_) => Some("one after the other:"),
        Item::Small(_) => Some("one workgroup:"),
        Item::Beside(_) => Some("side by side:"),
        _ => None,
    };
    if let Some(head) = several {
        let head = (head.to_owned(), Vec::new(), Extent::One);
        let indented = members.iter().map(|m| (format!("  {}", point(m)), m.uses.clone(), m.phase.over));
        return std::iter::once(head).chain(indented).collect();
    }
    vec![(members.iter().map(point).collect::<Vec<_>>().join(" + "), item.uses(), item.over())]
}

/// The kernels of a step that applies the collision of the one before, as a table: which stages share one, and the bytes that each
/// moves per fluid particle if every buffer is read and written once. Small kernels that share a workgroup stand below it; what is done ahead for many
/// steps is named first.
#[must_use]
pub fn fused((items, ahead): (&[Item], &[Member]), stages: &[(&'static Entry, u32, bool)], sizes: &Sizes) -> String {
    let rows: Vec<Row> = items.iter().flat_map(|i| rows(i, stages)).collect();
    let width = rows.iter().map(|(name, ..)| name.len()).max().unwrap_or(0);
    let done = |m: &Member| format!("once in {STEPS_AHEAD} steps: {} {}\n", stages[m.stage].0.kind, m.phase.entry);
    let mut text: String = ahead.iter().map(done).collect();
    let _ = writeln!(text, "{:<width$}  {:>15}  reads and writes", "kernel", "bytes/particle");
    let mut sum = 0.0;
    for (name, uses, over) in rows {
        if uses.is_empty() {
            let _ = writeln!(text, "{name}");
            continue;
        }
        let bytes: f64 = uses.iter().map(|u| traffic::moved(u, over, sizes)).sum();
        sum += bytes;
        let how = |u: &Use| match (u.read, u.write) {
            (true, true) => format!("+{}", u.buffer),
            (false, true) => format!("w {}", u.buffer),
            _ => format!("r {}", u.buffer),
        };
        let seen =
            uses.iter().filter(|u| !BACKGROUND.contains(&u.buffer.as_str()) && !u.buffer.starts_with("settings"));
        let list = seen.map(how).collect::<Vec<_>>().join(", ");
        let _ = writeln!(text, "{name:<width$}  {bytes:>15.2}  {list}");
    }
    let _ = writeln!(text, "{:<width$}  {sum:>15.2}  r reads, w writes, + both", "a step");
    text
}

/// A stage of a drawing.
struct Node<'a> {
    stage: usize,
    kind: &'static str,
    /// Buffers with whether the stage reads and whether it writes them.
    uses: Vec<(&'a str, bool, bool)>,
}

/// Stages in order of their first kernel, each with how it uses every buffer.
fn by_stage(kernels: &[Kernel]) -> Vec<Node<'_>> {
    let mut nodes: Vec<Node<'_>> = Vec::new();
    for kernel in kernels {
        let at = nodes.iter().position(|n| n.stage == kernel.stage).unwrap_or_else(|| {
            nodes.push(Node { stage: kernel.stage, kind: kernel.kind, uses: Vec::new() });
            nodes.len() - 1
        });
        for (name, how) in shown(kernel) {
            let (read, write) = (how != 'w', how != 'r');
            match nodes[at].uses.iter_mut().find(|(n, ..)| *n == name) {
                Some((_, r, w)) => (*r, *w) = (*r || read, *w || write),
                None => nodes[at].uses.push((name, read, write)),
            }
        }
    }
    nodes
}

/// A graph in the language of Graphviz: boxes are stages, ellipses are buffers, a bold line is the order.
#[must_use]
pub fn dot(name: &str, kernels: &[Kernel]) -> String {
    let mut text = format!("digraph \"{}\" {{\n  rankdir=LR;\n", name.replace(['"', '\\'], "_"));
    let stages = by_stage(kernels);
    for Node { kind, .. } in &stages {
        let _ = writeln!(text, "  \"stage {kind}\" [label=\"{kind}\", shape=box];");
    }
    for buffer in columns(kernels) {
        let _ = writeln!(text, "  \"{buffer}\" [shape=ellipse];");
    }
    for pair in stages.windows(2) {
        let _ = writeln!(text, "  \"stage {}\" -> \"stage {}\" [style=bold, weight=8];", pair[0].kind, pair[1].kind);
    }
    for Node { kind, uses, .. } in &stages {
        for (buffer, read, write) in uses {
            // One line with two heads is easier to follow than two lines.
            let _ = match (read, write) {
                (true, true) => writeln!(text, "  \"stage {kind}\" -> \"{buffer}\" [dir=both];"),
                (true, false) => writeln!(text, "  \"{buffer}\" -> \"stage {kind}\";"),
                _ => writeln!(text, "  \"stage {kind}\" -> \"{buffer}\";"),
            };
        }
    }
    text.push_str("}\n");
    text
}

/// The same graph in the language of Mermaid.
#[must_use]
pub fn mermaid(kernels: &[Kernel]) -> String {
    let mut text = String::from("flowchart LR\n");
    let stages = by_stage(kernels);
    for (i, Node { kind, .. }) in stages.iter().enumerate() {
        let _ = writeln!(text, "  s{i}[\"{kind}\"]");
    }
    let buffers = columns(kernels);
    for (i, buffer) in buffers.iter().enumerate() {
        let _ = writeln!(text, "  b{i}([\"{buffer}\"])");
    }
    for i in 1..stages.len() {
        let _ = writeln!(text, "  s{} ==> s{i}", i - 1);
    }
    for (i, Node { uses, .. }) in stages.iter().enumerate() {
        for (buffer, read, write) in uses {
            let b = buffers.iter().position(|n| n == buffer).expect("columns holds every shown buffer");
            let _ = match (read, write) {
                (true, true) => writeln!(text, "  s{i} <--> b{b}"),
                (true, false) => writeln!(text, "  b{b} --> s{i}"),
                _ => writeln!(text, "  s{i} --> b{b}"),
            };
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::Phase;

    fn kernels() -> Vec<Kernel> {
        let used = |name: &str, read, write| Use::whole(name, read, write);
        let kernel = |stage, kind, entry, receive, uses| Kernel { stage, kind, entry, receive, every_step: true, uses };
        vec![
            kernel(0, "sum", "clear", false, vec![used("system", true, false), used("moments", false, true)]),
            kernel(0, "sum", "add", false, vec![used("particles", true, false), used("moments", true, true)]),
            kernel(1, "apply", "apply", false, vec![used("moments", true, false)]),
            kernel(0, "sum", "take", true, vec![used("moments", true, false)]),
        ]
    }

    #[test]
    fn the_terminal_has_a_row_for_each_kernel_and_a_column_for_each_buffer() {
        let expected = "\
r reads, w writes, + reads and writes; a step runs from top to bottom

                           ┌ moments
                           │ ┌ particles
sum    clear               w ·
       add                 + r
apply  apply               r ·
sum    take (after apply)  r ·
";
        assert_eq!(terminal(&kernels()), expected);
    }

    #[test]
    fn graphs_have_both_kinds_of_nodes_and_directed_edges() {
        let text = dot("a \"run\"", &kernels());
        assert!(text.starts_with("digraph \"a _run_\" {"), "{text}");
        assert!(text.contains("\"stage sum\" -> \"moments\" [dir=both];"), "{text}");
        assert!(text.contains("\"particles\" -> \"stage sum\";"), "{text}");
        assert!(text.contains("\"moments\" -> \"stage apply\";") && !text.contains("\"stage apply\" -> \"moments\";"));
        assert!(!text.contains("system"));
        let text = mermaid(&kernels());
        assert!(text.contains("s0 ==> s1") && text.contains("b0 --> s1") && text.contains("s0 <--> b0"), "{text}");
        assert!(!text.contains("s1 --> b0"), "{text}");
    }

    #[test]
    fn the_fused_table_names_what_shares_a_kernel() {
        let kinds = ["squirmer-move", "stream", "shift-grid", "cell-reduce", "rotate", "apply"];
        let stages: Vec<_> = kinds.map(|k| (crate::stages::find(k).expect("a stage"), 1, true)).to_vec();
        let sizes = Sizes { particles: 1000, cells: 100, squirmers: 2, ..Sizes::default() };
        let items = super::super::fused::items(&stages, super::super::fused::Occasion::Next, &sizes).expect("valid");
        let wgsl = crate::stages::find("shift-grid").and_then(|e| e.fused).expect("it has a text").text("shift_ahead");
        let ahead = Member {
            stage: 2,
            wgsl,
            phase: Phase { entry: "shift_ahead", over: Extent::Steps },
            ..items[0].members()[0].clone()
        };
        let text = fused((&items, &[ahead]), &stages, &sizes);
        assert!(text.starts_with("once in 63 steps: shift-grid shift_ahead\n"), "{text}");
        assert!(text.contains("apply apply + stream stream + cell-reduce tally "), "{text}");
        assert!(text.contains("one workgroup:\n  squirmer-move drift_first "), "{text}");
        let line = text.lines().find(|l| l.starts_with("cell-reduce gather + rotate rotate")).expect("they share one");
        // Particles 24, links 4, chains of even and odd steps read and written 1.6, the operator 6.4, and the shift; no moments, which stay in registers.
        assert!(line.contains(" 36.0") && !line.contains("moments"), "{line}");
        assert!(text.lines().last().is_some_and(|l| l.starts_with("a step")), "{text}");
    }
}
