//! What a checkpoint says of a run: everything but what the pipeline file says again.

use super::books::Books;
use super::summary::Speed;
use super::{RunError, outputs::Marks};
use crate::checkpoint::{self, Damage, Found, Sections};
use crate::gpu::Form;
use crate::graph::Plan;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Beginning of the names of sections that hold a buffer.
const BUFFER: &str = "buffer/";

/// What identifies a run and its moment; JSON, for people too.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Note {
    /// Name of the run.
    pub run: String,
    /// Identity of the run, as in the header of every snapshot.
    pub run_id: [u8; 16],
    /// Hash of every value of the pipeline file that decides the trajectory.
    pub configuration: String,
    /// Version of the program.
    pub version: String,
    /// Adapter and driver: only the same give the same bits.
    pub adapter: String,
    /// How stages become kernels: which buffers there are.
    pub form: String,
    /// Steps done.
    pub step: u64,
    /// Fluid particles.
    pub particles: u64,
    /// Steps between two entries of the books; as it was at the start, also if the run is made longer.
    pub every: u64,
    /// Wall time and stages so far.
    pub speed: Speed,
}

/// A checkpoint's content.
#[derive(Debug)]
pub struct Saved {
    /// Identity and moment.
    pub note: Note,
    /// Where the outputs stand.
    pub marks: Marks,
    numbers: Vec<f64>,
    values: BTreeMap<String, String>,
    sections: Sections,
    /// What the user should know of how it was found.
    pub remark: Option<String>,
    /// The newer checkpoint that is damaged.
    damaged: Option<PathBuf>,
}

/// The values that decide a plan's trajectory; the form is none, but decides what a checkpoint holds.
fn decisive(plan: &Plan, form: Form) -> BTreeMap<String, String> {
    let mut values = checkpoint::decisive(&plan.resolved).unwrap_or_default();
    values.insert("--plan".into(), named(form).into());
    values
}

fn named(form: Form) -> &'static str {
    match form {
        Form::Loose => "loose",
        Form::Fused => "fused",
    }
}

/// Hash of the values.
fn hash(values: &BTreeMap<String, String>) -> String {
    let mut hasher = blake3::Hasher::new();
    for text in values.iter().flat_map(|(key, value)| [key, value]) {
        hasher.update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

impl Note {
    /// What stays the same during a run.
    pub fn of(plan: &Plan, form: Form, run_id: [u8; 16]) -> Self {
        Self {
            run: plan.name.clone(),
            run_id,
            configuration: hash(&decisive(plan, form)),
            version: env!("CARGO_PKG_VERSION").into(),
            adapter: String::new(),
            form: named(form).into(),
            step: 0,
            particles: 0,
            every: 1,
            speed: Speed::default(),
        }
    }
}

/// The sections of a checkpoint, made from what it is about.
pub struct Draft {
    /// Identity and moment.
    pub note: Note,
    /// The books, as numbers.
    pub books: Vec<f64>,
    /// Contents of the persistent buffers.
    pub buffers: Vec<(&'static str, Vec<u8>)>,
    /// The pipeline file with all defaults.
    pub resolved: String,
}

impl Draft {
    /// Writes the checkpoint into `dir`.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, dir: &Path, marks: &Marks) -> Result<(), RunError> {
        let (note, marks) = (json(&self.note), json(marks));
        let books: Vec<u8> = self.books.iter().flat_map(|x| x.to_le_bytes()).collect();
        let first: [(&str, &[u8]); 4] =
            [("run", &note), ("pipeline.toml", self.resolved.as_bytes()), ("outputs", &marks), ("books", &books)];
        let buffers = self.buffers.iter().map(|(name, bytes)| (format!("{BUFFER}{name}"), bytes.as_slice()));
        let sections: Vec<_> = first.map(|(name, bytes)| (name.to_owned(), bytes)).into_iter().chain(buffers).collect();
        Ok(checkpoint::write(dir, &sections)?)
    }
}

fn json<T: Serialize>(value: &T) -> Vec<u8> {
    serde_json::to_vec_pretty(value).expect("plain values, and keys that are texts")
}

fn from_json<T: DeserializeOwned>(sections: &Sections, name: &str) -> Result<T, Damage> {
    serde_json::from_slice(sections.get(name)?).map_err(|e| content(name, e.to_string()))
}

fn content(section: &str, reason: impl Into<String>) -> Damage {
    Damage::Content { section: section.into(), reason: reason.into() }
}

type Parts = (Note, Marks, Vec<f64>, BTreeMap<String, String>);

fn parts(sections: &Sections) -> Result<Parts, Damage> {
    let note: Note = from_json(sections, "run")?;
    let marks = from_json(sections, "outputs")?;
    let books = sections.get("books")?;
    let numbers = books.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
    let text = str::from_utf8(sections.get("pipeline.toml")?).ok();
    let unreadable = || content("pipeline.toml", "it is no pipeline file");
    let mut values = text.and_then(checkpoint::decisive).ok_or_else(unreadable)?;
    values.insert("--plan".into(), note.form.clone());
    if hash(&values) != note.configuration {
        return Err(content("pipeline.toml", "it is not that of the run"));
    }
    Ok((note, marks, numbers, values))
}

impl Saved {
    /// The newest checkpoint of `dir` that can be used, if there is any.
    ///
    /// # Errors
    /// If there are checkpoints, but none can be used.
    pub fn load(dir: &Path) -> Result<Option<Self>, RunError> {
        let found = checkpoint::load(dir, parts)?;
        let saved = |((note, marks, numbers, values), Found { path, sections, refused }): (Parts, Found)| {
            let remark = refused.as_ref().map(|(newer, why)| {
                format!("{} was not used: {why}; going on from {} instead", newer.display(), path.display())
            });
            Self { note, marks, numbers, values, sections, remark, damaged: refused.map(|(newer, _)| newer) }
        };
        Ok(found.map(saved))
    }

    /// Puts a newer checkpoint that is damaged aside, so that it does not take the place of this one when the next is written.
    ///
    /// # Errors
    /// If it cannot be renamed.
    pub fn put_aside(&self) -> Result<(), RunError> {
        Ok(self.damaged.as_deref().map_or(Ok(()), checkpoint::put_aside)?)
    }

    /// Values in which a plan differs from the run that this is of.
    #[must_use]
    pub fn differences(&self, plan: &Plan, form: Form) -> Vec<String> {
        checkpoint::differences(&self.values, &decisive(plan, form))
    }

    /// The books at the checkpoint.
    ///
    /// # Errors
    /// If they are not those of the plan's system.
    pub fn books(&self, plan: &Plan) -> Result<Books, RunError> {
        let reason = || format!("run.checkpoint: {}", content("books", "they are not those of this system"));
        Books::read(&plan.system, &self.numbers).ok_or_else(|| RunError::File {
            what: "use",
            path: "run.checkpoint".into(),
            source: std::io::Error::other(reason()),
        })
    }

    /// Contents of the persistent buffers.
    #[must_use]
    pub fn buffers(&self) -> Vec<(&str, &[u8])> {
        self.sections.iter().filter_map(|(name, bytes)| Some((name.strip_prefix(BUFFER)?, bytes))).collect()
    }
}
