//! Replays: an analyzer cannot tell one from a run, a stopped reader does not hold one up, and it can be steered.

#[path = "recordings/made.rs"]
#[allow(dead_code)]
mod made;

use squirm::analyze::{Limits, Live, Source};
use squirm::recording::{Moment, Range};
use squirm::replay::{Command as Ask, Control, Options, Pace, replay};
use squirm::wire::Kind;
use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(90);

/// A process that does not outlive its test.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Process {
    fn start(program: &str, folder: &Path, arguments: &[&str]) -> Self {
        let mut command = Command::new(program);
        command.current_dir(folder).args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        Self(command.spawn().expect("it starts"))
    }

    /// Starts a replay and waits until it publishes.
    fn replay(folder: &Path, arguments: &[&str]) -> Self {
        let mut process =
            Self::start(env!("CARGO_BIN_EXE_squirm"), folder, &[&["replay", "run.mcap"], arguments].concat());
        let mut line = String::new();
        let stderr = process.0.stderr.as_mut().expect("piped");
        BufReader::new(stderr).read_line(&mut line).expect("UTF-8");
        assert!(line.starts_with("publishing as "), "{line}");
        process
    }

    fn analyze(folder: &Path, arguments: &[&str]) -> Self {
        Self::start(env!("CARGO_BIN_EXE_squirm-analyze"), folder, &[&["swim"], arguments].concat())
    }

    /// Waits for the end; the exit status and what was printed.
    #[track_caller]
    fn end(mut self) -> (Option<i32>, String) {
        let begun = Instant::now();
        while self.0.try_wait().expect("a child").is_none() {
            assert!(begun.elapsed() < PATIENCE, "the process does not end");
            std::thread::sleep(Duration::from_millis(20));
        }
        let mut text = String::new();
        for stream in [
            self.0.stdout.take().map(|s| Box::new(s) as Box<dyn std::io::Read>),
            self.0.stderr.take().map(|s| Box::new(s) as _),
        ] {
            std::io::Read::read_to_string(&mut stream.expect("piped"), &mut text).expect("UTF-8");
        }
        (self.0.wait().expect("a child").code(), text)
    }
}

fn name(test: &str) -> String {
    format!("{test}-{}", std::process::id())
}

fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .map(|path| {
            (path.file_name().expect("a name").to_string_lossy().into_owned(), std::fs::read(&path).expect("a file"))
        })
        .collect();
    files.sort();
    files
}

#[test]
fn an_analyzer_of_a_replay_writes_what_it_writes_of_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    made::record(folder.path(), 1, 0..60);
    let name = name("as-a-run");
    let replay = Process::replay(folder.path(), &["--max", "--wait-for", "1", "--name", &name]);
    let (code, said) = Process::analyze(folder.path(), &["--live", &name, "--out", "live"]).end();
    assert!(code == Some(0) && said.contains("60 snapshots"), "{said}");
    let (code, said) = replay.end();
    assert!(code == Some(0) && said.contains("240 snapshots published"), "{said}");
    let (code, said) = Process::analyze(folder.path(), &["run.mcap", "--out", "file"]).end();
    assert_eq!(code, Some(0), "{said}");
    let live = files(&folder.path().join("live"));
    assert!(live.len() > 3 && live == files(&folder.path().join("file")));
}

