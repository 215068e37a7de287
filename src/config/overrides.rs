//! `--set key=value`: one more text that is parsed and laid over the tree of the file.

use super::node::{Item, Node, Pair};
use super::sections::SECTIONS;
use crate::diag::{self, Diagnostic, Sources, Span};

/// Lays `--set` arguments over the tree in their order; what cannot be placed becomes a diagnostic.
pub fn apply(root: &mut Node, overrides: &[String], sources: &mut Sources) -> Vec<Diagnostic> {
    overrides.iter().filter_map(|text| apply_one(root, text, sources).err()).collect()
}

fn apply_one(root: &mut Node, text: &str, sources: &mut Sources) -> Result<(), Diagnostic> {
    let source = sources.add(format!("--set {text}"), text);
    let whole = Span { source, start: 0, end: text.len() };
    let Some((path, raw)) = text.split_once('=') else {
        return Err(Diagnostic::error("an override needs a key and a value")
            .at(whole, "no `=` in here")
            .help("write --set run.steps=200"));
    };
    let start = path.len() + 1 + (raw.len() - raw.trim_start().len());
    let value = read_value(raw.trim(), source, start)?;
    let mut node = root;
    let mut steps = Vec::new();
    let mut at = 0;
    for step in path.split('.') {
        let lead = step.len() - step.trim_start().len();
        let span = Span { source, start: at + lead, end: at + lead + step.trim().len() };
        steps.push((step.trim(), span));
        at += step.len() + 1;
    }
    let ((last, last_span), way) = steps.split_last().expect("split gives at least one part");
    for (step, span) in way {
        node = descend(node, step, *span)?;
    }
    if matches!(node.item, Item::List(_)) {
        *descend(node, last, *last_span)? = value;
        return Ok(());
    }
    let Item::Table(pairs) = &mut node.item else {
        return Err(no_table(node, last, *last_span));
    };
    match pairs.iter_mut().find(|p| p.key == *last) {
        Some(pair) => *pair = Pair { key: pair.key.clone(), key_span: *last_span, node: value },
        None => pairs.push(Pair { key: (*last).to_string(), key_span: *last_span, node: value }),
    }
    Ok(())
}

/// A TOML value, or a bare word, which the shell user may write without quotes.
fn read_value(raw: &str, source: usize, start: usize) -> Result<Node, Diagnostic> {
    let span = Span { source, start, end: start + raw.len() };
    match Node::value(raw, source, start) {
        Ok(node) => Ok(node),
        Err(message) if raw.is_empty() || raw.starts_with(['[', '{', '"', '\'']) => {
            Err(Diagnostic::error(format!("the value of this override is not TOML: {message}"))
                .at(span, "here")
                .help("write numbers and words as they are, lists as [8,8,8], and quote the argument for the shell"))
        }
        Err(_) => Ok(Node { span, item: Item::Text(raw.to_string()) }),
    }
}

/// The child that `step` names: a key of a table (made if absent), or an element of a list by index, by its name or by its kind.
fn descend<'a>(node: &'a mut Node, step: &str, span: Span) -> Result<&'a mut Node, Diagnostic> {
    if !matches!(node.item, Item::Table(_) | Item::List(_)) {
        return Err(no_table(node, step, span));
    }
    match &mut node.item {
        Item::Table(pairs) => {
            let index = pairs.iter().position(|p| p.key == step).unwrap_or(pairs.len());
            if index == pairs.len() {
                let repeated = SECTIONS.iter().any(|s| s.repeated && s.name == step);
                let item = if repeated { Item::List(Vec::new()) } else { Item::Table(Vec::new()) };
                pairs.push(Pair { key: step.to_string(), key_span: span, node: Node { span, item } });
            }
            Ok(&mut pairs[index].node)
        }
        Item::List(nodes) => {
            let names: Vec<String> = nodes.iter().enumerate().map(|(i, n)| label(n, i)).collect();
            let index = step.parse::<usize>().ok().or_else(|| names.iter().position(|n| n == step));
            match index.and_then(|i| nodes.get_mut(i)) {
                Some(child) => Ok(child),
                None if names.is_empty() => Err(Diagnostic::error(format!("there is no `{step}`: the list is empty"))
                    .at(span, "nothing to override")
                    .help("add it to the pipeline file first")),
                None => Err(Diagnostic::error(format!("there is no element `{step}` in this list"))
                    .at(span, "names no element")
                    .help(elements(step, &names))),
            }
        }
        _ => unreachable!("any other item has been refused above"),
    }
}

