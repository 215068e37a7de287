//! Ctrl-C and termination: the first signal lets a run finish its step and its files, the second ends the program at once.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Becomes the number of the first SIGINT or SIGTERM. Without handlers a signal just ends the program.
pub fn first() -> Arc<AtomicUsize> {
    let (number, again) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        // Registered in this order: the flag is looked at before it is set.
        let _ = signal_hook::flag::register_conditional_shutdown(signal, 128 + signal, again.clone());
        let _ = signal_hook::flag::register(signal, again.clone());
        let _ = signal_hook::flag::register_usize(signal, number.clone(), usize::try_from(signal).unwrap_or(0));
    }
    number
}

/// The exit status of a program that ended because of a signal, as shells report it.
pub fn status(first: &AtomicUsize) -> ExitCode {
    ExitCode::from(u8::try_from(128 + first.load(Ordering::Relaxed)).unwrap_or(u8::MAX))
}
