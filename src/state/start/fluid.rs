//! The fluid at the start: uniformly random outside the squirmers, with thermal velocities.

use super::image::{lengths, nearest_image, periodic};
use super::stream::{Stream, Use};
use crate::math::spheroid::Spheroid;
use crate::state::{Particle, Squirmer, System};
use glam::DVec3;

/// Particles keep this distance from squirmers (a), so that rounding of positions puts none inside.
const CLEARANCE: f64 = 1e-4;
/// Places tried for one particle.
const ATTEMPTS: usize = 10_000;
/// Cells of the look-up grid at most.
const GRID: f64 = 8e6;

/// Finds the squirmer that a point lies in, through a grid of cells that list the bodies whose boxes meet them.
#[derive(Debug)]
pub struct Bodies<'a> {
    system: &'a System,
    bodies: Vec<(DVec3, DVec3, Spheroid)>,
    counts: [usize; 3],
    first: Vec<usize>,
    listed: Vec<usize>,
}

impl<'a> Bodies<'a> {
    /// The index of these squirmers.
    #[must_use]
    pub fn new(system: &'a System, squirmers: &[Squirmer]) -> Self {
        let edge = (system.domain.volume() / GRID).cbrt().max(1.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let counts = lengths(&system.domain).to_array().map(|l| ((l / edge) as usize).max(1));
        let body = |s: &Squirmer| (s.position, s.axis(), system.species[s.species].hull().grown(CLEARANCE));
        let mut index = Self {
            system,
            bodies: squirmers.iter().map(body).collect(),
            counts,
            first: vec![0; counts.iter().product::<usize>() + 1],
            listed: Vec::new(),
        };
        let cells: Vec<Vec<usize>> = index.bodies.iter().map(|b| index.cells_of(b)).collect();
        for cell in cells.iter().flatten() {
            index.first[cell + 1] += 1;
        }
        for cell in 1..index.first.len() {
            index.first[cell] += index.first[cell - 1];
        }
        index.listed = vec![0; index.first[index.first.len() - 1]];
        let mut next = index.first.clone();
        for (body, cells) in cells.iter().enumerate() {
            for cell in cells {
                index.listed[next[*cell]] = body;
                next[*cell] += 1;
            }
        }
        index
    }

    /// Grid cells that meet the box around a body, each once.
    #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss)]
    fn cells_of(&self, (centre, axis, shape): &(DVec3, DVec3, Spheroid)) -> Vec<usize> {
        let (l, periodic) = (lengths(&self.system.domain), periodic(&self.system.domain));
        let [xs, ys, zs] = [0, 1, 2].map(|k| {
            let half = shape.half_height(axis[k]);
            let n = self.counts[k] as i64;
            let cell = |x: f64| (x / l[k] * n as f64).floor() as i64;
            let (low, high) = (cell(centre[k] - half), cell(centre[k] + half));
            if high - low + 1 >= n {
                (0..n as usize).collect::<Vec<_>>()
            } else if periodic[k] {
                (low..=high).map(|c| c.rem_euclid(n) as usize).collect()
            } else {
                (low.max(0)..=high.min(n - 1)).map(|c| c as usize).collect()
            }
        });
        let mut cells = Vec::with_capacity(xs.len() * ys.len() * zs.len());
        for z in &zs {
            for y in &ys {
                cells.extend(xs.iter().map(|x| (z * self.counts[1] + y) * self.counts[0] + x));
            }
        }
        cells
    }

    /// The first squirmer that holds this point of the box.
    #[must_use]
    pub fn containing(&self, point: DVec3) -> Option<usize> {
        let l = lengths(&self.system.domain);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let [x, y, z] = [0, 1, 2].map(|k| ((point[k] / l[k] * self.counts[k] as f64) as usize).min(self.counts[k] - 1));
        let cell = (z * self.counts[1] + y) * self.counts[0] + x;
        self.listed[self.first[cell]..self.first[cell + 1]].iter().copied().find(|i| {
            let (centre, axis, shape) = &self.bodies[*i];
            let s = nearest_image(&self.system.domain, point - centre);
            let along = s.dot(*axis);
            let square = along * along;
            (s.length_squared() - square) / shape.across.powi(2) + square / shape.along.powi(2) < 1.0
        })
    }
}

/// `particle_count()` particles; none if some find no place.
#[must_use]
pub fn fluid(system: &System, squirmers: &[Squirmer]) -> Option<Vec<Particle>> {
    let bodies = Bodies::new(system, squirmers);
    let count = usize::try_from(system.particle_count()).ok()?;
    let mut particles = vec![Particle::default(); count];
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let share = count.div_ceil(threads).max(1);
    // Every particle has numbers of its own: the result does not depend on the number of threads.
    let filled = std::thread::scope(|scope| {
        let fill = |(chunk, part): (usize, &mut [Particle])| {
            let begin = chunk * share;
            part.iter_mut().enumerate().all(|(i, p)| {
                let particle = u32::try_from(begin + i).ok().and_then(|index| particle(system, &bodies, index));
                particle.map(|found| *p = found).is_some()
            })
        };
        let workers: Vec<_> =
            particles.chunks_mut(share).enumerate().map(|part| scope.spawn(move || fill(part))).collect();
        workers.into_iter().all(|w| w.join().unwrap_or(false))
    });
    filled.then_some(particles)
}

fn particle(system: &System, bodies: &Bodies, index: u32) -> Option<Particle> {
    let l = lengths(&system.domain);
    let mut places = Stream::new(system.run.seed, Use::Position, index);
    let position = (0..ATTEMPTS).find_map(|_| {
        let u = places.uniforms();
        let point = l * DVec3::new(u[0], u[1], u[2]);
        bodies.containing(point).is_none().then_some(point)
    })?;
    let velocity = system.fluid.temperature.sqrt() * Stream::new(system.run.seed, Use::Velocity, index).normals();
    Some(Particle { position, velocity })
}
