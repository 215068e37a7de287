//! `squirm-analyze`: what a run did, from its recording or while it is going.

use clap::{Arg, ArgMatches, Command, value_parser};
use squirm::analyze::kinds::{Entry, find};
use squirm::analyze::{AnalyzeError, DATA_LOST, Ending, Folder, KINDS, Limits, Live, Source, Window, run};
use squirm::params::{Field, Kind, Value, Values};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Exit status of a wrong command line; clap uses the same.
const WRONG_USAGE: u8 = 2;

fn main() -> ExitCode {
    let matches = program().get_matches();
    let (name, matches) = matches.subcommand().expect("clap wants a subcommand");
    if let Err(wrong) = check(matches) {
        eprintln!("error: {wrong}");
        return ExitCode::from(WRONG_USAGE);
    }
    match analyze(find(name).expect("every subcommand is a kind"), matches) {
        Ok(Ending { lost: 0, .. }) => ExitCode::SUCCESS,
        Ok(_) => ExitCode::from(DATA_LOST),
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::FAILURE
        }
    }
}

/// What clap cannot see.
fn check(matches: &ArgMatches) -> Result<(), String> {
    if let Some(path) = matches.get_one::<PathBuf>("recording") {
        let recording = Folder::new(path);
        if !recording.path().is_file() {
            return Err(format!(
                "there is no recording {}\nhelp: name the folder of a run, or its run.mcap; a run records only what an [[output]] asks it to",
                recording.path().display()
            ));
        }
    }
    let (from, to) = steps(matches).into_inner();
    if from > to {
        return Err(format!(
            "--from {from} lies after --to {to}\nhelp: give the first and the last step, in this order"
        ));
    }
    Ok(())
}

/// The steps that count.
fn steps(matches: &ArgMatches) -> RangeInclusive<u64> {
    let step = |name: &str| matches.get_one::<u64>(name).copied();
    step("from").unwrap_or(0)..=step("to").unwrap_or(u64::MAX)
}

/// The command line: a subcommand for every kind of analyzer.
fn program() -> Command {
    Command::new("squirm-analyze")
        .version(env!("CARGO_PKG_VERSION"))
        .about("Analyze a recorded or a live run of squirm")
        .after_help(
            "Units: length a (edge of a collision cell), mass m (one fluid particle), energy kT, time tau = a sqrt(m/kT).\n\
             Errors are standard errors of correlated series; NaN where too little is known.\n\
             Exit status: 0 done, 1 failed, 2 wrong usage, 3 done, but snapshots of a live run passed unseen.",
        )
        .subcommand_required(true)
        .arg_required_else_help(true)
        .subcommands(KINDS.iter().map(subcommand))
}

fn subcommand(entry: &Entry) -> Command {
    let summary = (entry.summary)().split_whitespace().collect::<Vec<_>>().join(" ");
    let short = summary.split_once(". ").map_or(summary.as_str(), |(first, _)| first).to_owned();
    let options = (entry.fields)().into_iter().map(|field| option(&field));
    Command::new(entry.name)
        .about(short)
        .override_usage(format!("squirm-analyze {} <RUN | --live NAME> [OPTIONS]", entry.name))
        .long_about(format!("{summary}\n\n{}", entry.needs()))
        .args(source())
        .args(options.map(|arg| arg.help_heading("What to measure")))
}

/// Where snapshots come from, and where results go.
fn source() -> [Arg; 7] {
    let count = |name: &'static str| Arg::new(name).long(name).value_parser(value_parser!(u64));
    let path = || value_parser!(PathBuf);
    [
        Arg::new("recording")
            .value_name("RUN")
            .help("The folder of a recorded run, or one recording (FILE.mcap)")
            .value_parser(path())
            .required_unless_present("live")
            .conflicts_with("live"),
        Arg::new("live").long("live").value_name("NAME").help("A run of this name that is going on this machine"),
        Arg::new("out")
            .long("out")
            .value_name("DIR")
            .help("Folder for tables (CSV) and charts (SVG) [default: beside the recording, or NAME.KIND]")
            .value_parser(path()),
        count("from").value_name("STEP").help("Leave out what was before this step"),
        count("to").value_name("STEP").help("Leave out what was after this step"),
        Arg::new("for")
            .long("for")
            .value_name("SECONDS")
            .help("Watch a live run for this long, not to its end")
            .requires("live")
            .value_parser(seconds),
        count("snapshots").value_name("N").help("Stop after this many snapshots of a live run").requires("live"),
    ]
}

