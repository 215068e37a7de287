//! `squirm adapters`: the GPUs that a run can use.

use super::RUN_FAILED;
use std::process::ExitCode;

/// Lists the adapters.
pub fn adapters() -> ExitCode {
    eprintln!("error: this build cannot list adapters");
    ExitCode::from(RUN_FAILED)
}
