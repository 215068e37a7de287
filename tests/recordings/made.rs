//! Recordings of a run that never was: every kind of snapshot, with numbers that are known.

use squirm::sink::{Provenance, Recorder};
use squirm::wire::{Fields, Kind, Particles, Scalars, Snapshot, SpeciesRow, Squirmers, Stamp};
use std::path::Path;

/// A small generator of reproducible numbers in [0, 1).
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn vectors<const N: usize>(&mut self, n: usize, scale: f32) -> Vec<[f32; N]> {
        (0..n).map(|_| std::array::from_fn(|_| scale * self.next())).collect()
    }
}

pub fn stamp(run: u8, seq: u64) -> Stamp {
    let (step, time) = (20 * seq, seq as f64);
    Stamp { run_id: [run; 16], step, time, seq, every: 20, box_size: [8.0; 3], walls: false }
}

/// The messages of moment `seq` of run `run`: squirmers, scalars, fields, particles.
pub fn messages(run: u8, seq: u64) -> [Vec<u8>; 4] {
    let mut noise = Noise(1000 * u64::from(run) + seq);
    let n = 3;
    let row = |name: &str, along, across| SpeciesRow {
        name: name.into(),
        along,
        across,
        b1: 0.1,
        beta: 1.0,
        rotlet: 0.0,
        u0: f64::NAN,
    };
    let squirmers = Squirmers {
        id: (0..n as u32).collect(),
        species: vec![0, 1, 0],
        position: noise.vectors(n, 8.0),
        unwrapped: noise.vectors::<3>(n, 8.0).into_iter().map(|v| v.map(f64::from)).collect(),
        axis: vec![[1.0, 0.0, 0.0]; n],
        orientation: vec![[0.0, std::f32::consts::FRAC_1_SQRT_2, 0.0, std::f32::consts::FRAC_1_SQRT_2]; n],
        velocity: noise.vectors(n, 1.0),
        angular_velocity: noise.vectors(n, 1.0),
        force: noise.vectors(n, 1.0),
        torque: noise.vectors(n, 1.0),
        table: vec![row("long", 2.0, 1.0), row("flat", 0.5, 1.5)],
    };
    let mut scalars = Scalars::default();
    scalars.push("temperature", "kT", f64::from(noise.next()));
    let fields = Fields {
        block: 2,
        blocks: [4, 4, 4],
        density: noise.vectors::<1>(64, 9.0).into_iter().map(|[d]| d).collect(),
        velocity: noise.vectors(64, 1.0),
    };
    let particles = Particles {
        fraction: 0.5,
        population: 100,
        position: noise.vectors(50, 8.0),
        rest: Vec::new(),
        velocity: noise.vectors(50, 1.0),
    };
    let stamp = stamp(run, seq);
    [squirmers.encode(&stamp), scalars.encode(&stamp), fields.encode(&stamp), particles.encode(&stamp)]
}

/// Records moments of a run into `dir`, as a run does.
pub fn record(dir: &Path, run: u8, moments: impl IntoIterator<Item = u64>) {
    let provenance =
        Provenance { run: "made".into(), run_id: [run; 16], seed: 7, version: "0".into(), ..Provenance::default() };
    let mut recorder = Recorder::create(dir, &provenance, "steps = 1\n").unwrap();
    for seq in moments {
        messages(run, seq).iter().for_each(|m| recorder.write(m).unwrap());
    }
    recorder.finish().unwrap();
}

/// Kind and step of a message.
pub fn name(message: &[u8]) -> (Kind, u64) {
    let snapshot = Snapshot::parse(message).unwrap();
    (snapshot.kind(), snapshot.header.step)
}