/// How the elements of a list can be named, where `step` names none.
fn elements(step: &str, names: &[String]) -> String {
    let numbered = names.iter().enumerate().all(|(i, name)| *name == i.to_string());
    let positions = match names.len() {
        1 => "the only position is 0".to_owned(),
        n => format!("positions count from 0 to {}", n - 1),
    };
    if numbered {
        positions
    } else if step.parse::<usize>().is_ok() {
        format!("{positions}; names and kinds serve, too: {}", names.join(", "))
    } else {
        let likely = diag::suggestion(step, names.iter().map(String::as_str));
        format!("{likely}; {positions}, and names and kinds serve, too")
    }
}

/// What an element of a list is called: its name, its kind, or its position.
fn label(node: &Node, index: usize) -> String {
    match node.get("name").or_else(|| node.get("kind")).map(|n| &n.item) {
        Some(Item::Text(name)) => name.clone(),
        _ => index.to_string(),
    }
}

fn no_table(node: &Node, step: &str, span: Span) -> Diagnostic {
    Diagnostic::error(format!("`{step}` cannot be set: what stands before it is {}, not a table", node.describe()))
        .at(span, "this key")
        .at(node.span, "the value it would be part of")
        .help("name a section and a key, as in --set run.steps=200")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(text: &str, overrides: &[&str]) -> (Node, Vec<Diagnostic>, Sources) {
        let mut sources = Sources::default();
        let source = sources.add("f.toml", text);
        let (mut root, errors) = Node::document(text, source);
        assert_eq!(errors, []);
        let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_string()).collect();
        let diagnostics = apply(&mut root, &overrides, &mut sources);
        (root, diagnostics, sources)
    }

    fn item<'a>(root: &'a Node, path: &[&str]) -> &'a Item {
        let node = path.iter().fold(root, |node, step| {
            step.parse::<usize>().map_or_else(|_| node.get(step), |i| node.elements().get(i)).expect("it is there")
        });
        &node.item
    }

    #[test]
    fn keys_indices_names_and_kinds_are_found() {
        let file = "[run]\nsteps=1\n[[squirmers]]\nname=\"puller\"\nb1=1.0\n[[stage]]\nkind=\"rotate\"\n";
        let (root, d, _) = set(
            file,
            &[
                "run.steps=200",
                "squirmers.puller.b1=0.5",
                "stage.rotate.angle=120",
                "stage.0.word=bare",
                "fluid.density=5",
            ],
        );
        assert_eq!(d, []);
        assert_eq!(item(&root, &["run", "steps"]), &Item::Integer(Some(200)));
        assert_eq!(item(&root, &["squirmers", "0", "b1"]), &Item::Float(0.5));
        assert_eq!(item(&root, &["stage", "0", "angle"]), &Item::Integer(Some(120)));
        assert_eq!(item(&root, &["stage", "0", "word"]), &Item::Text("bare".into()));
        assert_eq!(item(&root, &["fluid", "density"]), &Item::Integer(Some(5)));
    }

    #[test]
    fn an_override_knows_its_own_text() {
        let (root, _, sources) = set("[run]\nsteps=1\n", &["run.steps = abc"]);
        let span = root.get("run").unwrap().get("steps").unwrap().span;
        assert_eq!(sources.place(span), "--set run.steps = abc:1:13");
    }

    #[test]
    fn positions_that_exist_are_listed() {
        let helps = |file: &str, key: &str| {
            let (_, d, _) = set(file, &[key]);
            d[0].help.clone().expect("a remedy")
        };
        let outputs = "[[output]]\nevery=1\n[[output]]\nevery=2\n";
        assert_eq!(helps(outputs, "output.5.every=1"), "positions count from 0 to 1");
        assert_eq!(helps(&outputs[..19], "output.1.every=1"), "the only position is 0");
        let stages = "[[stage]]\nkind=\"stream\"\n[[stage]]\nkind=\"rotate\"\n";
        let both = "positions count from 0 to 1; names and kinds serve, too: stream, rotate";
        assert_eq!(helps(stages, "stage.2.angle=1"), both);
    }

    #[test]
    fn what_cannot_be_placed_is_said() {
        let file = "[run]\nsteps=1\n[[stage]]\nkind=\"rotate\"\n";
        let (_, d, _) =
            set(file, &["run.steps", "stage.rotat.angle=1", "run.steps.x=1", "box.size=[1,", "squirmers.a.b1=1"]);
        let messages: Vec<&str> = d.iter().map(|d| d.message.as_str()).collect();
        assert_eq!(messages.len(), 5, "{messages:?}");
        assert!(messages[0].contains("needs a key and a value"));
        assert!(messages[1].contains("no element `rotat`"));
        assert!(d[1].help.as_ref().unwrap().contains("did you mean `rotate`?"));
        assert!(messages[2].contains("a whole number, not a table"));
        assert!(messages[3].contains("not TOML"));
        assert!(messages[4].contains("the list is empty"));
    }
}
