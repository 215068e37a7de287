//! Snapshots as tables, also for starting a new run from them.

use super::{ExportError, Exported, Selection};
use crate::recording::{Choice, Series};
use crate::wire::{Fields, Kind, Particles, Scalars, Snapshot, Squirmers, Status, WireError};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// Writes one kind of snapshot into the new table `out`. Each number has the shortest form that reads back as the same number,
/// so that a complete table of particles is the very state, and a run can start from it.
///
/// The last snapshot, or that at one step, has the columns `x,y,z,vx,vy,vz` (particles) or
/// `x,y,z,ex,ey,ez,vx,vy,vz,id,species` (squirmers). Those of a range stand one after another, with step and time in front and
/// all that is known. Of scalars every snapshot is written.
///
/// # Errors
/// If the recording cannot be read or has no such snapshot, or `out` exists or cannot be written.
pub fn csv(recording: &Path, kind: Kind, selection: Selection, out: &Path) -> Result<Exported, ExportError> {
    let mut series = Series::open(recording, &[kind])?;
    let all = kind == Kind::Scalars || matches!(selection, Selection::Range(_));
    let mut choice = Choice::new(selection.range());
    let mut table = Table { out, writer: None, columns: Vec::new() };
    let (mut done, mut seen, mut newest) = (Exported { path: out.into(), ..Exported::default() }, None, None);
    while let Some(bytes) = series.next_message()? {
        let snapshot = Snapshot::parse(&bytes)?;
        seen = Some(snapshot.header.step);
        if !choice.takes(kind, &snapshot.header) {
            continue;
        }
        if all {
            table.append(&snapshot, true, &mut done)?;
        } else {
            newest = Some(bytes);
        }
    }
    if let Some(bytes) = newest {
        table.append(&Snapshot::parse(&bytes)?, false, &mut done)?;
    }
    let Some(mut writer) = table.writer else {
        return Err(ExportError::absent(recording, &[kind], selection, seen));
    };
    writer.flush().map_err(ExportError::io(out))?;
    done.warnings = series.finish().warnings;
    Ok(done)
}

/// A table being written; it is made with its first row.
struct Table<'a> {
    out: &'a Path,
    writer: Option<::csv::Writer<BufWriter<File>>>,
    columns: Vec<String>,
}

impl Table<'_> {
    /// Appends a snapshot; `stamped` says whether step and time stand in front.
    fn append(&mut self, snapshot: &Snapshot<'_>, stamped: bool, done: &mut Exported) -> Result<(), ExportError> {
        let header = snapshot.header;
        let stamp = if stamped { vec![header.step.to_string(), header.time.to_string()] } else { Vec::new() };
        let (names, rows) = rows(snapshot, stamped)?;
        let columns = if stamped { ["step", "time [tau]"].map(String::from).to_vec() } else { Vec::new() };
        let columns: Vec<String> = columns.into_iter().chain(names).collect();
        let failed = |e: ::csv::Error| ExportError::io(self.out)(std::io::Error::other(e));
        let writer = match &mut self.writer {
            Some(writer) => writer,
            None => {
                let file = File::create_new(self.out).map_err(ExportError::io(self.out))?;
                let writer = self.writer.insert(::csv::Writer::from_writer(BufWriter::new(file)));
                writer.write_record(&columns).map_err(failed)?;
                self.columns = columns.clone();
                writer
            }
        };
        if columns != self.columns {
            return Err(WireError::Malformed("the scalars changed during the run".into()).into());
        }
        for row in &rows {
            writer.write_record(stamp.iter().chain(row)).map_err(failed)?;
        }
        done.snapshots += 1;
        done.step = header.step;
        done.rows = if stamped { done.rows + rows.len() as u64 } else { header.rows };
        done.population = if stamped { done.rows } else { header.population };
        Ok(())
    }
}

/// Columns and rows of a snapshot.
type Rows = (Vec<String>, Vec<Vec<String>>);

