//! `squirm adapters`: the GPUs that a run can use.

use super::{RUN_FAILED, print};
use squirm::gpu::adapter::adapters as find;
use std::fmt::Write;
use std::process::ExitCode;

/// Lists the adapters.
pub fn adapters() -> ExitCode {
    let found = find();
    if found.is_empty() {
        say!("error: this machine has no Vulkan, Metal or DX12 adapter, not even a driver that computes on the CPU");
        say!("help: install the driver of your GPU, or Mesa's lavapipe (Debian: apt install mesa-vulkan-drivers)");
        return ExitCode::from(RUN_FAILED);
    }
    let mut text = String::new();
    for a in &found {
        let unfit = if a.usable { "" } else { " (lacks features that squirm needs)" };
        let _ = writeln!(text, "{}  {} [{}, {}] {}{unfit}", a.index, a.name, a.kind, a.backend, a.driver);
    }
    print(&text)
}
