//! Extended XYZ, with the names of columns that OVITO and ASE know: squirmers as ellipsoids.

use super::moments::{Moment, Moments};
use super::{ExportError, Exported, Selection};
use crate::wire::{FLAG_WALLS_Y, Kind, Squirmers};
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Columns behind the species; the orientation is a quaternion x, y, z, w, `aspherical_shape` the semi-axes in the body's frame.
/// `Z` is 0: ASE, which knows chemical elements only, would not read the names of species otherwise.
const COLUMNS: &str = "species:S:1:pos:R:3:velo:R:3:orientation:R:4:aspherical_shape:R:3:omega:R:3:id:I:1:Z:I:1";

/// Writes the squirmers and scalars of `recording` into the new file `out`.
///
/// # Errors
/// If the recording cannot be read or has no squirmers there, or `out` exists or cannot be written.
pub fn xyz(recording: &Path, selection: Selection, out: &Path) -> Result<Exported, ExportError> {
    let mut moments = Moments::open(recording, &[Kind::Squirmers, Kind::Scalars], selection.range())?;
    let io = ExportError::io(out);
    let mut file = None;
    let mut done = Exported { path: out.into(), ..Exported::default() };
    while let Some(moment) = moments.next_moment()? {
        let Some(squirmers) = &moment.squirmers else { continue };
        let file = match &mut file {
            Some(file) => file,
            slot => slot.insert(BufWriter::new(File::create_new(out).map_err(&io)?)),
        };
        file.write_all(frame(&moment, squirmers).as_bytes()).map_err(&io)?;
        let count = squirmers.id.len() as u64;
        done = Exported {
            snapshots: done.snapshots + 1,
            rows: count,
            population: count,
            step: moment.header.step,
            ..done
        };
    }
    let Some(mut file) = file else {
        return Err(ExportError::absent(recording, &[Kind::Squirmers], selection, moments.last));
    };
    file.flush().map_err(&io)?;
    done.warnings = moments.finish();
    Ok(done)
}

/// Letters, digits and underscores: other characters end a word or a key.
fn word(text: &str) -> String {
    let kept = |c: char| if c.is_alphanumeric() || "_-+.".contains(c) { c } else { '_' };
    text.chars().map(kept).collect()
}

/// One frame; writing into a `String` cannot fail.
fn frame(moment: &Moment, s: &Squirmers) -> String {
    let header = &moment.header;
    let [x, y, z] = header.box_size;
    let walls = if header.flags & FLAG_WALLS_Y != 0 { "T F T" } else { "T T T" };
    let mut text = format!("{}\nLattice=\"{x} 0 0 0 {y} 0 0 0 {z}\" Origin=\"0 0 0\" Properties={COLUMNS}", s.id.len());
    let _ = write!(text, " pbc=\"{walls}\" Step={} Time={}", header.step, header.time);
    for scalar in moment.scalars.iter().flat_map(|s| &s.list) {
        let _ = write!(text, " {}={}", word(&scalar.name), scalar.value);
    }
    text.push('\n');
    for i in 0..s.id.len() {
        let species = &s.table[s.species[i] as usize];
        text.push_str(&word(&species.name));
        let shape = [species.across, species.across, species.along];
        let numbers = s.position[i].iter().chain(&s.velocity[i]).chain(&s.orientation[i]).map(f32::to_string);
        let numbers =
            numbers.chain(shape.iter().map(f64::to_string)).chain(s.angular_velocity[i].iter().map(f32::to_string));
        numbers.for_each(|number| {
            let _ = write!(text, " {number}");
        });
        let _ = writeln!(text, " {} 0", s.id[i]);
    }
    text
}