fn seconds(text: &str) -> Result<Duration, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    Duration::try_from_secs_f64(value).map_err(|e| e.to_string())
}

/// The flag of an option.
fn option(field: &Field) -> Arg {
    let unit = if field.unit.is_empty() { String::new() } else { format!(" [{}]", field.unit) };
    let default = match &field.default {
        Some(value) => format!(" [default: {}]", plain(value)),
        None => String::new(),
    };
    let kind = field.kind;
    let arg = Arg::new(field.name)
        .long(field.name)
        .value_name(if matches!(kind, Kind::Choice(_)) { "WORD" } else { "NUMBER" })
        .help(format!("{}{unit}{default}", field.doc))
        .allow_negative_numbers(true);
    match kind {
        Kind::Choice(words) => arg.value_parser(clap::builder::PossibleValuesParser::new(words)),
        _ => arg.value_parser(move |text: &str| number(text, kind)),
    }
}

fn plain(value: &Value) -> String {
    match value {
        Value::Float(v) => v.to_string(),
        Value::Integer(v) => v.to_string(),
        Value::Text(text) => text.clone(),
        other => format!("{other:?}"),
    }
}

/// A number that the option accepts.
fn number(text: &str, kind: Kind) -> Result<Value, String> {
    let within = |good: bool, low: &dyn std::fmt::Display, high: &dyn std::fmt::Display| {
        if good { Ok(()) } else { Err(format!("it must lie between {low} and {high}")) }
    };
    match kind {
        Kind::Float { min, max } => {
            let value: f64 = text.parse().map_err(|_| "it must be a number".to_owned())?;
            within(value >= min && value <= max, &min, &max)?;
            Ok(Value::Float(value))
        }
        Kind::Integer { min, max } => {
            let value: i64 = text.parse().map_err(|_| "it must be a whole number".to_owned())?;
            within(value >= min && value <= max, &min, &max)?;
            Ok(Value::Integer(value))
        }
        _ => Err("an option of this kind cannot be given on the command line".into()),
    }
}

/// The options given, over the defaults.
fn options(entry: &Entry, matches: &ArgMatches) -> Values {
    let fields = (entry.fields)();
    let mut values = Values::defaults(&fields);
    for field in &fields {
        let given = match field.kind {
            Kind::Choice(_) => matches.get_one::<String>(field.name).map(|word| Value::Text(word.clone())),
            _ => matches.get_one::<Value>(field.name).cloned(),
        };
        if let Some(value) = given {
            values.set(field.name, value);
        }
    }
    values
}

fn analyze(entry: &Entry, matches: &ArgMatches) -> Result<Ending, AnalyzeError> {
    let (source, default): (Box<dyn Source>, PathBuf) = match matches.get_one::<PathBuf>("recording") {
        Some(path) => {
            let folder = Folder::new(path);
            let default = folder.path().with_extension(entry.name);
            (Box::new(folder), default)
        }
        None => {
            let run = matches.get_one::<String>("live").expect("clap wants one of the two");
            let limits = Limits {
                duration: matches.get_one("for").copied(),
                snapshots: matches.get_one("snapshots").copied(),
                stop: interrupted(),
            };
            (Box::new(Live::new(run, limits)), Path::new(run).with_extension(entry.name))
        }
    };
    let mut analyzer = (entry.make)(&options(entry, matches));
    let (report, ending) = run(&mut Window::new(source, steps(matches)), analyzer.as_mut())?;
    let out = matches.get_one::<PathBuf>("out").cloned().unwrap_or(default);
    report.write(&out)?;
    for warning in &ending.warnings {
        eprintln!("warning: {warning}");
    }
    print!("{}", report.summary);
    println!("{} snapshots; {} files in {}", ending.snapshots, report.files.len(), out.display());
    Ok(ending)
}

/// Becomes true at the first Ctrl-C, so that what was seen of a live run is still written; the second one kills.
fn interrupted() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        // Registered in this order: the flag is looked at before it is set. Without handlers Ctrl-C just ends the program.
        let _ = signal_hook::flag::register_conditional_default(signal, Arc::clone(&flag));
        let _ = signal_hook::flag::register(signal, Arc::clone(&flag));
    }
    flag
}
