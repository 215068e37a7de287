//! `squirm check`: what is wrong with pipeline files, and what they mean.

use super::{load, print, render};
use squirm::config::meaning;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Checks every file; the status is that of the last file with an error.
pub fn check(files: &[PathBuf], overrides: &[String]) -> ExitCode {
    let mut status = ExitCode::SUCCESS;
    let mut text = String::new();
    for file in files {
        match load(file, overrides) {
            Ok(loaded) => {
                render::all(&loaded.warnings, &loaded.sources);
                let _ = writeln!(text, "{}", meaning(&loaded));
            }
            Err(code) => status = code,
        }
    }
    match print(&text) {
        ExitCode::SUCCESS => status,
        failed => failed,
    }
}
