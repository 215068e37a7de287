//! Reading a snapshot message: nothing is trusted, nothing is copied unless its alignment asks for it.

use super::{Column, Header, Kind, MAGIC, VERSION, WireError};
use bytemuck::Pod;
use std::borrow::Cow;

/// A type that columns may hold.
pub trait Element: Pod + private::Sealed {
    /// Its number in the column table.
    const NUMBER: u32;
    /// Its name in messages.
    const NAME: &'static str;
}

mod private {
    pub trait Sealed {}
}

macro_rules! element {
    ($($type:ident = $number:literal),*) => {$(
        impl private::Sealed for $type {}
        impl Element for $type {
            const NUMBER: u32 = $number;
            const NAME: &'static str = stringify!($type);
        }
    )*};
}
element!(u8 = 1, u32 = 2, f32 = 3, f64 = 4);

/// Bytes and name of the element type with this number.
fn element(number: u32) -> Option<(u64, &'static str)> {
    [(1, "u8"), (4, "u32"), (4, "f32"), (8, "f64")].get(number.checked_sub(1)? as usize).copied()
}

/// A checked message.
#[derive(Debug, Clone)]
pub struct Snapshot<'a> {
    /// The header.
    pub header: Header,
    kind: Kind,
    columns: Vec<Column>,
    bytes: &'a [u8],
}

impl<'a> Snapshot<'a> {
    /// Checks everything but the columns' values. `bytes` may have any alignment and may be longer than the message.
    ///
    /// # Errors
    /// For whatever was not written by an [`Encoder`](super::Encoder) of this version.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, WireError> {
        let truncated = |need| WireError::Truncated { have: bytes.len(), need };
        let head = bytes.get(..size_of::<Header>()).ok_or(truncated(size_of::<Header>() as u64))?;
        let header: Header = bytemuck::pod_read_unaligned(head);
        if header.magic != MAGIC {
            return Err(WireError::Magic(header.magic));
        }
        if header.version != VERSION {
            return Err(WireError::Version(header.version));
        }
        let length = usize::try_from(header.bytes).ok().filter(|n| *n <= bytes.len()).ok_or(truncated(header.bytes))?;
        let bytes = &bytes[..length];
        let start = header.table as usize;
        let table = (header.columns as usize)
            .checked_mul(size_of::<Column>())
            .and_then(|n| start.checked_add(n))
            .filter(|_| start >= size_of::<Header>())
            .and_then(|end| bytes.get(start..end))
            .ok_or_else(|| WireError::Malformed("the column table lies outside the message".into()))?;
        let computed = header.checksum_with(table);
        if computed != header.checksum {
            return Err(WireError::Checksum { stored: header.checksum, computed });
        }
        let kind = header.kind()?;
        let columns: Vec<Column> = table.chunks_exact(size_of::<Column>()).map(bytemuck::pod_read_unaligned).collect();
        columns.iter().try_for_each(|c| check(c, length as u64))?;
        Ok(Self { header, kind, columns, bytes })
    }

    /// What the message holds.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The column table.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// All bytes of the message.
    #[must_use]
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The values of a column in row order; borrowed where their alignment allows.
    ///
    /// # Errors
    /// If there is no such column, or it has another type or number of components.
    pub fn flat<T: Element>(&self, name: &str, components: u32) -> Result<Cow<'a, [T]>, WireError> {
        let column = self.columns.iter().find(|c| c.name() == name);
        let column = column.ok_or_else(|| WireError::NoColumn { kind: self.kind.topic(), name: name.into() })?;
        if (column.element, column.components) != (T::NUMBER, components) {
            let found = element(column.element).map_or("?", |e| e.1);
            return Err(WireError::Type {
                name: name.into(),
                found: format!("{} x {found}", column.components),
                wanted: format!("{components} x {}", T::NAME),
            });
        }
        // `parse` has checked that offset and length lie inside the message.
        #[allow(clippy::cast_possible_truncation)]
        let (offset, rows) = (column.offset as usize, column.rows as usize);
        let values = &self.bytes[offset..offset + rows * components as usize * size_of::<T>()];
        Ok(match bytemuck::try_cast_slice(values) {
            Ok(aligned) => Cow::Borrowed(aligned),
            Err(_) => Cow::Owned(values.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect()),
        })
    }

    /// The rows of a column.
    ///
    /// # Errors
    /// As for [`Snapshot::flat`].
    pub fn rows<T: Element, const N: usize>(&self, name: &str) -> Result<Vec<[T; N]>, WireError> {
        #[allow(clippy::cast_possible_truncation)]
        Ok(self.flat::<T>(name, N as u32)?.as_chunks::<N>().0.to_vec())
    }

    /// The rows of a column with one component.
    ///
    /// # Errors
    /// As for [`Snapshot::flat`].
    pub fn values<T: Element>(&self, name: &str) -> Result<Vec<T>, WireError> {
        self.flat(name, 1).map(Cow::into_owned)
    }

    /// A column of zero-padded texts of `N` bytes.
    ///
    /// # Errors
    /// As for [`Snapshot::flat`].
    pub fn texts<const N: usize>(&self, name: &str) -> Result<Vec<String>, WireError> {
        Ok(self.rows::<u8, N>(name)?.iter().map(|t| super::header::text(t).to_owned()).collect())
    }

    /// Refuses a message of another kind.
    ///
    /// # Errors
    /// If the message is not of kind `wanted`.
    pub fn expect(&self, wanted: Kind) -> Result<(), WireError> {
        if self.kind == wanted {
            return Ok(());
        }
        Err(WireError::Kind { found: self.kind.topic(), wanted: wanted.topic() })
    }
}

/// A column's values lie inside the message, aligned to 8 bytes.
fn check(column: &Column, length: u64) -> Result<(), WireError> {
    let malformed = |what: &str| WireError::Malformed(format!("column `{}` {what}", column.name()));
    let (size, _) = element(column.element).ok_or_else(|| malformed("has an unknown element type"))?;
    if column.components == 0 || !column.offset.is_multiple_of(8) {
        return Err(malformed("has no components, or is not aligned to 8 bytes"));
    }
    let end = (u64::from(column.components) * size).checked_mul(column.rows).and_then(|n| column.offset.checked_add(n));
    match end {
        Some(end) if end <= length => Ok(()),
        _ => Err(malformed("lies outside the message")),
    }
}
