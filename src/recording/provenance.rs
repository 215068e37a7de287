//! What made a recording, as its attachment and its metadata say.

use mcap::Attachment;
use mcap::records::Metadata;
use serde_json::Value;
use std::collections::BTreeMap;

/// The attachment with everything that is known.
pub const ATTACHMENT: &str = "provenance.json";
/// The metadata record with the most important of it.
pub const METADATA: &str = "squirm:run";

/// What made a recording, as an attachment says it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Provenance(serde_json::Map<String, Value>);

impl Provenance {
    /// Reads the attachment, if it is the one.
    #[must_use]
    pub fn of(attachment: &Attachment<'_>) -> Option<Self> {
        let named = attachment.name == ATTACHMENT;
        named.then(|| serde_json::from_slice(&attachment.data).ok()).flatten().map(Self)
    }

    /// A text or a number of it, as a text.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<String> {
        match self.0.get(key)? {
            Value::String(text) => Some(text.clone()),
            Value::Number(number) => Some(number.to_string()),
            _ => None,
        }
    }

    /// Corrects the metadata of the run; says whether something was wrong.
    pub(super) fn mend(&self, metadata: &mut Metadata) -> bool {
        let ours = ["run", "run_id", "seed", "version"].map(|key| (key, self.get(key)));
        let known: Vec<(String, String)> =
            ours.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?))).collect();
        if metadata.name != METADATA || known.len() < 4 {
            return false;
        }
        let expected = run_metadata(known);
        let wrong = metadata.metadata != expected;
        metadata.metadata = expected;
        wrong
    }
}

/// The metadata record of a run: what identifies it, and the units of all recordings.
#[must_use]
pub fn run_metadata(identity: impl IntoIterator<Item = (String, String)>) -> BTreeMap<String, String> {
    let units = [
        ("units", "a (cell edge), m (particle mass), kT; tau = a sqrt(m/kT)"),
        ("time_unit", "log_time counts 1 tau as 1 s"),
    ];
    identity.into_iter().chain(units.map(|(k, v)| (k.to_owned(), v.to_owned()))).collect()
}
