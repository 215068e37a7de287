//! An analyzer of one's own: how often squirmers head up and down across a slit, from a recording or from a run that is going.
//!
//! `cargo run --release --example custom_analyzer -- runs/quickstart` reads a recorded run,
//! `cargo run --release --example custom_analyzer -- --live quickstart` watches one until it ends.

use squirm::analyze::statistics::blocked;
use squirm::analyze::table::Table;
use squirm::analyze::{AnalyzeError, Analyzer, Folder, Limits, Live, Report, Source, run};
use squirm::wire::{Kind, Snapshot, Squirmers};
use std::path::Path;

/// The mean of |e_y| over all squirmers, snapshot by snapshot: 1 if all stand upright, 0 if all lie, 1/2 if their directions are random.
#[derive(Default)]
struct Upright {
    times: Vec<f64>,
    means: Vec<f64>,
}

impl Analyzer for Upright {
    fn topics(&self) -> Vec<Kind> {
        vec![Kind::Squirmers]
    }

    fn take(&mut self, snapshot: &Snapshot<'_>) -> Result<(), AnalyzeError> {
        let squirmers = Squirmers::decode(snapshot)?;
        let sum: f64 = squirmers.axis.iter().map(|e| f64::from(e[1].abs())).sum();
        self.times.push(snapshot.header.time);
        self.means.push(sum / squirmers.axis.len() as f64);
        Ok(())
    }

    fn finish(&mut self) -> Result<Report, AnalyzeError> {
        if self.times.is_empty() {
            return Err(AnalyzeError::TooLittle("no squirmers in these snapshots".into()));
        }
        let mut table = Table::new("time [tau],<|e_y|>");
        self.times.iter().zip(&self.means).for_each(|(time, mean)| table.row(&[(*time).into(), (*mean).into()]));
        let found = blocked(&self.means);
        let summary = format!("<|e_y|> = {:.4} +- {:.4}\n", found.mean, found.error);
        Ok(Report { summary, files: vec![("upright.csv".into(), table.finish())] })
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut source: Box<dyn Source> = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["--live", name] => Box::new(Live::new(name, Limits::default())),
        [path] if !path.starts_with('-') => Box::new(Folder::new(Path::new(path))),
        _ => return Err("give the folder of a run, or --live and the name of one that is going".into()),
    };
    let (report, ending) = run(source.as_mut(), &mut Upright::default())?;
    ending.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    report.write(Path::new("upright"))?;
    println!("{}{} snapshots; the table is upright/upright.csv", report.summary, ending.snapshots);
    Ok(())
}
