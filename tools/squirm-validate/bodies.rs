//! Passive bodies followed through time: where they were, how they turned, and what that says of their diffusion.

use crate::case::Trouble;
use crate::neighbours::Neighbours;
use crate::periodic::PeriodicBody;
use crate::rig::{advance, sound};
use crate::rules::viscosity;
use glam::{DQuat, DVec3};
use squirm::analyze::statistics::{Estimate, blocked};
use squirm::buffers::SquirmerState;
use squirm::gpu::Session;
use squirm::state::{Squirmer, System, packed};

/// How far inside a body's hull the fluid comes to rest, in a: ghosts have the velocity of the body, while the fluid that they stand
/// for would go on along its gradient. It is the slip length of a plane wall; the default `offset` of a species is as large.
const SLIP_LENGTH: f64 = 0.12;

/// The system's first species in its periodic cube, with the surface on which the fluid does not slip.
pub fn periodic(system: &System) -> PeriodicBody {
    PeriodicBody {
        shape: system.species[0].hull().grown(-SLIP_LENGTH),
        edge: f64::from(system.domain.size[0]),
        density: system.fluid.density,
        viscosity: viscosity(system),
    }
}

/// The bodies at this moment, with the crossings of the box counted into their positions.
pub fn bodies(session: &Session) -> Result<Vec<Squirmer>, Trouble> {
    let mut raw = session.read::<SquirmerState>("squirmers")?;
    raw.truncate(session.system().squirmer_count() as usize);
    let size = DVec3::from_array(session.system().domain.size.map(f64::from));
    let mut squirmers = packed::unpack_squirmers(session.system(), &raw);
    for (squirmer, state) in squirmers.iter_mut().zip(&raw) {
        squirmer.position += size * DVec3::from_array(state.image.map(f64::from));
    }
    if squirmers.iter().all(|s| s.position.is_finite() && s.orientation.is_finite() && s.velocity.is_finite()) {
        Ok(squirmers)
    } else {
        Err(format!("a body is nowhere by step {}", session.step()).into())
    }
}

/// One body at evenly spaced moments.
#[derive(Debug, Clone, Default)]
pub struct Track {
    /// Centres in a, crossings of the box included.
    pub positions: Vec<DVec3>,
    /// Unit vectors along e.
    pub axes: Vec<DVec3>,
    /// Sums of the small rotations so far, each as a rotation vector in the frame of the body.
    pub turns: Vec<DVec3>,
}

/// All bodies of a run.
#[derive(Debug, Clone, Default)]
pub struct Tracks {
    /// One per body.
    pub bodies: Vec<Track>,
    /// Time between two moments, in tau.
    pub spacing: f64,
    /// How far away the other bodies are.
    pub neighbours: Neighbours,
}

/// How fast mean squares grow in each direction of the body frame: one value per origin of time, averaged over bodies.
#[derive(Debug, Clone, Default)]
pub struct Growth {
    /// Displacement along e.
    pub along: Vec<f64>,
    /// Displacement across e, per direction.
    pub across: Vec<f64>,
    /// Rotation about e.
    pub spin: Vec<f64>,
    /// Rotation about axes across e, per axis.
    pub tumble: Vec<f64>,
}

impl Tracks {
    /// Follows the bodies for `steps` steps and looks at them every `every`.
    pub fn follow(session: &mut Session, steps: u64, every: u64) -> Result<Self, Trouble> {
        let mut tracks = Self { spacing: every as f64 * session.system().run.dt, ..Self::default() };
        let mut before: Vec<DQuat> = Vec::new();
        for moment in 0..=steps / every {
            if moment > 0 {
                advance(session, every)?;
            }
            let now = bodies(session)?;
            tracks.neighbours.add(session.system(), &now);
            tracks.push(&now, &mut before);
        }
        sound(session)?;
        Ok(tracks)
    }

    fn push(&mut self, now: &[Squirmer], before: &mut Vec<DQuat>) {
        self.bodies.resize_with(now.len(), Track::default);
        for (i, (track, body)) in self.bodies.iter_mut().zip(now).enumerate() {
            let turn = match (track.turns.last(), before.get(i)) {
                (Some(sum), Some(old)) => *sum + rotation(old.inverse() * body.orientation),
                _ => DVec3::ZERO,
            };
            track.positions.push(body.position);
            track.axes.push(body.axis());
            track.turns.push(turn);
        }
        *before = now.iter().map(|b| b.orientation).collect();
    }

    /// Goes on with what was seen next, whose first moment is the last of these. The neighbours stay those of the first stretch.
    pub fn extend(&mut self, more: Self) {
        if self.bodies.is_empty() {
            *self = more;
            return;
        }
        for (track, next) in self.bodies.iter_mut().zip(more.bodies) {
            let turned = track.turns.last().copied().unwrap_or_default();
            track.positions.extend(next.positions.into_iter().skip(1));
            track.axes.extend(next.axes.into_iter().skip(1));
            track.turns.extend(next.turns.into_iter().skip(1).map(|t| turned + t));
        }
    }

