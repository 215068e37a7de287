//! `squirm info`, `verify`, `recover`, `cut`, `merge` as a user calls them, with right and wrong input.

use crate::made::{messages, name, record};
use squirm::recording::{Series, info};
use squirm::wire::Kind;
use std::path::Path;
use std::process::Command;

/// Status, standard output and standard error.
fn squirm(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_squirm"));
    let output = command.current_dir(folder).args(arguments).env("NO_COLOR", "1").output().expect("it starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("not killed"), text(output.stdout), text(output.stderr))
}

#[track_caller]
fn says(folder: &Path, arguments: &[&str], status: i32, part: &str) {
    let (code, out, err) = squirm(folder, arguments);
    assert!(code == status && (out.contains(part) || err.contains(part)), "{arguments:?}: {code}\n{out}\n{err}");
}

/// All messages of a recording and its warnings.
fn read(path: &Path, kinds: &[Kind]) -> (Vec<Vec<u8>>, Vec<String>) {
    let mut series = Series::open(path, kinds).unwrap();
    let mut given = Vec::new();
    while let Some(message) = series.next_message().unwrap() {
        given.push(message);
    }
    (given, series.finish().warnings)
}

/// A run whose first segment was killed while it wrote moment 5, and that was resumed from moment 3: `run.0001.mcap` and so on.
fn resumed(dir: &Path) {
    let first = tempfile::tempdir().unwrap();
    let second = tempfile::tempdir().unwrap();
    record(first.path(), 1, 0..6);
    record(second.path(), 1, 3..9);
    for stem in ["run", "run.fluid"] {
        let bytes = std::fs::read(first.path().join(format!("{stem}.mcap"))).unwrap();
        let chunks = mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes;
        // Moment 5 has three chunks of small topics, or one of particles and one for viewers.
        let last = chunks[chunks.len() - if stem == "run" { 3 } else { 2 }].chunk_start_offset as usize;
        std::fs::write(dir.join(format!("{stem}.mcap")), &bytes[..last + 50]).unwrap();
        std::fs::copy(second.path().join(format!("{stem}.mcap")), dir.join(format!("{stem}.0001.mcap"))).unwrap();
    }
}

#[test]
fn a_resumed_run_is_read_whole_and_nothing_twice() {
    let dir = tempfile::tempdir().unwrap();
    resumed(dir.path());
    let expected: Vec<Vec<u8>> = (0..9).flat_map(|seq| messages(1, seq)).collect();
    for path in [dir.path().to_owned(), dir.path().join("run.mcap")] {
        let (given, warnings) = read(&path, &Kind::ALL);
        assert_eq!(given.len(), 36);
        assert_eq!(given, expected);
        assert!(warnings.len() == 2 && warnings[0].contains("ends in the middle"), "{warnings:?}");
    }
    let (particles, _) = read(dir.path(), &[Kind::Particles]);
    assert_eq!(
        particles.iter().map(|m| name(m)).collect::<Vec<_>>(),
        (0..9).map(|s| (Kind::Particles, 20 * s)).collect::<Vec<_>>()
    );
    let (later, _) = read(&dir.path().join("run.0001.mcap"), &[Kind::Scalars]);
    assert_eq!(later.len(), 6, "a later segment stands alone");
}

#[test]
fn a_merged_run_is_one_clean_file() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    resumed(dir.path());
    says(dir.path(), &["merge", "run.0001.mcap", "run.mcap", "--out", "all.mcap"], 0, "27 snapshots");
    says(dir.path(), &["verify", "all.mcap"], 0, "clean: 27 whole chunks, 27 snapshots");
    let small = [Kind::Squirmers, Kind::Scalars, Kind::Fields];
    assert_eq!(read(&at("all.mcap"), &small), (read(dir.path(), &small).0, Vec::new()));
    let merged = info(&at("all.mcap")).unwrap();
    assert!(merged.topics.iter().all(|(_, t)| t.count == 9), "{merged:?}");
    says(dir.path(), &["merge", ".", "--out", "all.mcap"], 2, "exists already");
    says(dir.path(), &["merge", "run.fluid.mcap", "--out", "fluid.mcap"], 0, "9 snapshots");
    says(dir.path(), &["verify", "fluid.mcap"], 0, "clean");
    assert_eq!(read(&at("fluid.mcap"), &[Kind::Particles]).0.len(), 9);
    // Another run is refused, with the reason, and nothing is left.
    let other = tempfile::tempdir().unwrap();
    record(other.path(), 2, 6..8);
    let foreign = other.path().join("run.mcap");
    says(dir.path(), &["merge", "run.mcap", foreign.to_str().unwrap(), "--out", "no.mcap"], 2, "different runs (0101");
    assert!(!at("no.mcap").exists());
    std::fs::copy(&foreign, at("run.0002.mcap")).unwrap();
    let mut series = Series::open(dir.path(), &[Kind::Scalars]).unwrap();
    let failed = std::iter::from_fn(|| series.next_message().transpose()).find_map(Result::err);
    assert!(failed.is_some_and(|e| e.to_string().contains("come from different runs")));
    says(dir.path(), &["verify", "run.mcap"], 1, "comes from another run");
}

