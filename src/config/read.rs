//! From the tree to values: types, ranges, unknown and missing keys, checked against the parameters' own descriptions.

use super::node::{Item, Node, number_before_unit};
use super::sections::is_required;
use crate::diag::{self, Diagnostic, Span};
use crate::params::{Field, Kind, Value, Values};

/// Reads tables and collects what is wrong with them.
#[derive(Debug, Default)]
pub struct Reader {
    /// What was wrong so far.
    pub diagnostics: Vec<Diagnostic>,
    /// Whether to keep silent about missing keys, since the text around them could not be parsed.
    pub lenient: bool,
}

impl Reader {
    /// Values of one table, or `None` if any of them is wrong. `title` names the table in messages; keys in `also` are the
    /// caller's to read.
    pub fn table(&mut self, node: &Node, fields: &[Field], title: &str, also: &[&str]) -> Option<Values> {
        let Item::Table(pairs) = &node.item else {
            let keys: Vec<&str> = fields.iter().map(|f| f.name).collect();
            self.diagnostics.push(
                Diagnostic::error(format!("{title} must be a table, but this is {}", node.describe()))
                    .at(node.span, "not a table")
                    .help(format!("give it the keys {}", keys.join(", "))),
            );
            return None;
        };
        let mut values = Values::defaults(fields);
        let mut complete = true;
        for pair in pairs {
            match fields.iter().find(|f| f.name == pair.key) {
                Some(field) => match self.value(&pair.node, field) {
                    Some(value) => values.set(field.name, value),
                    None => complete = false,
                },
                None if also.contains(&pair.key.as_str()) => {}
                None => {
                    self.unknown(&pair.key, pair.key_span, fields, title, also);
                    complete = false;
                }
            }
        }
        for field in fields.iter().filter(|f| is_required(f)) {
            if !pairs.iter().any(|p| p.key == field.name) {
                complete = false;
                self.missing(node.span, field, title);
            }
        }
        complete.then_some(values)
    }

    fn unknown(&mut self, key: &str, span: Span, fields: &[Field], title: &str, also: &[&str]) {
        let known = fields.iter().map(|f| f.name).chain(also.iter().copied());
        self.diagnostics.push(
            Diagnostic::error(format!("{title} has no parameter `{key}`"))
                .at(span, "unknown key")
                .help(diag::suggestion(key, known)),
        );
    }

    fn missing(&mut self, span: Span, field: &Field, title: &str) {
        if !self.lenient {
            self.diagnostics.push(
                Diagnostic::error(format!("{title} lacks `{}`, which has no default: {}", field.name, field.doc))
                    .at(span, format!("`{}` is missing here", field.name))
                    .help(format!("add {} = ..., {}", field.name, accepts(field))),
            );
        }
    }

    /// One value, or `None` after a diagnostic.
    pub fn value(&mut self, node: &Node, field: &Field) -> Option<Value> {
        match field.kind {
            Kind::Float { min, max } => self.float(node, field, (min, max)).map(Value::Float),
            Kind::Integer { min, max } => self.integer(node, field, (min, max)).map(Value::Integer),
            Kind::Vector { len, min, max } => {
                let nodes = self.list(node, field, Some(len))?;
                all(nodes.iter().map(|n| self.float(n, field, (min, max)))).map(Value::Vector)
            }
            Kind::Counts { len, min, max } => {
                let nodes = self.list(node, field, Some(len))?;
                all(nodes.iter().map(|n| self.integer(n, field, (min, max)))).map(Value::Counts)
            }
            Kind::Rows { len } => {
                let rows = self.list(node, field, None)?;
                let rows = rows.iter().map(|row| {
                    let numbers = self.list(row, field, Some(len))?;
                    all(numbers.iter().map(|n| self.float(n, field, (f64::MIN, f64::MAX))))
                });
                all(rows).map(Value::Rows)
            }
            Kind::Words(words) => {
                let nodes = self.list(node, field, None)?;
                all(nodes.iter().map(|n| self.word(n, field, words))).map(Value::Words)
            }
            Kind::Texts => {
                let nodes = self.list(node, field, None)?;
                all(nodes.iter().map(|n| self.text(n, field))).map(Value::Words)
            }
            Kind::Choice(words) => self.word(node, field, words).map(Value::Text),
            Kind::Boolean => match node.item {
                Item::Boolean(b) => Some(Value::Boolean(b)),
                _ => self.wrong_type(node, field),
            },
            Kind::Text => self.text(node, field).map(Value::Text),
            Kind::Table { fields } => self.table(node, &fields(), &format!("`{}`", field.name), &[]).map(Value::Table),
        }
    }

    #[allow(clippy::cast_precision_loss)]
    fn float(&mut self, node: &Node, field: &Field, (min, max): (f64, f64)) -> Option<f64> {
        let number = match node.item {
            Item::Float(x) => x,
            Item::Integer(Some(i)) => i as f64,
            _ => return self.wrong_type(node, field),
        };
        if !number.is_finite() {
            let what = if number.is_nan() { "not a number" } else { "infinite" };
            return self.refuse(node, field, format!("`{}` is {what}: no simulation can run on it", field.name));
        }
        if (min..=max).contains(&number) { Some(number) } else { self.out_of_range(node, field, &plain(number)) }
    }

