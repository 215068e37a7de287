//! The list of stages: kinds, order, and whether every stage reads what an earlier one has computed in the same step.

use super::node::{Item, Node};
use super::read::Reader;
use super::{STAGE, tables};
use crate::buffers::CATALOGUE;
use crate::diag::{self, Diagnostic, Span};
use crate::graph::freshness::{self, Cause, Stale};
use crate::graph::kernels::{self, APPLY, Kernel};
use crate::params::Values;
use crate::stages::{self, Entry, REGISTRY};

/// One stage of the file.
#[derive(Debug, Clone)]
pub struct Listed {
    /// The registry entry.
    pub entry: &'static Entry,
    /// Its parameters; `None` if any of them is wrong.
    pub values: Option<Values>,
    /// Where its kind stands.
    pub span: Span,
    /// Its position in the file; `None` if it is implied.
    pub index: Option<usize>,
}

impl Listed {
    /// Whether the stage runs in every step.
    fn every_step(&self) -> bool {
        self.values.as_ref().is_none_or(|v| (self.entry.every)(v) == 1)
    }
}

/// Reads the list and appends the implied `apply`; also whether every kind is known.
pub fn read(reader: &mut Reader, root: &Node) -> (Vec<Listed>, bool) {
    let Some(nodes) = tables(reader, root, STAGE) else { return (Vec::new(), false) };
    if nodes.is_empty() && !reader.lenient {
        reader.diagnostics.push(
            Diagnostic::error("the pipeline has no stage, so a step would do nothing")
                .at(root.span, "no [[stage]] in this file")
                .help("list the stages of a step; `squirm stages` names them in their usual order"),
        );
    }
    let read: Vec<Option<Listed>> = nodes.iter().enumerate().map(|(i, n)| read_one(reader, n, i)).collect();
    let all_known = read.iter().all(Option::is_some) && !nodes.is_empty();
    let mut listed: Vec<Listed> = read.into_iter().flatten().collect();
    if !listed.iter().any(|s| s.entry.kind == APPLY)
        && let (Some(entry), Some(last)) = (stages::find(APPLY), listed.last())
        && listed.iter().any(|s| computes_operators(s.entry))
    {
        let values = Some(Values::defaults(&(entry.fields)()));
        listed.push(Listed { entry, values, span: last.span, index: None });
    }
    (listed, all_known)
}

/// Whether a stage writes the cells' operators, which ask for an `apply`.
fn computes_operators(entry: &'static Entry) -> bool {
    let uses = entry.phases.iter().filter_map(|p| kernels::uses(entry, p.entry).ok()).flatten();
    uses.into_iter().any(|u| u.write && u.buffer == "operators")
}

fn read_one(reader: &mut Reader, node: &Node, index: usize) -> Option<Listed> {
    let kinds = || REGISTRY.iter().map(|e| e.kind);
    let Some(kind) = node.get("kind") else {
        if !reader.lenient {
            let help = format!("add kind = \"...\"; kinds: {}", kinds().collect::<Vec<_>>().join(", "));
            let error = Diagnostic::error("a stage needs a kind, which says what it does");
            reader.diagnostics.push(error.at(node.span, "`kind` is missing here").help(help));
        }
        return None;
    };
    let Item::Text(name) = &kind.item else {
        let error = Diagnostic::error(format!("`kind` must be a text in quotes, but this is {}", kind.describe()));
        reader.diagnostics.push(error.at(kind.span, "this value").help("write kind = \"stream\""));
        return None;
    };
    let Some(entry) = stages::find(name) else {
        reader.diagnostics.push(
            Diagnostic::error(format!("there is no kind of stage \"{name}\""))
                .at(kind.span, "unknown kind")
                .help(diag::suggestion(name, kinds())),
        );
        return None;
    };
    let values = reader.table(node, &(entry.fields)(), &format!("stage `{name}`"), &["kind"]);
    Some(Listed { entry, values, span: kind.span, index: Some(index) })
}

