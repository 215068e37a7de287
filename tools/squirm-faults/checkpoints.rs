//! Damaged checkpoints: cut anywhere, and with flipped bits.

use super::child::{Folder, Trial};
use super::kill::saved_step;
use super::record::{compare, left};
use super::table::Row;
use rand::{Rng, RngExt};
use squirm::checkpoint::{self, CURRENT, PREVIOUS};
use std::path::Path;

/// Damages `count` copies of a run's checkpoint, half of them cut, half of them with flipped bits.
pub fn checkpoints(squirm: &Path, count: u32, random: &mut impl Rng) -> Result<Vec<Row>, String> {
    let trial = Trial::new(squirm, &[])?;
    trial.finish()?;
    let expected = left(&trial.dir())?;
    let read = |name: &str| std::fs::read(trial.dir().join(name)).map_err(|e| format!("{name}: {e}"));
    let (good, before) = (read(CURRENT)?, read(PREVIOUS)?);
    let older = checkpoint::decode(before.clone()).map_err(|e| e.to_string())?;
    let folder = Folder::new()?;
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).map_err(|e| e.to_string());
    let mut used = Row::new("a damaged checkpoint is refused with its reason, and the one before is used");
    let mut both = Row::new("where both are damaged both are refused");
    for number in 0..count {
        let damaged = damage(&good, number, random);
        write(CURRENT, &damaged)?;
        write(PREVIOUS, &before)?;
        let loaded = std::panic::catch_unwind(|| checkpoint::load(folder.path(), |s| Ok(s.clone())));
        used.enter(match loaded {
            Err(_) => Err("it panicked".into()),
            Ok(Ok(Some((sections, found)))) if sections == older && found.refused.is_some() => Ok(()),
            Ok(other) => Err(format!("{:?}", other.map(|found| found.map(|(_, f)| f.path)))),
        });
        write(PREVIOUS, &damage(&before, number + 1, random))?;
        let loaded = std::panic::catch_unwind(|| checkpoint::load(folder.path(), |_| Ok(())));
        both.enter(if matches!(loaded, Ok(Err(_))) { Ok(()) } else { Err("it was believed, or it panicked".into()) });
    }
    used.figures = format!("files of {} bytes", good.len());
    let mut resumed = Row::new("a run goes on from the previous checkpoint and ends in the same state");
    for number in 0..count.clamp(1, 3) {
        std::fs::write(trial.dir().join(CURRENT), damage(&good, number, random)).map_err(|e| e.to_string())?;
        std::fs::write(trial.dir().join(PREVIOUS), &before).map_err(|e| e.to_string())?;
        resumed.enter(trial.finish().and_then(|()| compare(&left(&trial.dir())?, &expected)));
        resumed.figures = format!("to step {}", saved_step(&trial.dir())?.unwrap_or(0));
    }
    Ok(vec![used, both, resumed])
}

/// The bytes, cut or with one to three flipped bits.
fn damage(good: &[u8], number: u32, random: &mut impl Rng) -> Vec<u8> {
    let mut bytes = good.to_vec();
    if number.is_multiple_of(2) {
        bytes.truncate(random.random_range(0..good.len()));
        return bytes;
    }
    // Headers are short: half of the flips go there, or hardly any would.
    let range = if number % 4 == 1 { 0..good.len().min(1024) } else { 0..good.len() };
    let first = random.random_range(range.clone());
    bytes[first] ^= 1 << random.random_range(0..8);
    for _ in 0..random.random_range(0..3) {
        let other = random.random_range(range.clone());
        if other != first {
            bytes[other] ^= 1 << random.random_range(0..8);
        }
    }
    bytes
}
