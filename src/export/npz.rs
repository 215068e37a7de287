//! NumPy's archive: every column of every kind as one array, frames x rows x components.

use super::{ExportError, Exported, Selection};
use crate::recording::{Choice, Series};
use crate::wire::{Column, Kind, Scalars, Snapshot};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// An array being collected.
struct Array {
    key: String,
    unit: String,
    /// NumPy's name of the type.
    dtype: String,
    /// Shape of one frame.
    shape: Vec<usize>,
    /// Whether it has a first axis of frames.
    frames: Option<usize>,
    bytes: Vec<u8>,
}

/// Writes the kinds of `recording` into the new file `out`. Arrays are named as in `squirmers.position`, `scalars.temperature` and
/// `fields.step`; `units` lists names and units. Everything is held in memory until the end.
///
/// # Errors
/// If the recording cannot be read or has none of the kinds there, if an array exceeds 4 GB, or `out` exists or cannot be written.
pub fn npz(recording: &Path, selection: Selection, kinds: &[Kind], out: &Path) -> Result<Exported, ExportError> {
    let mut series = Series::open(recording, kinds)?;
    let mut choice = Choice::new(selection.range());
    let mut arrays: Vec<Array> = Vec::new();
    let (mut done, mut last) = (Exported { path: out.into(), ..Exported::default() }, None);
    while let Some(bytes) = series.next_message()? {
        let snapshot = Snapshot::parse(&bytes)?;
        last = Some(snapshot.header.step);
        if choice.takes(snapshot.kind(), &snapshot.header) {
            take(&snapshot, &mut arrays)?;
            let (rows, population) = (snapshot.header.rows, snapshot.header.population);
            (done.snapshots, done.step) = (done.snapshots + 1, snapshot.header.step);
            (done.rows, done.population) = (done.rows + rows, done.population + population);
        }
    }
    if arrays.is_empty() {
        return Err(ExportError::absent(recording, kinds, selection, last));
    }
    arrays.push(units(&arrays));
    archive(&arrays, out)?;
    done.warnings = series.finish().warnings;
    Ok(done)
}

/// Adds a snapshot to the arrays of its kind.
fn take(snapshot: &Snapshot<'_>, arrays: &mut Vec<Array>) -> Result<(), ExportError> {
    let kind = snapshot.kind();
    let key = |name: &str| format!("{}.{name}", kind.topic());
    let header = &snapshot.header;
    add(arrays, key("step"), "", "<u8", Vec::new(), &header.step.to_le_bytes())?;
    add(arrays, key("time"), "tau", "<f8", Vec::new(), &header.time.to_le_bytes())?;
    once(arrays, key("box"), "a", "<f8", vec![3], bytemuck::cast_slice(&header.box_size));
    if kind == Kind::Scalars {
        for scalar in Scalars::decode(snapshot)?.list {
            add(arrays, key(&scalar.name), &scalar.unit, "<f8", Vec::new(), &scalar.value.to_le_bytes())?;
        }
        return Ok(());
    }
    if kind == Kind::Fields {
        let blocks: Vec<u8> = header.blocks.iter().chain([&header.block]).flat_map(|n| n.to_le_bytes()).collect();
        once(arrays, key("blocks"), "", "<u4", vec![4], &blocks);
    }
    for column in snapshot.columns() {
        let (dtype, components, bytes) = values(snapshot, column)?;
        let shape = [&[column.rows as usize][..], &components].concat();
        if column.name().starts_with("species.") {
            once(arrays, key(column.name()), column.unit(), &dtype, shape, &bytes);
        } else {
            add(arrays, key(column.name()), column.unit(), &dtype, shape, &bytes)?;
        }
    }
    Ok(())
}

/// Type, further axes and bytes of a column; rows of bytes are texts.
fn values(snapshot: &Snapshot<'_>, column: &Column) -> Result<(String, Vec<usize>, Vec<u8>), ExportError> {
    let (name, width) = (column.name(), column.components);
    let axes = if width == 1 { Vec::new() } else { vec![width as usize] };
    Ok(match column.element {
        1 => (format!("|S{width}"), Vec::new(), snapshot.flat::<u8>(name, width)?.into_owned()),
        2 => ("<u4".into(), axes, bytemuck::cast_slice(&snapshot.flat::<u32>(name, width)?).to_vec()),
        3 => ("<f4".into(), axes, bytemuck::cast_slice(&snapshot.flat::<f32>(name, width)?).to_vec()),
        _ => ("<f8".into(), axes, bytemuck::cast_slice(&snapshot.flat::<f64>(name, width)?).to_vec()),
    })
}

