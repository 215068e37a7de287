//! Analyzers on hand-made snapshots: exact answers where there are any, five standard errors where chance is in play.

mod clusters;
mod flow_field;
mod profile;
mod spectrum;
mod structure;

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use squirm::analyze::kinds::find;
use squirm::analyze::{AnalyzeError, Analyzer, Report};
use squirm::params::{Value, Values};
use squirm::wire::{Fields, Snapshot, SpeciesRow, Squirmers, Stamp};
use std::collections::HashMap;

/// An analyzer with some options set.
fn make(kind: &str, options: &[(&'static str, Value)]) -> Box<dyn Analyzer> {
    let entry = find(kind).expect("a kind");
    let mut values = Values::defaults(&(entry.fields)());
    options.iter().for_each(|(name, value)| values.set(name, value.clone()));
    (entry.make)(&values)
}

fn text(word: &str) -> Value {
    Value::Text(word.into())
}

fn stamp(seq: u64, box_size: [f64; 3], walls: bool) -> Stamp {
    Stamp { run_id: [1; 16], step: 10 * seq, time: 0.5 * seq as f64, seq, every: 10, box_size, walls }
}

fn take(analyzer: &mut dyn Analyzer, message: &[u8]) -> Result<(), AnalyzeError> {
    analyzer.take(&Snapshot::parse(message).expect("a snapshot"))
}

/// Squirmers of one species at rest.
fn squirmers(places: &[[f32; 3]], axes: &[[f32; 3]], along: f64, across: f64) -> Squirmers {
    let n = places.len();
    let still = vec![[0.0f32; 3]; n];
    Squirmers {
        id: (0..n as u32).collect(),
        species: vec![0; n],
        position: places.to_vec(),
        unwrapped: places.iter().map(|p| p.map(f64::from)).collect(),
        axis: axes.to_vec(),
        orientation: vec![[0.0, 0.0, 0.0, 1.0]; n],
        velocity: still.clone(),
        angular_velocity: still.clone(),
        force: still.clone(),
        torque: still,
        table: vec![SpeciesRow { name: "body".into(), along, across, ..SpeciesRow::default() }],
    }
}

/// Fields with a velocity that depends on the middle of the block.
fn fields(blocks: [u32; 3], block: u32, density: f32, mut velocity: impl FnMut([f64; 3]) -> [f64; 3]) -> Fields {
    let count = blocks.iter().product::<u32>();
    let middle = |i: u32| {
        let place = [i % blocks[0], i / blocks[0] % blocks[1], i / (blocks[0] * blocks[1])];
        place.map(|p| (f64::from(p) + 0.5) * f64::from(block))
    };
    let velocity = (0..count).map(|i| velocity(middle(i)).map(|v| v as f32)).collect();
    Fields { block, blocks, density: vec![density; count as usize], velocity }
}

/// Rows of a table by the names of their columns; an `error` goes with the column before it, as in `g(r) error`.
fn table(report: &Report, file: &str) -> Vec<HashMap<String, f64>> {
    let content = &report.files.iter().find(|f| f.0 == file).unwrap_or_else(|| panic!("no {file}")).1;
    let mut lines = content.lines();
    let mut names: Vec<String> = Vec::new();
    for name in lines.next().expect("a header").split(',') {
        let last = names.last().cloned().unwrap_or_default();
        names.push(if name == "error" { format!("{last} error") } else { name.into() });
    }
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), names.len(), "{line}");
        names.iter().cloned().zip(cells.iter().map(|c| c.parse().unwrap_or(f64::NAN))).collect()
    };
    lines.map(row).collect()
}

fn chance(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

fn normal(rng: &mut impl Rng) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// A direction uniform on the sphere.
fn direction(rng: &mut impl Rng) -> [f32; 3] {
    let v = [0; 3].map(|_| normal(rng));
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    v.map(|c| (c / length) as f32)
}

#[track_caller]
fn close(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance, "{found} instead of {wanted}");
}

#[test]
fn every_picture_is_complete_and_every_number_has_a_unit_or_none() {
    let mut rng = chance(4);
    for kind in squirm::analyze::KINDS {
        let mut analyzer = make(kind.name, &[]);
        for seq in 0..5 {
            let stamp = stamp(seq, [12.0, 8.0, 16.0], true);
            let place = |rng: &mut ChaCha8Rng| [12.0, 8.0, 16.0].map(|l: f32| l * rng.random::<f32>());
            let places = [0; 6].map(|_| place(&mut rng));
            let axes = [0; 6].map(|_| direction(&mut rng));
            let fluid = fields([6, 4, 8], 2, 5.0, |_| [0; 3].map(|_| normal(&mut rng)));
            let topics = kind.topics.iter().chain(kind.extras);
            for topic in topics {
                match topic.topic() {
                    "squirmers" => {
                        take(analyzer.as_mut(), &squirmers(&places, &axes, 2.0, 1.0).encode(&stamp)).unwrap()
                    }
                    "fields" => take(analyzer.as_mut(), &fluid.encode(&stamp)).unwrap(),
                    _ => {}
                }
            }
        }
        let report = analyzer.finish().unwrap();
        assert!(report.files.len() >= 2 && !report.summary.is_empty());
        for (name, content) in &report.files {
            if name.ends_with(".svg") {
                assert!(content.starts_with("<svg") && content.trim_end().ends_with("</svg>"), "{name}");
                assert!(content.len() < 100_000, "{} {name}: {}", kind.name, content.len());
            } else {
                assert!(name.ends_with(".csv"));
                let (names, rows) = content.split_once('\n').expect("a header");
                let columns = names.split(',').count();
                assert!(!rows.is_empty() && rows.lines().all(|l| l.split(',').count() == columns), "{name}");
            }
        }
    }
}

#[test]
fn analyzers_say_what_they_lack_and_refuse_a_system_that_changes() {
    for kind in squirm::analyze::KINDS {
        let said = make(kind.name, &[]).finish().unwrap_err().to_string();
        assert!(said.contains(kind.topics[0].topic()), "{said}");
        let mut analyzer = make(kind.name, &[]);
        let message = |edge: f64| match kind.topics[0].topic() {
            "fields" => fields([4; 3], 1, 5.0, |_| [0.0; 3]).encode(&stamp(0, [edge; 3], false)),
            _ => squirmers(&[[1.0; 3]; 2], &[[1.0, 0.0, 0.0]; 2], 2.0, 1.0).encode(&stamp(0, [edge; 3], false)),
        };
        take(analyzer.as_mut(), &message(4.0)).unwrap();
        if kind.name != "swim" {
            let said = take(analyzer.as_mut(), &message(3.5)).unwrap_err().to_string();
            assert!(said.contains("more than one run"), "{said}");
        }
    }
}

/// Analyzers must start at once on machines without a GPU: nothing of wgpu may end up in their program. Mangled names
/// carry the length of a crate's name before it; the loader of Vulkan carries that of its library.
#[cfg(target_os = "linux")]
#[test]
fn the_program_has_nothing_of_the_gpu_in_it() {
    let holds = |program: &str, part: &[u8]| {
        let bytes = std::fs::read(program).expect("built");
        bytes.windows(part.len()).any(|w| w == part)
    };
    for part in [b"8wgpu_hal".as_slice(), b"9wgpu_core", b"libvulkan.so"] {
        let name = String::from_utf8_lossy(part);
        assert!(!holds(env!("CARGO_BIN_EXE_squirm-analyze"), part), "{name} in squirm-analyze");
        assert!(holds(env!("CARGO_BIN_EXE_squirm"), part), "{name} is not even in squirm");
    }
}
