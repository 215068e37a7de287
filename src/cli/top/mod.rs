//! `squirm top`: a run that is going, on a terminal, until the user leaves; plain lines elsewhere.

mod board;
mod view;

use super::{RUN_FAILED, signals};
use board::{Board, News};
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use squirm::analyze::{self, Limits, Live, Source};
use squirm::wire::{Kind, Status};
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// Longest time between two pictures.
const PICTURE: Duration = Duration::from_millis(100);
/// Time between two looks at who reads what.
const READERS: Duration = Duration::from_secs(1);

/// Arguments of `squirm top`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Name of the run, as `squirm ps` lists it; may be left out if only one is going.
    run: Option<String>,
}

/// Watches the run.
pub fn top(args: &Args) -> ExitCode {
    let failed = |error: &dyn std::fmt::Display| {
        say!("error: {error}");
        ExitCode::from(RUN_FAILED)
    };
    let run = match args.run.clone().map_or_else(only_run, Ok) {
        Ok(run) => run,
        Err(error) => return failed(&error),
    };
    // Asked first, so that a wrong name is an error and not an empty picture.
    if let Err(error) = exists(&run) {
        return failed(&error);
    }
    let signal = signals::first();
    let (sender, news) = channel();
    follow(&run, sender);
    let mut board = Board::new(&run);
    if std::io::stdout().is_terminal() && std::io::stdin().is_terminal() {
        if let Err(error) = picture(&mut board, &news, &signal) {
            return failed(&format!("the terminal cannot be used: {error}"));
        }
    } else {
        say!("no terminal: one line a second; `squirm top` draws where standard input and output are a terminal");
        lines(&mut board, &news, &signal);
    }
    if signal.load(Ordering::Relaxed) != 0 {
        return signals::status(&signal);
    }
    if board.died() { failed(&board.ending()) } else { ExitCode::SUCCESS }
}

/// The run, if there is only one.
fn only_run() -> Result<String, String> {
    let runs = analyze::running().map_err(|e| e.to_string())?;
    match &runs[..] {
        [] => Err("no run of yours is going on this machine".into()),
        [run] => Ok(run.name.clone()),
        more => {
            let names: Vec<&str> = more.iter().map(|r| r.name.as_str()).collect();
            Err(format!("several runs are going: name one of {}", names.join(", ")))
        }
    }
}

fn exists(run: &str) -> Result<(), String> {
    let runs = analyze::running().map_err(|e| e.to_string())?;
    match runs.iter().find(|r| r.name == run) {
        Some(found) if found.topics.iter().any(|(kind, _)| *kind == Kind::Status) => Ok(()),
        Some(_) => Err(format!("`{run}` tells no status; `squirm tap` prints its topics")),
        None => {
            let names: Vec<&str> = runs.iter().map(|r| r.name.as_str()).collect();
            let list = if names.is_empty() { "no run is going".into() } else { format!("going: {}", names.join(", ")) };
            Err(format!("no run named `{run}` is going here; {list}"))
        }
    }
}

/// Two threads that end with the program: one waits for statuses, one looks for readers.
fn follow(run: &str, sender: Sender<News>) {
    let (name, statuses) = (run.to_owned(), sender.clone());
    std::thread::spawn(move || {
        let ending = Live::new(&name, Limits::default()).drive(&[Kind::Status], &mut |snapshot| {
            let news = News::Status(snapshot.header.stamp(), Box::new(Status::decode(snapshot)?));
            Ok(if statuses.send(news).is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) })
        });
        let _ = statuses.send(News::Over(ending.err().map(|e| e.to_string())));
    });
    let name = run.to_owned();
    std::thread::spawn(move || {
        loop {
            let runs = analyze::running().unwrap_or_default();
            let topics = runs.into_iter().find(|r| r.name == name).map_or(Vec::new(), |r| r.topics);
            if sender.send(News::Topics(topics)).is_err() {
                return;
            }
            std::thread::sleep(READERS);
        }
    });
}

/// Draws until the user leaves. The terminal is given back also after an error.
fn picture(board: &mut Board, news: &Receiver<News>, signal: &AtomicUsize) -> std::io::Result<()> {
    let mut terminal = ratatui::try_init()?;
    let mut turn = || -> std::io::Result<()> {
        loop {
            news.try_iter().for_each(|n| board.take(n));
            terminal.draw(|frame| view::draw(frame, board))?;
            if signal.load(Ordering::Relaxed) != 0 {
                return Ok(());
            }
            // A resized terminal is drawn anew like any other.
            if event::poll(PICTURE)? && leaves(&event::read()?) {
                return Ok(());
            }
        }
    };
    let done = turn();
    ratatui::try_restore()?;
    done
}

/// q, Escape or Ctrl-C, which is no signal while a program draws.
fn leaves(event: &Event) -> bool {
    let Event::Key(key) = event else { return false };
    let control = key.modifiers.contains(KeyModifiers::CONTROL);
    key.kind == KeyEventKind::Press
        && (matches!(key.code, KeyCode::Char('q') | KeyCode::Esc) || (control && key.code == KeyCode::Char('c')))
}

/// One line for each status, until the run ends.
fn lines(board: &mut Board, news: &Receiver<News>, signal: &AtomicUsize) {
    let mut last = Instant::now();
    while signal.load(Ordering::Relaxed) == 0 && board.is_going() {
        match news.recv_timeout(PICTURE) {
            Ok(n) => {
                let told = matches!(n, News::Status(..));
                board.take(n);
                if told && super::print(&format!("{}\n", board.line())) != ExitCode::SUCCESS {
                    return;
                }
                last = Instant::now();
            }
            Err(RecvTimeoutError::Timeout) if last.elapsed() > board::SILENCE => {
                last = Instant::now();
                say!("{}", board.ending());
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
    if !board.is_going() && !board.died() {
        super::print(&format!("{}\n", board.ending()));
    }
}
