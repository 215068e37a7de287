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

impl Balance {
    fn numbers(&self) -> Vec<f64> {
        let vectors = [self.fluid_momentum, self.body_momentum, self.walls[0], self.walls[1]];
        let numbers = [self.count, self.time, self.fluid_energy, self.body_energy];
        numbers.into_iter().chain(vectors.iter().flat_map(DVec3::to_array)).collect()
    }

    fn read(numbers: &[f64]) -> Option<Self> {
        let [count, time, fluid_energy, body_energy, vectors @ ..] = numbers else { return None };
        let vectors: Vec<DVec3> = vectors.chunks_exact(3).map(DVec3::from_slice).collect();
        let [fluid_momentum, body_momentum, low, high] = vectors.try_into().ok()?;
        let (count, time, fluid_energy, body_energy) = (*count, *time, *fluid_energy, *body_energy);
        Some(Self { count, time, fluid_energy, body_energy, fluid_momentum, body_momentum, walls: [low, high] })
    }
}

/// Collected over a run.
#[derive(Debug, Clone, PartialEq, Default)]
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

    /// All numbers in it, in an order that [`Books::read`] knows.
    #[must_use]
    pub fn numbers(&self) -> Vec<f64> {
        #[allow(clippy::cast_precision_loss)]
        fn list(into: &mut Vec<f64>, values: &[f64]) {
            into.push(values.len() as f64);
            into.extend(values);
        }
        let mut all = vec![f64::from(u8::from(self.stuck))];
        let balances = self.balances.map_or(Vec::new(), |(first, last)| [first.numbers(), last.numbers()].concat());
        list(&mut all, &balances);
        list(&mut all, &self.temperatures);
        self.speeds.iter().for_each(|speeds| list(&mut all, speeds));
        if let Some((time, places, axes)) = &self.before {
            all.push(*time);
            all.extend(places.iter().chain(axes).flat_map(DVec3::to_array));
        }
        all
    }

    /// Books of a system from [`Books::numbers`]; `None` if these are not the numbers of such books.
    #[must_use]
    pub fn read(system: &System, numbers: &[f64]) -> Option<Self> {
        fn list<'a>(from: &mut &'a [f64]) -> Option<&'a [f64]> {
            let (length, rest) = from.split_first()?;
            #[allow(clippy::cast_precision_loss)]
            let length = (0..=rest.len()).contains(&(*length as usize)).then_some(*length as usize)?;
            let (values, rest) = rest.split_at(length);
            *from = rest;
            Some(values)
        }
        let mut books = Self::new(system);
        let (stuck, mut rest) = numbers.split_first()?;
        books.stuck = *stuck != 0.0;
        let balances = list(&mut rest)?;
        if !balances.is_empty() {
            let (first, last) = balances.split_at(balances.len() / 2);
            books.balances = Some((Balance::read(first)?, Balance::read(last)?));
        }
        books.temperatures = list(&mut rest)?.to_vec();
        for speeds in &mut books.speeds {
            *speeds = list(&mut rest)?.to_vec();
        }
        let squirmers = system.squirmer_count() as usize;
        if let Some((time, rest)) = rest.split_first() {
            let vectors = |part: &[f64]| part.chunks_exact(3).map(DVec3::from_slice).collect();
            let (places, axes) =
                rest.split_at_checked(3 * squirmers).filter(|(_, axes)| axes.len() == 3 * squirmers)?;
            books.before = Some((*time, vectors(places), vectors(axes)));
        }
        Some(books)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::{Domain, Fluid, Init, Run, SemiAxes, Species};

    /// Two squirmers of two species.
    fn system() -> System {
        let species = |name: &str| Species {
            name: name.into(),
            count: 1,
            semi_axes: SemiAxes { along: 2.0, across: 1.0 },
            offset: 0.0,
            force: [0.0; 3],
            b1: 0.1,
            beta: 0.0,
            rotlet: 0.0,
            passive: false,
            held: false,
            start: "random".into(),
            poses: None,
        };
        System {
            run: Run { seed: 1, steps: 1, dt: 0.1, live: false },
            domain: Domain { size: [8; 3], walls: None },
            fluid: Fluid { density: 10.0, temperature: 1.0, acceleration: [0.0; 3] },
            species: vec![species("a"), species("b")],
            init: Init { from: None },
        }
    }

    #[test]
    fn they_read_back_bit_by_bit() {
        let system = system();
        let balance = Balance { count: 5120.0, time: 0.1, walls: [DVec3::X, DVec3::Y], ..Balance::default() };
        let vectors = vec![DVec3::new(0.1, 1e-300, -7.0), DVec3::Z];
        let full = Books {
            stuck: true,
            balances: Some((balance, Balance { time: 0.3, ..balance })),
            temperatures: vec![1.0 / 3.0, 0.99],
            speeds: vec![vec![], vec![0.1, -0.2, 0.3]],
            before: Some((0.7, vectors.clone(), vectors)),
            ..Books::new(&system)
        };
        for books in [Books::new(&system), full] {
            let numbers = books.numbers();
            assert_eq!(Books::read(&system, &numbers), Some(books));
            if numbers.len() > 5 {
                for length in 0..numbers.len() {
                    let cut = Books::read(&system, &numbers[..length]);
                    assert!(cut.is_none_or(|b| b.before.is_none()), "{length}");
                }
            }
        }
    }
}
