//! Ctrl-C and termination: the first signal lets a run finish its step and its files, the second ends the program at once.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Becomes the number of the first SIGINT or SIGTERM; SIGUSR1, which batch systems send some time before they kill, counts as
/// SIGTERM. Without handlers a signal just ends the program.
pub fn first() -> Arc<AtomicUsize> {
    let (number, again) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
    for (signal, as_) in signals() {
        // Registered in this order: the flag is looked at before it is set.
        let _ = signal_hook::flag::register_conditional_shutdown(signal, 128 + as_, again.clone());
        let _ = signal_hook::flag::register(signal, again.clone());
        let _ = signal_hook::flag::register_usize(signal, number.clone(), usize::try_from(as_).unwrap_or(0));
    }
    number
}

/// Becomes true with the first of these signals, for what looks at a flag.
pub fn flag() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    for (signal, _) in signals() {
        let _ = signal_hook::flag::register(signal, flag.clone());
    }
    flag
}

/// Signals that end a run, and the number that each counts as.
fn signals() -> Vec<(i32, i32)> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    let signals = vec![(SIGINT, SIGINT), (SIGTERM, SIGTERM)];
    #[cfg(unix)]
    let signals = [signals, vec![(signal_hook::consts::SIGUSR1, SIGTERM)]].concat();
    signals
}

/// The exit status of a program that ended because of a signal, as shells report it.
pub fn status(first: &AtomicUsize) -> ExitCode {
    ExitCode::from(u8::try_from(128 + first.load(Ordering::Relaxed)).unwrap_or(u8::MAX))
}