/// Duplicates, order and freshness.
pub fn check(listed: &[Listed], all_kinds_known: bool, found: &mut Vec<Diagnostic>) {
    for (i, stage) in listed.iter().enumerate() {
        if let Some(first) = listed[..i].iter().find(|s| s.entry.kind == stage.entry.kind) {
            found.push(
                Diagnostic::error(format!("the stage `{}` is listed twice", stage.entry.kind))
                    .at(stage.span, "again here")
                    .at(first.span, "first here")
                    .help("remove one of the two: each stage runs once in a step"),
            );
        }
        let misplaced = |s: &&Listed| {
            let before = listed[..i].iter().any(|b| b.entry.kind == s.entry.kind);
            stage.entry.after.contains(&s.entry.kind) && !before
        };
        for later in listed[i + 1..].iter().filter(misplaced) {
            let (kind, before) = (stage.entry.kind, later.entry.kind);
            found.push(
                Diagnostic::error(format!("the stage `{kind}` stands before `{before}`, but must come after it"))
                    .at(stage.span, "too early")
                    .at(later.span, format!("`{before}` stands here"))
                    .help(format!("move the [[stage]] of `{kind}` below that of `{before}`")),
            );
        }
    }
    let repeated = found.iter().any(|d| d.message.ends_with("is listed twice"));
    if all_kinds_known && !repeated {
        check_buffers(listed, found);
    }
}

fn check_buffers(listed: &[Listed], found: &mut Vec<Diagnostic>) {
    let stages: Vec<(&'static Entry, bool)> = listed.iter().map(|s| (s.entry, s.every_step())).collect();
    let kernels = match kernels::kernels(&stages) {
        Ok(kernels) => kernels,
        Err(error) => {
            let message = format!("a shader of this program is not valid: {error}");
            found.push(
                Diagnostic::error(message).help("this is a fault of the program, not of the file: please report it"),
            );
            return;
        }
    };
    for stale in freshness::stale_reads(&kernels, CATALOGUE) {
        found.push(stale_diagnostic(&stale, &kernels, listed));
    }
    for (stage, buffer) in freshness::unread(&kernels, CATALOGUE) {
        let kind = listed[stage].entry.kind;
        found.push(
            Diagnostic::warning(format!("`{kind}` computes `{buffer}`, but no stage uses it"))
                .at(listed[stage].span, "work for nothing")
                .help(format!("remove `{kind}`, or add the stages that need `{buffer}`")),
        );
    }
}

fn stale_diagnostic(stale: &Stale, kernels: &[Kernel], listed: &[Listed]) -> Diagnostic {
    let reader = &kernels[stale.kernel];
    let place = listed[reader.stage].span;
    let (kind, buffer) = (reader.kind, &stale.buffer);
    let verb = if stale.adds { "adds to" } else { "reads" };
    let at = format!("{verb} `{buffer}`");
    let makers: Vec<&str> = kernels::makers(buffer).into_iter().filter(|m| *m != kind).collect();
    let maker = makers.first().map_or_else(|| format!("a stage that computes `{buffer}`"), |m| format!("`{m}`"));
    match &stale.cause {
        Cause::NotComputed => {
            let later = makers.first().and_then(|m| listed.iter().find(|s| s.entry.kind == *m));
            let message = format!("`{kind}` {verb} `{buffer}`, but no stage before it has computed that in this step");
            let error = Diagnostic::error(message).at(place, at);
            match later {
                Some(s) => error
                    .at(s.span, format!("{maker} stands here"))
                    .help(format!("move the [[stage]] of {maker} above that of `{kind}`")),
                None => error.help(match makers.first() {
                    Some(m) => format!("add a [[stage]] with kind = \"{m}\" before `{kind}`"),
                    None => format!("add {maker} before `{kind}`"),
                }),
            }
        }
        Cause::Spoiled { kernel, source } => {
            let culprit = &kernels[*kernel];
            let other = culprit.kind;
            Diagnostic::error(format!(
                "`{kind}` {verb} `{buffer}`, which is out of date: `{other}` has changed `{source}` since it was computed"
            ))
            .at(place, at)
            .at(listed[culprit.stage].span, format!("changes `{source}`"))
            .help(format!("move `{other}` above {maker}, or below `{kind}`"))
        }
        Cause::Occasional { kernel } => {
            let culprit = &kernels[*kernel];
            let other = culprit.kind;
            Diagnostic::error(format!(
                "`{kind}` {verb} `{buffer}` in every step, but `{other}` computes it only in some"
            ))
            .at(place, at)
            .at(listed[culprit.stage].span, "not in every step")
            .help(format!("set every = 1 in `{other}`"))
        }
    }
}