    #[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss)]
    fn integer(&mut self, node: &Node, field: &Field, (min, max): (i64, i64)) -> Option<i64> {
        match node.item {
            Item::Integer(Some(i)) if (min..=max).contains(&i) => Some(i),
            Item::Integer(Some(i)) => self.out_of_range(node, field, &i.to_string()),
            Item::Integer(None) => {
                let message =
                    format!("`{}` must be a whole number of at most {}, but this is beyond it", field.name, max);
                self.refuse(node, field, message)
            }
            Item::Float(x) if x.fract() == 0.0 && x.abs() < 1e15 => {
                let message = format!("`{}` must be written as a whole number", field.name);
                let diagnostic = Diagnostic::error(message).at(node.span, "has a point or an exponent");
                self.diagnostics.push(diagnostic.help(format!("write {}", x as i64)));
                None
            }
            _ => self.wrong_type(node, field),
        }
    }

    fn text(&mut self, node: &Node, field: &Field) -> Option<String> {
        match &node.item {
            Item::Text(text) => Some(text.clone()),
            _ => self.wrong_type(node, field),
        }
    }

    fn word(&mut self, node: &Node, field: &Field, words: &[&'static str]) -> Option<String> {
        let Item::Text(text) = &node.item else {
            return self.wrong_type(node, field);
        };
        if words.contains(&text.as_str()) {
            return Some(text.clone());
        }
        let help = match words {
            [only] => format!("it can only be \"{only}\": {}", field.doc),
            words => diag::suggestion(text, words.iter().copied()),
        };
        let error = Diagnostic::error(format!("`{}` cannot be \"{text}\"", field.name));
        self.diagnostics.push(error.at(node.span, "unknown word").help(help));
        None
    }

    fn list<'a>(&mut self, node: &'a Node, field: &Field, len: Option<usize>) -> Option<&'a [Node]> {
        let Item::List(nodes) = &node.item else {
            return self.wrong_type(node, field);
        };
        match len {
            Some(len) if nodes.len() != len => {
                let message = format!("`{}` needs {len} numbers, but this has {}", field.name, nodes.len());
                self.refuse(node, field, message)
            }
            _ => Some(nodes),
        }
    }

    fn wrong_type<T>(&mut self, node: &Node, field: &Field) -> Option<T> {
        let unit = match &node.item {
            Item::Text(text) => number_before_unit(text),
            _ => None,
        };
        let message = format!("`{}` must be {}, but this is {}", field.name, noun(field.kind), node.describe());
        match unit {
            Some(number) => {
                let help = format!("numbers carry no unit: write {number} alone. {}", sentence(&accepts(field)));
                self.diagnostics.push(Diagnostic::error(message).at(node.span, "this value").help(help));
                None
            }
            None => self.refuse(node, field, message),
        }
    }

    fn out_of_range<T>(&mut self, node: &Node, field: &Field, value: &str) -> Option<T> {
        let message = format!("`{}` must be {}: {value} is out of range", field.name, range(field));
        self.refuse(node, field, message)
    }

    fn refuse<T>(&mut self, node: &Node, field: &Field, message: String) -> Option<T> {
        let help = format!("{} {}", field.doc, sentence(&accepts(field)));
        self.diagnostics.push(Diagnostic::error(message).at(node.span, "this value").help(help));
        None
    }
}

/// All values, or `None` if one is missing; every one is asked for, so that every error is found.
fn all<T>(values: impl Iterator<Item = Option<T>>) -> Option<Vec<T>> {
    let values: Vec<Option<T>> = values.collect();
    values.into_iter().collect()
}

/// A number as people write it.
fn plain(number: f64) -> String {
    if (1e-6..1e12).contains(&number.abs()) || number == 0.0 { number.to_string() } else { format!("{number:e}") }
}

fn noun(kind: Kind) -> String {
    match kind {
        Kind::Float { .. } => "a number".into(),
        Kind::Integer { .. } => "a whole number".into(),
        Kind::Boolean => "true or false".into(),
        Kind::Text => "a text in quotes".into(),
        Kind::Choice(_) => "a word in quotes".into(),
        Kind::Vector { len, .. } => format!("a list of {len} numbers"),
        Kind::Counts { len, .. } => format!("a list of {len} whole numbers"),
        Kind::Words(_) => "a list of words".into(),
        Kind::Texts => "a list of texts in quotes".into(),
        Kind::Rows { len } => format!("a list of rows of {len} numbers"),
        Kind::Table { .. } => "a table".into(),
    }
}

fn sentence(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or(String::new(), |first| format!("{}{}.", first.to_uppercase(), chars.as_str()))
}

/// What a parameter accepts, with range and unit: `a number from 0 to 180, in degree`.
#[must_use]
pub fn accepts(field: &Field) -> String {
    let range = range(field);
    if field.unit.is_empty() { range } else { format!("{range}, in {}", field.unit) }
}

/// What a parameter accepts, without its unit.
#[must_use]
pub fn range(field: &Field) -> String {
    let noun = noun(field.kind);
    match field.kind {
        Kind::Float { min, max } | Kind::Vector { min, max, .. } => format!("{noun} from {min} to {max}"),
        Kind::Integer { min, max } | Kind::Counts { min, max, .. } if max < i64::MAX => {
            format!("{noun} from {min} to {max}")
        }
        Kind::Integer { min, .. } | Kind::Counts { min, .. } => format!("{noun}, {min} or more"),
        Kind::Choice(words) => format!("one of {}", words.join(", ")),
        Kind::Words(words) => format!("a list of {}", words.join(", ")),
        Kind::Table { fields } => {
            let keys: Vec<&str> = fields().iter().map(|f| f.name).collect();
            format!("a table with {}", keys.join(", "))
        }
        Kind::Boolean | Kind::Text | Kind::Texts | Kind::Rows { .. } => noun,
    }
}
