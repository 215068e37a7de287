//! What an analyzer finds in a run that is going is what it finds in the recording, to the last bit of every file, for every kind.

use super::{PATIENCE, Process};
use squirm::analyze::kinds::{Entry, find};
use squirm::analyze::{AnalyzeError, Ending, Folder, KINDS, Limits, Live, Recording, Report, Source, Visit, run};
use squirm::params::Values;
use squirm::sink::Publisher;
use squirm::wire::Kind;
use std::collections::{BTreeMap, VecDeque};
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::mpsc::{Sender, channel};
use std::time::{Duration, Instant};

/// Two squirmers in a slit; squirmers twice as often as the rest.
const FILE: &str = r#"
[run]
steps = 120
dt = 0.05
[box]
size = [12, 8, 12]
walls = { axis = "y", condition = "no-slip" }
[fluid]
density = 5
[[squirmers]]
name = "swimmer"
count = 2
semi_axes = { along = 2.5, across = 1.5 }
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
kind = "wall-ghosts"
[[stage]]
kind = "squirmer-fill"
[[stage]]
kind = "rotate"
[[stage]]
kind = "restore-thermostat"
[[output]]
record = ["squirmers"]
publish = ["squirmers"]
every = 5
[[output]]
record = ["fields", "particles"]
publish = ["fields", "particles"]
every = 10
block = 2
fraction = 0.1
"#;

fn squirm(folder: &Path, name: &str, more: &[&str]) -> Command {
    std::fs::write(folder.join(format!("{name}.toml")), FILE).expect("written");
    let mut command = Command::new(env!("CARGO_BIN_EXE_squirm"));
    command.current_dir(folder).args(["run", &format!("{name}.toml"), "--out", "out", "--quiet"]).args(more);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).env("NO_COLOR", "1");
    command
}

/// Topics that an analyzer uses in this run.
fn topics(entry: &Entry) -> Vec<Kind> {
    entry.topics.iter().chain(entry.extras).copied().collect()
}

/// The report of one kind, with its defaults.
fn report(entry: &Entry, source: &mut dyn Source) -> (Report, Ending) {
    let mut analyzer = (entry.make)(&Values::defaults(&(entry.fields)()));
    run(source, analyzer.as_mut()).unwrap_or_else(|e| panic!("{}: {e}", entry.name))
}

/// A live source that says when a snapshot has been taken.
struct Acknowledged(Live, Sender<()>);

impl Source for Acknowledged {
    fn offers(&self, topic: Kind) -> bool {
        self.0.offers(topic)
    }

    fn drive(&mut self, topics: &[Kind], visit: &mut Visit<'_>) -> Result<Ending, AnalyzeError> {
        let taken = &self.1;
        self.0.drive(topics, &mut |snapshot| {
            let flow = visit(snapshot)?;
            taken.send(()).expect("the test listens");
            Ok(flow)
        })
    }
}

/// The messages of a recorded run, topic by topic.
fn messages(folder: &Path) -> BTreeMap<Kind, VecDeque<Vec<u8>>> {
    let mut all: BTreeMap<Kind, VecDeque<Vec<u8>>> = BTreeMap::new();
    let kinds = [Kind::Squirmers, Kind::Fields, Kind::Particles];
    let ending = Folder::new(folder).drive(&kinds, &mut |snapshot| {
        all.entry(snapshot.kind()).or_default().push_back(snapshot.bytes().to_vec());
        Ok(ControlFlow::Continue(()))
    });
    assert_eq!(ending.expect("readable").warnings, Vec::<String>::new());
    all
}

/// The snapshots of a run, published again in an order of topics that no run has, reach every kind of analyzer at once.
#[test]
fn every_kind_finds_the_same_live_whatever_the_order_of_topics() {
    let folder = tempfile::tempdir().expect("a folder");
    let name = format!("order-{}", std::process::id());
    assert!(squirm(folder.path(), &name, &[]).status().expect("it starts").success());
    let out = folder.path().join("out");
    let mut all = messages(&out);
    assert_eq!(all.values().map(VecDeque::len).collect::<Vec<_>>(), [25, 13, 13]);
    let lengths: Vec<(Kind, usize)> =
        all.iter().map(|(k, m)| (*k, m.iter().map(Vec::len).max().unwrap_or(0))).collect();
    let mut publisher = Publisher::open(&name, &lengths).expect("shared memory");
    // Late joiners begin with the newest snapshot: the first of each topic must be there.
    for queue in all.values_mut() {
        publisher.publish(&queue.pop_front().expect("not empty")).expect("published");
    }
    let (taken, acknowledged) = channel();
    let readers: Vec<_> = KINDS
        .iter()
        .map(|entry| {
            let mut source = Acknowledged(Live::new(&name, Limits::default()), taken.clone());
            std::thread::spawn(move || report(entry, &mut source))
        })
        .collect();
    let readers_of = |kind: Kind| KINDS.iter().filter(|e| topics(e).contains(&kind)).count();
    let begun = Instant::now();
    let mut missing: usize = all.keys().map(|k| readers_of(*k)).sum();
    while missing > 0 {
        publisher.welcome();
        missing -= usize::from(acknowledged.recv_timeout(Duration::from_millis(20)).is_ok());
        assert!(begun.elapsed() < PATIENCE, "{missing} analyzers have not joined");
    }
    // Five of one topic, then five of the next: partners lie several snapshots apart.
    while all.values().any(|queue| !queue.is_empty()) {
        for (kind, queue) in all.iter_mut().rev() {
            for message in queue.drain(..queue.len().min(5)) {
                assert_eq!(publisher.publish(&message).expect("published"), readers_of(*kind));
                (0..readers_of(*kind)).for_each(|_| acknowledged.recv_timeout(PATIENCE).expect("it is taken"));
            }
        }
    }
    drop(publisher);
    for (entry, reader) in KINDS.iter().zip(readers) {
        let (live, ending) = reader.join().expect("no panic");
        assert_eq!((ending.lost, ending.warnings), (0, Vec::new()), "{}", entry.name);
        let (recorded, _) = report(entry, &mut Folder::new(&out));
        let differ: Vec<&String> =
            live.files.iter().zip(&recorded.files).filter(|(a, b)| a != b).map(|(a, _)| &a.0).collect();
        assert!(live == recorded, "{}: {differ:?} differ, or the summary", entry.name);
    }
}

