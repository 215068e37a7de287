//! Faults that kernels report, in words: what went wrong, where, and what to do.

use super::RunError;
use crate::buffers::{Fault, SquirmerState};
use crate::graph::Plan;

/// Whether the words of `faults` tell of a fault that stops a run; `step` steps were done when they were read.
///
/// # Errors
/// If they do.
pub fn check(plan: &Plan, step: u64, words: &[u32]) -> Result<(), RunError> {
    let flags = words.first().copied().unwrap_or(0);
    let _ = plan;
    let what: Vec<&str> =
        Fault::ALL.iter().filter(|f| flags & **f as u32 != 0).map(|f| said(*f)).filter(|s| !s.is_empty()).collect();
    if what.is_empty() { Ok(()) } else { Err(RunError::Fault { step, what: what.join("; ") }) }
}

fn said(fault: Fault) -> &'static str {
    match fault {
        Fault::Speed => {
            "a particle is faster than 12 thermal speeds: the fluid is being heated; use the thermostat, or a smaller force or dt"
        }
        Fault::Count => "a cell holds more particles than its sums allow: the fluid is being compressed somewhere",
        Fault::Energy => "the kinetic energy of one cell left the range of its sum: the fluid is being heated",
        Fault::Steric => "a steric force left its range: squirmers overlap; use more substeps or a smaller dt",
        Fault::Impulse => {
            "an impulse on a squirmer left its range: the fluid is being heated, or a body turns too fast"
        }
        Fault::Crowded => "more than seven squirmers are near one cell: they overlap",
        Fault::Nan => "a velocity is not a number",
        Fault::Spill => {
            "more than a sixteenth of all particles share cells whose lists are full, at nearly two standard deviations above the mean: the fluid is being compressed somewhere"
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
    for (name, bytes) in buffers {
        match *name {
            "velocities" => {
                let mut words = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b));
                if let Some(word) = words.position(|v| !v.is_finite()) {
                    return fault(format!("the velocity of particle {} is not a number", word / 3));
                }
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
