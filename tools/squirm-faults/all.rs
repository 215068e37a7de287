//! All cases after each other.

use super::table::{Row, text};
use super::{checkpoints, disk, kill, memory, pipelines, readers, recordings, signals, soak, stopped};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::path::{Path, PathBuf};

/// How often each case is tried.
struct Extent {
    kills: u32,
    checkpoints: u32,
    signals: u32,
    recordings: u32,
    readers: u32,
    stopped: u32,
    disks: u32,
    pipelines: u32,
    minutes: f64,
}

const SHORT: Extent = Extent {
    kills: 2,
    checkpoints: 40,
    signals: 3,
    recordings: 20,
    readers: 4,
    stopped: 20,
    disks: 1,
    pipelines: 2000,
    minutes: 1.0,
};

const LONG: Extent = Extent {
    kills: 200,
    checkpoints: 1000,
    signals: 50,
    recordings: 1000,
    readers: 100,
    stopped: 60,
    disks: 8,
    pipelines: 200_000,
    minutes: 60.0,
};

/// Where the pipeline files lie that are shipped.
pub fn shipped() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines")
}

/// Runs every case; each prints its rows when it is over, since all together take long.
pub fn all(squirm: &Path, seed: u64, long: bool) -> Result<Vec<Row>, String> {
    let extent = if long { LONG } else { SHORT };
    let random = || ChaCha8Rng::seed_from_u64(seed);
    type Case<'a> = Box<dyn Fn() -> Result<Vec<Row>, String> + 'a>;
    let cases: [(&str, Case<'_>); 10] = [
        ("checkpoints", Box::new(|| checkpoints::checkpoints(squirm, extent.checkpoints, &mut random()))),
        ("recordings", Box::new(|| recordings::recordings(squirm, extent.recordings, &mut random()))),
        ("pipelines", Box::new(|| pipelines::pipelines(squirm, &shipped(), extent.pipelines, seed))),
        ("disk", Box::new(|| disk::disk(squirm, extent.disks))),
        ("memory", Box::new(|| memory::memory(squirm))),
        ("signals", Box::new(|| signals::signals(squirm, extent.signals, &mut random()))),
        ("kill", Box::new(|| kill::kill(squirm, extent.kills, &mut random()))),
        ("readers", Box::new(|| readers::readers(squirm, extent.readers, &mut random()))),
        ("stopped", Box::new(|| stopped::stopped(squirm, extent.stopped))),
        ("soak", Box::new(|| soak::soak(squirm, extent.minutes, &mut random()))),
    ];
    let mut rows = Vec::new();
    for (name, case) in &cases {
        let began = std::time::Instant::now();
        let found = case().unwrap_or_else(|why| {
            let mut row = Row::new("the case can be run");
            row.enter(Err(why));
            vec![row]
        });
        eprintln!("{name}, {:.0} s:\n{}", began.elapsed().as_secs_f64(), text(&found));
        rows.extend(found);
    }
    Ok(rows)
}
