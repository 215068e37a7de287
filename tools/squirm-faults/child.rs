//! Runs as child processes, in folders of their own.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// Longest wait for a process.
const PATIENCE: Duration = Duration::from_secs(300);

/// A small run with walls, squirmers, thermostat and sorting, whose checkpoints come often and at odd steps.
pub const FILE: &str = r#"
run = { steps = 60, dt = 0.05 }
box = { size = [8, 8, 8], walls = { axis = "y" } }
fluid = { density = 5 }
squirmers = [{ name = "puller", count = 2, semi_axes = { along = 2.0, across = 1.5 }, b1 = 0.1, beta = 1.0 }]
stage = [
    { kind = "squirmer-move" }, { kind = "stream" }, { kind = "squirmer-collide" }, { kind = "shift-grid" },
    { kind = "sort-reorder", every = 5 }, { kind = "cell-reduce" }, { kind = "wall-ghosts" }, { kind = "squirmer-fill" },
    { kind = "rotate" }, { kind = "restore-thermostat", mode = "thermostat" },
]
output = [
    { record = ["squirmers", "scalars"], csv = ["scalars", "squirmers"], every = 3 },
    { record = ["fields", "particles"], fraction = 1.0, every = 10 },
]
checkpoint = { every = 7 }
"#;

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
    overrides: Vec<String>,
}

/// A process that does not outlive its owner.
pub struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Trial {
    /// With the file and nothing else yet.
    pub fn new(squirm: &Path, overrides: &[&str]) -> Result<Self, String> {
        let folder = Folder::new()?;
        std::fs::write(folder.path().join("trial.toml"), FILE).map_err(|e| e.to_string())?;
        let overrides = overrides.iter().map(|o| (*o).to_owned()).collect();
        Ok(Self { folder, squirm: squirm.into(), overrides })
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
        let mut command = Command::new(&self.squirm);
        command.current_dir(self.folder.path()).args(["run", "trial.toml", "--quiet", "--out"]).arg(dir);
        command.args(self.overrides.iter().flat_map(|o| ["--set", o])).stdin(Stdio::null()).stdout(Stdio::null());
        command.stderr(Stdio::piped()).env("NO_COLOR", "1");
        command.spawn().map(Process).map_err(|e| format!("{} does not start: {e}", self.squirm.display()))
    }

    /// Runs to the end.
    pub fn finish(&self) -> Result<(), String> {
        let (code, said) = self.start()?.wait()?;
        if code == Some(0) { Ok(()) } else { Err(format!("it ended with {code:?}: {said}")) }
    }
}

impl Process {
    /// Sends a signal by its name, as in `-INT`.
    pub fn signal(&self, name: &str) -> Result<(), String> {
        let status = Command::new("kill").args([name, &self.0.id().to_string()]).stderr(Stdio::null()).status();
        status.map(drop).map_err(|e| format!("no kill: {e}"))
    }

    /// Kills it, unless it has ended by itself; whether it had not.
    pub fn kill(mut self) -> Result<bool, String> {
        let going = self.0.try_wait().map_err(|e| e.to_string())?.is_none();
        self.0.kill().and_then(|()| self.0.wait()).map_err(|e| e.to_string())?;
        Ok(going)
    }

    /// Waits for its end: its status, and what it said.
    pub fn wait(mut self) -> Result<(Option<i32>, String), String> {
        let begun = Instant::now();
        while self.0.try_wait().map_err(|e| e.to_string())?.is_none() {
            if begun.elapsed() > PATIENCE {
                return Err("it does not end".into());
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let mut said = String::new();
        if let Some(mut stderr) = self.0.stderr.take() {
            let _ = std::io::Read::read_to_string(&mut stderr, &mut said);
        }
        Ok((self.0.wait().map_err(|e| e.to_string())?.code(), said))
    }
}
