//! Readers that are slower than the run: how long it waits for them, what is lost, and that nothing hangs on the dead or stopped.
#![cfg(unix)]

use squirm::analyze::{Limits, Live, Source};
use squirm::sink::{Offer, OnSlow, Publisher, SinkError};
use squirm::wire::{Kind, Scalars, Stamp};
use std::ops::ControlFlow;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(60);

fn message(seq: u64) -> Vec<u8> {
    let mut scalars = Scalars::default();
    scalars.push("temperature", "kT", 1.0);
    scalars.encode(&Stamp { seq, step: seq, ..Stamp::default() })
}

fn unique(name: &str) -> String {
    format!("{name}-{}", std::process::id())
}

fn open(run: &str, on_slow: OnSlow) -> Publisher {
    Publisher::offer(run, &[Offer { kind: Kind::Scalars, max: message(0).len(), on_slow }]).expect("shared memory")
}

/// Not a test of its own: a reader that takes one snapshot and then no more for an hour.
#[test]
fn reads_one_and_sleeps() {
    let Ok(run) = std::env::var("SQUIRM_TEST_SLEEPER") else { return };
    let _ = Live::new(&run, Limits::default()).drive(&[Kind::Scalars], &mut |_| {
        std::thread::sleep(Duration::from_secs(3600));
        Ok(ControlFlow::Continue(()))
    });
}

struct Sleeper(Child);

impl Drop for Sleeper {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Sleeper {
    /// A reader that has taken a snapshot of `publisher`, whose next messages have these numbers.
    fn attach(run: &str, publisher: &mut Publisher, seq: &mut u64) -> Self {
        let child = Command::new(std::env::current_exe().expect("a name"))
            .args(["--exact", "reads_one_and_sleeps", "--test-threads", "1"])
            .env("SQUIRM_TEST_SLEEPER", run)
            .stdout(Stdio::null())
            .spawn()
            .expect("it starts");
        let begun = Instant::now();
        while publisher.publish(&message(*seq)).expect("published") == 0 {
            assert!(begun.elapsed() < PATIENCE, "the reader does not come");
            *seq += 1;
            std::thread::sleep(Duration::from_millis(5));
        }
        // It has woken up and sleeps over its first snapshot.
        std::thread::sleep(Duration::from_millis(500));
        Self(child)
    }

