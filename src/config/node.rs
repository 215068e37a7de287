//! The pipeline file as a tree of values that know where they were written.

use crate::diag::{self, Diagnostic, Span};
use toml::de::{DeTable, DeValue};

/// One value of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Where the value stands; of a table, its header.
    pub span: Span,
    /// The value.
    pub item: Item,
}

/// What a [`Node`] holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// Text.
    Text(String),
    /// A whole number; `None` if it does not fit 64 bits.
    Integer(Option<i64>),
    /// A number with a point or an exponent; may be infinite or not a number.
    Float(f64),
    /// `true` or `false`.
    Boolean(bool),
    /// A date or time, which no parameter takes.
    Date,
    /// A list.
    List(Vec<Node>),
    /// A table in the order of the file.
    Table(Vec<Pair>),
}

/// One key of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// The key.
    pub key: String,
    /// Where the key stands.
    pub key_span: Span,
    /// Its value.
    pub node: Node,
}

impl Node {
    /// Parses a whole TOML document and recovers from errors, so that as much as possible can be checked.
    #[must_use]
    pub fn document(text: &str, source: usize) -> (Self, Vec<Diagnostic>) {
        let (table, errors) = DeTable::parse_recoverable(text);
        let mut diagnostics: Vec<Diagnostic> = errors.iter().map(|e| syntax_error(e, text, source)).collect();
        // What follows on the line of an error is mostly its echo.
        let lines = diag::line_starts(text);
        let line = |span: Span| lines.partition_point(|start| *start <= span.start);
        diagnostics.dedup_by_key(|d| d.labels.first().map_or(0, |(span, _)| line(*span)));
        let item = table_item(table.get_ref(), source, 0);
        (Self { span: Span { source, start: 0, end: 0 }, item }, diagnostics)
    }

    /// Parses one TOML value that begins at byte `offset` of its source.
    ///
    /// # Errors
    /// If the text is no TOML value.
    pub fn value(text: &str, source: usize, offset: usize) -> Result<Self, String> {
        let value = DeValue::parse(text).map_err(|e| e.message().to_string())?;
        let span = Span { source, start: offset, end: offset + text.len() };
        Ok(Self { span, item: item_of(value.get_ref(), source, offset) })
    }

    /// What the value is, in words.
    #[must_use]
    pub fn describe(&self) -> &'static str {
        match self.item {
            Item::Text(_) => "a text",
            Item::Integer(_) => "a whole number",
            Item::Float(_) => "a number with a fraction",
            Item::Boolean(_) => "true or false",
            Item::Date => "a date or time",
            Item::List(_) => "a list",
            Item::Table(_) => "a table",
        }
    }

    /// The value of a key, if this is a table that has it.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.pair(key).map(|p| &p.node)
    }

    /// A key with its value, if this is a table that has it.
    #[must_use]
    pub fn pair(&self, key: &str) -> Option<&Pair> {
        match &self.item {
            Item::Table(pairs) => pairs.iter().find(|p| p.key == key),
            _ => None,
        }
    }

    /// The elements of a list; nothing for anything else.
    #[must_use]
    pub fn elements(&self) -> &[Node] {
        match &self.item {
            Item::List(nodes) => nodes,
            _ => &[],
        }
    }

    /// Where the value at `path` (keys and list indices) stands, or else the nearest thing around it.
    #[must_use]
    pub fn place(&self, path: &[&str]) -> Span {
        let mut node = self;
        for step in path {
            let next = step.parse::<usize>().map_or_else(|_| node.get(step), |i| node.elements().get(i));
            match next {
                Some(n) => node = n,
                None => break,
            }
        }
        node.span
    }
}

fn syntax_error(error: &toml::de::Error, text: &str, source: usize) -> Diagnostic {
    let range = error.span().unwrap_or(text.len()..text.len());
    let start = text.floor_char_boundary(range.start);
    let span = Span { source, start, end: text.floor_char_boundary(range.end).max(start) };
    let message = error.message();
    let twice = message.contains("duplicate key");
    let name = text.get(span.start..span.end).unwrap_or("");
    let line = text[..span.start].rfind('\n').map_or(0, |at| at + 1);
    let value = text[line..].lines().next().and_then(|l| l.split_once('=')).map_or("", |(_, value)| value);
    let alone = number_before_unit(value).map(|number| format!("numbers carry no unit: write {number} alone"));
    let diagnostic = if twice {
        Diagnostic::error(format!("`{name}` is given twice: only one value can hold"))
    } else {
        Diagnostic::error(format!("this is not TOML: {message}"))
    };
    diagnostic.at(span, if twice { "given again here" } else { "here" }).help(match alone {
        _ if twice => {
            "remove one of the two; sections that may repeat are written with double brackets, as in [[squirmers]]"
                .into()
        }
        Some(alone) => alone,
        None => {
            "texts stand in quotes, lists in [ ], sections in [ ] and repeated sections in [[ ]] on lines of their own"
                .into()
        }
    })
}

