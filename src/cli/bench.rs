//! `squirm bench`: measures cases and pipeline files, prints tables or JSON, and compares with an older report.

use super::{Form, Overrides, RUN_FAILED, WRONG_USAGE, load, print, render, run, signals};
use squirm::bench::{self, BenchError, CASES, Case, Effort, Kind, Report, Skipped, cases};
use squirm::config::{self, Failure, Loaded};
use squirm::diag::{Diagnostic, Sources, suggestion};
use squirm::gpu::{Gpu, GpuError};
use squirm::sim::RunError;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;

/// Arguments of `squirm bench`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Cases of --list, or pipeline files [default: all cases that suit the adapter].
    #[arg(value_name = "CASE|FILE")]
    subjects: Vec<String>,
    /// List the cases with their targets, and measure nothing.
    #[arg(long)]
    list: bool,
    /// Measure each case for at least this long [default: 1 on a GPU, and 500 steps; 10 on a CPU].
    #[arg(long, value_name = "SECONDS", value_parser = positive, conflicts_with = "steps")]
    seconds: Option<f64>,
    /// Measure this many steps of each case, in at least five batches.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    steps: Option<u64>,
    /// Particles of the fluid cases without squirmers, as in --size 10e6,40e6,130e6 [default: 10 million on a GPU, 54 million in the slit; 32^3 cells on a CPU].
    #[arg(long, value_name = "PARTICLES", value_parser = positive, value_delimiter = ',')]
    size: Vec<f64>,
    /// How stages become kernels: fused, where neighbours share one, or loose, where each has its own.
    #[arg(long, value_enum, default_value_t = Form::Fused)]
    plan: Form,
    /// GPU to use: part of its name, or its number in `squirm adapters`.
    #[arg(long, value_name = "NAME|INDEX", value_parser = clap::builder::NonEmptyStringValueParser::new())]
    adapter: Option<String>,
    #[command(flatten)]
    overrides: Overrides,
    /// Write everything that was measured to this file; `-`: to standard output, in place of the tables.
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
    /// Compare with a file of --json; exit status 1 if a case became slower by more than its spread and 5 %.
    #[arg(long, value_name = "FILE")]
    against: Option<PathBuf>,
    /// Take the figures from a file of --json, and measure nothing.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["subjects", "seconds", "steps", "size", "adapter", "set"])]
    from: Option<PathBuf>,
}

fn positive(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "it is no number".to_owned())?;
    if value > 0.0 && value < 1e10 { Ok(value) } else { Err("it must be above 0 and below 1e10".into()) }
}

/// Something to measure.
struct Task {
    name: String,
    what: String,
    loaded: Loaded,
    case: Option<&'static Case>,
    named: bool,
}

/// Measures, prints, and compares.
pub fn bench(args: &Args) -> ExitCode {
    if args.list {
        return list();
    }
    match all(args) {
        Ok(code) | Err(code) => code,
    }
}

fn list() -> ExitCode {
    let mut text = String::from("case         what it is; target on one H100\n");
    for case in CASES {
        let gpu = if case.cpu.is_none() { " (on a CPU only if named)" } else { "" };
        let target = case.target_text();
        let target = if target.is_empty() { String::new() } else { format!("; at most {target}") };
        let _ = writeln!(text, "{:<12} {}{gpu}{target}", case.name, case.what);
    }
    print(&text)
}

fn wrong(error: Diagnostic) -> ExitCode {
    render::all(&[error], &Sources::default());
    ExitCode::from(WRONG_USAGE)
}

fn all(args: &Args) -> Result<ExitCode, ExitCode> {
    let before = args.against.as_deref().map(read).transpose()?;
    let to_stdout = args.json.as_deref() == Some(Path::new("-"));
    if let Some(path) = args.json.as_deref().filter(|_| !to_stdout) {
        writable(path)?;
    }
    let report = match &args.from {
        Some(path) => {
            let report = read(path)?;
            if !to_stdout {
                let cases = report.cases.iter().map(|c| bench::case(c, report.has_targets()));
                let outputs = report.outputs.iter().map(|o| bench::output(o, report.has_targets()));
                print(
                    &std::iter::once(bench::header(&report)).chain(cases).chain(outputs).collect::<Vec<_>>().join("\n"),
                );
            }
            report
        }
        None => measured(args, !to_stdout)?,
    };
    match &args.json {
        Some(_) if to_stdout => {
            print(&report.json());
        }
        Some(path) => std::fs::write(path, report.json()).map_err(|error| {
            say!("error: cannot write {}: {error}", path.display());
            ExitCode::from(RUN_FAILED)
        })?,
        None => {}
    }
    Ok(before.map_or(ExitCode::SUCCESS, |before| verdict(args, &before, &report, to_stdout)))
}