    fn signal(&self, signal: &str) {
        let sent = Command::new("kill").args([signal, &self.0.id().to_string()]).status().expect("kill is there");
        assert!(sent.success());
    }
}

/// Publishes until a message takes longer than `long`, and says how long it took.
fn until_full(publisher: &mut Publisher, seq: &mut u64, long: Duration) -> Result<Duration, SinkError> {
    for _ in 0..10 {
        *seq += 1;
        let begun = Instant::now();
        publisher.publish(&message(*seq))?;
        if begun.elapsed() >= long {
            return Ok(begun.elapsed());
        }
    }
    panic!("no message had to wait");
}

#[test]
fn a_reader_that_is_slow_within_the_limit_loses_nothing() {
    let run = unique("patient");
    let mut publisher = open(&run, OnSlow::Block(PATIENCE));
    let reader = {
        let run = run.clone();
        std::thread::spawn(move || {
            let mut seen = Vec::new();
            let ending = Live::new(&run, Limits::default()).drive(&[Kind::Scalars], &mut |s| {
                seen.push(s.header.seq);
                std::thread::sleep(Duration::from_millis(3));
                Ok(ControlFlow::Continue(()))
            });
            (seen, ending.expect("it ends"))
        })
    };
    let (mut seq, mut reached) = (0, 0);
    let begun = Instant::now();
    while reached < 200 {
        assert!(begun.elapsed() < PATIENCE, "the reader does not come");
        reached += publisher.publish(&message(seq)).expect("published");
        seq += 1;
        std::thread::sleep(Duration::from_micros(if reached == 0 { 1000 } else { 0 }));
    }
    assert_eq!(publisher.dropped(), 0);
    drop(publisher);
    let (seen, ending) = reader.join().expect("no panic");
    assert_eq!(ending.lost, 0, "{ending:?}");
    assert!(seen.len() >= 200 && seen.windows(2).all(|w| w[1] == w[0] + 1) && seen.last() == Some(&(seq - 1)));
}

#[test]
fn a_stopped_reader_costs_the_limit_once_and_is_waited_for_again_when_it_has_caught_up() {
    let run = unique("stopped");
    let limit = Duration::from_millis(400);
    let mut publisher = open(&run, OnSlow::Block(limit));
    let mut seq = 0;
    let sleeper = Sleeper::attach(&run, &mut publisher, &mut seq);
    sleeper.signal("-STOP");
    let waited = until_full(&mut publisher, &mut seq, limit / 2).expect("block never ends a run");
    assert!(waited >= limit && waited < limit + Duration::from_secs(5), "{waited:?}");
    assert_eq!(publisher.dropped(), 1);
    let begun = Instant::now();
    for i in 0..50 {
        publisher.publish(&message(seq + 1 + i)).expect("published");
    }
    assert!(begun.elapsed() < 20 * limit, "50 messages wait for nobody: {:?}", begun.elapsed());
    assert_eq!(publisher.dropped(), 51);
    sleeper.signal("-CONT");
}

#[test]
fn a_killed_reader_is_not_waited_for() {
    let run = unique("corpse");
    let mut publisher = open(&run, OnSlow::Block(Duration::from_secs(3600)));
    let mut seq = 0;
    let mut sleeper = Sleeper::attach(&run, &mut publisher, &mut seq);
    sleeper.0.kill().expect("killed");
    sleeper.0.wait().expect("a child");
    let begun = Instant::now();
    for i in 0..20 {
        publisher.publish(&message(seq + 1 + i)).expect("published");
    }
    eprintln!("20 messages with a killed reader: {:?}", begun.elapsed());
    assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
    assert_eq!(publisher.dropped(), 0, "the dead lose nothing");
}

#[test]
fn abort_ends_the_run_with_the_name_of_the_topic() {
    let run = unique("abort");
    let limit = Duration::from_millis(300);
    let mut publisher = open(&run, OnSlow::Abort(limit));
    let mut seq = 0;
    let _sleeper = Sleeper::attach(&run, &mut publisher, &mut seq);
    let error = until_full(&mut publisher, &mut seq, PATIENCE).expect_err("it ends");
    assert!(matches!(error, SinkError::SlowReader { topic: "scalars", limit: l } if l == limit), "{error}");
    assert!(error.to_string().contains("took no snapshot for 0.3 s"), "{error}");
}

#[test]
fn a_wait_can_be_cut_short() {
    let run = unique("hurry");
    let mut publisher = open(&run, OnSlow::Block(Duration::from_secs(3600)));
    let mut seq = 0;
    let _sleeper = Sleeper::attach(&run, &mut publisher, &mut seq);
    let hurry = publisher.hurrier();
    std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(300));
        hurry();
    });
    let waited = until_full(&mut publisher, &mut seq, Duration::from_millis(50)).expect("no error");
    assert!(waited < Duration::from_secs(20), "{waited:?}");
}

/// What coming, going and dying readers cost the one who publishes.
#[test]
fn ten_kills_of_a_reader_do_not_stall_the_publisher() {
    let run = unique("kills");
    let mut publisher = open(&run, OnSlow::Drop);
    let (mut seq, mut longest) = (0, Duration::ZERO);
    for _ in 0..10 {
        let mut sleeper = Sleeper::attach(&run, &mut publisher, &mut seq);
        sleeper.0.kill().expect("killed");
        sleeper.0.wait().expect("a child");
        for _ in 0..100 {
            seq += 1;
            let begun = Instant::now();
            publisher.publish(&message(seq)).expect("published");
            publisher.welcome();
            longest = longest.max(begun.elapsed());
            std::thread::sleep(Duration::from_millis(1));
        }
        // What the next reader does when it comes.
        Publisher::open(&unique("other"), &[]).expect("shared memory");
    }
    eprintln!("longest call with ten killed readers: {longest:?}");
    assert!(longest < Duration::from_secs(2), "{longest:?}");
}
