//! Small shared memory, in a mount namespace of its own: refused with the sizes, or done without; never a bus error.

use super::{prepared, squirm};
use std::path::Path;
use std::process::Command;

/// Runs `squirm` where /dev/shm has this size; `None` where the system does not allow to try. Exit status and standard error.
fn with_memory(size: &str, folder: &Path, name: &str, set: &[&str]) -> Option<(Option<i32>, String)> {
    let script = format!(
        "mount -t tmpfs -o size={size} tmpfs /dev/shm || exit 99; exec {} run {name}.toml --out out-{size} {}",
        env!("CARGO_BIN_EXE_squirm"),
        set.iter().map(|s| format!("--set {s}")).collect::<Vec<_>>().join(" ")
    );
    let mut command = Command::new("unshare");
    // A domain of its own, too: files of this one would outlive their memory.
    let tmp = folder.join("tmp");
    std::fs::create_dir_all(&tmp).expect("made");
    command.args(["-m", "sh", "-c", &script]).current_dir(folder).env("NO_COLOR", "1").env("TMPDIR", tmp);
    let output = command.output().ok()?;
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.code() == Some(99) || said.contains("unshare failed") {
        eprintln!("not tried, since no other shared memory can be mounted here: {said}");
        return None;
    }
    Some((output.status.code(), said))
}

#[test]
fn sixty_four_megabytes_are_used_as_far_as_they_go() {
    // 12 messages of all 3,000 particles are 1.3 MB.
    let output = "[[output]]\npublish = [\"particles\", \"scalars\"]\nevery = 2\nfraction = 1.0\n";
    let (folder, name) = prepared("small", output);
    let short = "run.steps=20";
    let Some((code, said)) = with_memory("64m", folder.path(), &name, &[short]) else { return };
    assert_eq!(code, Some(0), "{said}");
    let (code, said) = with_memory("1m", folder.path(), &name, &[short]).expect("as before");
    assert_eq!(code, Some(1), "{said}");
    let parts = [
        "shared memory is too small: publishing scalars, particles needs ",
        " bytes in /dev/shm, ",
        " are free",
        "--shm-size",
        "live = false",
    ];
    parts.iter().for_each(|part| assert!(said.contains(part), "{part}: {said}"));
    assert!(!folder.path().join("out-1m").exists(), "nothing is left of a run that was refused");
    let (code, said) = with_memory("1m", folder.path(), &name, &[short, "run.live=false"]).expect("as before");
    assert_eq!(code, Some(0), "{said}");
}

#[test]
fn a_run_that_publishes_nothing_does_without_shared_memory() {
    let (folder, name) = prepared("tiny", "");
    let Some((code, said)) = with_memory("64k", folder.path(), &name, &["run.steps=20"]) else { return };
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("this run cannot be watched: shared memory is too small"), "{said}");
    let ended = squirm(folder.path(), &["check", &format!("{name}.toml")]);
    assert_eq!(ended.0, Some(0));
}