#[test]
fn a_hole_between_segments_is_told() {
    let dir = tempfile::tempdir().unwrap();
    for (number, moments) in [("", 0..3), (".0001", 5..7)] {
        let made = tempfile::tempdir().unwrap();
        record(made.path(), 1, moments);
        std::fs::copy(made.path().join("run.mcap"), dir.path().join(format!("run{number}.mcap"))).unwrap();
    }
    let (given, warnings) = read(dir.path(), &[Kind::Scalars]);
    assert_eq!((given.len(), warnings), (5, vec!["2 snapshots that the run made are not in its recording".to_owned()]));
    says(dir.path(), &["merge", ".", "--out", "all.mcap"], 0, "6 snapshots of the run are in none of the files");
    says(dir.path(), &["verify", "all.mcap"], 1, "2 snapshots of scalars between steps 40 and 100 are missing");
}

#[test]
fn a_part_is_cut_out() {
    let dir = tempfile::tempdir().unwrap();
    record(dir.path(), 1, 0..10);
    let steps = |file: &str, kind: Kind| -> Vec<u64> {
        read(&dir.path().join(file), &[kind]).0.iter().map(|m| name(m).1).collect()
    };
    says(
        dir.path(),
        &["cut", "run.mcap", "--from", "40", "--to", "6tau", "--out", "a.mcap"],
        0,
        "15 snapshots, 50 messages",
    );
    assert_eq!(steps("a.mcap", Kind::Fields), [40, 60, 80, 100, 120]);
    says(dir.path(), &["verify", "a.mcap"], 0, "clean");
    let arguments = ["cut", ".", "--every", "4", "--topics", "squirmers,/squirmers/scene", "--out", "b.mcap"];
    says(dir.path(), &arguments, 0, "3 snapshots, 6 messages");
    assert_eq!((steps("b.mcap", Kind::Squirmers), steps("b.mcap", Kind::Scalars)), (vec![0, 80, 160], vec![]));
    // What was left out on purpose is not missing.
    says(dir.path(), &["verify", "b.mcap"], 0, "clean");
    let first = info(&dir.path().join("b.mcap")).unwrap();
    assert_eq!(first.attachments.keys().collect::<Vec<_>>(), ["pipeline.toml", "provenance.json"]);
    assert_eq!((first.run.as_deref(), first.seed.as_deref()), (Some("made"), Some("7")));
    says(
        dir.path(),
        &["cut", "run.mcap", "--from", "500", "--out", "c.mcap"],
        2,
        "no snapshot of any topic in that range",
    );
    let reversed = "the range is reversed: it begins at step 10 and ends at step 5";
    says(dir.path(), &["cut", "run.mcap", "--from", "10", "--to", "5", "--out", "c.mcap"], 2, reversed);
    says(dir.path(), &["replay", "run.mcap", "--from", "10", "--to", "5"], 2, reversed);
    says(dir.path(), &["cut", "run.mcap", "--from", "5s", "--out", "c.mcap"], 2, "neither a step");
    says(dir.path(), &["cut", "run.mcap", "--every", "0", "--out", "c.mcap"], 2, "--every");
    says(dir.path(), &["cut", "absent.mcap", "--out", "c.mcap"], 2, "there is no recording absent.mcap");
    says(dir.path(), &["cut", "run.mcap", "--out", "a.mcap"], 2, "exists already");
    assert!(!dir.path().join("c.mcap").exists());
}

