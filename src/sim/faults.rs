//! Faults that kernels report, in words: what went wrong, where, and what to do.

use super::RunError;
use crate::buffers::{Fault, Site, SquirmerState};
use crate::graph::Plan;

/// Whether the words of `faults` tell of a fault that stops a run; `done` steps were done when they were read.
///
/// # Errors
/// If they do.
pub fn check(plan: &Plan, done: u64, words: &[u32]) -> Result<(), RunError> {
    let flags = words.first().copied().unwrap_or(0);
    let found = Fault::ALL.iter().filter(|f| flags & **f as u32 != 0).map(|f| said(*f)).filter(|s| !s.is_empty());
    let what: Vec<&str> = found.collect();
    if what.is_empty() {
        return Ok(());
    }
    let (step, place) = place(plan, done, words);
    Err(RunError::Fault { step, what: format!("{place}{}", what.join("; ")) })
}

/// The step of the first fault, and where it was seen, as far as that is known (shaders/lib/fault.wgsl).
fn place(plan: &Plan, done: u64, words: &[u32]) -> (u64, String) {
    let [_, site, cell, owner, step, ..] = *words else { return (done, String::new()) };
    let Some(site) = Site::ALL.iter().find(|s| **s as u32 == site) else { return (done, String::new()) };
    let mut parts = vec![match site {
        Site::Snapshot => "in the state after it".to_owned(),
        site => format!("in {}", site.stage()),
    }];
    if let Some(cell) = cell.checked_sub(1) {
        let [x, y, z] = plan.system.domain.cell_at(cell);
        let grid = if *site == Site::Snapshot { "" } else { " of the shifted grid" };
        parts.push(format!("cell ({x}, {y}, {z}){grid}"));
    }
    if let Some(owner) = owner.checked_sub(1) {
        parts.push(format!("{} {owner}", site.owner()));
    }
    (step_of(done, step).unwrap_or(done), format!("{}: ", parts.join(", ")))
}

/// The step whose low word this is, not after `done`; none for 0.
fn step_of(done: u64, low: u32) -> Option<u64> {
    let step = (done & !u64::from(u32::MAX)) | u64::from(low);
    (low != 0).then(|| if step > done { step.saturating_sub(1 << 32) } else { step })
}

fn said(fault: Fault) -> &'static str {
    match fault {
        Fault::Speed => {
            "a particle is faster than 12 thermal speeds, or infinitely fast: the fluid is being heated; use the thermostat, or a smaller force or dt"
        }
        Fault::Count => "a cell holds more particles than its sums allow: the fluid is being compressed somewhere",
        Fault::Energy => "the kinetic energy of one cell left the range of its sum: the fluid is being heated",
        Fault::Steric => "a steric force left its range: squirmers overlap; use more substeps or a smaller dt",
        Fault::Impulse => {
            "an impulse on a squirmer left its range: the fluid is being heated, or a body turns too fast"
        }
        Fault::Crowded => "more than seven squirmers are near one cell: they overlap",
        Fault::Nan => "a velocity is not a number",
        Fault::Room => {
            "128 cells hold more particles than there is room for: the fluid is being compressed somewhere; a run that goes on from its checkpoint makes room for the crowd that it finds there, and one begun with `--plan loose` has no such limit"
        }
        Fault::Stuck => "",
    }
}

/// Whether every velocity of particles and squirmers is a finite number: what a checkpoint needs to be worth keeping. The kernels see
/// this a step later.
///
/// # Errors
/// If one is not.
pub fn finite(step: u64, buffers: &[(&'static str, Vec<u8>)]) -> Result<(), RunError> {
    let fault = |what: String| Err(RunError::Fault { step, what });
    let particles_move = |bad: Option<usize>| match bad {
        Some(particle) => fault(format!("the velocity of particle {particle} is not a number")),
        None => Ok(()),
    };
    for (name, bytes) in buffers {
        match *name {
            "particles" => {
                let particles: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(bytes);
                particles_move(particles.iter().position(|p| !f32::from_bits(p[3]).is_finite()))?;
            }
            "velocities_yz" => {
                let velocities: Vec<[f32; 2]> = bytemuck::pod_collect_to_vec(bytes);
                particles_move(velocities.iter().position(|v| !v.iter().all(|c| c.is_finite())))?;
            }
            "squirmers" => {
                let whole = bytes.len() / size_of::<SquirmerState>() * size_of::<SquirmerState>();
                let states: Vec<SquirmerState> = bytemuck::pod_collect_to_vec(&bytes[..whole]);
                let well = |s: &SquirmerState| {
                    let numbers = [&s.velocity[..], &s.angular_momentum, &s.orientation, &s.remainder];
                    numbers.into_iter().flatten().all(|x| x.is_finite())
                };
                if let Some(squirmer) = states.iter().position(|s| !well(s)) {
                    return fault(format!("the motion of squirmer {squirmer} is not a number"));
                }
            }
            _ => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn low_words_are_of_the_last_step_that_they_fit() {
        assert_eq!(step_of(100, 34), Some(34));
        assert_eq!(step_of(100, 0), None);
        assert_eq!(step_of((7 << 32) + 5, 3), Some((7 << 32) + 3));
        assert_eq!(step_of((7 << 32) + 5, 0xffff_fffe), Some((6 << 32) + 0xffff_fffe));
    }

    #[test]
    fn what_is_no_number_is_found_with_its_owner() {
        // Any bits are a position.
        let particles = [[f32::NAN.to_bits(), u32::MAX, 3, 0.5f32.to_bits()]; 4];
        let buffers = |p: [[u32; 4]; 4], v: [[f32; 2]; 4]| {
            [("particles", bytemuck::bytes_of(&p).to_vec()), ("velocities_yz", bytemuck::bytes_of(&v).to_vec())]
        };
        assert!(finite(9, &buffers(particles, [[0.5; 2]; 4])).is_ok());
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let (mut along, mut across) = (particles, [[0.5; 2]; 4]);
            along[2][3] = bad.to_bits();
            across[2][1] = bad;
            for spoilt in [buffers(along, [[0.5; 2]; 4]), buffers(particles, across)] {
                let said = finite(9, &spoilt).expect_err("not finite").to_string();
                assert!(said.starts_with("step 9: the velocity of particle 2 is"), "{said}");
            }
        }
        let mut squirmers = vec![SquirmerState::default(); 3];
        let buffers = |s: &[SquirmerState]| vec![("squirmers", bytemuck::cast_slice(s).to_vec())];
        assert!(finite(9, &buffers(&squirmers)).is_ok());
        squirmers[1].angular_momentum[2] = f32::NAN;
        assert!(finite(9, &buffers(&squirmers)).is_err());
    }
}
