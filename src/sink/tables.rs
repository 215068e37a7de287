//! Snapshots as plain tables: `scalars.csv` with one row per snapshot, `squirmers.csv` with one per squirmer and snapshot.

use super::SinkError;
use crate::wire::{Kind, Scalars, Snapshot, Squirmers};
use std::fs::File;
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// What of a table is certainly on the disk.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Rows {
    /// Name of its file, without the directory.
    pub name: String,
    /// Length in bytes.
    pub bytes: u64,
}

/// Names of the tables.
const NAMES: [&str; 2] = ["scalars.csv", "squirmers.csv"];

/// One table.
struct Table {
    path: PathBuf,
    writer: csv::Writer<BufWriter<File>>,
    columns: Vec<String>,
}

/// Writes CSV files whose first row names columns and units, as in `temperature [kT]`.
pub struct Tables {
    dir: PathBuf,
    scalars: Option<Table>,
    squirmers: Option<Table>,
}

impl Tables {
    /// Tables in `dir`, each begun with its first snapshot.
    ///
    /// # Errors
    /// If one of the files exists.
    pub fn create(dir: &Path) -> Result<Self, SinkError> {
        for name in NAMES {
            let path = dir.join(name);
            if path.exists() {
                return Err(SinkError::Exists(path));
            }
        }
        Ok(Self { dir: dir.into(), scalars: None, squirmers: None })
    }

    /// Goes on after a resumption: tables are cut to what they had at the checkpoint; those begun later go.
    ///
    /// # Errors
    /// If a table has lost rows that it had, or cannot be read or written.
    pub fn resume(dir: &Path, at: &[Rows]) -> Result<Self, SinkError> {
        let [scalars, squirmers] = NAMES.map(|name| Table::resume(dir, name, at.iter().find(|r| r.name == name)));
        Ok(Self { dir: dir.into(), scalars: scalars?, squirmers: squirmers? })
    }

    /// Waits until everything written so far is on the disk, and says what that is.
    ///
    /// # Errors
    /// If the system cannot write it.
    pub fn sync(&mut self) -> Result<Vec<Rows>, SinkError> {
        [&mut self.scalars, &mut self.squirmers].into_iter().flatten().map(Table::sync).collect()
    }

    /// Appends one message of squirmers or scalars; others have no table and are passed over.
    ///
    /// # Errors
    /// If the bytes are no snapshot, or the file cannot be written.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), SinkError> {
        let snapshot = Snapshot::parse(bytes)?;
        let (step, time) = (snapshot.header.step.to_string(), snapshot.header.time.to_string());
        match snapshot.kind() {
            Kind::Scalars => {
                let scalars = Scalars::decode(&snapshot)?.list;
                let names = scalars.iter().map(|s| titled(&s.name, &s.unit));
                let columns: Vec<String> = ["step".into(), "time [tau]".into()].into_iter().chain(names).collect();
                let table = table(&mut self.scalars, &self.dir, NAMES[0], columns)?;
                table.row([step, time].into_iter().chain(scalars.iter().map(|s| s.value.to_string())))?;
                table.flush()
            }
            Kind::Squirmers => {
                let squirmers = Squirmers::decode(&snapshot)?;
                let table = table(&mut self.squirmers, &self.dir, NAMES[1], squirmer_columns())?;
                for i in 0..squirmers.id.len() {
                    table.row([step.clone(), time.clone()].into_iter().chain(squirmer_row(&squirmers, i)))?;
                }
                table.flush()
            }
            Kind::Fields | Kind::Particles | Kind::Status => Ok(()),
        }
    }
}

