//! The books of a run: temperature, momentum, energy, and how fast the squirmers swim.

use super::frames::Frame;
use crate::analyze::statistics;
use crate::state::System;
use glam::DVec3;

/// What the books know of one moment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Balance {
    /// Fluid particles.
    pub count: f64,
    /// Simulated time in tau.
    pub time: f64,
    /// Kinetic energy of the fluid in kT.
    pub fluid_energy: f64,
    /// Kinetic energy of the squirmers in kT.
    pub body_energy: f64,
    /// Momentum of the fluid.
    pub fluid_momentum: DVec3,
    /// Momentum of the squirmers.
    pub body_momentum: DVec3,
    /// Momentum received by the two walls since the start.
    pub walls: [DVec3; 2],
}

/// Collected over a run.
#[derive(Debug, Clone, Default)]
pub struct Books {
    system: Option<System>,
    /// The first and the last balance.
    pub balances: Option<(Balance, Balance)>,
    /// Temperatures of the fluid, in kT.
    pub temperatures: Vec<f64>,
    /// Per species, the squirmers' mean speed along their axis between successive samples, in sqrt(kT/m).
    pub speeds: Vec<Vec<f64>>,
    /// Some particle had to be pushed out of a squirmer.
    pub stuck: bool,
    before: Option<(f64, Vec<DVec3>, Vec<DVec3>)>,
}

impl Books {
    /// Empty books.
    #[must_use]
    pub fn new(system: &System) -> Self {
        Self { system: Some(system.clone()), speeds: vec![Vec::new(); system.species.len()], ..Self::default() }
    }

    /// Enters one frame; `fluid` says whether its totals were measured.
    pub fn enter(&mut self, frame: &Frame, fluid: bool) {
        let Some(system) = self.system.clone() else { return };
        self.stuck |= frame.stuck();
        if fluid {
            let (body_energy, body_momentum) = frame.bodies(&system);
            let balance = Balance {
                count: frame.totals.count,
                time: frame.time,
                fluid_energy: frame.totals.energy,
                body_energy,
                fluid_momentum: frame.totals.momentum,
                body_momentum,
                walls: frame.wall_impulses,
            };
            if frame.totals.temperature > 0.0 {
                self.temperatures.push(frame.totals.temperature);
            }
            self.balances = Some((self.balances.map_or(balance, |(first, _)| first), balance));
        }
        let axes: Vec<DVec3> = frame.squirmers.iter().map(crate::state::Squirmer::axis).collect();
        if let Some((time, places, old)) = &self.before
            && frame.time > *time
        {
            for (species, speeds) in self.speeds.iter_mut().enumerate() {
                let mine = frame.squirmers.iter().enumerate().filter(|(_, s)| s.species == species);
                let steps: Vec<f64> = mine
                    .map(|(i, _)| {
                        (frame.unwrapped[i] - places[i]).dot((axes[i] + old[i]).normalize()) / (frame.time - time)
                    })
                    .collect();
                #[allow(clippy::cast_precision_loss)]
                speeds.push(steps.iter().sum::<f64>() / steps.len() as f64);
            }
        }
        self.before = Some((frame.time, frame.unwrapped.clone(), axes));
    }

    /// Mean temperature of the second half of the run and its error, in kT.
    #[must_use]
    pub fn temperature(&self) -> (f64, f64) {
        mean(&self.temperatures[self.temperatures.len() / 2..])
    }

    /// Mean swim speed of a species and its error; the first tenth of the run is left out.
    #[must_use]
    pub fn swim_speed(&self, species: usize) -> (f64, f64) {
        let series = &self.speeds[species];
        mean(&series[series.len() / 10..])
    }
}

fn mean(series: &[f64]) -> (f64, f64) {
    let estimate = statistics::blocked(series);
    (estimate.mean, estimate.error)
}
