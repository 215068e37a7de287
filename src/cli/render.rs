//! Diagnostics for people: the line of the file, what is wrong with it, and what to do.

use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, NamedSource};
use squirm::diag::{Diagnostic, Severity, Sources, Span};
use std::fmt;
use std::io::IsTerminal;

/// Diagnostics that are printed at most; nobody reads more.
const SHOWN: usize = 100;

/// Bytes of a line that is drawn at most.
const WIDE: usize = 2000;

/// Prints the first diagnostics to standard error, and how many there were.
pub fn all(diagnostics: &[Diagnostic], sources: &Sources) {
    let handler = GraphicalReportHandler::new_themed(theme()).with_width(width()).with_context_lines(1);
    for diagnostic in &diagnostics[..diagnostics.len().min(SHOWN)] {
        let wide = diagnostic.labels.iter().any(|(span, _)| is_wide(*span, sources));
        if wide {
            say!("{}\n", diagnostic.plain(sources));
            continue;
        }
        let mut text = String::new();
        match handler.render_report(&mut text, &Report::new(diagnostic, sources)) {
            Ok(()) => say!("{}\n", text.trim_end()),
            Err(_) => say!("{}\n", diagnostic.plain(sources)),
        }
    }
    if diagnostics.len() > SHOWN {
        say!("and {} more\n", diagnostics.len() - SHOWN);
    }
    let errors = diagnostics.iter().filter(|d| d.is_error()).count();
    if errors > 0 {
        let warnings = diagnostics.len() - errors;
        say!("{}, {}: nothing was started, nothing written", count(errors, "error"), count(warnings, "warning"));
    }
}

/// Whether a span is in a text with a line so long that it can be neither drawn nor read: miette panics at 65,536 columns.
fn is_wide(span: Span, sources: &Sources) -> bool {
    sources.get(span.source).is_some_and(|source| source.text.lines().any(|line| line.len() > WIDE))
}

fn count(n: usize, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}

/// Colours and box characters on a terminal, unless <https://no-color.org> forbids colours; plain text elsewhere.
fn theme() -> GraphicalTheme {
    let plain = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
    match (std::io::stderr().is_terminal(), plain) {
        (true, false) => GraphicalTheme::unicode(),
        (true, true) => GraphicalTheme::unicode_nocolor(),
        (false, _) => GraphicalTheme::none(),
    }
}

fn width() -> usize {
    std::env::var("COLUMNS").ok().and_then(|c| c.parse().ok()).unwrap_or(110)
}

/// A diagnostic as miette sees it. Only the first label's text is shown with its lines; other texts go into the help.
struct Report<'a> {
    diagnostic: &'a Diagnostic,
    source: Option<NamedSource<String>>,
    labels: Vec<LabeledSpan>,
    help: String,
}

impl<'a> Report<'a> {
    fn new(diagnostic: &'a Diagnostic, sources: &Sources) -> Self {
        let first = diagnostic.labels.first().map(|(span, _)| span.source);
        let source = first.and_then(|s| sources.get(s)).map(|s| NamedSource::new(&s.name, s.text.clone()));
        let mut labels = Vec::new();
        let mut help = diagnostic.help.clone().unwrap_or_default();
        for (index, (span, text)) in diagnostic.labels.iter().enumerate() {
            if Some(span.source) == first {
                let at = (span.start, span.end - span.start);
                labels.push(if index == 0 {
                    LabeledSpan::new_primary_with_span(Some(text.clone()), at)
                } else {
                    LabeledSpan::new_with_span(Some(text.clone()), at)
                });
            } else {
                help = format!("{help}\n{text}: {}", sources.place(*span));
            }
        }
        Self { diagnostic, source, labels, help: help.trim_start().to_owned() }
    }
}

impl fmt::Debug for Report<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.diagnostic.message)
    }
}

impl fmt::Display for Report<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.diagnostic.message)
    }
}

impl std::error::Error for Report<'_> {}

impl miette::Diagnostic for Report<'_> {
    fn severity(&self) -> Option<miette::Severity> {
        Some(match self.diagnostic.severity {
            Severity::Error => miette::Severity::Error,
            Severity::Warning => miette::Severity::Warning,
        })
    }

    fn code<'b>(&'b self) -> Option<Box<dyn fmt::Display + 'b>> {
        let word = if self.diagnostic.is_error() { "error" } else { "warning" };
        Some(Box::new(word))
    }

    fn help<'b>(&'b self) -> Option<Box<dyn fmt::Display + 'b>> {
        (!self.help.is_empty()).then(|| Box::new(&self.help) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn miette::SourceCode> {
        self.source.as_ref().map(|s| s as &dyn miette::SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        Some(Box::new(self.labels.iter().cloned()))
    }
}
