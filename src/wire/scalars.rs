//! The `scalars` message: named numbers about the whole system.

use super::encode::message_bytes;
use super::header::padded;
use super::{Encoder, Kind, Snapshot, Stamp, WireError};

/// One named number.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scalar {
    /// Name, at most 32 bytes.
    pub name: String,
    /// Unit, at most 16 bytes; empty for a pure number.
    pub unit: String,
    /// Value.
    pub value: f64,
}

/// Numbers of one moment.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scalars {
    /// In the order in which they were added.
    pub list: Vec<Scalar>,
}

impl Scalars {
    /// Appends a number.
    pub fn push(&mut self, name: &str, unit: &str, value: f64) {
        self.list.push(Scalar { name: name.into(), unit: unit.into(), value });
    }

    /// The number of this name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<f64> {
        self.list.iter().find(|s| s.name == name).map(|s| s.value)
    }

    /// Length of the message of `n` numbers.
    #[must_use]
    pub fn message_bytes(n: usize) -> usize {
        message_bytes(&[32, 16, 8].map(|width| (width, n)))
    }

    /// The message.
    #[must_use]
    pub fn encode(&self, stamp: &Stamp) -> Vec<u8> {
        let names: Vec<[u8; 32]> = self.list.iter().map(|s| padded(&s.name)).collect();
        let units: Vec<[u8; 16]> = self.list.iter().map(|s| padded(&s.unit)).collect();
        let values: Vec<[f64; 1]> = self.list.iter().map(|s| [s.value]).collect();
        Encoder::new(Kind::Scalars, stamp)
            .rows(values.len(), values.len() as u64)
            .column("name", "", &names)
            .column("unit", "", &units)
            .column("value", "", &values)
            .finish()
    }

    /// The numbers of a message.
    ///
    /// # Errors
    /// If it is a message of another kind, or its columns do not fit together.
    pub fn decode(snapshot: &Snapshot<'_>) -> Result<Self, WireError> {
        snapshot.expect(Kind::Scalars)?;
        let (names, units) = (snapshot.texts::<32>("name")?, snapshot.texts::<16>("unit")?);
        let values = snapshot.values::<f64>("value")?;
        if names.len() != values.len() || units.len() != values.len() {
            return Err(WireError::Malformed("the scalars' columns have different lengths".into()));
        }
        let rows = names.into_iter().zip(units).zip(values);
        Ok(Self { list: rows.map(|((name, unit), value)| Scalar { name, unit, value }).collect() })
    }
}