    /// Moments taken.
    pub fn len(&self) -> usize {
        self.bodies.first().map_or(0, |b| b.positions.len())
    }

    /// The moment nearest to a time since the start.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn moment(&self, time: f64) -> usize {
        (time / self.spacing).round() as usize
    }

    /// Half the growth of mean squares between two lags in tau, per time: the diffusion coefficients' means over these lags. What the
    /// body does before the first lag, while inertia and its own flow carry it, drops out.
    pub fn growth(&self, (from, to): (f64, f64)) -> Growth {
        let (near, far) = (self.moment(from), self.moment(to));
        let origins = self.len().saturating_sub(far);
        let share = 1.0 / (2.0 * (far - near) as f64 * self.spacing * self.bodies.len() as f64);
        let zero = || vec![0.0; origins];
        let mut growth = Growth { along: zero(), across: zero(), spin: zero(), tumble: zero() };
        for track in &self.bodies {
            for i in 0..origins {
                let (e, r, t) = (track.axes[i], &track.positions, &track.turns);
                let (d1, d2) = (r[i + near] - r[i], r[i + far] - r[i]);
                let (t1, t2) = (t[i + near] - t[i], t[i + far] - t[i]);
                let along = d2.dot(e).powi(2) - d1.dot(e).powi(2);
                let spin = t2.z * t2.z - t1.z * t1.z;
                growth.along[i] += share * along;
                growth.across[i] += share * 0.5 * (d2.length_squared() - d1.length_squared() - along);
                growth.spin[i] += share * spin;
                growth.tumble[i] += share * 0.5 * (t2.length_squared() - t1.length_squared() - spin);
            }
        }
        growth
    }
}

/// Directions averaged, weighted by their number.
pub fn isotropic(one: &[f64], two: &[f64]) -> Estimate {
    let series: Vec<f64> = one.iter().zip(two).map(|(a, b)| (a + 2.0 * b) / 3.0).collect();
    blocked(&series)
}

/// The rotation vector of a small rotation, whichever sign the quaternion has.
fn rotation(q: DQuat) -> DVec3 {
    if q.w < 0.0 { (-q).to_scaled_axis() } else { q.to_scaled_axis() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use squirm::analyze::statistics::mean;

    /// Normal numbers from a linear congruence: enough for a random walk.
    struct Normals(u64);

    impl Normals {
        fn next(&mut self) -> f64 {
            let mut sum = -6.0;
            for _ in 0..12 {
                self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                sum += (self.0 >> 11) as f64 / 9_007_199_254_740_992.0;
            }
            sum
        }

        fn vector(&mut self) -> DVec3 {
            DVec3::new(self.next(), self.next(), self.next())
        }
    }

    /// A random walk in the frame of a body that turns: variances per step 2 D dt with known D in each direction.
    fn walk(steps: usize) -> Tracks {
        let mut normals = Normals(5);
        let mut tracks = Tracks { spacing: 2.0, ..Tracks::default() };
        let mut bodies: Vec<Squirmer> = (0..4)
            .map(|_| Squirmer {
                species: 0,
                position: DVec3::ZERO,
                orientation: DQuat::IDENTITY,
                velocity: DVec3::ZERO,
                angular_momentum: DVec3::ZERO,
            })
            .collect();
        let mut before = Vec::new();
        for _ in 0..steps {
            for body in &mut bodies {
                let slide = DVec3::new(0.1, 0.1, 0.3) * normals.vector();
                body.position += body.orientation * slide;
                let turn = DVec3::new(0.01, 0.01, 0.02) * normals.vector();
                body.orientation *= DQuat::from_scaled_axis(turn);
            }
            tracks.push(&bodies, &mut before);
        }
        tracks
    }

    #[test]
    fn a_random_walk_has_the_diffusion_that_was_put_in() {
        let growth = walk(20_000).growth((4.0, 10.0));
        let expected = [(0.3, growth.along), (0.1, growth.across), (0.02, growth.spin), (0.01, growth.tumble)];
        for (amplitude, series) in expected {
            let d = f64::powi(amplitude, 2) / (2.0 * 2.0);
            let found = blocked(&series);
            assert!(found.error < 0.03 * d, "{found:?}");
            assert!((mean(&series) - d).abs() < 4.0 * found.error + 0.02 * d, "{found:?} {d}");
        }
    }

    #[test]
    fn both_signs_of_a_quaternion_are_one_rotation() {
        let q = DQuat::from_scaled_axis(DVec3::new(0.01, -0.02, 0.03));
        assert!((rotation(-q) - rotation(q)).length() < 1e-12);
    }
}
