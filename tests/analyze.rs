//! Analyzers and sources: exact answers for known motion, damaged recordings, and one result from file and from memory.

use glam::{DQuat, DVec3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use squirm::analyze::statistics::{blocked, independent, jackknife};
use squirm::analyze::swim::{Sample, Swim, Trajectories};
use squirm::analyze::{AnalyzeError, Analyzer, Ending, Limits, Live, Recording, Source, run};
use squirm::export::{ExportError, Exported, Selection, csv as table};
use squirm::recording::RecordingError;
use squirm::sink::{Provenance, Publisher, Recorder};
use squirm::wire::{Kind, Particles, Scalars, Snapshot, SpeciesRow, Squirmers, Stamp};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

fn stamp(seq: u64) -> Stamp {
    Stamp { run_id: [7; 16], step: 20 * seq, time: seq as f64, seq, every: 20, box_size: [16.0; 3], walls: false }
}

/// Two squirmers that swim along x and y at 0.25.
fn straight(seq: u64) -> Squirmers {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0f32]];
    let travelled = 0.25 * seq as f64;
    Squirmers {
        id: vec![0, 1],
        species: vec![0, 0],
        position: axes.map(|e| e.map(|c| (f64::from(c) * travelled).rem_euclid(16.0) as f32)).to_vec(),
        unwrapped: axes.map(|e| e.map(|c| f64::from(c) * travelled)).to_vec(),
        axis: axes.to_vec(),
        orientation: vec![[0.0, 0.0, 0.0, 1.0]; 2],
        velocity: axes.map(|e| e.map(|c| 0.25 * c)).to_vec(),
        angular_velocity: vec![[0.0; 3]; 2],
        force: vec![[0.0; 3]; 2],
        torque: vec![[0.0; 3]; 2],
        table: vec![SpeciesRow {
            name: "puller".into(),
            along: 4.0,
            across: 2.0,
            b1: 0.4,
            beta: 1.0,
            rotlet: 0.0,
            u0: 0.25,
        }],
    }
}

/// A recording of `n` snapshots of straight swimming in a fresh directory.
fn recorded(n: u64) -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let mut recorder = Recorder::create(dir.path(), &Provenance::default(), "steps = 1\n").unwrap();
    (0..n).for_each(|seq| recorder.write(&straight(seq).encode(&stamp(seq))).unwrap());
    recorder.finish().unwrap();
    let path = dir.path().join("run.mcap");
    (dir, path)
}

/// Every squirmer message of a recording, and how the scan ended.
fn scan(path: &Path) -> Result<(Vec<Vec<u8>>, Ending), AnalyzeError> {
    let mut messages = Vec::new();
    let ending = Recording::new(path).drive(&[Kind::Squirmers], &mut |s| {
        messages.push(s.bytes().to_vec());
        Ok(ControlFlow::Continue(()))
    })?;
    Ok((messages, ending))
}

#[test]
fn straight_swimming_is_measured_exactly() {
    let (_dir, path) = recorded(40);
    let (report, ending) = run(&mut Recording::new(&path), &mut Swim::default()).unwrap();
    assert_eq!((ending.snapshots, ending.warnings.len()), (40, 0));
    let file = |name: &str| &report.files.iter().find(|f| f.0 == name).unwrap().1;
    let row: Vec<&str> = file("swim.csv").lines().nth(1).unwrap().split(',').collect();
    assert_eq!(row[..8], ["puller", "2", "40", "0.25", "0", "0.25", "0", "0.25"]);
    for line in file("msd.csv").lines().skip(1) {
        let cells: Vec<f64> = line.split(',').skip(1).map(|c| c.parse().unwrap()).collect();
        assert_eq!((cells[1], cells[2]), ((0.25 * cells[0]).powi(2), 0.0), "{line}");
    }
    // Up to a quarter of 39 intervals, about ten per factor of ten: 1, 2, 3, 4, 5, 6 and 8.
    assert_eq!(file("msd.csv").lines().count(), 8);
    assert!(file("orientation.csv").lines().skip(1).all(|l| l.split(',').nth(2) == Some("1")));
    assert!(["swim.svg", "msd.svg", "orientation.svg"].iter().all(|f| file(f).trim_end().ends_with("</svg>")));
}

