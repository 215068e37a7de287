//! Snapshots of several kinds, moment by moment.

use super::ExportError;
use crate::recording::{Choice, Range, Series};
use crate::wire::{Fields, Header, Kind, Particles, Scalars, Snapshot, Squirmers};
use std::path::Path;

/// Everything that was recorded after the same step.
#[derive(Debug, Clone, Default)]
pub struct Moment {
    /// Header of the first snapshot.
    pub header: Header,
    /// Squirmers.
    pub squirmers: Option<Squirmers>,
    /// Scalars.
    pub scalars: Option<Scalars>,
    /// Fields.
    pub fields: Option<Fields>,
    /// Fluid particles.
    pub particles: Option<Particles>,
}

/// Reads moments in order.
pub struct Moments {
    series: Series,
    choice: Choice,
    ahead: Option<Vec<u8>>,
    /// Step of the newest snapshot seen, chosen or not.
    pub last: Option<u64>,
}

impl Moments {
    /// The moments of `range` with snapshots of these kinds.
    ///
    /// # Errors
    /// If there is no such recording.
    pub fn open(path: &Path, kinds: &[Kind], range: Range) -> Result<Self, ExportError> {
        Ok(Self { series: Series::open(path, kinds)?, choice: Choice::new(range), ahead: None, last: None })
    }

    /// The next moment.
    ///
    /// # Errors
    /// At damage.
    pub fn next_moment(&mut self) -> Result<Option<Moment>, ExportError> {
        let mut moment: Option<Moment> = None;
        loop {
            let bytes = match self.ahead.take() {
                Some(bytes) => bytes,
                None => match self.series.next_message()? {
                    Some(bytes) => bytes,
                    None => return Ok(moment),
                },
            };
            let snapshot = Snapshot::parse(&bytes)?;
            let header = snapshot.header;
            if moment.as_ref().is_some_and(|m| m.header.step != header.step) {
                self.ahead = Some(bytes);
                return Ok(moment);
            }
            self.last = Some(header.step);
            if !self.choice.takes(snapshot.kind(), &header) {
                continue;
            }
            let moment = moment.get_or_insert_with(|| Moment { header, ..Moment::default() });
            match snapshot.kind() {
                Kind::Squirmers => moment.squirmers = Some(Squirmers::decode(&snapshot)?),
                Kind::Scalars => moment.scalars = Some(Scalars::decode(&snapshot)?),
                Kind::Fields => moment.fields = Some(Fields::decode(&snapshot)?),
                Kind::Particles => moment.particles = Some(Particles::decode(&snapshot)?),
                // Of the moment in which it was sent, not of the system.
                Kind::Status => {}
            }
        }
    }

    /// What the user should know of the recording.
    #[must_use]
    pub fn finish(self) -> Vec<String> {
        self.series.finish().warnings
    }
}
