//! The files that one run has recorded, as one source.

use super::{AnalyzeError, Ending, Recording, Source, Visit};
use crate::wire::Kind;
use std::path::{Path, PathBuf};

/// File of the small topics.
const RUN: &str = "run.mcap";
/// File of the particles, beside it.
const FLUID: &str = "run.fluid.mcap";

/// A recorded run: `run.mcap`, and `run.fluid.mcap` beside it where particles are asked for; or any one recording.
#[derive(Debug, Clone)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// The run recorded in the folder `path`, or in the file `path`.
    #[must_use]
    pub fn new(path: &Path) -> Self {
        Self { path: if path.is_dir() { path.join(RUN) } else { path.into() } }
    }

    /// The recording of the small topics.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Source for Folder {
    /// One file after the other.
    fn drive(&mut self, topics: &[Kind], visit: &mut Visit<'_>) -> Result<Ending, AnalyzeError> {
        let beside = self.path.with_file_name(FLUID);
        let split = self.path.file_name().is_some_and(|name| name == RUN) && beside.exists();
        let (bulk, small): (Vec<Kind>, Vec<Kind>) =
            topics.iter().copied().partition(|t| split && *t == Kind::Particles);
        let mut broken = false;
        let mut all = Ending::default();
        for (path, topics) in [(&self.path, small), (&beside, bulk)] {
            if topics.is_empty() || broken {
                continue;
            }
            let ending = Recording::new(path).drive(&topics, &mut |snapshot| {
                let flow = visit(snapshot)?;
                broken = flow.is_break();
                Ok(flow)
            })?;
            all.snapshots += ending.snapshots;
            all.lost += ending.lost;
            all.warnings.extend(ending.warnings);
        }
        Ok(all)
    }
}