#[test]
fn lost_snapshots_do_not_bend_time() {
    let mut swim = Swim::default();
    for seq in (0..60).filter(|seq| seq % 7 != 3) {
        swim.take(&Snapshot::parse(&straight(seq).encode(&stamp(seq))).unwrap()).unwrap();
    }
    let report = swim.finish().unwrap();
    let msd = &report.files.iter().find(|f| f.0 == "msd.csv").unwrap().1;
    for line in msd.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').skip(1).map(|c| c.parse().unwrap()).collect();
        assert_eq!(cells[1], (0.25 * cells[0]).powi(2), "{line}");
    }
}

/// Turning by 0 or theta about a random perpendicular axis each step makes <e(n).e(0)> = ((1 + cos theta) / 2)^n exactly.
#[test]
fn rotational_diffusion_is_recovered_within_its_error() {
    let (theta, squirmers, steps) = (0.28f64, 40, 2000);
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut axes: Vec<DVec3> = (0..squirmers).map(|_| DVec3::Z).collect();
    let mut track = Trajectories::default();
    for step in 0..steps {
        let sample = |e: &DVec3| Sample { position: DVec3::ZERO, velocity: *e * 0.1, axis: *e };
        track.push(step, step as f64, axes.iter().map(sample).collect());
        for e in &mut axes {
            let about = e.any_orthonormal_vector();
            let about = DQuat::from_axis_angle(*e, rng.random::<f64>() * std::f64::consts::TAU) * about;
            let turn = if rng.random::<bool>() { theta } else { 0.0 };
            *e = (DQuat::from_axis_angle(about, turn) * *e).normalize();
        }
    }
    let remembered = f64::midpoint(1.0, theta.cos());
    let exact = -remembered.ln() / 2.0;
    let found = track.rotational_diffusion();
    // The shortest lags know most: 40 x 2000 throws of a coin give a relative error of 1/sqrt(80000).
    let error = exact / 80_000f64.sqrt();
    assert!(found.error > 0.5 * error && found.error < 2.0 * error, "{found:?} {error}");
    assert!((found.mean - exact).abs() < 5.0 * found.error, "{found:?} {exact}");
    let lag = track.orientations()[9];
    assert!((lag.value.mean - remembered.powf(lag.time)).abs() < 5.0 * lag.value.error, "{lag:?}");
    assert!((track.speed().mean - 0.1).abs() < 1e-12);
}

/// An angular velocity that is remembered for tau_r = 5: at short lags the axis turns ballistically, and -ln<e(t).e(0)>/2t is
/// far below D_R = s^2 (1/2 + phi/(1 - phi)) there (Green and Kubo, summed over whole steps).
#[test]
fn inertia_does_not_bias_rotational_diffusion() {
    let (phi, s, squirmers, steps) = ((-0.2f64).exp(), 0.02, 40, 4000);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut axes: Vec<DVec3> = (0..squirmers).map(|_| DVec3::Z).collect();
    let mut spins: Vec<DVec3> = axes.iter().map(|_| s * DVec3::from_array([0; 3].map(|_| normal(&mut rng)))).collect();
    let mut track = Trajectories::default();
    for step in 0..steps {
        let sample = |e: &DVec3| Sample { position: DVec3::ZERO, velocity: *e, axis: *e };
        track.push(step, step as f64, axes.iter().map(sample).collect());
        for (e, spin) in axes.iter_mut().zip(&mut spins) {
            *e = (DQuat::from_scaled_axis(*spin) * *e).normalize();
            let noise = DVec3::from_array([0; 3].map(|_| normal(&mut rng)));
            *spin = phi * *spin + (1.0 - phi * phi).sqrt() * s * noise;
        }
    }
    let exact = s * s * (0.5 + phi / (1.0 - phi));
    let found = track.rotational_diffusion();
    // What inertia leaves is tau_r/t of the first lag used, which is within two errors of the later ones: allow both.
    assert!(found.error < 0.1 * exact, "{found:?} {exact}");
    assert!((found.mean - exact).abs() < 5.0 * found.error, "{found:?} {exact}");
    let first = track.orientations()[0].value.mean;
    assert!(-first.ln() / 2.0 < 0.2 * exact, "the shortest lag is ballistic");
}

