//! The fixed head of every snapshot message and the entries of its column table.

use super::{Kind, Stamp, WireError};
use bytemuck::{Pod, Zeroable};

/// The first eight bytes of every message: a high bit and both line ends reveal transfers that are not binary-clean.
pub const MAGIC: [u8; 8] = *b"\x89SQRM\r\n\x1a";
/// Version of the layout; raised when a reader of the old one would misread the new one.
pub const VERSION: u32 = 1;
/// Bit of [`Header::flags`]: walls at y = 0 and y = L.
pub const FLAG_WALLS_Y: u32 = 1;

/// The header: 160 bytes, no padding.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Header {
    /// [`MAGIC`].
    pub magic: [u8; 8],
    /// [`VERSION`].
    pub version: u32,
    /// Number of the [`Kind`].
    pub kind: u32,
    /// Identity of the run.
    pub run_id: [u8; 16],
    /// Steps done.
    pub step: u64,
    /// Simulated time in tau.
    pub time: f64,
    /// Count of snapshots of this kind before this one.
    pub seq: u64,
    /// Length of the message, header and padding included; a multiple of 16.
    pub bytes: u64,
    /// Squirmers, scalars, blocks or particles in the message.
    pub rows: u64,
    /// How many there are in all; more than `rows` where only a share is sent.
    pub population: u64,
    /// Edges of the box in a.
    pub box_size: [f64; 3],
    /// Share of the population that was asked for.
    pub fraction: f64,
    /// Steps between two snapshots of this kind; 0 if not fixed.
    pub every: u64,
    /// Bits: [`FLAG_WALLS_Y`].
    pub flags: u32,
    /// Entries of the column table.
    pub columns: u32,
    /// Where the column table begins.
    pub table: u32,
    /// Edge of a block in a (fields), else 0.
    pub block: u32,
    /// Blocks along x, y and z (fields), else 0.
    pub blocks: [u32; 3],
    /// Always 0.
    pub reserved: [u32; 2],
    /// CRC-32 (IEEE 802.3) of the header before this field, followed by the column table.
    pub checksum: u32,
}

const _: () = assert!(size_of::<Header>() == 160);

impl Default for Header {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl Header {
    /// A header of this kind and time; lengths and checksum are the encoder's.
    #[must_use]
    pub fn new(kind: Kind, stamp: &Stamp) -> Self {
        Self {
            magic: MAGIC,
            version: VERSION,
            kind: kind as u32,
            run_id: stamp.run_id,
            step: stamp.step,
            time: stamp.time,
            seq: stamp.seq,
            box_size: stamp.box_size,
            flags: if stamp.walls { FLAG_WALLS_Y } else { 0 },
            every: stamp.every,
            ..Self::zeroed()
        }
    }

    /// When and where the snapshot was taken.
    #[must_use]
    pub fn stamp(&self) -> Stamp {
        Stamp {
            run_id: self.run_id,
            step: self.step,
            time: self.time,
            seq: self.seq,
            every: self.every,
            box_size: self.box_size,
            walls: self.flags & FLAG_WALLS_Y != 0,
        }
    }

    /// The kind; known for every header that came through [`Snapshot::parse`](super::Snapshot::parse).
    ///
    /// # Errors
    /// If the number is not a kind's.
    pub fn kind(&self) -> Result<Kind, WireError> {
        Kind::from_number(self.kind).ok_or_else(|| WireError::Malformed(format!("unknown kind {}", self.kind)))
    }

    /// The checksum that belongs to this header and this column table.
    #[must_use]
    pub fn checksum_with(&self, table: &[u8]) -> u32 {
        let mut crc = crc32fast::Hasher::new();
        crc.update(&bytemuck::bytes_of(self)[..size_of::<Self>() - 4]);
        crc.update(table);
        crc.finalize()
    }
}

/// One entry of the column table: 64 bytes, no padding.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Column {
    name: [u8; 24],
    unit: [u8; 16],
    /// Number of the element type: 1 u8, 2 u32, 3 f32, 4 f64.
    pub element: u32,
    /// Elements in one row.
    pub components: u32,
    /// Where the values begin in the message; a multiple of 8.
    pub offset: u64,
    /// Rows.
    pub rows: u64,
}

const _: () = assert!(size_of::<Column>() == 64);

impl Column {
    /// An entry; `name` and `unit` are cut to the bytes they have.
    #[must_use]
    pub fn new(name: &str, unit: &str, element: u32, components: u32, offset: u64, rows: u64) -> Self {
        Self { name: padded(name), unit: padded(unit), element, components, offset, rows }
    }

    /// What the column is called.
    #[must_use]
    pub fn name(&self) -> &str {
        text(&self.name)
    }

    /// Unit of its values; empty for pure numbers.
    #[must_use]
    pub fn unit(&self) -> &str {
        text(&self.unit)
    }
}

/// `text` in `N` bytes, filled up with zeros, cut at a character's boundary.
pub(super) fn padded<const N: usize>(text: &str) -> [u8; N] {
    let cut = (0..=text.len().min(N)).rev().find(|n| text.is_char_boundary(*n)).unwrap_or(0);
    let mut bytes = [0; N];
    bytes[..cut].copy_from_slice(&text.as_bytes()[..cut]);
    bytes
}

/// The text before the zeros; empty if it is not UTF-8.
pub(super) fn text(bytes: &[u8]) -> &str {
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    std::str::from_utf8(&bytes[..end]).unwrap_or("")
}
