//! `squirm-validate`: holds the program against theory and published results.

mod bodies;
mod case;
mod cases;
mod crowd;
mod flow_map;
mod jobs;
mod lattice;
mod measure;
mod neighbours;
mod periodic;
mod profile;
mod record;
mod report;
mod rig;
mod rules;
mod swimmer;

use case::{Case, Control, Part, Size, Trouble, Verdict};
use clap::Parser;
use record::Record;
use rig::Rig;
use squirm::gpu::Gpu;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Measure what is known of the model, compare it with theory and published results, and write a report.
///
/// Every part is kept in a file as soon as it is measured; what is there already is not measured again.
///
/// Exit code 0: every row passes; 1: a row misses its tolerance, or a spoiled variant went unnoticed; 2: a case could not be run.
#[derive(Parser)]
#[command(version)]
struct Cli {
    /// Cases, or CASE/PART; all if none is named.
    cases: Vec<String>,
    /// Minutes on two cores: catches errors of principle (the default).
    #[arg(long, conflicts_with = "full")]
    quick: bool,
    /// For a GPU: statistical errors below a third of the tolerances.
    #[arg(long)]
    full: bool,
    /// List cases, parts and controls, and measure nothing.
    #[arg(long)]
    list: bool,
    /// Run the negative controls instead: variants that are wrong on purpose and that the quick cases must notice.
    #[arg(long, conflicts_with_all = ["full", "report"])]
    controls: bool,
    /// Measure again what is already there.
    #[arg(long)]
    again: bool,
    /// Parts that are measured at a time, each in a process of its own [default: one on a GPU, as many as there are cores on a CPU].
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(1..=256))]
    jobs: Option<u16>,
    /// Begin no further part after this time; the next call goes on.
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    duration: Option<Duration>,
    /// Where measured parts are kept [default: docs/validation/data, or target/validation for quick runs].
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Write the report of all that is kept into this folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Folder of the pipeline files.
    #[arg(long, value_name = "DIR", default_value = "pipelines/validation")]
    pipelines: PathBuf,
    /// GPU to use: part of its name, or its number in `squirm adapters`.
    #[arg(long, value_name = "NAME|INDEX")]
    adapter: Option<String>,
}

fn seconds(text: &str) -> Result<Duration, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    Duration::try_from_secs_f64(value).map_err(|e| e.to_string())
}

fn main() -> ExitCode {
    match validate(&Cli::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::from(2)
        }
    }
}

fn validate(cli: &Cli) -> Result<bool, Trouble> {
    let size = if cli.full { Size::Full } else { Size::Quick };
    let chosen = choose(&cli.cases, size)?;
    if cli.list {
        list(&chosen);
        return Ok(true);
    }
    let gpu = Gpu::open(cli.adapter.as_deref())?;
    let mut rig = Rig { gpu, pipelines: cli.pipelines.clone(), size, spoil: None };
    if cli.controls {
        return controls(&mut rig, &chosen);
    }
    let default = if cli.full { "docs/validation/data" } else { "target/validation" };
    let data = cli.data.clone().unwrap_or_else(|| default.into());
    let good = measure(cli, &rig, &chosen, &data)?;
    if let Some(folder) = &cli.report {
        let cases: Vec<&Case> = cases::ALL.iter().collect();
        let mut records = Vec::new();
        for case in &cases {
            for part in (case.parts)(size) {
                records.extend(record::load(&data, case.name, &part.name, size)?);
            }
        }
        report::write(folder, size, &cases, &records)?;
        println!("report in {}", folder.display());
    }
    Ok(good)
}