/// Prints the comparison; to standard error where standard output has the JSON.
fn verdict(args: &Args, before: &Report, report: &Report, to_stderr: bool) -> ExitCode {
    let found = bench::compare(before, report);
    let old = args.against.as_deref().unwrap_or(Path::new("")).display();
    if found.common == 0 {
        return wrong(
            Diagnostic::error(format!("no case was measured both now and in {old}"))
                .help("compare the same cases at the same size"),
        );
    }
    let mut text = format!("against {old}\n{}", found.text);
    if !found.slower.is_empty() {
        let _ = writeln!(text, "slower by more than its spread and 5 %: {}", found.slower.join("; "));
    }
    if to_stderr {
        say!("{}", text.trim_end());
    } else {
        print(&format!("\n{text}"));
    }
    if found.slower.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(RUN_FAILED) }
}

/// Reads a report.
fn read(path: &Path) -> Result<Report, ExitCode> {
    let name = path.display();
    let text = std::fs::read_to_string(path).map_err(|error| {
        wrong(Diagnostic::error(format!("the report {name} cannot be read: {error}")).help("name a file of --json"))
    })?;
    Report::parse(&text).map_err(|error| {
        wrong(
            Diagnostic::error(format!("{name} is no report of a benchmark: {error}"))
                .help("name a file that `squirm bench --json FILE` of this version has written"),
        )
    })
}

/// Whether a report can be written here, asked before anything is measured.
fn writable(path: &Path) -> Result<(), ExitCode> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (name, folder_name) = (path.display(), folder.display());
    if path.is_dir() {
        return Err(wrong(Diagnostic::error(format!("{name} is a folder")).help("name a file behind --json")));
    }
    if !folder.is_dir() {
        return Err(wrong(Diagnostic::error(format!("there is no folder {folder_name} for {name}")).help("create it")));
    }
    Ok(())
}

/// Opens the adapter, and measures there what was asked for.
fn measured(args: &Args, show: bool) -> Result<Report, ExitCode> {
    known(&args.subjects)?;
    let gpu = Gpu::open(args.adapter.as_deref()).map_err(|error| {
        say!("error: {error}");
        ExitCode::from(if matches!(error, GpuError::NoSuchAdapter { .. }) { WRONG_USAGE } else { RUN_FAILED })
    })?;
    let mut skipped = Vec::new();
    let tasks = tasks(args, gpu.summary.kind == "CPU", &mut skipped)?;
    let signal = signals::first();
    let stop = || signal.load(Ordering::Relaxed) != 0;
    let failed = |task: Option<&Task>, error: BenchError| match (error, task) {
        (BenchError::Stopped, _) => signals::status(&signal),
        (BenchError::Run(error), Some(task)) => run::report(&task.loaded, &error),
        (error, task) => {
            let name = task.map_or(String::new(), |t| format!("{}: ", t.name));
            say!("error: {name}{error}");
            ExitCode::from(RUN_FAILED)
        }
    };
    let mut report = Report {
        version: env!("CARGO_PKG_VERSION").into(),
        adapter: gpu.summary.name.clone(),
        kind: gpu.summary.kind.into(),
        driver: gpu.summary.driver.clone(),
        plan: if args.plan == Form::Fused { "fused" } else { "loose" }.into(),
        copy: bench::copy(&gpu).map_err(|error| failed(None, error))?,
        cases: Vec::new(),
        outputs: Vec::new(),
        skipped: Vec::new(),
    };
    if show {
        print(&bench::header(&report));
    }
    for task in &tasks {
        match measure(args, (&gpu, &mut report, &stop), task) {
            Ok(text) if show => {
                print(&format!("\n{text}"));
            }
            Ok(_) => {}
            Err(BenchError::Run(RunError::Gpu(e @ (GpuError::TooLarge { .. } | GpuError::OutOfMemory { .. }))))
                if !task.named =>
            {
                skip(&mut skipped, &task.name, e.to_string());
            }
            Err(error) => return Err(failed(Some(task), error)),
        }
    }
    report.skipped = skipped;
    Ok(report)
}

