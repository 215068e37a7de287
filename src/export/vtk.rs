//! VTK's XML files for ParaView: fields as images, squirmers as points, and a list of times for each.

use super::moments::{Moment, Moments};
use super::{ExportError, Exported, Selection};
use crate::wire::{Fields, Kind, Squirmers};
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes `fields.STEP.vti` and `squirmers.STEP.vtp` for every moment into the folder `out`, and `fields.pvd` and `squirmers.pvd`,
/// which list them with their times.
///
/// # Errors
/// If the recording cannot be read or has neither of them there, or a file exists or cannot be written.
pub fn vtk(recording: &Path, selection: Selection, kinds: &[Kind], out: &Path) -> Result<Vec<Exported>, ExportError> {
    let kinds: Vec<Kind> = kinds.iter().copied().filter(|k| [Kind::Fields, Kind::Squirmers].contains(k)).collect();
    let mut moments = Moments::open(recording, &kinds, selection.range())?;
    let mut lists: Vec<(Kind, String, Exported)> = Vec::new();
    while let Some(moment) = moments.next_moment()? {
        for kind in &kinds {
            let Some((ending, piece, rows)) = piece(*kind, &moment) else { continue };
            let step = moment.header.step;
            let name = format!("{}.{step:09}.{ending}", kind.topic());
            piece.write(&out.join(&name))?;
            let index = lists.iter().position(|l| l.0 == *kind).unwrap_or_else(|| {
                let path = out.join(format!("{}.pvd", kind.topic()));
                lists.push((*kind, String::new(), Exported { path, ..Exported::default() }));
                lists.len() - 1
            });
            let (_, list, done) = &mut lists[index];
            let _ = writeln!(list, "<DataSet timestep=\"{}\" part=\"0\" file=\"{name}\"/>", moment.header.time);
            (done.snapshots, done.rows, done.population, done.step) = (done.snapshots + 1, rows, rows, step);
        }
    }
    if lists.is_empty() {
        return Err(ExportError::absent(recording, &kinds, selection, moments.last));
    }
    let warnings = moments.finish();
    let mut done = Vec::new();
    for (_, list, mut exported) in lists {
        let text =
            format!("<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n{list}</Collection>\n</VTKFile>\n");
        let io = ExportError::io(&exported.path);
        File::create_new(&exported.path).and_then(|mut file| file.write_all(text.as_bytes())).map_err(io)?;
        if done.is_empty() {
            exported.warnings.clone_from(&warnings);
        }
        done.push(exported);
    }
    Ok(done)
}

/// The file of a kind at a moment: its ending, its content, and how many rows it has.
fn piece(kind: Kind, moment: &Moment) -> Option<(&'static str, Piece, u64)> {
    match kind {
        Kind::Fields => moment.fields.as_ref().map(|f| ("vti", image(f), f.density.len() as u64)),
        Kind::Squirmers => moment.squirmers.as_ref().map(|s| ("vtp", points(s), s.id.len() as u64)),
        _ => None,
    }
}

/// One file: text in which every array is named, and the arrays behind it.
#[derive(Default)]
struct Piece {
    head: String,
    data: Vec<u8>,
    tail: String,
}

impl Piece {
    /// An array in the appended data: its length as u64, then its numbers.
    fn array<T: bytemuck::Pod>(&mut self, name: &str, kind: &str, width: usize, values: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        let offset = self.data.len();
        let _ = writeln!(
            self.head,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{width}\" format=\"appended\" offset=\"{offset}\"/>"
        );
        self.data.extend_from_slice(&(bytes.len() as u64).to_le_bytes());
        self.data.extend_from_slice(bytes);
    }

    fn write(&self, path: &PathBuf) -> Result<(), ExportError> {
        let io = ExportError::io(path);
        let mut file = BufWriter::new(File::create_new(path).map_err(&io)?);
        let begin = format!("{}{}<AppendedData encoding=\"raw\">\n_", self.head, self.tail);
        let parts = [begin.as_bytes(), &self.data, b"\n</AppendedData>\n</VTKFile>\n"];
        parts.iter().try_for_each(|part| file.write_all(part)).and_then(|()| file.flush()).map_err(&io)
    }
}

/// Opens a file of this type.
fn opened(kind: &str) -> String {
    format!("<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n")
}

/// Blocks as cells of an image.
fn image(f: &Fields) -> Piece {
    let [nx, ny, nz] = f.blocks;
    let (extent, edge) = (format!("0 {nx} 0 {ny} 0 {nz}"), f.block);
    let mut piece = Piece { head: opened("ImageData"), ..Piece::default() };
    let _ =
        writeln!(piece.head, "<ImageData WholeExtent=\"{extent}\" Origin=\"0 0 0\" Spacing=\"{edge} {edge} {edge}\">");
    let _ = writeln!(piece.head, "<Piece Extent=\"{extent}\">\n<CellData Scalars=\"density\" Vectors=\"velocity\">");
    piece.array("density", "Float32", 1, &f.density);
    piece.array("velocity", "Float32", 3, f.velocity.as_flattened());
    piece.tail = "</CellData>\n</Piece>\n</ImageData>\n".into();
    piece
}

/// Squirmers as points with vectors: axis, velocity, and the semi-axes for glyphs.
fn points(s: &Squirmers) -> Piece {
    let n = s.id.len();
    let mut piece = Piece { head: opened("PolyData"), ..Piece::default() };
    let counts = format!(
        "NumberOfPoints=\"{n}\" NumberOfVerts=\"{n}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\""
    );
    let _ = writeln!(piece.head, "<PolyData>\n<Piece {counts}>\n<PointData Vectors=\"axis\">");
    piece.array("axis", "Float32", 3, s.axis.as_flattened());
    piece.array("velocity", "Float32", 3, s.velocity.as_flattened());
    piece.array("angular_velocity", "Float32", 3, s.angular_velocity.as_flattened());
    let quaternion: Vec<[f32; 4]> = s.orientation.iter().map(|[x, y, z, w]| [*w, *x, *y, *z]).collect();
    piece.array("quaternion_wxyz", "Float32", 4, quaternion.as_flattened());
    let shape = |t: &u32| {
        let t = &s.table[*t as usize];
        [t.across as f32, t.across as f32, t.along as f32]
    };
    piece.array("semi_axes", "Float32", 3, s.species.iter().map(shape).collect::<Vec<_>>().as_flattened());
    piece.array("id", "UInt32", 1, &s.id);
    piece.array("species", "UInt32", 1, &s.species);
    piece.head.push_str("</PointData>\n<Points>\n");
    piece.array("position", "Float32", 3, s.position.as_flattened());
    piece.head.push_str("</Points>\n<Verts>\n");
    let (places, ends): (Vec<i64>, Vec<i64>) = (0..n as i64).map(|i| (i, i + 1)).unzip();
    piece.array("connectivity", "Int64", 1, &places);
    piece.array("offsets", "Int64", 1, &ends);
    piece.tail = "</Verts>\n</Piece>\n</PolyData>\n".into();
    piece
}