/// A folder means all that the run recorded: a fluid that is damaged must not pass as clean.
#[test]
fn a_folder_means_all_of_its_recordings() {
    let dir = tempfile::tempdir().unwrap();
    record(dir.path(), 1, 0..4);
    says(dir.path(), &["verify", "."], 0, ".: clean: 20 whole chunks, 16 snapshots in 2 files");
    says(dir.path(), &["info", "."], 0, "run.fluid.mcap: ");
    says(dir.path(), &["info", "."], 0, "/squirm/particles");
    let apart = "warning: the particles are not taken along: name their recording by itself, ./run.fluid.mcap";
    says(dir.path(), &["cut", ".", "--out", "part.mcap"], 0, apart);
    says(dir.path(), &["merge", ".", "--out", "whole.mcap"], 0, apart);
    let particles = ["cut", ".", "--topics", "particles", "--out", "none.mcap"];
    says(dir.path(), &particles, 2, "no snapshot of particles in that range; the particles are not taken along");
    let path = dir.path().join("run.fluid.mcap");
    let mut bytes = std::fs::read(&path).unwrap();
    let chunk = mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes[1].clone();
    bytes[(chunk.chunk_start_offset + chunk.chunk_length - 9) as usize] ^= 4;
    std::fs::write(&path, bytes).unwrap();
    says(dir.path(), &["verify", "."], 1, ".: DAMAGED");
    says(dir.path(), &["verify", "."], 1, "run.fluid.mcap, byte ");
    says(dir.path(), &["info", "."], 0, "warning: ./run.fluid.mcap, byte ");
    says(dir.path(), &["verify", "run.mcap"], 0, "clean");
    // The fluid of another run does not belong there.
    let other = tempfile::tempdir().unwrap();
    record(other.path(), 2, 0..4);
    std::fs::copy(other.path().join("run.fluid.mcap"), &path).unwrap();
    says(dir.path(), &["verify", "."], 1, "comes from another run");
}

