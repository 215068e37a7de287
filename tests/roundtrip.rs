//! A state leaves a run and comes back: recorded, exported, and fed to another run through `[init]`.

use std::path::Path;
use std::process::{Command, Output};

const STREAM: &str = r#"
[run]
seed = 5
steps = 1
dt = 0.5
[box]
size = [8, 8, 8]
[fluid]
density = 1
[init]
from = "start.csv"
[[stage]]
kind = "stream"
[[output]]
record = ["particles", "scalars"]
every = 1
fraction = 1.0
"#;

/// The stages of a collision that keeps momentum, angular momentum and energy of every cell.
const COLLIDE: &str = r#"
[[stage]]
kind = "shift-grid"
[[stage]]
kind = "cell-reduce"
[[stage]]
kind = "rotate"
[[stage]]
kind = "restore-thermostat"
mode = "energy"
angular_momentum = true
"#;

type Row = [f64; 6];

fn squirm(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_squirm"));
    command.current_dir(folder).args(arguments).env("NO_COLOR", "1").env("COLUMNS", "200").output().expect("it starts")
}

fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = squirm(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn write(path: &Path, rows: &[Row]) {
    let line = |r: &Row| r.map(|v| v.to_string()).join(",") + "\n";
    std::fs::write(path, "x,y,z,vx,vy,vz\n".to_owned() + &rows.iter().map(line).collect::<String>()).expect("written");
}

fn read(path: &Path) -> Vec<Row> {
    let mut table = csv::Reader::from_path(path).expect("a table");
    assert_eq!(table.headers().expect("a header"), vec!["x", "y", "z", "vx", "vy", "vz"]);
    table.deserialize().map(|row| row.expect("six numbers")).collect()
}

/// Runs `file` from these particles and exports those after its last step.
fn run(file: &str, rows: &[Row]) -> Vec<Row> {
    let folder = tempfile::tempdir().expect("a folder");
    write(&folder.path().join("start.csv"), rows);
    std::fs::write(folder.path().join("two.toml"), file).expect("written");
    succeeds(folder.path(), &["run", "two.toml", "--out", "run", "--quiet"]);
    succeeds(folder.path(), &["export", "run", "--to", "csv"]);
    read(&folder.path().join("run/csv/particles.csv"))
}

/// Rows in an order that does not depend on that in memory.
fn sorted(mut rows: Vec<Row>) -> Vec<Row> {
    rows.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    rows
}

#[test]
fn two_particles_stream_across_the_box() {
    let start = [[1.0, 2.0, 3.0, 0.5, -0.25, 1.0], [7.75, 0.125, 4.0, 1.0, -0.5, 0.0]];
    let expected = [[1.25, 1.875, 3.5, 0.5, -0.25, 1.0], [0.25, 7.875, 4.0, 1.0, -0.5, 0.0]];
    // Every number here is a multiple of 2^-29 of the box, so that nothing is rounded.
    assert_eq!(sorted(run(STREAM, &start)), sorted(expected.to_vec()));
}

#[test]
fn a_no_slip_wall_turns_a_particle_round() {
    let file = STREAM.replace("size = [8, 8, 8]", "size = [8, 8, 8]\nwalls = { axis = \"y\" }");
    // It meets y = 0 after 0.25 of the 0.5 and goes back the way it came.
    let found = run(&file, &[[3.0, 0.125, 4.0, 1.0, -0.5, 0.25]]);
    assert_eq!(found, [[3.0, 0.125, 4.0, -1.0, 0.5, -0.25]]);
}

fn momentum(rows: &[Row]) -> [f64; 3] {
    [3, 4, 5].map(|k| rows.iter().map(|r| r[k]).sum())
}

fn angular_momentum(rows: &[Row]) -> [f64; 3] {
    [(1, 2), (2, 0), (0, 1)].map(|(a, b)| rows.iter().map(|r| r[a] * r[3 + b] - r[b] * r[3 + a]).sum())
}

fn energy(rows: &[Row]) -> f64 {
    rows.iter().map(|r| 0.5 * r[3..].iter().map(|v| v * v).sum::<f64>()).sum()
}

#[test]
fn a_collision_keeps_momentum_angular_momentum_and_energy() {
    // Four neighbours in the middle of a box: after a random shift of the grid some of them share a cell in most runs.
    let start: Vec<Row> = vec![
        [3.0, 4.0, 3.0, 0.5, -0.25, 1.0],
        [3.1, 4.1, 3.2, -0.5, 0.75, 0.125],
        [3.2, 3.9, 3.1, 0.25, 0.5, -1.0],
        [2.9, 4.2, 2.95, -1.0, -0.5, 0.25],
    ];
    let mut collided = 0;
    for seed in 0..4 {
        let seeded = STREAM.replace("seed = 5", &format!("seed = {seed}")).replace("dt = 0.5", "dt = 0.02");
        let streamed = run(&seeded, &start);
        let found = run(&seeded.replace("[[output]]", &format!("{COLLIDE}[[output]]")), &start);
        collided += usize::from(found.iter().zip(&streamed).any(|(a, b)| a[3..] != b[3..]));
        let places = |rows: &[Row]| sorted(rows.iter().map(|r| [r[0], r[1], r[2], 0.0, 0.0, 0.0]).collect());
        assert_eq!(places(&found), places(&streamed), "a collision moves nothing");
        assert!((energy(&found) - energy(&start)).abs() < 1e-5, "{found:?}");
        let pairs = [(momentum(&found), momentum(&streamed)), (angular_momentum(&found), angular_momentum(&streamed))];
        for (after, before) in pairs {
            assert!((0..3).all(|k| (after[k] - before[k]).abs() < 2e-5), "{after:?} after {before:?}");
        }
    }
    assert!(collided > 0, "no two particles ever shared a cell");
}

#[test]
fn a_full_snapshot_gives_the_state_back_to_the_last_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let random = STREAM.replace("from = \"start.csv\"", "").replace("density = 1", "density = 5");
    std::fs::write(at("random.toml"), random.replace("[8, 8, 8]", "[13, 9, 11]")).expect("written");
    succeeds(folder.path(), &["run", "random.toml", "--out", "first", "--quiet"]);
    let said = succeeds(folder.path(), &["export", "first", "--at", "1", "--topic", "particles", "--out", "."]);
    assert!(said.contains("particles.csv: 6435 rows, step 1"), "{said}");
    std::fs::rename(at("particles.csv"), at("start.csv")).expect("moved");
    let again = STREAM.replace("[8, 8, 8]", "[13, 9, 11]").replace("density = 1", "density = 5");
    std::fs::write(at("again.toml"), again.replace("steps = 1", "steps = 0")).expect("written");
    succeeds(folder.path(), &["run", "again.toml", "--out", "second", "--quiet"]);
    succeeds(folder.path(), &["export", "second", "--topic", "particles"]);
    let (first, second) = (read(&at("start.csv")), read(&at("second/csv/particles.csv")));
    assert_eq!(sorted(first.clone()), sorted(second));
    let digest = |run: &str| {
        let text = std::fs::read_to_string(at(run).join("summary.json")).expect("a summary");
        serde_json::from_str::<serde_json::Value>(&text).expect("JSON")["digest"].clone()
    };
    assert_eq!(digest("first"), digest("second"), "the state on the GPU is the same");
    assert!(first.iter().any(|r| f64::from(r[0] as f32) != r[0]), "f32 positions would not have sufficed");
}