fn normal(rng: &mut impl Rng) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// x' = phi x + noise of unit variance: the variance of the mean of n is (1 + phi) / (1 - phi) / (1 - phi^2) / n up to
/// O(1/n^2).
#[test]
fn blocking_finds_the_error_of_correlated_series() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for phi in [0.0, 0.5, 0.9, 0.97] {
        let (n, series_count) = (8192, 100);
        let mut sum = 0.0;
        for _ in 0..series_count {
            let mut x = normal(&mut rng) / (1.0f64 - phi * phi).sqrt();
            let series: Vec<f64> = (0..n)
                .map(|_| {
                    x = phi * x + normal(&mut rng);
                    x
                })
                .collect();
            sum += blocked(&series).error.powi(2);
        }
        let exact = ((1.0 + phi) / (1.0 - phi) / (1.0 - phi * phi) / f64::from(n)).sqrt();
        let ratio = (sum / f64::from(series_count)).sqrt() / exact;
        // A single error estimated from k blocks scatters by 1/sqrt(2k), some 10 percent, so 1 percent over 100 of them;
        // stopping once the correlation cannot be seen leaves a bias of a few percent.
        assert!((0.94..1.04).contains(&ratio), "phi {phi}: {ratio}");
    }
}

#[test]
fn errors_of_few_values() {
    assert_eq!((blocked(&[2.0]).mean, independent(&[2.0]).mean), (2.0, 2.0));
    assert!(blocked(&[2.0]).error.is_nan() && independent(&[2.0]).error.is_nan() && blocked(&[]).mean.is_nan());
    assert_eq!((blocked(&[1.0; 9]).error, independent(&[1.0, 3.0]).error), (0.0, 1.0));
    // The jackknife of a mean, one value at a time, is the standard error exactly.
    let values = [1.0, 4.0, 2.0, 8.0, 5.0];
    let kept_mean = |keep: &dyn Fn(usize) -> bool| {
        let kept: Vec<f64> = (0..5).filter(|i| keep(*i)).map(|i| values[i]).collect();
        kept.iter().sum::<f64>() / kept.len() as f64
    };
    assert!((jackknife(5, 5, kept_mean) - independent(&values).error).abs() < 1e-14);
}

#[test]
fn a_cut_recording_gives_its_whole_chunks() {
    let (dir, path) = recorded(6);
    let bytes = std::fs::read(&path).unwrap();
    let (all, _) = scan(&path).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let ends: Vec<u64> = summary.chunk_indexes.iter().map(|c| c.chunk_start_offset + c.chunk_length).collect();
    assert_eq!(ends.len(), 6);
    let cut = dir.path().join("cut.mcap");
    let every_chunk_end = ends.iter().flat_map(|e| [e - 1, *e, e + 1]).map(|n| n as usize);
    for length in (0..bytes.len()).step_by(61).chain(every_chunk_end).chain(bytes.len() - 40..bytes.len()) {
        std::fs::write(&cut, &bytes[..length]).unwrap();
        let whole = ends.iter().filter(|e| **e <= length as u64).count();
        match scan(&cut) {
            Ok((messages, ending)) => {
                assert_eq!(messages, all[..whole], "cut at {length}");
                assert_eq!(ending.warnings.len(), 1, "cut at {length}");
            }
            Err(e) => assert!(whole == 0 && matches!(e, AnalyzeError::Recording(_)), "cut at {length}: {e}"),
        }
    }
}