#[test]
fn info_tells_what_there_is() {
    let dir = tempfile::tempdir().unwrap();
    record(dir.path(), 1, 0..3);
    let (code, out, err) = squirm(dir.path(), &["info", "."]);
    assert_eq!((code, err.as_str()), (0, ""));
    for part in
        ["made  (id 0101", "seed      7", "pipeline.toml: 10 B", "/squirm/fields", "0..40", "0..2", "8 x 8 x 8 a"]
    {
        assert!(out.contains(part), "{part}: {out}");
    }
    let (_, json, _) = squirm(dir.path(), &["info", "run.mcap", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!((&json["run"], &json["seed"], &json["version"]), (&"made".into(), &"7".into(), &"0".into()));
    assert_eq!(
        (&json["topics"]["/squirm/scalars"]["count"], &json["topics"]["/squirm/scalars"]["steps"][1]),
        (&3.into(), &40.into())
    );
    assert!(json["uncompressed"].as_u64() > json["compressed"].as_u64() && json["files"][0]["complete"] == true);
    std::fs::write(dir.path().join("text.mcap"), "x,y,z\n1,2,3\n").unwrap();
    says(dir.path(), &["info", "text.mcap"], 1, "text.mcap is no recording");
    says(dir.path(), &["info", "absent"], 2, "there is no recording absent");
}

#[test]
fn recover_says_what_it_could_not_save() {
    let dir = tempfile::tempdir().unwrap();
    record(dir.path(), 1, 0..4);
    says(
        dir.path(),
        &["recover", "run.mcap"],
        0,
        "run.recovered.mcap: 40 of 40 messages in 12 chunks, 2 attachments; nothing was lost",
    );
    let all: Vec<Vec<u8>> = read(&dir.path().join("run.mcap"), &Kind::ALL[..3]).0;
    assert_eq!(read(&dir.path().join("run.recovered.mcap"), &Kind::ALL[..3]).0, all);
    // One bit of the second chunk, which holds the scalars of the first moment.
    let mut bytes = std::fs::read(dir.path().join("run.mcap")).unwrap();
    let chunk = mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes[1].clone();
    bytes[(chunk.chunk_start_offset + chunk.chunk_length - 9) as usize] ^= 4;
    std::fs::write(dir.path().join("bad.mcap"), &bytes).unwrap();
    let place = format!("bad.mcap, byte {}: a chunk", chunk.chunk_start_offset);
    says(dir.path(), &["verify", "bad.mcap"], 1, &place);
    says(dir.path(), &["cut", "bad.mcap", "--out", "no.mcap"], 1, "`squirm recover` keeps what is whole");
    says(
        dir.path(),
        &["recover", "bad.mcap", "--out", "good.mcap"],
        3,
        "39 of 40 messages in 11 chunks, 2 attachments; something was lost",
    );
    says(dir.path(), &["recover", "bad.mcap", "--out", "good.mcap"], 2, "exists already");
    assert_eq!(read(&dir.path().join("good.mcap"), &Kind::ALL[..3]).0, [&all[..1], &all[2..]].concat());
    // The first chunk declares the channels of the rest; without the end, our own messages still say what they are.
    let first =
        mcap::Summary::read(&std::fs::read(dir.path().join("run.mcap")).unwrap()).unwrap().unwrap().chunk_indexes[0]
            .clone();
    let mut bytes = std::fs::read(dir.path().join("run.mcap")).unwrap();
    bytes[(first.chunk_start_offset + first.chunk_length - 9) as usize] ^= 4;
    bytes.truncate(bytes.len() - 10);
    std::fs::write(dir.path().join("headless.mcap"), &bytes).unwrap();
    says(dir.path(), &["recover", "headless.mcap", "--out", "h.mcap"], 3, "something was lost");
    assert_eq!(read(&dir.path().join("h.mcap"), &[Kind::Squirmers]).0.len(), 3);
    std::fs::write(dir.path().join("stub.mcap"), &bytes[..60]).unwrap();
    says(dir.path(), &["recover", "stub.mcap", "--out", "s.mcap"], 1, "before its first whole snapshot");
    assert!(!dir.path().join("s.mcap").exists());
}

/// A file that lacks its end has metadata that nothing protects, unless it is held against the attachment.
#[test]
fn metadata_without_a_checksum_are_mended() {
    let dir = tempfile::tempdir().unwrap();
    record(dir.path(), 1, 0..3);
    let mut bytes = std::fs::read(dir.path().join("run.mcap")).unwrap();
    let seed = bytes.windows(9).position(|w| w == b"seed\x01\0\0\x007").expect("the metadata");
    bytes[seed + 8] = b'5';
    bytes.truncate(bytes.len() - 10);
    std::fs::write(dir.path().join("bad.mcap"), &bytes).unwrap();
    says(dir.path(), &["verify", "bad.mcap"], 1, "do not agree with provenance.json");
    says(dir.path(), &["recover", "bad.mcap", "--out", "good.mcap"], 0, "are mended from provenance.json");
    let good = std::fs::read(dir.path().join("good.mcap")).unwrap();
    assert!(good.windows(9).any(|w| w == b"seed\x01\0\0\x007"));
    says(dir.path(), &["verify", "good.mcap"], 0, "clean");
}

/// What a run starts from (`[init] from`) comes from the last segment that has it, and never from damaged bytes.
#[test]
fn a_state_is_exported_from_segments_and_never_from_damage() {
    let dir = tempfile::tempdir().unwrap();
    resumed(dir.path());
    let export = |out: &'static str| ["export", ".", "--topic", "particles", "--out", out];
    says(dir.path(), &export("last"), 0, "particles.csv: 50 rows, step 160");
    says(dir.path(), &[&export("at")[..], &["--at", "60"]].concat(), 0, "step 60");
    says(dir.path(), &[&export("time")[..], &["--at", "3tau"]].concat(), 0, "step 60");
    says(dir.path(), &[&export("no")[..], &["--at", "3.5tau"]].concat(), 1, "at 3.5 tau; the last is at step 160");
    says(dir.path(), &[&export("no")[..], &["--at", "3s"]].concat(), 2, "neither a step, as in 2000, nor a time");
    let reversed = ["--from", "5", "--until", "2"];
    says(dir.path(), &[&export("no")[..], &reversed].concat(), 2, "the range is reversed: it begins at step 5");
    // The last snapshot must not silently become an older one.
    let path = dir.path().join("run.fluid.0001.mcap");
    let mut bytes = std::fs::read(&path).unwrap();
    let chunks = mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes;
    let last = &chunks[chunks.len() - 2];
    bytes[(last.chunk_start_offset + last.chunk_length - 9) as usize] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    says(dir.path(), &export("damaged"), 1, "`squirm recover` keeps what is whole");
    assert!(!dir.path().join("damaged").exists());
    // Tables of a range tell their snapshots apart.
    let arguments = ["export", "run.mcap", "--topic", "scalars", "--from", "20", "--until", "3tau", "--out", "range"];
    says(dir.path(), &arguments, 0, "scalars.csv: 3 rows, step 60");
    let table = std::fs::read_to_string(dir.path().join("range/scalars.csv")).unwrap();
    let steps: Vec<&str> = table.lines().map(|l| l.split(',').next().unwrap()).collect();
    assert_eq!(steps, ["step", "20", "40", "60"]);
    says(dir.path(), &["export", ".", "--to", "gsd", "--topic", "fields"], 2, "gsd does not hold fields");
    says(dir.path(), &["export", ".", "--to", "xyz", "--every", "2"], 0, "run.xyz: 5 snapshots, the last at step 160");
    says(dir.path(), &["export", ".", "--to", "xyz"], 2, "run.xyz exists already");
    says(dir.path(), &["export", ".", "--to", "npz", "--from", "9999"], 1, "in that range; the last is at step 160");
}
