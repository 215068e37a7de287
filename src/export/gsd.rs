//! GSD in HOOMD's schema, for OVITO, HOOMD-blue and freud: squirmers as ellipsoids, scalars as logged quantities.

use super::gsd_file::GsdFile;
use super::moments::{Moment, Moments};
use super::{ExportError, Exported, Selection};
use crate::wire::{Kind, Squirmers};
use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::Path;

/// Writes the squirmers and scalars of `recording` into the new file `out`.
///
/// HOOMD's box is centred on the origin, so positions are shifted by half of the box; its quaternions are (w, x, y, z). Mass is
/// not recorded and remains HOOMD's default.
///
/// # Errors
/// If the recording cannot be read or has no squirmers there, or `out` exists or cannot be written.
pub fn gsd(recording: &Path, selection: Selection, out: &Path) -> Result<Exported, ExportError> {
    let mut moments = Moments::open(recording, &[Kind::Squirmers, Kind::Scalars], selection.range())?;
    let io = ExportError::io(out);
    let mut file = None;
    let mut done = Exported { path: out.into(), ..Exported::default() };
    while let Some(moment) = moments.next_moment()? {
        let Some(squirmers) = &moment.squirmers else { continue };
        let file = match &mut file {
            Some(file) => file,
            slot => {
                let sink = BufWriter::new(File::create_new(out).map_err(&io)?);
                slot.insert(GsdFile::create(sink).map_err(&io)?)
            }
        };
        frame(file, &moment, squirmers, done.snapshots == 0).map_err(&io)?;
        file.end_frame();
        let count = squirmers.id.len() as u64;
        done = Exported {
            snapshots: done.snapshots + 1,
            rows: count,
            population: count,
            step: moment.header.step,
            ..done
        };
    }
    let Some(file) = file else {
        return Err(ExportError::absent(recording, &[Kind::Squirmers], selection, moments.last));
    };
    file.finish(concat!("squirm ", env!("CARGO_PKG_VERSION")), "hoomd", (1, 4)).map_err(&io)?;
    done.warnings = moments.finish();
    Ok(done)
}

/// One frame. What does not change stands in the first frame only: readers look there for what another lacks.
fn frame<W: Write + Seek>(file: &mut GsdFile<W>, moment: &Moment, s: &Squirmers, first: bool) -> std::io::Result<()> {
    let size = moment.header.box_size;
    let count = u32::try_from(s.id.len()).unwrap_or(u32::MAX);
    file.chunk("configuration/step", 1, &[moment.header.step])?;
    file.chunk("log/time", 1, &[moment.header.time])?;
    if first {
        file.chunk("configuration/dimensions", 1, &[3u8])?;
        file.chunk("configuration/box", 1, &[size[0] as f32, size[1] as f32, size[2] as f32, 0.0, 0.0, 0.0])?;
        let names: Vec<String> = s.table.iter().map(|t| t.name.clone()).collect();
        strings(file, "particles/types", &names)?;
        let shape = |t: &crate::wire::SpeciesRow| {
            serde_json::json!({"type": "Ellipsoid", "a": t.across, "b": t.across, "c": t.along}).to_string()
        };
        strings(file, "particles/type_shapes", &s.table.iter().map(shape).collect::<Vec<_>>())?;
        file.chunk("particles/typeid", 1, &s.species)?;
        // Of the sphere with the same volume, for tools that draw nothing else.
        let diameter = |t: &u32| {
            let t = &s.table[*t as usize];
            2.0 * (t.along * t.across * t.across).cbrt() as f32
        };
        file.chunk("particles/diameter", 1, &s.species.iter().map(diameter).collect::<Vec<_>>())?;
    }
    file.chunk("particles/N", 1, &[count])?;
    let centred = |p: &[f32; 3]| -> [f32; 3] { std::array::from_fn(|k| (f64::from(p[k]) - 0.5 * size[k]) as f32) };
    let position: Vec<[f32; 3]> = s.position.iter().map(centred).collect();
    file.chunk("particles/position", 3, position.as_flattened())?;
    let orientation: Vec<[f32; 4]> = s.orientation.iter().map(|[x, y, z, w]| [*w, *x, *y, *z]).collect();
    file.chunk("particles/orientation", 4, orientation.as_flattened())?;
    file.chunk("particles/velocity", 3, s.velocity.as_flattened())?;
    let turns = |i: usize| -> [i32; 3] {
        std::array::from_fn(|k| ((s.unwrapped[i][k] - f64::from(s.position[i][k])) / size[k]).round() as i32)
    };
    let image: Vec<[i32; 3]> = (0..s.id.len()).map(turns).collect();
    file.chunk("particles/image", 3, image.as_flattened())?;
    for (name, column) in [("angular_velocity", &s.angular_velocity), ("force", &s.force), ("torque", &s.torque)] {
        file.chunk(&format!("log/particles/{name}"), 3, column.as_flattened())?;
    }
    file.chunk("log/particles/id", 1, &s.id)?;
    for scalar in moment.scalars.iter().flat_map(|s| &s.list) {
        file.chunk(&format!("log/{}", scalar.name), 1, &[scalar.value])?;
    }
    Ok(())
}

/// Texts as rows of equal length.
fn strings<W: Write + Seek>(file: &mut GsdFile<W>, name: &str, texts: &[String]) -> std::io::Result<()> {
    let width = texts.iter().map(String::len).max().unwrap_or(0) + 1;
    let rows = texts.iter().flat_map(|t| t.bytes().chain(std::iter::repeat(0)).take(width));
    file.chunk(name, width, &rows.map(u8::cast_signed).collect::<Vec<i8>>())
}