#[test]
fn no_flipped_bit_passes_silently() {
    let (dir, path) = recorded(6);
    let bytes = std::fs::read(&path).unwrap();
    let (all, _) = scan(&path).unwrap();
    let summary_start = mcap::read::footer(&bytes).unwrap().summary_start as usize;
    // The data section ends with a record of 13 bytes that holds its checksum.
    let data_end = summary_start - 13;
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let flipped = dir.path().join("flipped.mcap");
    for _ in 0..1500 {
        let (byte, bit) = (rng.random_range(0..bytes.len()), rng.random_range(0..8));
        let mut damaged = bytes.clone();
        damaged[byte] ^= 1 << bit;
        std::fs::write(&flipped, &damaged).unwrap();
        match scan(&flipped) {
            Err(_) => {}
            Ok((messages, ending)) if ending.warnings.is_empty() => {
                assert!(byte >= data_end && messages == all, "bit {bit} of byte {byte} passed");
            }
            Ok((messages, _)) => assert_eq!(messages, all[..messages.len()], "bit {bit} of byte {byte}"),
        }
    }
}

#[test]
fn damage_is_reported_as_such() {
    let (dir, path) = recorded(3);
    let mut bytes = std::fs::read(&path).unwrap();
    let chunk = mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes[1].clone();
    let last = (chunk.chunk_start_offset + chunk.chunk_length - 9) as usize;
    bytes[last] ^= 0x10;
    let damaged = dir.path().join("damaged.mcap");
    std::fs::write(&damaged, &bytes).unwrap();
    let error = run(&mut Recording::new(&damaged), &mut Swim::default()).unwrap_err().to_string();
    assert!(error.contains("damaged.mcap is damaged"), "{error}");
    std::fs::write(&damaged, "x,y,z\n1,2,3\n").unwrap();
    assert!(matches!(scan(&damaged), Err(AnalyzeError::Recording(RecordingError::NoRecording(_)))));
}

#[test]
fn live_and_recorded_agree() {
    let name = format!("agree-{}", std::process::id());
    let messages: Vec<Vec<u8>> = (0..30).map(|seq| straight(seq).encode(&stamp(seq))).collect();
    let mut publisher = Publisher::open(&name, &[(Kind::Squirmers, messages[0].len())]).unwrap();
    // A late joiner starts with the newest snapshot.
    publisher.publish(&messages[0]).unwrap();
    let (taken, acknowledged) = channel();
    let reader = std::thread::spawn(move || {
        let mut swim = Swim::default();
        let ending = Live::new(&name, Limits::default()).drive(&[Kind::Squirmers], &mut |s| {
            swim.take(s)?;
            taken.send(s.header.seq).unwrap();
            Ok(ControlFlow::Continue(()))
        });
        (swim.finish().unwrap(), ending.unwrap())
    });
    let patience = Duration::from_millis(20);
    let first = (0..500).find_map(|_| {
        publisher.welcome();
        acknowledged.recv_timeout(patience).ok()
    });
    assert_eq!(first, Some(0));
    for (seq, message) in messages.iter().enumerate().skip(1) {
        assert_eq!(publisher.publish(message).unwrap(), 1);
        assert_eq!(acknowledged.recv_timeout(Duration::from_secs(10)).unwrap(), seq as u64);
    }
    drop(publisher);
    let (live, ending) = reader.join().unwrap();
    assert_eq!(ending, Ending { snapshots: 30, lost: 0, warnings: Vec::new() });
    let (_dir, path) = recorded(30);
    assert_eq!(live, run(&mut Recording::new(&path), &mut Swim::default()).unwrap().0);
}

/// Writes a table where there may be an older one.
fn fresh_table(recording: &Path, kind: Kind, at: Option<u64>, out: &Path) -> Result<Exported, ExportError> {
    let _ = std::fs::remove_file(out);
    table(recording, kind, at.map_or(Selection::Usual, Selection::Step), out)
}