fn titled(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

/// Names of the columns in the order of [`squirmer_row`].
fn squirmer_columns() -> Vec<String> {
    let vectors = [
        ("", "a"),
        ("unwrapped_", "a"),
        ("e", ""),
        ("v", "sqrt(kT/m)"),
        ("omega_", "1/tau"),
        ("force_", "kT/a"),
        ("torque_", "kT"),
    ];
    let components =
        vectors.iter().flat_map(|(name, unit)| ["x", "y", "z"].map(|c| titled(&format!("{name}{c}"), unit)));
    let first = ["step", "time [tau]", "id", "species"].map(String::from);
    first.into_iter().chain(components).collect()
}

/// Everything about squirmer `i` but step and time; numbers in the shortest form that reads back as the same value.
pub(crate) fn squirmer_row(squirmers: &Squirmers, i: usize) -> Vec<String> {
    let mut row = vec![squirmers.id[i].to_string(), squirmers.table[squirmers.species[i] as usize].name.clone()];
    row.extend(squirmers.position[i].iter().map(f32::to_string));
    row.extend(squirmers.unwrapped[i].iter().map(f64::to_string));
    for column in
        [&squirmers.axis, &squirmers.velocity, &squirmers.angular_velocity, &squirmers.force, &squirmers.torque]
    {
        row.extend(column[i].iter().map(f32::to_string));
    }
    row
}

/// The table in `slot`, begun if this is its first row. The columns of a table never change.
fn table<'a>(
    slot: &'a mut Option<Table>,
    dir: &Path,
    name: &str,
    columns: Vec<String>,
) -> Result<&'a mut Table, SinkError> {
    let table = match slot.take() {
        Some(table) => table,
        None => {
            let path = dir.join(name);
            let file = File::create_new(&path).map_err(|e| SinkError::io(&path, e))?;
            let mut table =
                Table { path, writer: csv::Writer::from_writer(BufWriter::new(file)), columns: columns.clone() };
            table.row(columns.iter())?;
            table
        }
    };
    let table = slot.insert(table);
    if table.columns != columns {
        let source =
            std::io::Error::other("the scalars changed during the run; a table has the same columns in every row");
        return Err(SinkError::Io { path: table.path.clone(), source });
    }
    Ok(table)
}

impl Table {
    fn resume(dir: &Path, name: &str, at: Option<&Rows>) -> Result<Option<Self>, SinkError> {
        let path = dir.join(name);
        let io = |e| SinkError::io(&path, e);
        let Some(at) = at else {
            return match std::fs::remove_file(&path) {
                Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(io(e)),
                _ => Ok(None),
            };
        };
        let mut file = File::options().read(true).write(true).open(&path).map_err(io)?;
        let found = file.metadata().map_err(io)?.len();
        if found < at.bytes {
            return Err(SinkError::Torn { path, found, wanted: at.bytes });
        }
        file.set_len(at.bytes).map_err(io)?;
        let columns = csv::Reader::from_reader(&file).headers().map_err(|e| io(std::io::Error::other(e)))?.clone();
        file.seek(SeekFrom::End(0)).map_err(io)?;
        let columns = columns.iter().map(str::to_owned).collect();
        Ok(Some(Self { path, writer: csv::Writer::from_writer(BufWriter::new(file)), columns }))
    }

    fn sync(&mut self) -> Result<Rows, SinkError> {
        self.flush()?;
        let file = self.writer.get_ref().get_ref();
        let bytes = file.sync_data().and_then(|()| file.metadata()).map_err(|e| SinkError::io(&self.path, e))?.len();
        let name = self.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Rows { name, bytes })
    }

    fn row<T: AsRef<[u8]>>(&mut self, fields: impl Iterator<Item = T>) -> Result<(), SinkError> {
        self.writer.write_record(fields).map_err(|e| match e.into_kind() {
            csv::ErrorKind::Io(e) => SinkError::io(&self.path, e),
            kind => SinkError::Io { path: self.path.clone(), source: std::io::Error::other(format!("{kind:?}")) },
        })
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        self.writer
            .flush()
            .and_then(|()| self.writer.get_ref().get_ref().flush())
            .map_err(|e| SinkError::io(&self.path, e))
    }
}