/// Steps of the squirmers' snapshots that a reader gets; it waits for `go` with the first one in its hand.
fn reader(name: &str, go: Option<Receiver<()>>) -> JoinHandle<Vec<u64>> {
    let mut live = Live::new(name, Limits::default());
    std::thread::spawn(move || {
        let mut steps = Vec::new();
        let begun = Instant::now();
        loop {
            let found = live.drive(&[Kind::Squirmers], &mut |snapshot| {
                steps.push(snapshot.header.step);
                if let Some(go) = go.as_ref().filter(|_| steps.len() == 1) {
                    go.recv_timeout(PATIENCE).expect("the replay hangs");
                }
                Ok(ControlFlow::Continue(()))
            });
            match found {
                Ok(_) => return steps,
                Err(error) => assert!(begun.elapsed() < PATIENCE, "{error}"),
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    })
}

#[test]
fn a_stuck_reader_does_not_hold_a_replay_up_and_others_lose_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    made::record(folder.path(), 1, 0..40);
    let name = name("stuck");
    let (go, waits) = channel();
    let readers = [reader(&name, Some(waits)), reader(&name, None)];
    let pace = Pace::Max(Duration::from_millis(300));
    let options = Options { name: Some(name), pace, range: Range::default(), repeat: false, wait_for: 2 };
    let done = replay(folder.path(), &options, &mut Script(VecDeque::new())).expect("it plays");
    go.send(()).expect("it waits");
    let [stuck, other] = readers.map(|r| r.join().expect("a reader"));
    assert_eq!(other, (0..40).map(|seq| 20 * seq).collect::<Vec<u64>>());
    // One in its hand, as many as its queue holds behind it, and nothing else.
    assert_eq!((done.snapshots, stuck), (160, vec![0, 20, 40]));
    assert_eq!(done.dropped, 37);
}

#[test]
fn lines_steer_a_replay_and_wrong_use_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    made::record(folder.path(), 1, 0..5);
    let name = name("lines");
    let mut replay = Process::replay(folder.path(), &["--speed", "0.001", "--name", &name]);
    let arguments = ["replay", "run.mcap", "--max", "--name", &name];
    let second = Process::start(env!("CARGO_BIN_EXE_squirm"), folder.path(), &arguments).end();
    assert!(second.0 == Some(0) && second.1.contains(&format!("publishing as {name}-2; ")), "{}", second.1);
    replay.0.stdin.as_mut().expect("piped").write_all(b"seek 2tau\nquit\n").expect("it listens");
    let (code, said) = replay.end();
    assert!(code == Some(0) && said.contains("snapshots published"), "{said}");
    for (arguments, status, part) in [
        (&["replay", "absent.mcap"][..], 2, "there is no recording absent.mcap"),
        (&["replay", "run.mcap", "--speed", "0"], 2, "a number above 0"),
        (&["replay", "run.mcap", "--from", "9999"], 2, "no snapshot in that range"),
    ] {
        let (code, said) = Process::start(env!("CARGO_BIN_EXE_squirm"), folder.path(), arguments).end();
        assert!(code == Some(status) && said.contains(part), "{arguments:?}: {code:?} {said}");
    }
}

/// Asks one thing each time it is asked for something.
struct Script(VecDeque<Option<Ask>>);

impl Control for Script {
    fn command(&mut self) -> Option<Ask> {
        self.0.pop_front().unwrap_or_default()
    }
}

#[test]
fn it_holds_and_jumps() {
    let folder = tempfile::tempdir().expect("a folder");
    made::record(folder.path(), 1, 0..10);
    let play = |test: &str, asked: &[Option<Ask>]| {
        let (name, range) = (Some(name(test)), Range { to: Some(Moment::Step(160)), ..Range::default() });
        let pace = Pace::Max(Duration::from_secs(1));
        let options = Options { name, pace, range, repeat: false, wait_for: 0 };
        replay(folder.path(), &options, &mut Script(asked.iter().copied().collect())).expect("it plays").snapshots
    };
    let (seek, rest) = (Some(Ask::Seek(Moment::Step(120))), None);
    assert_eq!(play("all", &[]), 9 * 4);
    assert_eq!(play("ahead", &[seek]), 3 * 4);
    assert_eq!(play("held", &[Some(Ask::Pause), rest, rest, Some(Ask::Quit)]), 0);
    // A jump while it holds shows one moment, all kinds of it.
    let held = [Some(Ask::Pause), seek, rest, rest, rest, rest, rest, rest, rest, rest, rest, Some(Ask::Quit)];
    assert_eq!(play("shown", &held), 4);
    // Back from the second moment to the first, by a twentieth of 8 tau at least to the start.
    let back = [rest, rest, rest, rest, rest, rest, rest, rest, Some(Ask::Seek(Moment::Time(0.0)))];
    assert!(play("back", &back) > 9 * 4);
}
