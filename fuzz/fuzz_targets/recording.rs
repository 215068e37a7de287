//! Any bytes as a recording: reading, verifying and recovering end, and what was recovered can be read to its end.
#![no_main]

use libfuzzer_sys::fuzz_target;
use squirm::recording::{Series, recover, verify};
use squirm::wire::{Kind, Snapshot};
use std::path::Path;

fn read(path: &Path) -> Result<u64, squirm::recording::RecordingError> {
    let mut series = Series::open(path, &Kind::ALL)?;
    let mut messages = 0;
    while let Some(message) = series.next_message()? {
        Snapshot::parse(&message).expect("only snapshots are given");
        messages += 1;
    }
    Ok(messages)
}

fuzz_target!(|bytes: &[u8]| {
    // Memory, not a disk: a file is written for every input.
    let folder = Path::new("/dev/shm");
    let [path, out] = ["in", "out"].map(|name| folder.join(format!("squirm-fuzz-{}-{name}.mcap", std::process::id())));
    std::fs::write(&path, bytes).expect("written");
    let _ = std::fs::remove_file(&out);
    let given = read(&path);
    let _ = verify(&path);
    if recover(&path, &out).is_ok() {
        let saved = read(&out);
        // An interrupted sequence, or a run in two files, is refused in both.
        if let (Ok(given), Ok(saved)) = (given, saved) {
            assert!(saved >= given, "{given} snapshots are read, {saved} recovered");
        }
    }
});
