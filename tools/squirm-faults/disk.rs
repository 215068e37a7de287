//! A disk that fills up: the run ends with the reason, and its checkpoint and recordings stay readable.

use super::child::{Folder, Trial};
use super::kill::saved_step;
use super::table::Row;
use squirm::analyze::{Recording, Source};
use squirm::wire::Kind;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, Stdio};

/// A file system in memory that goes with its owner.
struct Small<'a>(&'a Path);

impl<'a> Small<'a> {
    fn mount(at: &'a Path, kilobytes: u32) -> Option<Self> {
        let size = format!("size={kilobytes}k");
        let mut command = Command::new("mount");
        command.args(["-t", "tmpfs", "-o", &size, "tmpfs"]).arg(at).stdout(Stdio::null()).stderr(Stdio::null());
        command.status().is_ok_and(|s| s.success()).then_some(Self(at))
    }
}

impl Drop for Small<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0).status();
    }
}

/// Lets runs fill disks of `count` sizes.
pub fn disk(squirm: &Path, count: u32) -> Result<Vec<Row>, String> {
    let mut row = Row::new("a full disk ends a run with status 1 and the reason; checkpoint and recording can be read");
    let mut shown = Vec::new();
    for number in 0..count {
        let trial = Trial::new(squirm, &["run.steps=100000"])?;
        let folder = Folder::new()?;
        // A checkpoint takes about 80 kB, a frame of all particles as much.
        let Some(_small) = Small::mount(folder.path(), 700 + 130 * number) else {
            row.figures = "this user may not mount a file system".into();
            return Ok(vec![row]);
        };
        row.enter(filled(&trial, &folder.path().join("run")).map(|frames| shown.push(frames)));
    }
    row.figures = format!("frames that can be read: {shown:?}");
    Ok(vec![row])
}

fn filled(trial: &Trial, dir: &Path) -> Result<u64, String> {
    let (code, said) = trial.start_in(dir)?.wait()?;
    if code != Some(1) || !(said.contains("disk full") || said.contains("No space left")) {
        return Err(format!("it ended with {code:?}: {said}"));
    }
    saved_step(dir)?.ok_or("there is no checkpoint")?;
    let mut frames = 0;
    let count = |_: &squirm::wire::Snapshot<'_>| {
        frames += 1;
        Ok(ControlFlow::Continue(()))
    };
    let mut count = count;
    Recording::new(dir).drive(&Kind::ALL, &mut count).map_err(|e| e.to_string())?;
    Ok(frames)
}
