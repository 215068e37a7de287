//! Runs seen from outside while they go: analyzers, recordings, signals, `ps`, `top`, `tap`.
#![cfg(target_os = "linux")]

mod analyzers;
mod lost;
mod recorded;
mod runs;
mod slow;
mod views;

use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A small box that would go on for hours and publishes what is put in for `OUTPUT`.
const FILE: &str = r#"
[run]
steps = 100000000
dt = 0.05
[box]
size = [10, 8, 8]
[fluid]
density = 5
[[squirmers]]
name = "swimmer"
count = 1
semi_axes = { along = 2.5, across = 2.0 }
b1 = 0.05
[[stage]]
kind = "squirmer-move"
[[stage]]
kind = "stream"
[[stage]]
kind = "squirmer-collide"
[[stage]]
kind = "shift-grid"
[[stage]]
kind = "cell-reduce"
[[stage]]
kind = "squirmer-fill"
[[stage]]
kind = "rotate"
[[stage]]
kind = "restore-thermostat"
"#;

/// Longest time for anything on a busy machine.
pub const PATIENCE: Duration = Duration::from_secs(240);

/// A folder with the file and these outputs, under a name that no other test uses.
pub fn prepared(test: &str, outputs: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let name = format!("{test}-{}", std::process::id());
    std::fs::write(folder.path().join(format!("{name}.toml")), format!("{FILE}{outputs}")).expect("written");
    (folder, name)
}

/// A process that does not outlive its test.
pub struct Process(pub Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Process {
    pub fn start(folder: &Path, arguments: &[&str]) -> Self {
        Self::of(env!("CARGO_BIN_EXE_squirm"), folder, arguments)
    }

    /// Of another program than squirm.
    pub fn of(program: &str, folder: &Path, arguments: &[&str]) -> Self {
        let mut command = Command::new(program);
        command.current_dir(folder).args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        Self(command.env("NO_COLOR", "1").spawn().expect("it starts"))
    }

    pub fn run(folder: &Path, name: &str, out: &str) -> Self {
        Self::start(folder, &["run", &format!("{name}.toml"), "--out", out])
    }

    pub fn signal(&self, signal: &str) {
        let sent = Command::new("kill").args([signal, &self.0.id().to_string()]).status().expect("kill is there");
        assert!(sent.success());
    }

    /// Waits for the end; exit status, standard output and standard error.
    pub fn end(mut self) -> (Option<i32>, String, String) {
        let begun = Instant::now();
        while self.0.try_wait().expect("a child").is_none() {
            assert!(begun.elapsed() < PATIENCE, "the process does not end");
            std::thread::sleep(Duration::from_millis(20));
        }
        let (mut out, mut err) = (String::new(), String::new());
        self.0.stdout.take().expect("piped").read_to_string(&mut out).expect("UTF-8");
        self.0.stderr.take().expect("piped").read_to_string(&mut err).expect("UTF-8");
        (self.0.wait().expect("a child").code(), out, err)
    }
}

/// Runs a command of squirm to its end; exit status, standard output and standard error.
pub fn squirm(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let Output { status, stdout, stderr } = Command::new(env!("CARGO_BIN_EXE_squirm"))
        .current_dir(folder)
        .args(arguments)
        .env("NO_COLOR", "1")
        .stdin(Stdio::null())
        .output()
        .expect("it starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (status.code(), text(stdout), text(stderr))
}

/// What `squirm ps --json` says of a run.
pub fn listed(folder: &Path, name: &str) -> Option<serde_json::Value> {
    let (code, out, err) = squirm(folder, &["ps", "--json"]);
    assert_eq!(code, Some(0), "{err}");
    let list: Vec<serde_json::Value> = serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {out}"));
    list.into_iter().find(|run| run["run"] == name)
}

/// Waits until a run is listed and has done a step.
#[track_caller]
pub fn wait_for(folder: &Path, name: &str) -> serde_json::Value {
    wait_until(&format!("{name} is not listed"), || {
        listed(folder, name).filter(|run| run["step"].as_u64().is_some_and(|s| s > 0))
    })
}

/// Waits until there is something.
#[track_caller]
pub fn wait_until<T>(complaint: &str, mut there: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(found) = there() {
            return found;
        }
        assert!(begun.elapsed() < PATIENCE, "{complaint}");
        std::thread::sleep(Duration::from_millis(50));
    }
}