#[test]
fn exports_say_what_they_cannot_do() {
    let folder = tempfile::tempdir().expect("a folder");
    write(&folder.path().join("start.csv"), &[[1.0; 6], [2.0; 6]]);
    std::fs::write(folder.path().join("two.toml"), STREAM).expect("written");
    succeeds(folder.path(), &["run", "two.toml", "--out", "run", "--quiet"]);
    let fails = |arguments: &[&str], status: i32, part: &str| {
        let output = squirm(folder.path(), arguments);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(status) && text.contains(part), "{arguments:?}: {text}");
    };
    fails(&["export", "absent"], 2, "there is no recording absent");
    fails(&["export", "two.toml"], 1, "is no recording");
    fails(&["export", "run", "--at", "7"], 1, "at step 7; the last is at step 1");
    fails(&["export", "run", "--topic", "squirmers"], 1, "no snapshot of squirmers: was the topic recorded?");
    assert!(!folder.path().join("run/csv/squirmers.csv").exists());
    let said = succeeds(folder.path(), &["export", "run"]);
    assert!(said.contains("particles.csv: 2 rows, step 1") && said.contains("scalars.csv: 2 rows"), "{said}");
    let scalars = std::fs::read_to_string(folder.path().join("run/csv/scalars.csv")).expect("a table");
    assert!(scalars.starts_with("step,time [tau],temperature [kT]") && scalars.lines().count() == 3, "{scalars}");
    fails(&["export", "run"], 2, "particles.csv exists already");
}