fn rows(snapshot: &Snapshot<'_>, full: bool) -> Result<Rows, ExportError> {
    Ok(match snapshot.kind() {
        Kind::Particles => particles(&Particles::decode(snapshot)?, full),
        Kind::Squirmers if full => squirmers(&Squirmers::decode(snapshot)?),
        Kind::Squirmers => poses(&Squirmers::decode(snapshot)?),
        Kind::Scalars => scalars(&Scalars::decode(snapshot)?),
        Kind::Fields => fields(&Fields::decode(snapshot)?),
        Kind::Status => scalars(&Status::decode(snapshot)?.numbers()),
    })
}

/// Names of three components with their unit.
fn vector(name: &str, unit: &str) -> [String; 3] {
    ["x", "y", "z"].map(|c| if unit.is_empty() { format!("{name}{c}") } else { format!("{name}{c} [{unit}]") })
}

fn texts<T: ToString>(values: &[T]) -> impl Iterator<Item = String> {
    values.iter().map(T::to_string)
}

fn particles(p: &Particles, full: bool) -> Rows {
    let (a, v) = if full { ("a", "sqrt(kT/m)") } else { ("", "") };
    let row = |i: usize| texts(&p.place(i)).chain(texts(&p.velocity[i])).collect();
    ([vector("", a), vector("v", v)].concat(), (0..p.velocity.len()).map(row).collect())
}

fn poses(s: &Squirmers) -> Rows {
    let names = ["x", "y", "z", "ex", "ey", "ez", "vx", "vy", "vz", "id", "species"].map(String::from).to_vec();
    let row = |i: usize| {
        let numbers = texts(&s.position[i]).chain(texts(&s.axis[i])).chain(texts(&s.velocity[i]));
        numbers.chain([s.id[i].to_string(), s.table[s.species[i] as usize].name.clone()]).collect()
    };
    (names, (0..s.id.len()).map(row).collect())
}

fn squirmers(s: &Squirmers) -> Rows {
    let mut names = vec!["id".to_owned(), "species".to_owned()];
    let quaternion = ["qx", "qy", "qz", "qw"].map(String::from);
    names.extend([vector("", "a"), vector("unwrapped_", "a"), vector("e", "")].concat());
    names.extend(quaternion);
    let rest = [("v", "sqrt(kT/m)"), ("omega_", "1/tau"), ("force_", "kT/a"), ("torque_", "kT")];
    names.extend(rest.iter().flat_map(|(name, unit)| vector(name, unit)));
    let row = |i: usize| {
        let mut row = vec![s.id[i].to_string(), s.table[s.species[i] as usize].name.clone()];
        row.extend(texts(&s.position[i]).chain(texts(&s.unwrapped[i])).chain(texts(&s.axis[i])));
        row.extend(texts(&s.orientation[i]));
        for column in [&s.velocity, &s.angular_velocity, &s.force, &s.torque] {
            row.extend(texts(&column[i]));
        }
        row
    };
    (names, (0..s.id.len()).map(row).collect())
}

fn scalars(s: &Scalars) -> Rows {
    let name = |s: &crate::wire::Scalar| format!("{} [{}]", s.name, s.unit).replace(" []", "");
    (s.list.iter().map(name).collect(), vec![s.list.iter().map(|s| s.value.to_string()).collect()])
}

/// Blocks with their centres.
fn fields(f: &Fields) -> Rows {
    let names = [&vector("", "a")[..], &["density [m/a^3]".to_owned()], &vector("v", "sqrt(kT/m)")].concat();
    let [nx, ny, _] = f.blocks.map(|n| n as usize);
    let row = |i: usize| {
        let centre = [i % nx, i / nx % ny, i / nx / ny].map(|n| f64::from(f.block) * (n as f64 + 0.5));
        texts(&centre).chain([f.density[i].to_string()]).chain(texts(&f.velocity[i])).collect()
    };
    (names, (0..f.density.len()).map(row).collect())
}