#[test]
fn particles_survive_the_table_bit_by_bit() {
    let dir = tempfile::tempdir().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut vectors = |scale: f32| (0..50).map(|_| [(); 3].map(|()| scale * rng.random::<f32>())).collect::<Vec<_>>();
    let all: Vec<Particles> = (0..3)
        .map(|i| Particles {
            fraction: 1.0,
            population: 50 + i / 2,
            position: vectors(300.0),
            rest: vectors(1e-6),
            velocity: vectors(1e-7),
        })
        .collect();
    let mut recorder = Recorder::create(dir.path(), &Provenance::default(), "").unwrap();
    for (seq, particles) in (0..).zip(&all) {
        recorder.write(&particles.encode(&stamp(seq))).unwrap();
        recorder.write(&straight(seq).encode(&stamp(seq))).unwrap();
    }
    recorder.finish().unwrap();
    let (recording, out) = (dir.path().join("run.mcap"), dir.path().join("start.csv"));
    for (at, index, complete) in [(Some(20), 1, true), (None, 2, false)] {
        let exported = fresh_table(&recording, Kind::Particles, at, &out).unwrap();
        assert_eq!((exported.rows, exported.step, exported.complete()), (50, 20 * index as u64, complete));
        let mut table = csv::Reader::from_path(&out).unwrap();
        assert_eq!(table.headers().unwrap(), vec!["x", "y", "z", "vx", "vy", "vz"]);
        let rows: Vec<[f64; 6]> = table.deserialize().map(Result::unwrap).collect();
        for (i, row) in rows.iter().enumerate() {
            assert_eq!(row[..3], all[index].place(i));
            assert_eq!([row[3], row[4], row[5]].map(|v| v as f32), all[index].velocity[i]);
        }
    }
    let error = fresh_table(&recording, Kind::Particles, Some(21), &out).unwrap_err().to_string();
    assert!(error.ends_with("has no snapshot of particles at step 21; the last is at step 40"), "{error}");
    assert_eq!(fresh_table(&recording, Kind::Squirmers, None, &out).unwrap().rows, 2);
    let table = std::fs::read_to_string(&out).unwrap();
    assert_eq!(table.lines().nth(2).unwrap(), "0,0.5,0,0,1,0,0,0.25,0,1,puller");
}

#[test]
fn recordings_without_squirmers_say_so() {
    let dir = tempfile::tempdir().unwrap();
    let mut recorder = Recorder::create(dir.path(), &Provenance::default(), "").unwrap();
    recorder.write(&Scalars::default().encode(&stamp(0))).unwrap();
    recorder.finish().unwrap();
    let error = run(&mut Recording::new(&dir.path().join("run.mcap")), &mut Swim::default()).unwrap_err();
    assert_eq!(error.to_string(), "0 snapshots of squirmers: at least 2 are needed");
}

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_squirm-analyze"))
}

#[test]
fn the_program_writes_tables_and_charts_and_its_exit_code_says_how_it_went() {
    let (dir, path) = recorded(12);
    let output = program().arg("swim").arg(&path).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8(output.stdout).unwrap().contains("0.25000 +- 0.00000"));
    for file in ["swim.csv", "msd.csv", "orientation.csv", "swim.svg", "msd.svg", "orientation.svg"] {
        assert!(dir.path().join("run.swim").join(file).exists(), "{file}");
    }
    let code = |args: &[&str]| program().args(args).output().unwrap().status.code();
    assert_eq!((code(&["swim", "nowhere.mcap"]), code(&["swim", "/"])), (Some(2), Some(2)));
    let recording = path.to_str().unwrap();
    assert_eq!(code(&["swim", recording, "--from", "40", "--to", "20"]), Some(2));
    assert_eq!(code(&["swim", recording, "--from", "100000"]), Some(1), "nothing is left of the recording");
    assert_eq!(code(&["swim", "--live", "no-such-run"]), Some(1));
    assert_eq!((code(&["swim"]), code(&["swim", "a.mcap", "--live", "b"]), code(&[])), (Some(2), Some(2), Some(2)));
}

#[test]
fn the_program_follows_a_run_of_another_process() {
    let name = format!("other-process-{}", std::process::id());
    let out = tempfile::tempdir().unwrap();
    let length = straight(0).encode(&stamp(0)).len();
    let mut publisher = Publisher::open(&name, &[(Kind::Squirmers, length)]).unwrap();
    let mut child = program()
        .args(["swim", "--live", &name, "--snapshots", "5", "--out"])
        .arg(out.path())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let begin = Instant::now();
    for seq in 0.. {
        publisher.publish(&straight(seq).encode(&stamp(seq))).unwrap();
        if child.try_wait().unwrap().is_some() {
            break;
        }
        assert!(begin.elapsed().as_secs() < 20, "the program does not end");
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(String::from_utf8(output.stdout).unwrap().contains("5 snapshots; 6 files"));
}
