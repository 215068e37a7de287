//! Building a snapshot message: columns in, bytes out.

use super::{Column, Element, Header, Kind, Stamp};

/// Collects columns, then lays them out behind the header and the column table.
#[derive(Debug)]
pub struct Encoder {
    header: Header,
    columns: Vec<Column>,
    values: Vec<u8>,
}

impl Encoder {
    /// An empty message.
    #[must_use]
    pub fn new(kind: Kind, stamp: &Stamp) -> Self {
        Self { header: Header { fraction: 1.0, ..Header::new(kind, stamp) }, columns: Vec::new(), values: Vec::new() }
    }

    /// The header, for the fields that one kind alone has.
    pub fn header_mut(&mut self) -> &mut Header {
        &mut self.header
    }

    /// Says how many rows the message has, of how many that there are.
    #[must_use]
    pub fn rows(mut self, rows: usize, population: u64) -> Self {
        self.header.rows = rows as u64;
        self.header.population = population;
        self
    }

    /// Appends a column whose rows are `N` elements each.
    #[must_use]
    pub fn column<T: Element, const N: usize>(self, name: &str, unit: &str, rows: &[[T; N]]) -> Self {
        self.flat(name, unit, N, rows.as_flattened())
    }

    /// Appends a column of values in row order, `components` to a row.
    #[must_use]
    pub fn flat<T: Element>(mut self, name: &str, unit: &str, components: usize, values: &[T]) -> Self {
        #[allow(clippy::cast_possible_truncation)]
        let width = components as u32;
        let (offset, rows) = (self.values.len() as u64, (values.len() / components.max(1)) as u64);
        self.columns.push(Column::new(name, unit, T::NUMBER, width, offset, rows));
        self.values.extend_from_slice(bytemuck::cast_slice(values));
        self.values.resize(self.values.len().next_multiple_of(8), 0);
        self
    }

    /// The message.
    #[must_use]
    pub fn finish(mut self) -> Vec<u8> {
        let (head, table) = (size_of::<Header>(), size_of::<Column>() * self.columns.len());
        for column in &mut self.columns {
            column.offset += (head + table) as u64;
        }
        let bytes = (head + table + self.values.len()).next_multiple_of(16);
        #[allow(clippy::cast_possible_truncation)]
        {
            self.header.columns = self.columns.len() as u32;
            self.header.table = head as u32;
        }
        self.header.bytes = bytes as u64;
        self.header.checksum = self.header.checksum_with(bytemuck::cast_slice(&self.columns));
        let mut message = Vec::with_capacity(bytes);
        message.extend_from_slice(bytemuck::bytes_of(&self.header));
        message.extend_from_slice(bytemuck::cast_slice(&self.columns));
        message.append(&mut self.values);
        message.resize(bytes, 0);
        message
    }
}

/// Length of a message with columns of so many bytes a row and so many rows: what to announce when a topic is opened.
pub(super) fn message_bytes(columns: &[(usize, usize)]) -> usize {
    let values: usize = columns.iter().map(|(width, rows)| (width * rows).next_multiple_of(8)).sum();
    (size_of::<Header>() + size_of::<Column>() * columns.len() + values).next_multiple_of(16)
}