/// Appends a frame to an array.
fn add(
    arrays: &mut Vec<Array>,
    key: String,
    unit: &str,
    dtype: &str,
    shape: Vec<usize>,
    bytes: &[u8],
) -> Result<(), ExportError> {
    if let Some(array) = arrays.iter_mut().find(|a| a.key == key) {
        if array.shape != shape || array.dtype != dtype {
            return Err(ExportError::Unfit(format!(
                "{key} has {shape:?} values in one snapshot and {:?} in another: an array cannot hold both; export a range",
                array.shape
            )));
        }
        array.frames = array.frames.map(|n| n + 1);
        array.bytes.extend_from_slice(bytes);
        return Ok(());
    }
    let (unit, dtype) = (unit.into(), dtype.into());
    arrays.push(Array { key, unit, dtype, shape, frames: Some(1), bytes: bytes.to_vec() });
    Ok(())
}

/// Keeps what is the same in all frames as it was in the first.
fn once(arrays: &mut Vec<Array>, key: String, unit: &str, dtype: &str, shape: Vec<usize>, bytes: &[u8]) {
    if !arrays.iter().any(|a| a.key == key) {
        let (unit, dtype) = (unit.into(), dtype.into());
        arrays.push(Array { key, unit, dtype, shape, frames: None, bytes: bytes.to_vec() });
    }
}

/// Names and units of all arrays, as an array of texts.
fn units(arrays: &[Array]) -> Array {
    let width = arrays.iter().map(|a| a.key.len().max(a.unit.len())).max().unwrap_or(1);
    let padded = |text: &str| text.bytes().chain(std::iter::repeat(0)).take(width).collect::<Vec<u8>>();
    let bytes = arrays.iter().flat_map(|a| [padded(&a.key), padded(&a.unit)]).flatten().collect();
    let (dtype, shape) = (format!("|S{width}"), vec![arrays.len(), 2]);
    Array { key: "units".into(), unit: String::new(), dtype, shape, frames: None, bytes }
}

impl Array {
    /// The head of the NPY format, version 1 (numpy.lib.format): its length is a multiple of 64.
    fn head(&self) -> Vec<u8> {
        let axes: Vec<String> = self.frames.iter().chain(&self.shape).map(|n| format!("{n},")).collect();
        let mut text = format!("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", self.dtype, axes.concat());
        while !(10 + text.len() + 1).is_multiple_of(64) {
            text.push(' ');
        }
        text.push('\n');
        #[allow(clippy::cast_possible_truncation)]
        let length = (text.len() as u16).to_le_bytes();
        [&b"\x93NUMPY\x01\x00"[..], &length, text.as_bytes()].concat()
    }
}

/// A ZIP archive of stored members (PKWARE APPNOTE 4.3), which is what NumPy reads.
fn archive(arrays: &[Array], out: &Path) -> Result<(), ExportError> {
    let io = ExportError::io(out);
    let total: u64 = arrays.iter().map(|a| a.bytes.len() as u64 + 1024).sum();
    if total >= u64::from(u32::MAX) {
        let gb = total as f64 * 1e-9;
        return Err(ExportError::Unfit(format!(
            "{gb:.1} GB do not fit into one archive: take a range, --every, or --topic"
        )));
    }
    let mut file = BufWriter::new(File::create_new(out).map_err(&io)?);
    let (mut directory, mut at) = (Vec::new(), 0u32);
    let mut write = |bytes: &[u8], at: &mut u32| {
        #[allow(clippy::cast_possible_truncation)]
        let length = bytes.len() as u32;
        *at += length;
        file.write_all(bytes)
    };
    for array in arrays {
        let (head, name) = (array.head(), format!("{}.npy", array.key));
        let mut crc = crc32fast::Hasher::new();
        crc.update(&head);
        crc.update(&array.bytes);
        #[allow(clippy::cast_possible_truncation)]
        let (size, length) = ((head.len() + array.bytes.len()) as u32, name.len() as u16);
        // Version 2.0, no flags, stored, 1 January 1980; then checksum, both sizes, lengths of name and extra field.
        let mut common = [20u16, 0, 0, 0, 33].map(u16::to_le_bytes).concat();
        common.extend([crc.finalize(), size, size].map(u32::to_le_bytes).concat());
        common.extend([length, 0].map(u16::to_le_bytes).concat());
        directory.extend([&b"PK\x01\x02\x14\x00"[..], &common, &[0; 10], &at.to_le_bytes(), name.as_bytes()].concat());
        for bytes in [&b"PK\x03\x04"[..], &common, name.as_bytes(), &head, &array.bytes] {
            write(bytes, &mut at).map_err(&io)?;
        }
    }
    #[allow(clippy::cast_possible_truncation)]
    let (count, length, begin) = (arrays.len() as u16, directory.len() as u32, at);
    let end = [
        &b"PK\x05\x06\0\0\0\0"[..],
        &[count, count].map(u16::to_le_bytes).concat(),
        &[length, begin].map(u32::to_le_bytes).concat(),
        &[0, 0],
    ]
    .concat();
    write(&directory, &mut at).and_then(|()| write(&end, &mut at)).map_err(&io)?;
    file.flush().map_err(&io)
}
