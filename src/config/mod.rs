//! From a pipeline file to a validated plan: every finding collected, each with its place, and nothing started or written.

mod analyzers;
mod check;
mod late;
mod list;
mod meaning;
mod node;
mod outputs;
mod overrides;
mod pace;
mod read;
mod resolve;
mod room;
mod schema;
mod sections;
mod table;

pub use meaning::{Meaning, SpeciesMeaning, bytes, meaning};
pub use read::accepts;
pub use resolve::toml_value;
pub use schema::schema;
pub use sections::{SECTIONS, STAGE, Section, is_required};

use crate::diag::{self, Diagnostic, Sources, Span};
use crate::graph::{AnalyzerProgram, Checkpoints, Output, Plan, PlannedStage};
use crate::params::{Params, Values};
use crate::state::{Domain, Fluid, Init, Run, Species, System};
use list::Listed;
use node::{Item, Node};
use read::Reader;
use std::collections::HashSet;
use std::path::Path;

/// A pipeline file without errors.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// What to run.
    pub plan: Plan,
    /// Fluid particles at the start: of a random start, or the rows of the table that it comes from.
    pub particles: u64,
    /// What looks wrong but may be meant.
    pub warnings: Vec<Diagnostic>,
    /// The texts that the warnings point into.
    pub sources: Sources,
    root: Node,
}

/// A pipeline file with at least one error.
#[derive(Debug, Clone)]
pub struct Failure {
    /// The texts that the diagnostics point into.
    pub sources: Sources,
    /// Every error and warning, in the order of the file; last what it only might lack.
    pub diagnostics: Vec<Diagnostic>,
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.diagnostics.iter().try_for_each(|d| writeln!(f, "{}", d.plain(&self.sources)))
    }
}

impl std::error::Error for Failure {}

/// Reads a pipeline file. `path` names it in messages, and its stem names the run; `overrides` are `--set` arguments; files that
/// it names are looked for from `base_dir`.
///
/// # Errors
/// If anything in it forbids a run; all of it is reported.
pub fn load(path: &str, text: &str, overrides: &[String], base_dir: &Path) -> Result<Loaded, Failure> {
    let mut sources = Sources::default();
    let source = sources.add(path, text);
    let (mut root, syntax) = Node::document(text, source);
    let unplaced = overrides::apply(&mut root, overrides, &mut sources);
    let mut reader = Reader { lenient: !syntax.is_empty(), ..Reader::default() };
    let parsed = read_sections(&mut reader, &root);
    let mut found = reader.diagnostics;
    let mut loaded = None;
    let system = parsed.system.map(|system| with_absolute_start(system, base_dir));
    list::check(&parsed.stages, parsed.all_kinds_known, &mut found);
    if let Some(system) = &system {
        let particles = table::rows(system, &root, &mut found);
        check::system(system, &root, &mut found);
        check::together(system, &parsed.stages, &root, &mut found);
        if let Some(outputs) = &parsed.outputs {
            outputs::check(outputs, system, &root, &mut found);
            if let Some(programs) = &parsed.analyzers {
                analyzers::check(programs, outputs, system, &root, &mut found);
            }
        }
        let leaves = (|| Some((parsed.outputs?, parsed.analyzers?, parsed.checkpoints?)))();
        loaded = plan(path, system, &parsed.stages, leaves).zip(particles);
    }
    without_echoes(&mut found, &syntax, &sources);
    found.extend(syntax);
    found.extend(unplaced);
    found.sort_by_key(|d| {
        let (source, start, end) = d.labels.first().map_or((usize::MAX, 0, 0), |(s, _)| (s.source, s.start, s.end));
        // What may be missing anywhere comes after what is wrong somewhere.
        (end == 0 && !d.is_error(), source, start)
    });
    match loaded {
        Some((plan, particles)) if !found.iter().any(Diagnostic::is_error) => {
            Ok(Loaded { plan, particles, warnings: found, sources, root })
        }
        _ => Err(Failure { sources, diagnostics: found }),
    }
}

/// Takes out what is only the echo of a syntax error: it stands on the same line, or at a value that could not be read.
fn without_echoes(found: &mut Vec<Diagnostic>, syntax: &[Diagnostic], sources: &Sources) {
    let line = |span: Span| (span.source, sources.line(span));
    let place = |d: &Diagnostic| d.labels.first().map(|(span, _)| *span);
    // A file may have thousands of both.
    let lines: HashSet<(usize, usize)> = syntax.iter().filter_map(place).map(line).collect();
    let texts: HashSet<usize> = syntax.iter().filter_map(place).map(|span| span.source).collect();
    found.retain(|d| {
        let echo = |at: Span| texts.contains(&at.source) && (at.end == 0 || lines.contains(&line(at)));
        !place(d).is_some_and(echo)
    });
}

/// The start table's path as it must stand in the resolved file, which lies elsewhere.
fn with_absolute_start(mut system: System, base_dir: &Path) -> System {
    if let Some(from) = &mut system.init.from {
        let path = base_dir.join(&*from);
        *from = std::path::absolute(&path).unwrap_or(path).to_string_lossy().into_owned();
    }
    system
}

