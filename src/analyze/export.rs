//! Recorded snapshots as tables for other programs, and for starting a new run from them.

use super::{AnalyzeError, Recording, Source};
use crate::segments;
use crate::wire::{Kind, Particles, Scalars, Snapshot, Squirmers, WireError};
use std::io::{BufWriter, Write};
use std::ops::ControlFlow;
use std::path::Path;

/// What was exported.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Exported {
    /// Rows in the table.
    pub rows: u64,
    /// How many there were in the run; more than `rows` where only a share was recorded.
    pub population: u64,
    /// Step of the snapshot.
    pub step: u64,
    /// What the user should know about the recording.
    pub warnings: Vec<String>,
}

impl Exported {
    /// Whether the table holds all there was; a run can be started exactly from complete tables only.
    #[must_use]
    pub fn complete(&self) -> bool {
        self.rows == self.population
    }
}

/// Writes the fluid particles of the last snapshot, or of that at step `at`, as `x,y,z,vx,vy,vz` into `out`: each number in
/// the shortest form that reads back as the same number, so that a complete table is the very state, and a run can start from it.
/// `recording` may be `run.mcap`; the fluid is looked for beside it.
///
/// # Errors
/// If the recording cannot be read or has no such snapshot, or `out` cannot be written.
pub fn particles_csv(recording: &Path, out: &Path, at: Option<u64>) -> Result<Exported, AnalyzeError> {
    let beside = recording.with_file_name("run.fluid.mcap");
    let fluid = recording.file_name().is_some_and(|n| n == "run.mcap") && segments::of(&beside)[0].exists();
    let path = if fluid { &beside } else { recording };
    let write = |snapshot: &Snapshot<'_>, file: &mut dyn Write| {
        let particles = Particles::decode(snapshot)?;
        let text = |r: std::io::Result<()>| r.map_err(AnalyzeError::io(out));
        text(writeln!(file, "x,y,z,vx,vy,vz"))?;
        for (i, [vx, vy, vz]) in particles.velocity.iter().enumerate() {
            let [x, y, z] = particles.place(i);
            text(writeln!(file, "{x},{y},{z},{vx},{vy},{vz}"))?;
        }
        Ok(())
    };
    export(path, Kind::Particles, out, at, write)
}

/// Writes the squirmers of the last snapshot, or of that at step `at`, as `x,y,z,ex,ey,ez,vx,vy,vz,id,species` into `out`.
///
/// # Errors
/// If the recording cannot be read or has no such snapshot, or `out` cannot be written.
pub fn squirmers_csv(recording: &Path, out: &Path, at: Option<u64>) -> Result<Exported, AnalyzeError> {
    let write = |snapshot: &Snapshot<'_>, file: &mut dyn Write| {
        let squirmers = Squirmers::decode(snapshot)?;
        let mut table = csv::Writer::from_writer(file);
        let failed = |e: csv::Error| AnalyzeError::io(out)(std::io::Error::other(e));
        table.write_record(["x", "y", "z", "ex", "ey", "ez", "vx", "vy", "vz", "id", "species"]).map_err(failed)?;
        for i in 0..squirmers.id.len() {
            let vectors = [squirmers.position[i], squirmers.axis[i], squirmers.velocity[i]];
            let numbers = vectors.as_flattened().iter().map(f32::to_string);
            let name = squirmers.table[squirmers.species[i] as usize].name.clone();
            table.write_record(numbers.chain([squirmers.id[i].to_string(), name])).map_err(failed)?;
        }
        table.flush().map_err(AnalyzeError::io(out))
    };
    export(recording, Kind::Squirmers, out, at, write)
}

/// Writes the scalars of every snapshot, or of that at step `at`, into `out`, one row each; columns are named as in `temperature [kT]`.
///
/// # Errors
/// If the recording cannot be read or has no such snapshot, or `out` cannot be written.
pub fn scalars_csv(recording: &Path, out: &Path, at: Option<u64>) -> Result<Exported, AnalyzeError> {
    let (mut rows, mut columns, mut seen) = (Vec::new(), Vec::new(), None);
    let ending = Recording::new(recording).drive(&[Kind::Scalars], &mut |snapshot| {
        let header = &snapshot.header;
        seen = Some(header.step);
        if at.is_none_or(|at| at == header.step) {
            let scalars = Scalars::decode(snapshot)?.list;
            let named = |s: &crate::wire::Scalar| format!("{} [{}]", s.name, s.unit).replace(" []", "");
            let names: Vec<String> = scalars.iter().map(named).collect();
            if !rows.is_empty() && names != columns {
                return Err(WireError::Malformed("the scalars changed during the run".into()).into());
            }
            columns = names;
            let first = [header.step.to_string(), header.time.to_string()];
            rows.push(first.into_iter().chain(scalars.iter().map(|s| s.value.to_string())).collect::<Vec<_>>());
        }
        Ok(ControlFlow::Continue(()))
    })?;
    let step = seen.filter(|_| !rows.is_empty()).ok_or_else(|| absent(recording, Kind::Scalars, at, seen))?;
    let write = || {
        let mut table = csv::Writer::from_path(out)?;
        table.write_record(["step", "time [tau]"].into_iter().chain(columns.iter().map(String::as_str)))?;
        rows.iter().try_for_each(|row| table.write_record(row))?;
        table.flush()?;
        Ok(())
    };
    write().map_err(|e: csv::Error| AnalyzeError::io(out)(std::io::Error::other(e)))?;
    let count = rows.len() as u64;
    Ok(Exported { rows: count, population: count, step: at.unwrap_or(step), warnings: ending.warnings })
}

/// Finds the snapshot and hands it to `write` together with the new file.
fn export(
    path: &Path,
    kind: Kind,
    out: &Path,
    at: Option<u64>,
    write: impl Fn(&Snapshot<'_>, &mut dyn Write) -> Result<(), AnalyzeError>,
) -> Result<Exported, AnalyzeError> {
    let mut found: Option<Vec<u8>> = None;
    let mut seen = None;
    let ending = Recording::new(path).drive(&[kind], &mut |snapshot| {
        let step = snapshot.header.step;
        seen = Some(step);
        if at.is_none_or(|at| at == step) {
            found = Some(snapshot.bytes().to_vec());
        }
        Ok(if at == Some(step) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    })?;
    let bytes = found.ok_or_else(|| absent(path, kind, at, seen))?;
    let snapshot = Snapshot::parse(&bytes)?;
    let mut file = BufWriter::new(std::fs::File::create(out).map_err(AnalyzeError::io(out))?);
    write(&snapshot, &mut file)?;
    file.flush().map_err(AnalyzeError::io(out))?;
    let header = snapshot.header;
    Ok(Exported { rows: header.rows, population: header.population, step: header.step, warnings: ending.warnings })
}

fn absent(path: &Path, kind: Kind, at: Option<u64>, seen: Option<u64>) -> AnalyzeError {
    let (path, kind) = (path.display(), kind.topic());
    AnalyzeError::TooLittle(match (at, seen) {
        (Some(at), Some(last)) => format!("{path} has no snapshot of {kind} at step {at}; the last is at step {last}"),
        _ => format!("{path} has no snapshot of {kind}: was the topic recorded?"),
    })
}
