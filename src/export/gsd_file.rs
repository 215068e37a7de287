//! The file layer of GSD 2 (gsd.readthedocs.io): a header, chunks of data, an index of them, and a list of their names.

use std::collections::BTreeMap;
use std::io::{Seek, SeekFrom, Write};

/// First bytes of every file.
const MAGIC: u64 = 0x65DF_65DF_65DF_65DF;
/// Length of the header.
const HEADER: u64 = 256;
/// Room for one name, by which the length of the list is counted.
const NAME: usize = 64;

/// Numbers that a chunk may hold.
pub(super) trait Element: bytemuck::Pod {
    /// Its number in the index.
    const NUMBER: u8;
}

macro_rules! element {
    ($($type:ident = $number:literal),*) => {$(
        impl Element for $type {
            const NUMBER: u8 = $number;
        }
    )*};
}
element!(u8 = 1, u32 = 3, u64 = 4, i8 = 5, i32 = 7, f32 = 9, f64 = 10);

/// A chunk's place, as in the index.
struct Entry {
    frame: u64,
    rows: u64,
    at: u64,
    width: u32,
    name: u16,
    element: u8,
}

/// A file being written to `W`, frame by frame.
pub(super) struct GsdFile<W: Write + Seek> {
    sink: W,
    at: u64,
    frame: u64,
    entries: Vec<Entry>,
    names: BTreeMap<String, u16>,
    order: Vec<String>,
}

impl<W: Write + Seek> GsdFile<W> {
    /// Begins a file; its header is written last, since it says where the index is.
    pub fn create(mut sink: W) -> std::io::Result<Self> {
        sink.write_all(&[0; HEADER as usize])?;
        Ok(Self { sink, at: HEADER, frame: 0, entries: Vec::new(), names: BTreeMap::new(), order: Vec::new() })
    }

    /// Adds a chunk of rows of so many numbers to the present frame.
    pub fn chunk<T: Element>(&mut self, name: &str, width: usize, values: &[T]) -> std::io::Result<()> {
        let too_many = || std::io::Error::other("a GSD file has at most 65535 names");
        let id = match self.names.get(name) {
            Some(id) => *id,
            None => {
                let id = u16::try_from(self.order.len()).map_err(|_| too_many())?;
                self.names.insert(name.into(), id);
                self.order.push(name.into());
                id
            }
        };
        let bytes: &[u8] = bytemuck::cast_slice(values);
        self.sink.write_all(bytes)?;
        let (rows, width) = ((values.len() / width.max(1)) as u64, u32::try_from(width).map_err(|_| too_many())?);
        self.entries.push(Entry { frame: self.frame, rows, at: self.at, width, name: id, element: T::NUMBER });
        self.at += bytes.len() as u64;
        Ok(())
    }

    /// Ends the frame.
    pub fn end_frame(&mut self) {
        self.frame += 1;
    }

    /// Writes index, names and header.
    pub fn finish(mut self, application: &str, schema: &str, version: (u32, u32)) -> std::io::Result<W> {
        let index_at = self.at;
        // Readers search it by frame and name.
        self.entries.sort_by_key(|e| (e.frame, e.name));
        for e in &self.entries {
            let words = [e.frame, e.rows, e.at].map(u64::to_le_bytes).concat();
            self.sink.write_all(&words)?;
            self.sink.write_all(&[&e.width.to_le_bytes()[..], &e.name.to_le_bytes(), &[e.element, 0]].concat())?;
        }
        let names_at = index_at + 32 * self.entries.len() as u64;
        let mut names: Vec<u8> = self.order.iter().flat_map(|n| n.bytes().chain([0])).collect();
        // One zero more marks the end.
        let rooms = (names.len() + 1).div_ceil(NAME);
        names.resize(rooms * NAME, 0);
        self.sink.write_all(&names)?;
        self.sink.seek(SeekFrom::Start(0))?;
        let numbers = [MAGIC, index_at, self.entries.len() as u64, names_at, rooms as u64].map(u64::to_le_bytes);
        let versions = [version.0 << 16 | version.1, 2 << 16].map(u32::to_le_bytes);
        let text = |text: &str| {
            let mut bytes = text.as_bytes()[..text.len().min(NAME - 1)].to_vec();
            bytes.resize(NAME, 0);
            bytes
        };
        let header = [numbers.concat(), versions.concat(), text(application), text(schema), vec![0; 80]].concat();
        self.sink.write_all(&header)?;
        self.sink.flush()?;
        Ok(self.sink)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_in_the_header_and_index_lead_to_the_data() {
        let mut file = GsdFile::create(std::io::Cursor::new(Vec::new())).unwrap();
        file.chunk("b", 2, &[1.0f32, 2.0, 3.0, 4.0]).unwrap();
        file.end_frame();
        file.chunk("a", 1, &[7u64]).unwrap();
        file.chunk("b", 2, &[5.0f32, 6.0]).unwrap();
        let bytes = file.finish("test", "hoomd", (1, 4)).unwrap().into_inner();
        let u64_at = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        let (index, count, names, rooms) = (u64_at(8) as usize, u64_at(16), u64_at(24) as usize, u64_at(32));
        assert_eq!((count, index, names, rooms), (3, 256 + 16 + 8 + 8, index + 96, 1));
        assert_eq!((bytes.len(), &bytes[names..names + 5]), (names + 64, &b"b\0a\0\0"[..]));
        // Frame 1: `b` has the smaller number, so it comes first although it was written last.
        let entry = index + 32;
        assert_eq!((u64_at(entry), u64_at(entry + 8), u64_at(entry + 16)), (1, 1, 256 + 24));
        assert_eq!(bytes[entry + 24..entry + 32], [2, 0, 0, 0, 0, 0, 9, 0]);
        assert_eq!(&bytes[40..48], &[4, 0, 1, 0, 0, 0, 2, 0]);
    }
}
