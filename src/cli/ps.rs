//! `squirm ps`: the runs of this user that are going.

use super::{RUN_FAILED, print, watch};
use serde_json::{Value, json};
use squirm::analyze::{self, Running};
use squirm::wire::{Kind, Stamp, Status};
use std::fmt::Write;
use std::process::ExitCode;

/// Arguments of `squirm ps`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// A run and what it says of itself.
type Row = (Running, Option<(Stamp, Status)>);

/// Lists the runs.
pub fn ps(args: &Args) -> ExitCode {
    let runs = match analyze::running() {
        Ok(runs) => runs,
        Err(error) => {
            say!("error: {error}");
            return ExitCode::from(RUN_FAILED);
        }
    };
    // Each run may take its time to answer, so all are asked at once.
    let rows: Vec<Row> = std::thread::scope(|scope| {
        let asked: Vec<_> = runs.iter().map(|r| scope.spawn(|| watch::status(&r.name))).collect();
        let answers = asked.into_iter().map(|a| a.join().ok().flatten());
        runs.iter().cloned().zip(answers).collect()
    });
    if args.json {
        let list: Vec<Value> = rows.iter().map(object).collect();
        return print(&format!("{:#}\n", Value::Array(list)));
    }
    if rows.is_empty() {
        return print("no run of yours is going on this machine\n");
    }
    print(&table(&rows))
}

/// Topics but the status, which every run has.
fn topics(run: &Running) -> impl Iterator<Item = &(Kind, usize)> {
    run.topics.iter().filter(|(kind, _)| *kind != Kind::Status)
}

fn object((run, answer): &Row) -> Value {
    let readers: serde_json::Map<String, Value> =
        topics(run).map(|(kind, readers)| (kind.topic().into(), json!(readers))).collect();
    let mut row = json!({ "run": run.name, "subscribers": readers });
    if let Some((stamp, status)) = answer {
        row["step"] = json!(stamp.step);
        row["steps"] = json!(status.steps);
        row["time"] = json!(stamp.time);
        row["steps_per_second"] = json!(status.speed);
        row["seconds"] = json!(watch::age(status));
        row["seconds_left"] = json!(watch::left(stamp.step, status));
        row["pid"] = json!(status.pid);
        row["folder"] = json!(status.folder);
        row["adapter"] = json!(status.adapter);
        row["published"] = json!(status.published);
        row["dropped"] = json!(status.dropped);
        row["phase"] = json!(status.phase);
    }
    row
}

/// Columns as wide as their widest cell.
fn table(rows: &[Row]) -> String {
    let head = ["RUN", "STEP", "OF", "DONE", "STEPS/S", "LEFT", "GOING FOR", "PID", "TOPICS (SUBSCRIBERS)"];
    let mut cells = vec![head.map(str::to_owned)];
    cells.extend(rows.iter().map(cells_of));
    let width = |column: usize| cells.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let mut text = String::new();
    for row in &cells {
        let line = row.iter().zip(&widths).enumerate().map(|(i, (cell, width))| match i {
            1..=7 => format!("{cell:>width$}"),
            _ => format!("{cell:<width$}"),
        });
        let _ = writeln!(text, "{}", line.collect::<Vec<_>>().join("  ").trim_end());
    }
    text
}

fn cells_of((run, answer): &Row) -> [String; 9] {
    let list: Vec<String> = topics(run).map(|(kind, readers)| format!("{} ({readers})", kind.topic())).collect();
    let list = if list.is_empty() { "-".into() } else { list.join(", ") };
    let name = watch::tame(&run.name);
    let Some((stamp, status)) = answer else {
        return [&name, "-", "-", "-", "-", "-", "-", "-", &list].map(str::to_owned);
    };
    [
        name,
        stamp.step.to_string(),
        status.steps.to_string(),
        format!("{:.1} %", watch::share(stamp.step, status)),
        watch::rate(status.speed),
        watch::left(stamp.step, status).map_or("?".into(), watch::time),
        watch::time(watch::age(status)),
        status.pid.to_string(),
        list,
    ]
}