/// The last step recorded so far.
fn reached(recording: &Path) -> u64 {
    let mut last = 0;
    let _ = Recording::new(recording).drive(&[Kind::Fields], &mut |s| {
        last = s.header.step;
        Ok(ControlFlow::Continue(()))
    });
    last
}

fn analyzer(folder: &Path, source: &[&str], entry: &Entry, out: &str, steps: (u64, u64)) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_squirm-analyze"));
    let (from, to) = (steps.0.to_string(), steps.1.to_string());
    command.current_dir(folder).arg(entry.name).args(source).args(["--from", &from, "--to", &to, "--out", out]);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

/// All kinds at once as processes on a run that is going; whether every one of them saw every snapshot of these steps.
fn watched(folder: &Path, name: &str, steps: (u64, u64)) -> bool {
    let children: Vec<Process> = KINDS
        .iter()
        .map(|e| {
            Process(
                analyzer(folder, &["--live", name], e, &format!("live-{}", e.name), steps).spawn().expect("it starts"),
            )
        })
        .collect();
    let mut whole = true;
    for (entry, mut child) in KINDS.iter().zip(children) {
        let begun = Instant::now();
        while child.0.try_wait().expect("a child").is_none() {
            assert!(begun.elapsed() < PATIENCE, "{} does not end", entry.name);
            std::thread::sleep(Duration::from_millis(20));
        }
        let (mut stdout, mut stderr) = (Vec::new(), Vec::new());
        std::io::Read::read_to_end(child.0.stdout.as_mut().expect("piped"), &mut stdout).expect("read");
        std::io::Read::read_to_end(child.0.stderr.as_mut().expect("piped"), &mut stderr).expect("read");
        let output = Output { status: child.0.wait().expect("a child"), stdout, stderr };
        let text = said(&output);
        // Squirmers come every 5 steps, fields and particles every 10; both ends count.
        let every = |k: &Kind| if *k == Kind::Squirmers { 5 } else { 10 };
        let wanted: u64 = topics(entry).iter().map(|k| (steps.1 - steps.0) / every(k) + 1).sum();
        whole &=
            output.status.success() && text.contains(&format!("\n{wanted} snapshots; ")) && !text.contains("warning");
    }
    whole
}

/// Files of a folder with their contents.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let paths = entries.map(|e| e.expect("an entry").path());
    paths
        .map(|p| (p.file_name().expect("a name").to_string_lossy().into_owned(), std::fs::read(&p).expect("read")))
        .collect()
}

#[test]
fn analyzers_attached_to_a_run_write_what_they_write_from_its_recording() {
    let folder = tempfile::tempdir().expect("a folder");
    let name = format!("attached-{}", std::process::id());
    let mut process =
        Process(squirm(folder.path(), &name, &["--set", "run.steps=100000000"]).spawn().expect("it starts"));
    let recording = folder.path().join("out/run.mcap");
    let begun = Instant::now();
    while reached(&recording) < 20 {
        assert!(begun.elapsed() < PATIENCE && process.0.try_wait().expect("a child").is_none(), "nothing is recorded");
        std::thread::sleep(Duration::from_millis(50));
    }
    let (before, clock) = (reached(&recording), Instant::now());
    std::thread::sleep(Duration::from_secs(1));
    let speed = (reached(&recording) - before) as f64 / clock.elapsed().as_secs_f64();
    // An analyzer that a busy machine keeps from reading loses snapshots, and says so: then try again with more time to
    // begin.
    let steps = [2.0, 6.0, 15.0, 30.0, 30.0, 30.0].into_iter().find_map(|seconds| {
        let from = (reached(&recording) + (speed * seconds) as u64) / 10 * 10 + 10;
        watched(folder.path(), &name, (from, from + 60)).then_some((from, from + 60))
    });
    let steps = steps.expect("no attempt saw every snapshot");
    let stopped = Command::new("kill").args(["-INT", &process.0.id().to_string()]).status().expect("kill is there");
    assert!(stopped.success() && process.0.wait().expect("a child").code() == Some(130));
    for entry in KINDS {
        let out = format!("recorded-{}", entry.name);
        let output = analyzer(folder.path(), &["out"], entry, &out, steps).output().expect("it starts");
        assert!(output.status.success(), "{}", said(&output));
        let (live, recorded) =
            (files(&folder.path().join(format!("live-{}", entry.name))), files(&folder.path().join(out)));
        assert!(live.len() >= 2 && live == recorded, "{}: {:?}", entry.name, live.keys());
    }
    // Negative control: other steps give other files.
    let entry = find("clusters").expect("a kind");
    analyzer(folder.path(), &["out"], entry, "other", (0, steps.1)).output().expect("it starts");
    assert!(files(&folder.path().join("other")) != files(&folder.path().join("live-clusters")));
}
