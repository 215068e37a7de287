//! What a user types: single keys on a terminal, lines through a pipe.

use squirm::recording::Moment;
use squirm::replay::Command;
use std::io::Read;
use std::sync::mpsc::{Receiver, channel};

/// Listens on standard input, on a thread of its own that ends with the program.
pub struct Keys {
    commands: Receiver<Command>,
    mode: Option<terminal::Mode>,
    listens: bool,
}

impl Keys {
    /// Begins to listen, unless standard input is the terminal of somebody else: a program in the background that reads from it is stopped.
    pub fn new() -> Self {
        let (sender, commands) = channel();
        let mode = terminal::Mode::single_keys();
        let listens = mode.is_some() || !std::io::IsTerminal::is_terminal(&std::io::stdin());
        let single = mode.is_some();
        if listens {
            std::thread::spawn(move || {
                let mut typed = Vec::new();
                let mut buffer = [0; 64];
                while let Ok(n @ 1..) = std::io::stdin().lock().read(&mut buffer) {
                    typed.extend_from_slice(&buffer[..n]);
                    let understood = if single { keys(&mut typed) } else { lines(&mut typed) };
                    if understood.into_iter().any(|command| sender.send(command).is_err()) {
                        return;
                    }
                }
            });
        }
        Self { commands, mode, listens }
    }

    /// What to type.
    pub fn help(&self) -> &'static str {
        match (&self.mode, self.listens) {
            (Some(_), _) => "space holds, arrows jump, q ends",
            (None, true) => "lines `pause`, `forward`, `back`, `seek STEP|TIMEtau`, `quit` steer it",
            (None, false) => "Ctrl-C ends",
        }
    }

    /// The next command, if there is one.
    pub fn next(&self) -> Option<Command> {
        self.commands.try_recv().ok()
    }
}

/// Takes whole keys from what was typed; arrows are escape sequences.
fn keys(typed: &mut Vec<u8>) -> Vec<Command> {
    let mut found = Vec::new();
    while let Some(first) = typed.first().copied() {
        let (length, command) = match (first, typed.get(1), typed.get(2)) {
            (b' ', ..) => (1, Some(Command::Pause)),
            (b'q' | b'Q', ..) => (1, Some(Command::Quit)),
            (0x1b, Some(b'[' | b'O'), Some(b'C')) => (3, Some(Command::Forward)),
            (0x1b, Some(b'[' | b'O'), Some(b'D')) => (3, Some(Command::Back)),
            (0x1b, Some(b'[' | b'O'), Some(_)) => (3, None),
            (0x1b, None, _) | (0x1b, Some(b'[' | b'O'), None) => return found,
            _ => (1, None),
        };
        typed.drain(..length);
        found.extend(command);
    }
    found
}

/// Takes whole lines from what came; a line that is no command is answered on standard error.
fn lines(typed: &mut Vec<u8>) -> Vec<Command> {
    let mut found = Vec::new();
    while let Some(end) = typed.iter().position(|b| *b == b'\n') {
        let line: Vec<u8> = typed.drain(..=end).collect();
        let line = String::from_utf8_lossy(&line);
        match line.split_whitespace().collect::<Vec<_>>()[..] {
            [] => {}
            ["pause"] => found.push(Command::Pause),
            ["forward"] => found.push(Command::Forward),
            ["back"] => found.push(Command::Back),
            ["quit"] => found.push(Command::Quit),
            ["seek", to] => match to.parse::<Moment>() {
                Ok(moment) => found.push(Command::Seek(moment)),
                Err(error) => say!("{error}"),
            },
            _ => say!("`{}` is none of: pause, forward, back, seek STEP|TIMEtau, quit", line.trim()),
        }
    }
    found
}

#[cfg(unix)]
mod terminal {
    use rustix::termios::{LocalModes, OptionalActions, Termios, isatty, tcgetattr, tcgetpgrp, tcsetattr};
    use std::io::stdin;

    /// A terminal that hands over single keys until this is dropped.
    pub struct Mode(Termios);

    impl Mode {
        pub fn single_keys() -> Option<Self> {
            let foreground = isatty(stdin()) && tcgetpgrp(stdin()).ok()? == rustix::process::getpgrp();
            let before = foreground.then(|| tcgetattr(stdin()).ok()).flatten()?;
            let mut single = before.clone();
            single.local_modes.remove(LocalModes::ICANON | LocalModes::ECHO);
            tcsetattr(stdin(), OptionalActions::Now, &single).ok()?;
            Some(Self(before))
        }
    }

    impl Drop for Mode {
        fn drop(&mut self) {
            // A terminal that has gone needs no mode.
            let _ = tcsetattr(stdin(), OptionalActions::Now, &self.0);
        }
    }
}

#[cfg(not(unix))]
mod terminal {
    pub struct Mode;

    impl Mode {
        pub fn single_keys() -> Option<Self> {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_understood_also_in_pieces() {
        let mut typed = b" x\x1b[C\x1b[A\x1b".to_vec();
        assert_eq!(keys(&mut typed), [Command::Pause, Command::Forward]);
        typed.extend_from_slice(b"[Dq");
        assert_eq!((keys(&mut typed), typed), (vec![Command::Back, Command::Quit], vec![]));
    }

    #[test]
    fn lines_are_understood_when_they_are_whole() {
        let mut typed = b"pause\nseek 20\nseek 2.5tau\nfly\nseek\n\nqu".to_vec();
        let seek = |moment| Command::Seek(moment);
        assert_eq!(lines(&mut typed), [Command::Pause, seek(Moment::Step(20)), seek(Moment::Time(2.5))]);
        typed.extend_from_slice(b"it\n");
        assert_eq!(lines(&mut typed), [Command::Quit]);
    }
}