/// What a run leaves behind, and starts: its outputs, analyzers and checkpoints.
type Leaves = (Vec<Output>, Vec<AnalyzerProgram>, Checkpoints);

fn plan(path: &str, system: &System, stages: &[Listed], leaves: Option<Leaves>) -> Option<Plan> {
    let name = Path::new(path).file_stem().map_or_else(|| "run".into(), |s| s.to_string_lossy().into_owned());
    let stages = stages.iter().map(|s| Some(PlannedStage { entry: s.entry, values: s.values.clone()? }));
    let stages: Vec<PlannedStage> = stages.collect::<Option<_>>()?;
    let (outputs, analyzers, checkpoints) = leaves?;
    let resolved = resolve::write(&name, system, &stages, &outputs, &analyzers, &checkpoints);
    Some(Plan { name, system: system.clone(), stages, outputs, analyzers, checkpoints, resolved })
}

/// What could be read of a file; `None` where something of it is wrong.
struct Parsed {
    system: Option<System>,
    stages: Vec<Listed>,
    all_kinds_known: bool,
    outputs: Option<Vec<Output>>,
    analyzers: Option<Vec<AnalyzerProgram>>,
    checkpoints: Option<Checkpoints>,
}

fn read_sections(reader: &mut Reader, root: &Node) -> Parsed {
    if let Item::Table(pairs) = &root.item {
        for pair in pairs.iter().filter(|p| !SECTIONS.iter().any(|s| s.name == p.key)) {
            unknown_section(reader, &pair.key, pair.key_span);
        }
    }
    let run = one::<Run>(reader, root, "run");
    let domain = one::<Domain>(reader, root, "box");
    let fluid = one::<Fluid>(reader, root, "fluid");
    let init = one::<Init>(reader, root, "init");
    let species = many::<Species>(reader, root, "squirmers");
    let outputs = many::<Output>(reader, root, "output");
    let analyzers = many::<AnalyzerProgram>(reader, root, "analyzer");
    let checkpoints = one::<Checkpoints>(reader, root, "checkpoint");
    let (stages, all_kinds_known) = list::read(reader, root);
    let system = (|| Some(System { run: run?, domain: domain?, fluid: fluid?, species: species?, init: init? }))();
    Parsed { system, stages, all_kinds_known, outputs, analyzers, checkpoints }
}

fn unknown_section(reader: &mut Reader, key: &str, span: Span) {
    let home = SECTIONS.iter().find(|s| (s.fields)().iter().any(|f| f.name == key));
    let help = match home {
        Some(section) => format!("`{key}` belongs under {}", section.header()),
        None => diag::suggestion(key, SECTIONS.iter().map(|s| s.name)),
    };
    let message = format!("a pipeline file has no section `{key}`");
    reader.diagnostics.push(Diagnostic::error(message).at(span, "unknown section").help(help));
}

/// The only table of a section.
fn one<P: Params>(reader: &mut Reader, root: &Node, name: &str) -> Option<P> {
    let fields = P::fields();
    let values = match root.get(name) {
        Some(node) if matches!(node.item, Item::List(_)) => {
            reader.diagnostics.push(
                Diagnostic::error(format!("there is only one {name}, so its section cannot repeat"))
                    .at(node.span, "double brackets")
                    .help(format!("write [{name}]")),
            );
            return None;
        }
        Some(node) => reader.table(node, &fields, &format!("[{name}]"), &[]),
        None if fields.iter().any(is_required) => {
            let keys: Vec<&str> = fields.iter().filter(|f| is_required(f)).map(|f| f.name).collect();
            if !reader.lenient {
                let what = P::summary().trim_end_matches('.');
                reader.diagnostics.push(
                    Diagnostic::error(format!("the section [{name}] is missing. {what}"))
                        .at(root.span, "nowhere in this file")
                        .help(format!("add [{name}] with {}", keys.join(", "))),
                );
            }
            None
        }
        None => Some(Values::defaults(&fields)),
    };
    values.map(|v| P::from_values(&v))
}

/// All tables of a repeated section.
fn many<P: Params>(reader: &mut Reader, root: &Node, name: &str) -> Option<Vec<P>> {
    let nodes = tables(reader, root, name)?;
    let read = nodes.iter().map(|n| reader.table(n, &P::fields(), &format!("[[{name}]]"), &[]));
    let read: Vec<Option<Values>> = read.collect();
    read.into_iter().map(|v| v.map(|v| P::from_values(&v))).collect()
}

/// The elements of a repeated section, none if it is absent.
fn tables<'a>(reader: &mut Reader, root: &'a Node, name: &str) -> Option<&'a [Node]> {
    match root.get(name) {
        None => Some(&[]),
        Some(Node { item: Item::List(nodes), .. }) => Some(nodes),
        Some(node) => {
            reader.diagnostics.push(
                Diagnostic::error(format!(
                    "`{name}` may repeat, so it is a list of tables, but this is {}",
                    node.describe()
                ))
                .at(node.span, "single brackets")
                .help(format!("write [[{name}]]")),
            );
            None
        }
    }
}