/// The number of a text that is a number and a word behind it, as in `0.05 tau`.
pub fn number_before_unit(text: &str) -> Option<&str> {
    let text = text.trim();
    let numeric = text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    // Of `1e3m` the longest number counts.
    let ends = text.char_indices().map(|(at, _)| at).rev().filter(|_| numeric);
    let number = ends.map(|end| text[..end].trim_end()).find(|number| number.parse::<f64>().is_ok())?;
    text[number.len()..].trim_start().starts_with(char::is_alphabetic).then_some(number)
}

fn table_item(table: &DeTable<'_>, source: usize, offset: usize) -> Item {
    let pairs = table.iter().map(|(key, value)| {
        let (k, v) = (key.span(), value.span());
        Pair {
            key: key.get_ref().to_string(),
            key_span: Span { source, start: offset + k.start, end: offset + k.end },
            node: Node {
                span: Span { source, start: offset + v.start, end: offset + v.end },
                item: item_of(value.get_ref(), source, offset),
            },
        }
    });
    Item::Table(pairs.collect())
}

fn item_of(value: &DeValue<'_>, source: usize, offset: usize) -> Item {
    match value {
        DeValue::String(s) => Item::Text(s.to_string()),
        DeValue::Integer(i) => Item::Integer(i64::from_str_radix(i.as_str(), i.radix()).ok()),
        DeValue::Float(f) => Item::Float(f.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(b) => Item::Boolean(*b),
        DeValue::Datetime(_) => Item::Date,
        DeValue::Array(values) => Item::List(
            values
                .iter()
                .map(|v| Node {
                    span: Span { source, start: offset + v.span().start, end: offset + v.span().end },
                    item: item_of(v.get_ref(), source, offset),
                })
                .collect(),
        ),
        DeValue::Table(table) => table_item(table, source, offset),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diag::Sources;

    #[test]
    fn values_keep_their_places() {
        let text = "[run]\nsteps = 0x10\n[[stage]]\nkind = \"a\"\n[[stage]]\nkind = \"b\"\n";
        let mut sources = Sources::default();
        let source = sources.add("f", text);
        let (root, errors) = Node::document(text, source);
        assert_eq!(errors, []);
        assert_eq!(root.get("run").unwrap().get("steps").unwrap().item, Item::Integer(Some(16)));
        assert_eq!(sources.line_column(root.place(&["run", "steps"])), (2, 9));
        assert_eq!(sources.line_column(root.place(&["stage", "1", "kind"])), (6, 8));
        assert_eq!(sources.line_column(root.place(&["stage", "1", "absent"])), (5, 1), "the header of its table");
    }

    #[test]
    fn numbers_with_units_are_recognised() {
        for (text, number) in [
            ("0.05 tau", Some("0.05")),
            (" 1e-3tau # small", Some("1e-3")),
            ("-2 kT", Some("-2")),
            ("7 a\u{b2}", Some("7")),
        ] {
            assert_eq!(number_before_unit(text), number, "{text}");
        }
        for text in ["0.05", "tau", "", "\"0.05 tau\"", "1979-05-27", "5 # five", "infinite", "[1, 2 tau]", "1.2.3"] {
            assert_eq!(number_before_unit(text), None, "{text}");
        }
    }

    #[test]
    fn every_syntax_error_is_reported_and_the_rest_is_read() {
        let text = "[run]\nsteps = = 3\nseed = 4\nseed = 5\n[box]\nsize = 7\n";
        let (root, errors) = Node::document(text, 0);
        assert_eq!(errors.len(), 2, "{errors:?}");
        assert!(errors[1].message.contains("`seed` is given twice"), "{errors:?}");
        assert_eq!(root.get("box").unwrap().get("size").unwrap().item, Item::Integer(Some(7)));
    }
}