fn skip(skipped: &mut Vec<Skipped>, case: &str, why: String) {
    say!("{case}: skipped: {why}");
    skipped.push(Skipped { case: case.to_owned(), why });
}

/// Measures one task into the report; its table.
fn measure(
    args: &Args,
    (gpu, report, stop): (&Gpu, &mut Report, &dyn Fn() -> bool),
    task: &Task,
) -> Result<String, BenchError> {
    let plan = &task.loaded.plan;
    let [x, y, z] = plan.system.domain.size;
    say!("{}: {x} x {y} x {z} cells ...", task.name);
    let targets = report.has_targets();
    if task.case.is_some_and(|c| c.kind == Kind::Outputs) {
        let costs = bench::outputs((args.adapter.as_deref(), args.plan.into()), (&task.name, plan), stop)?;
        let lines: String = costs.iter().map(|c| bench::output(c, targets)).collect();
        report.outputs.extend(costs);
        return Ok(format!("{}: {}, {x} x {y} x {z} cells\n{lines}", task.name, task.what));
    }
    let effort = Effort { seconds: args.seconds, steps: args.steps };
    let subject = (task.name.as_str(), task.what.as_str(), plan);
    let found = bench::measure((gpu, &report.copy, args.plan.into()), subject, effort, stop)?;
    let target = task.case.and_then(|c| c.target);
    let found = found.with_target(target, plan.system.fluid.density, &report.cases);
    let text = bench::case(&found, targets);
    report.cases.push(found);
    Ok(text)
}

/// Whether it is meant as a file.
fn is_file(subject: &str) -> bool {
    subject.contains(['/', '\\', '.']) || Path::new(subject).exists()
}

/// Refuses what is neither a case nor a file.
fn known(subjects: &[String]) -> Result<(), ExitCode> {
    match subjects.iter().find(|s| cases::find(s).is_none() && !is_file(s)) {
        None => Ok(()),
        Some(unknown) => Err(wrong(Diagnostic::error(format!("there is no case `{unknown}`")).help(format!(
            "{}; or give the path of a pipeline file",
            suggestion(unknown, CASES.iter().map(|c| c.name))
        )))),
    }
}

/// What to measure on an adapter.
fn tasks(args: &Args, cpu: bool, skipped: &mut Vec<Skipped>) -> Result<Vec<Task>, ExitCode> {
    let sizes: Vec<Option<f64>> =
        if args.size.is_empty() { vec![None] } else { args.size.iter().copied().map(Some).collect() };
    let of = |case: &'static Case, named: bool| {
        let sizes = if case.scales() { &sizes[..] } else { &[None] };
        let task = |size: &Option<f64>| {
            let mut loaded = of_case(case, *size, cpu, &args.overrides.set)?;
            loaded.plan.outputs.clear();
            Ok(Task { name: case.name.to_owned(), what: case.what.to_owned(), loaded, case: Some(case), named })
        };
        sizes.iter().map(task).collect::<Result<Vec<_>, ExitCode>>()
    };
    let mut tasks = Vec::new();
    for case in CASES.iter().filter(|_| args.subjects.is_empty()) {
        if cpu && case.cpu.is_none() {
            skip(skipped, case.name, "too large for a CPU unless it is named".into());
        } else {
            tasks.extend(of(case, false)?);
        }
    }
    for subject in &args.subjects {
        if let Some(case) = cases::find(subject) {
            tasks.extend(of(case, true)?);
            continue;
        }
        let mut loaded = load(Path::new(subject), &args.overrides.set)?;
        loaded.plan.outputs.clear();
        render::all(&loaded.warnings, &loaded.sources);
        let name = loaded.plan.name.clone();
        tasks.push(Task { name, what: subject.clone(), loaded, case: None, named: true });
    }
    Ok(tasks)
}

/// A case's pipeline with what the case and the command line change in it.
fn of_case(case: &Case, size: Option<f64>, cpu: bool, set: &[String]) -> Result<Loaded, ExitCode> {
    let overrides: Vec<String> = case.overrides(size, cpu).into_iter().chain(set.iter().cloned()).collect();
    let (file, text) = case.file;
    config::load(file, text, &overrides, Path::new("")).map_err(|Failure { sources, diagnostics }| {
        render::all(&diagnostics, &sources);
        ExitCode::from(WRONG_USAGE)
    })
}
