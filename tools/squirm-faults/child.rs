//! Runs as child processes, in folders of their own.

use std::fs::File;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// Longest wait for a process.
const PATIENCE: Duration = Duration::from_secs(300);

/// A small system with walls, squirmers, thermostat and sorting.
const SYSTEM: &str = r#"
run = { steps = 60, dt = 0.05 }
box = { size = [8, 8, 8], walls = { axis = "y" } }
fluid = { density = 5 }
squirmers = [{ name = "puller", count = 2, semi_axes = { along = 2.0, across = 1.5 }, b1 = 0.1, beta = 1.0 }]
stage = [
    { kind = "squirmer-move" }, { kind = "stream" }, { kind = "squirmer-collide" }, { kind = "shift-grid" },
    { kind = "sort-reorder", every = 5 }, { kind = "cell-reduce" }, { kind = "wall-ghosts" }, { kind = "squirmer-fill" },
    { kind = "rotate" }, { kind = "restore-thermostat", mode = "thermostat" },
]
"#;

/// Two recordings and both tables, and checkpoints that come often and at odd steps.
const RECORDED: &str = r#"
output = [
    { record = ["squirmers", "scalars"], csv = ["scalars", "squirmers"], every = 3 },
    { record = ["fields", "particles"], fraction = 1.0, every = 10 },
]
checkpoint = { every = 7 }
"#;

/// A run that would go on for hours.
pub const ENDLESS: [&str; 1] = ["run.steps=1000000000"];

/// A temporary folder that goes with its owner.
pub struct Folder(PathBuf);

impl Folder {
    /// A new one.
    pub fn new() -> Result<Self, String> {
        static MADE: AtomicU32 = AtomicU32::new(0);
        let number = MADE.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("squirm-faults-{}-{number}", std::process::id()));
        std::fs::create_dir(&path).map_err(|e| format!("cannot create {}: {e}", path.display()))?;
        Ok(Self(path))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A run's file and directory in a folder that goes with it.
pub struct Trial {
    folder: Folder,
    squirm: PathBuf,
    name: String,
    overrides: Vec<String>,
}

/// A process that does not outlive its owner.
pub struct Process {
    child: Child,
    /// What it writes to standard error; a pipe that nobody reads would stop it one day.
    said: File,
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Trial {
    /// Of a small run that records; nothing but its file is there yet.
    pub fn new(squirm: &Path, overrides: &[&str]) -> Result<Self, String> {
        Self::with(squirm, RECORDED, overrides)
    }

    /// Of the same system with these outputs, the rest of its file.
    pub fn with(squirm: &Path, outputs: &str, overrides: &[&str]) -> Result<Self, String> {
        let folder = Folder::new()?;
        // The folder's name is like no other's, so the run's is not either.
        let name = folder.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
        std::fs::write(folder.path().join(format!("{name}.toml")), format!("{SYSTEM}{outputs}"))
            .map_err(|e| e.to_string())?;
        let overrides = overrides.iter().map(|o| (*o).to_owned()).collect();
        Ok(Self { folder, squirm: squirm.into(), name, overrides })
    }

    /// The name of the run.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The folder of the file.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The directory of the run.
    pub fn dir(&self) -> PathBuf {
        self.folder.path().join("run")
    }

    /// Begins the run, or goes on with it.
    pub fn start(&self) -> Result<Process, String> {
        self.start_in(&self.dir())
    }

    /// The same in another directory.
    pub fn start_in(&self, dir: &Path) -> Result<Process, String> {
        Process::start(&mut self.command(dir))
    }

    /// The command that runs it into `dir`; warnings are printed, progress is, too.
    pub fn command(&self, dir: &Path) -> Command {
        let mut command = Command::new(&self.squirm);
        command.current_dir(self.folder.path()).arg("run").arg(format!("{}.toml", self.name)).arg("--out").arg(dir);
        command.args(self.overrides.iter().flat_map(|o| ["--set", o]));
        command
    }

    /// Runs to the end.
    pub fn finish(&self) -> Result<(), String> {
        let (code, said) = self.start()?.wait()?;
        if code == Some(0) { Ok(()) } else { Err(format!("it ended with {code:?}: {said}")) }
    }
}

impl Process {
    /// Starts a command whose standard output is of no interest.
    pub fn start(command: &mut Command) -> Result<Self, String> {
        Self::start_into(command, Stdio::null())
    }

    /// Starts a command.
    pub fn start_into(command: &mut Command, out: impl Into<Stdio>) -> Result<Self, String> {
        let said = unnamed().map_err(|e| format!("no file for what a process says: {e}"))?;
        let error = said.try_clone().map_err(|e| e.to_string())?;
        command.stdin(Stdio::null()).stdout(out).stderr(error).env("NO_COLOR", "1");
        let program = command.get_program().to_string_lossy().into_owned();
        command.spawn().map(|child| Self { child, said }).map_err(|e| format!("{program} does not start: {e}"))
    }

    /// Its number.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Sends a signal by its name, as in `-INT`.
    pub fn signal(&self, name: &str) -> Result<(), String> {
        let status = Command::new("kill").args([name, &self.child.id().to_string()]).stderr(Stdio::null()).status();
        status.map(drop).map_err(|e| format!("no kill: {e}"))
    }

    /// Whether it has ended.
    pub fn ended(&mut self) -> Result<bool, String> {
        self.child.try_wait().map(|status| status.is_some()).map_err(|e| e.to_string())
    }

    /// Kills it, unless it has ended by itself; whether it had not.
    pub fn kill(mut self) -> Result<bool, String> {
        let going = !self.ended()?;
        self.child.kill().and_then(|()| self.child.wait()).map_err(|e| e.to_string())?;
        Ok(going)
    }

    /// Waits for its end: its status, and what it said.
    pub fn wait(mut self) -> Result<(Option<i32>, String), String> {
        let begun = Instant::now();
        while !self.ended()? {
            if begun.elapsed() > PATIENCE {
                return Err("it does not end".into());
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let mut said = Vec::new();
        let read = self.said.rewind().and_then(|()| self.said.read_to_end(&mut said));
        read.map_err(|e| e.to_string())?;
        let code = self.child.wait().map_err(|e| e.to_string())?.code();
        Ok((code, String::from_utf8_lossy(&said).into_owned()))
    }
}

/// A file that is gone with its last handle.
fn unnamed() -> std::io::Result<File> {
    let folder = Folder::new().map_err(std::io::Error::other)?;
    File::options().read(true).write(true).create_new(true).open(folder.path().join("said"))
}