/// The cases that are named, each with its parts.
fn choose(names: &[String], size: Size) -> Result<Vec<(&'static Case, Vec<Part>)>, Trouble> {
    let mut chosen: Vec<(&'static Case, Vec<Part>)> = Vec::new();
    for case in cases::ALL {
        let wanted = |part: &Part| {
            names.is_empty() || names.iter().any(|n| n == case.name || *n == format!("{}/{}", case.name, part.name))
        };
        let parts: Vec<Part> = (case.parts)(size).into_iter().filter(wanted).collect();
        if !parts.is_empty() {
            chosen.push((case, parts));
        }
    }
    for name in names {
        let known = |(case, parts): &(&Case, Vec<Part>)| {
            name == case.name || parts.iter().any(|p| *name == format!("{}/{}", case.name, p.name))
        };
        if !chosen.iter().any(known) {
            let all = cases::ALL.iter().map(|c| c.name).collect::<Vec<_>>().join(", ");
            return Err(format!("there is no case `{name}`; there are: {all}; --list shows their parts").into());
        }
    }
    Ok(chosen)
}

fn list(chosen: &[(&'static Case, Vec<Part>)]) {
    for (case, parts) in chosen {
        println!("{}: {}", case.name, case.title);
        for part in parts {
            println!("    {}/{}", case.name, part.name);
        }
        for control in case.controls {
            println!("    control {}: {}", control.name, control.about);
        }
    }
}

/// Says what has been measured, and measures what has not; true if all of it is good.
fn measure(cli: &Cli, rig: &Rig, chosen: &[(&'static Case, Vec<Part>)], data: &Path) -> Result<bool, Trouble> {
    let began = Instant::now();
    let mut good = true;
    let mut missing: Vec<(&Case, &Part)> = Vec::new();
    for (case, part) in chosen.iter().flat_map(|(case, parts)| parts.iter().map(move |part| (*case, part))) {
        let kept = if cli.again { None } else { record::load(data, case.name, &part.name, rig.size)? };
        match kept {
            Some(record) => good &= say(&record, rig.size),
            None => missing.push((case, part)),
        }
    }
    let jobs = jobs_at_a_time(cli, rig).min(missing.len());
    if jobs > 1 {
        missing.sort_by_key(|(_, part)| !part.long);
        let names: Vec<String> = missing.iter().map(|(case, part)| format!("{}/{}", case.name, part.name)).collect();
        let parts = names.iter().map(String::as_str).collect();
        let arguments = arguments(cli, rig, data);
        return Ok(jobs::run(&jobs::Jobs { count: jobs, arguments, duration: cli.duration, parts })? && good);
    }
    for (case, part) in missing {
        if cli.duration.is_some_and(|d| began.elapsed() >= d) {
            println!("{}/{}: left for the next call", case.name, part.name);
            continue;
        }
        let record = measure_part(rig, case, part)?;
        record::store(data, &record)?;
        good &= say(&record, rig.size);
    }
    Ok(good)
}

fn jobs_at_a_time(cli: &Cli, rig: &Rig) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    cli.jobs.map_or_else(|| if rig.gpu.summary.kind == "CPU" { cores() } else { 1 }, usize::from)
}

/// What a process is told that measures one part.
fn arguments(cli: &Cli, rig: &Rig, data: &Path) -> Vec<String> {
    let size = if rig.size == Size::Full { "--full" } else { "--quick" };
    let mut arguments: Vec<String> = [size, "--again", "--jobs", "1", "--data"].map(str::to_owned).to_vec();
    arguments.extend([data.display().to_string(), "--pipelines".into(), cli.pipelines.display().to_string()]);
    arguments.extend(cli.adapter.iter().flat_map(|adapter| ["--adapter".to_owned(), adapter.clone()]));
    arguments
}

fn measure_part(rig: &Rig, case: &Case, part: &Part) -> Result<Record, Trouble> {
    let began = Instant::now();
    let outcome = (part.measure)(rig).map_err(|e| format!("{}/{}: {e}", case.name, part.name))?;
    Ok(Record {
        case: case.name.into(),
        part: part.name.clone(),
        size: rig.size,
        adapter: rig.gpu.summary.name.clone(),
        driver: rig.gpu.summary.driver.clone(),
        version: env!("CARGO_PKG_VERSION").into(),
        date: record::today(),
        seconds: began.elapsed().as_secs_f64(),
        outcome,
    })
}

fn say(record: &Record, size: Size) -> bool {
    println!("{}/{} ({:.1} s)", record.case, record.part, record.seconds);
    let mut good = true;
    for row in &record.outcome.rows {
        let verdict = row.verdict(size);
        let expected = row.expected.map_or_else(String::new, |e| format!(", expected {e:.5} +- {:.5}", row.tolerance));
        println!("    {} [{}]: {}{expected}: {}", row.quantity, row.setup, report::with_error(row), verdict.word());
        good &= verdict.good();
    }
    good
}

/// Runs every control of the chosen cases; true if each of them is noticed.
fn controls(rig: &mut Rig, chosen: &[(&'static Case, Vec<Part>)]) -> Result<bool, Trouble> {
    let mut all = true;
    for (case, _) in chosen {
        for control in case.controls {
            all &= noticed(rig, case, control)?;
        }
    }
    Ok(all)
}

fn noticed(rig: &mut Rig, case: &Case, control: &Control) -> Result<bool, Trouble> {
    let began = Instant::now();
    let parts = (case.parts)(rig.size);
    let part = parts.iter().find(|p| p.name == control.part);
    let part = part.ok_or_else(|| format!("control {} of {}: no part {}", control.name, case.name, control.part))?;
    rig.spoil = Some(control.spoil);
    let outcome = (part.measure)(rig);
    rig.spoil = None;
    // A run that breaks down has been noticed too.
    let (caught, how) = match outcome {
        Ok(outcome) => {
            let missed = outcome.rows.iter().filter(|r| r.verdict(rig.size) == Verdict::Miss);
            let missed: Vec<String> = missed.map(|r| format!("{} {}", r.quantity, report::with_error(r))).collect();
            (!missed.is_empty(), missed.join(", "))
        }
        Err(e) => (true, e.to_string()),
    };
    let word = if caught { "noticed" } else { "NOT NOTICED" };
    let seconds = began.elapsed().as_secs_f64();
    println!("{}: {} ({}): {word}: {how} ({seconds:.1} s)", case.name, control.name, control.about);
    Ok(caught)
}
