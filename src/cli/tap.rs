//! `squirm tap`: snapshots of a run that is going, for people or as JSON.

use super::{RUN_FAILED, signals, watch};
use serde_json::{Map, Value, json};
use squirm::analyze::{Limits, Live, Source};
use squirm::wire::{Fields, Kind, Particles, Scalar, Scalars, Snapshot, Squirmers, Status, WireError};
use std::fmt::Write as _;
use std::io::Write as _;
use std::ops::ControlFlow;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Rows of a long table that are shown.
const SHOWN: usize = 10;

/// Arguments of `squirm tap`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Name of the run, as `squirm ps` lists it.
    run: String,
    /// What to print.
    #[arg(value_parser = clap::builder::PossibleValuesParser::new(Kind::ALL.map(Kind::topic)))]
    topic: String,
    /// One JSON object per line, with every value.
    #[arg(long)]
    json: bool,
    /// Stop after so many snapshots.
    #[arg(long, value_name = "N")]
    count: Option<u64>,
    /// Stop after so long.
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    duration: Option<Duration>,
}

fn seconds(text: &str) -> Result<Duration, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    Duration::try_from_secs_f64(value).map_err(|e| e.to_string())
}

/// Prints snapshots until the run ends.
pub fn tap(args: &Args) -> ExitCode {
    let kind = Kind::from_topic(&args.topic).expect("clap accepts topics only");
    let signal = signals::first();
    // A topic that is silent must not keep it from ending.
    let limits = Limits { duration: args.duration, snapshots: args.count, stop: signals::flag() };
    let mut out = std::io::stdout().lock();
    let ending = Live::new(&args.run, limits).drive(&[kind], &mut |snapshot| {
        // Values that do not fit together are told and passed over: a tap is for finding out.
        let text = if args.json { Ok(format!("{}\n", object(snapshot))) } else { readable(snapshot) };
        match text {
            Ok(text) => {
                if out.write_all(text.as_bytes()).and_then(|()| out.flush()).is_err() {
                    return Ok(ControlFlow::Break(()));
                }
            }
            Err(error) => say!("warning: step {}: {error}", snapshot.header.step),
        }
        let stopped = signal.load(Ordering::Relaxed) != 0;
        Ok(if stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    });
    match ending {
        Ok(ending) => {
            ending.warnings.iter().for_each(|warning| say!("warning: {warning}"));
            if signal.load(Ordering::Relaxed) == 0 { ExitCode::SUCCESS } else { signals::status(&signal) }
        }
        Err(error) => {
            say!("error: {error}");
            ExitCode::from(RUN_FAILED)
        }
    }
}

/// Every column with all its values; a row of one component is a number, of letters a text.
fn object(snapshot: &Snapshot<'_>) -> Value {
    let header = &snapshot.header;
    let mut columns = Map::new();
    for column in snapshot.columns() {
        let (name, n) = (column.name(), column.components);
        let values: Result<Vec<Value>, WireError> = match column.element {
            1 => snapshot.flat::<u8>(name, n).map(|v| v.iter().map(|x| json!(x)).collect()),
            2 => snapshot.flat::<u32>(name, n).map(|v| v.iter().map(|x| json!(x)).collect()),
            3 => snapshot.flat::<f32>(name, n).map(|v| v.iter().map(|x| single(*x)).collect()),
            _ => snapshot.flat::<f64>(name, n).map(|v| v.iter().map(|x| json!(x)).collect()),
        };
        let Ok(values) = values else { continue };
        let rows = values.chunks_exact(n as usize).map(|row| match column.element {
            1 => json!(letters(row)),
            _ if n == 1 => row[0].clone(),
            _ => json!(row),
        });
        columns.insert(name.into(), rows.collect());
    }
    json!({
        "topic": snapshot.kind().topic(), "step": header.step, "time": header.time, "seq": header.seq,
        "box": header.box_size, "population": header.population, "columns": columns,
    })
}

/// The shortest decimal that reads back as the same f32.
fn single(x: f32) -> Value {
    x.to_string().parse::<f64>().map_or(Value::Null, |x| json!(x))
}

fn letters(row: &[Value]) -> String {
    let bytes: Vec<u8> = row.iter().filter_map(|v| u8::try_from(v.as_u64()?).ok()).take_while(|b| *b != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A snapshot for people.
fn readable(snapshot: &Snapshot<'_>) -> Result<String, WireError> {
    let header = &snapshot.header;
    let mut text =
        format!("{}  step {}  time {} tau  #{}", snapshot.kind().topic(), header.step, header.time, header.seq);
    match snapshot.kind() {
        Kind::Squirmers => squirmers(&mut text, &Squirmers::decode(snapshot)?),
        Kind::Scalars => numbers(&mut text, &Scalars::decode(snapshot)?.list),
        Kind::Fields => fields(&mut text, &Fields::decode(snapshot)?),
        Kind::Particles => particles(&mut text, &Particles::decode(snapshot)?),
        Kind::Status => status(&mut text, &Status::decode(snapshot)?),
    }
    Ok(text)
}

fn numbers(text: &mut String, list: &[Scalar]) {
    text.push('\n');
    for s in list {
        let _ = writeln!(text, "  {:<24} {:>14}  {}", watch::tame(&s.name), number(s.value), watch::tame(&s.unit));
    }
}

/// A number with six digits, plain where that is readable.
fn number(value: f64) -> String {
    match value.abs() {
        v if v == 0.0 || (v.fract() == 0.0 && v < 1e12) => format!("{value}"),
        v if (1e-3..1e6).contains(&v) => format!("{value:.6}"),
        _ => format!("{value:.5e}"),
    }
}

fn squirmers(text: &mut String, s: &Squirmers) {
    let _ = writeln!(
        text,
        "  {} squirmers\n{:>8} {:<12} {:>30} {:>24} {:>10}",
        s.id.len(),
        "id",
        "species",
        "x, y, z [a]",
        "axis",
        "v.e"
    );
    for i in 0..s.id.len() {
        let (p, e, v) = (s.position[i], s.axis[i], s.velocity[i]);
        let name = watch::tame(&s.table[s.species[i] as usize].name);
        let along: f32 = (0..3).map(|k| v[k] * e[k]).sum();
        let place = format!("{:.3} {:.3} {:.3}", p[0], p[1], p[2]);
        let axis = format!("{:.3} {:.3} {:.3}", e[0], e[1], e[2]);
        let _ = writeln!(text, "{:>8} {name:<12} {place:>30} {axis:>24} {along:>10.5}", s.id[i]);
    }
}

/// Mean, least and greatest value.
fn spread(values: impl Iterator<Item = f64> + Clone) -> String {
    let (n, sum) = values.clone().fold((0.0, 0.0), |(n, sum), v| (n + 1.0, sum + v));
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (v.min(low), v.max(high)));
    if n == 0.0 { "nothing".into() } else { format!("mean {:.5}, from {low:.5} to {high:.5}", sum / n) }
}

fn length(v: &[f32; 3]) -> f64 {
    v.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt()
}

fn vector(v: &[f32; 3]) -> String {
    format!("{:>10.5} {:>10.5} {:>10.5}", v[0], v[1], v[2])
}

fn fields(text: &mut String, f: &Fields) {
    let [x, y, z] = f.blocks;
    let _ = writeln!(text, "  {x} x {y} x {z} blocks with edges of {} a", f.block);
    let _ = writeln!(text, "  density [m/a^3]     {}", spread(f.density.iter().map(|d| f64::from(*d))));
    let _ = writeln!(text, "  speed [sqrt(kT/m)]  {}", spread(f.velocity.iter().map(length)));
    for (i, (density, velocity)) in f.density.iter().zip(&f.velocity).take(SHOWN).enumerate() {
        let _ = writeln!(text, "{i:>8} {density:>10.4}  {}", vector(velocity));
    }
    more(text, f.density.len());
}

fn particles(text: &mut String, p: &Particles) {
    let _ = writeln!(text, "  {} of {} particles", p.position.len(), p.population);
    let _ = writeln!(text, "  speed [sqrt(kT/m)]  {}", spread(p.velocity.iter().map(length)));
    for (place, velocity) in p.position.iter().zip(&p.velocity).take(SHOWN) {
        let _ = writeln!(text, "  {}  {}", vector(place), vector(velocity));
    }
    more(text, p.position.len());
}

fn more(text: &mut String, rows: usize) {
    if rows > SHOWN {
        let _ = writeln!(text, "  ... and {} more", rows - SHOWN);
    }
}

fn status(text: &mut String, s: &Status) {
    numbers(text, &s.numbers().list);
    for (name, value) in [("phase", &s.phase), ("adapter", &s.adapter), ("folder", &s.folder)] {
        let _ = writeln!(text, "  {name:<24} {}", watch::tame(value));
    }
    for (stage, time) in &s.stages {
        let _ = writeln!(text, "  {:<24} {:>14.1}  ns per step", watch::tame(stage), time);
    }
}
