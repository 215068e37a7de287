//! Diagnostics: what is wrong, where, why, and what to do. A leaf: it neither reads files nor prints.

/// A stretch of one source text, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Span {
    /// Index into [`Sources`].
    pub source: usize,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

/// How bad a diagnostic is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The run may go on.
    Warning,
    /// The run must not start.
    Error,
}

/// One thing to tell the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad.
    pub severity: Severity,
    /// What is wrong and why, in one or two sentences.
    pub message: String,
    /// Where; the first is the place itself, others explain it.
    pub labels: Vec<(Span, String)>,
    /// What to do.
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error without a place.
    #[must_use]
    pub fn error(message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, message: message.into(), labels: Vec::new(), help: None }
    }

    /// A warning without a place.
    #[must_use]
    pub fn warning(message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(message) }
    }

    /// Adds a place and what is there.
    #[must_use]
    pub fn at(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push((span, text.into()));
        self
    }

    /// Adds what to do.
    #[must_use]
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }

    /// Whether it forbids the run.
    #[must_use]
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }

    /// One line of plain text: `file:line:column: error: message (help)`.
    #[must_use]
    pub fn plain(&self, sources: &Sources) -> String {
        let place = self.labels.first().map_or(String::new(), |(span, _)| format!("{}: ", sources.place(*span)));
        let word = if self.is_error() { "error" } else { "warning" };
        let help = self.help.as_ref().map_or(String::new(), |h| format!(" (help: {h})"));
        format!("{place}{word}: {}{help}", self.message)
    }
}

/// One text that diagnostics point into.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// What to call it: a file name, or `--set key=value`.
    pub name: String,
    /// The whole text.
    pub text: String,
    /// Where each line but the first begins, in bytes: a file may have thousands of findings.
    lines: Vec<usize>,
}

/// The texts of one configuration: the pipeline file first, then the overrides.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Sources(Vec<Source>);

impl Sources {
    /// Adds a text and returns its index for [`Span::source`].
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<String>) -> usize {
        let text = text.into();
        let lines = line_starts(&text);
        self.0.push(Source { name: name.into(), text, lines });
        self.0.len() - 1
    }

    /// The text of this index.
    #[must_use]
    pub fn get(&self, source: usize) -> Option<&Source> {
        self.0.get(source)
    }

    /// The line, from 1, in which the span begins.
    #[must_use]
    pub fn line(&self, span: Span) -> usize {
        self.get(span.source).map_or(1, |s| s.lines.partition_point(|start| *start <= span.start) + 1)
    }

    /// Line and column, both from 1, at which the span begins; columns count characters.
    #[must_use]
    pub fn line_column(&self, span: Span) -> (usize, usize) {
        let Some(source) = self.get(span.source) else { return (1, 1) };
        let line = self.line(span);
        let start = line.checked_sub(2).map_or(0, |before| source.lines[before]);
        let end = source.text.floor_char_boundary(span.start).max(start);
        (line, source.text[start..end].chars().count() + 1)
    }

    /// `name:line:column`.
    #[must_use]
    pub fn place(&self, span: Span) -> String {
        let (line, column) = self.line_column(span);
        format!("{}:{line}:{column}", self.get(span.source).map_or("?", |s| s.name.as_str()))
    }
}

/// Where each line but the first begins, in bytes.
#[must_use]
pub fn line_starts(text: &str) -> Vec<usize> {
    text.match_indices('\n').map(|(at, _)| at + 1).collect()
}

/// The candidate that is most like `word`, if any is likely to have been meant.
#[must_use]
pub fn closest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    candidates
        .into_iter()
        .map(|c| (strsim::jaro_winkler(&word, &c.to_lowercase()), c))
        // One slip of the finger changes much of a short word.
        .filter(|(likeness, c)| *likeness > 0.8 || strsim::damerau_levenshtein(&word, &c.to_lowercase()) == 1)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, c)| c)
}

/// `, did you mean ...?` for the closest candidate, else a list of all of them.
#[must_use]
pub fn suggestion<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let all: Vec<&str> = candidates.into_iter().collect();
    match closest(word, all.iter().copied()) {
        Some(c) => format!("did you mean `{c}`?"),
        None if all.is_empty() => "nothing is allowed here".into(),
        None => format!("allowed here: {}", all.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_count_from_one_and_in_characters() {
        let mut sources = Sources::default();
        let source = sources.add("f.toml", "a = 1\n# ü\nü = 2\n");
        let at = |start| sources.line_column(Span { source, start, end: start });
        assert_eq!(at(0), (1, 1));
        assert_eq!(at(4), (1, 5));
        assert_eq!(at(11), (3, 1));
        assert_eq!(at(14), (3, 3));
        assert_eq!(at(1000), (4, 1));
    }

    #[test]
    fn a_likely_slip_is_named_and_an_unlikely_one_is_not() {
        assert_eq!(closest("stpes", ["seed", "steps", "dt"]), Some("steps"));
        assert_eq!(closest("temprature", ["density", "temperature"]), Some("temperature"));
        assert_eq!(closest("colour", ["density", "temperature"]), None);
        assert_eq!(suggestion("colour", ["density"]), "allowed here: density");
    }

    #[test]
    fn a_plain_line_has_place_severity_message_and_help() {
        let mut sources = Sources::default();
        let source = sources.add("f.toml", "x\ny\n");
        let d = Diagnostic::error("wrong").at(Span { source, start: 2, end: 3 }, "here").help("do this");
        assert_eq!(d.plain(&sources), "f.toml:2:1: error: wrong (help: do this)");
        assert_eq!(Diagnostic::warning("odd").plain(&sources), "warning: odd");
    }
}
