//! Shared memory that is too small, or fills up while a run goes: refused with the sizes, or done without; never a bus error.

use super::child::Trial;
use super::table::Row;
use std::path::Path;
use std::process::{Command, Stdio};

/// All particles and the scalars: 12 messages of both are about 1.2 MB.
const BULKY: &str = "output = [{ publish = [\"particles\", \"scalars\"], every = 2, fraction = 1.0 }]\n";
/// Nothing but the status.
const BARE: &str = "output = [{ record = [\"scalars\"], every = 2 }]\n";
/// The status with which the script says that it may not mount.
const FORBIDDEN: i32 = 99;

/// What is done where shared memory has a certain size.
struct Place {
    claim: &'static str,
    /// Size of /dev/shm.
    size: &'static str,
    outputs: &'static str,
    overrides: &'static [&'static str],
    /// Shell: `$@` is the command that runs.
    script: &'static str,
    status: i32,
    /// What it has to say.
    parts: &'static [&'static str],
}

/// Fills shared memory in the middle of a run, lets a reader come, makes room and lets another one come.
const FILL: &str = r#"
"$@" & run=$!
until "$0" tap "$NAME" scalars --count 1 --for 1 >/dev/null 2>&1; do kill -0 $run || exit 98; done
dd if=/dev/zero of=/dev/shm/fill bs=4k 2>/dev/null
sleep 1
"$0" tap "$NAME" scalars --count 1 --for 1 >/dev/null 2>&1
"$0" ps >/dev/null 2>&1
rm /dev/shm/fill
sleep 1
"$0" tap "$NAME" scalars --count 3 --for 20 --json >seen || exit 97
[ "$(wc -l <seen)" -eq 3 ] || exit 96
kill -INT $run
wait $run
"#;

const PLACES: &[Place] = &[
    Place {
        claim: "shared memory of 64 MB, as in a container, is enough for a small run",
        size: "64m",
        outputs: BULKY,
        overrides: &["run.steps=20"],
        script: "exec \"$@\"",
        status: 0,
        parts: &[],
    },
    Place {
        claim: "of 1 MB it is refused at the start, with sizes and cure",
        size: "1m",
        outputs: BULKY,
        overrides: &["run.steps=20"],
        script: "exec \"$@\"",
        status: 1,
        parts: &[
            "shared memory is too small: publishing scalars, particles needs ",
            " bytes in /dev/shm, ",
            " are free",
            "--shm-size",
            "live = false",
        ],
    },
    Place {
        claim: "with live = false the same run goes",
        size: "1m",
        outputs: BULKY,
        overrides: &["run.steps=20", "run.live=false"],
        script: "exec \"$@\"",
        status: 0,
        parts: &[],
    },
    Place {
        claim: "of 64 kB a run that publishes nothing goes, with a warning",
        size: "64k",
        outputs: BARE,
        overrides: &["run.steps=20"],
        script: "exec \"$@\"",
        status: 0,
        parts: &["this run cannot be watched: shared memory is too small"],
    },
    Place {
        claim: "of one page, too",
        size: "4k",
        outputs: BARE,
        overrides: &["run.steps=20"],
        script: "exec \"$@\"",
        status: 0,
        parts: &["this run cannot be watched"],
    },
    Place {
        claim: "full in the middle of a run it costs snapshots and no more: readers come again when there is room",
        size: "16m",
        outputs: BULKY,
        overrides: &["run.steps=1000000000"],
        script: FILL,
        status: 130,
        parts: &["is full: nothing is published until there is room"],
    },
];

/// Tries them all.
pub fn memory(squirm: &Path) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    for place in PLACES {
        let mut row = Row::new(place.claim);
        match tried(squirm, place)? {
            None => row.figures = "this user may not mount another shared memory".into(),
            Some(found) => row.enter(found),
        }
        rows.push(row);
    }
    Ok(rows)
}

/// In a mount namespace of its own; `None` where the system does not allow it.
fn tried(squirm: &Path, place: &Place) -> Result<Option<Result<(), String>>, String> {
    let trial = Trial::with(squirm, place.outputs, place.overrides)?;
    let script = format!("mount -t tmpfs -o size={} tmpfs /dev/shm || exit {FORBIDDEN}; {}", place.size, place.script);
    // A domain of its own, too: files of this one would outlive their memory.
    let tmp = trial.folder().join("tmp");
    std::fs::create_dir(&tmp).map_err(|e| e.to_string())?;
    let run = trial.command(&trial.dir());
    let mut command = Command::new("unshare");
    command.args(["-m", "sh", "-c", &script]).arg(run.get_program()).arg(run.get_program()).args(run.get_args());
    command.current_dir(trial.folder()).env("NO_COLOR", "1").env("NAME", trial.name()).env("TMPDIR", tmp);
    let Ok(output) = command.stdin(Stdio::null()).output() else { return Ok(None) };
    let said = String::from_utf8_lossy(&output.stderr);
    if output.status.code() == Some(FORBIDDEN) || said.contains("unshare failed") {
        return Ok(None);
    }
    if output.status.code() != Some(place.status) {
        return Ok(Some(Err(format!("{}: {said}", output.status))));
    }
    let missing = place.parts.iter().find(|part| !said.contains(**part));
    Ok(Some(missing.map_or(Ok(()), |part| Err(format!("it does not say `{part}`: {said}")))))
}
