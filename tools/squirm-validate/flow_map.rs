//! The mean flow around a squirmer in the frame of its axis: velocities in the lab, over cylindrical bins that go with the body.

use crate::case::Trouble;
use crate::rig::{Planned, Rig, advance, sound};
use crate::swimmer::{settling, turn};
use glam::DVec3;
use squirm::gpu::Session;
use squirm::math::spheroid::Spheroid;
use squirm::state::{Squirmer, packed};

/// What was seen of the only squirmer of a periodic box and of the fluid around it.
pub struct Watched {
    /// The fluid.
    pub map: FlowMap,
    /// Mean axis.
    pub axis: DVec3,
    /// Mean angular velocities about the axis between two frames, 1/tau.
    pub spins: Vec<f64>,
}

/// Lets the flow develop, and then takes a frame after every `every` steps.
pub fn watch(rig: &Rig, planned: &Planned, frames: usize, every: u64) -> Result<Watched, Trouble> {
    const STRETCHES: usize = 20;
    let state = rig.start(planned)?;
    let mut session = rig.session(planned, &state)?;
    advance(&mut session, settling(&planned.system))?;
    let mut map = FlowMap::new(0.45 * f64::from(planned.system.domain.size[0]), STRETCHES);
    let (mut axis, mut spins) = (DVec3::ZERO, Vec::new());
    let mut before: Option<Squirmer> = None;
    for frame in 0..frames {
        advance(&mut session, every)?;
        let now = map.take(&session, frame * STRETCHES / frames)?;
        if let Some(before) = before {
            let turned = turn(before.orientation, now.orientation).dot(now.axis());
            spins.push(turned / (every as f64 * planned.system.run.dt));
        }
        axis += now.axis();
        before = Some(now);
    }
    sound(&session)?;
    Ok(Watched { map, axis: axis.normalize(), spins })
}

/// Bins of the edge 1 a: rho from 0 to `reach`, z from -`reach` to `reach`; in several stretches of time, for errors.
pub struct FlowMap {
    reach: usize,
    stretches: Vec<Vec<Sum>>,
}

/// Sums of one bin.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    count: f64,
    flow: DVec3,
}

impl Sum {
    fn add(&mut self, other: Self) {
        self.count += other.count;
        self.flow += other.flow;
    }
}

/// A bin that lies outside the body by more than half.
#[derive(Debug, Clone)]
pub struct Bin {
    /// Centre: rho and z.
    pub place: (f64, f64),
    /// Points of equal volume in it that lie outside the body: rho, z and weight.
    pub points: Vec<(f64, f64, f64)>,
    index: usize,
}

impl Bin {
    /// Distance of the centre from that of the body.
    pub fn distance(&self) -> f64 {
        self.place.0.hypot(self.place.1)
    }

    /// Mean over the bin of what is given in rho and z.
    pub fn mean(&self, f: impl Fn(f64, f64) -> DVec3) -> DVec3 {
        let weight: f64 = self.points.iter().map(|p| p.2).sum();
        self.points.iter().map(|(rho, z, w)| *w * f(*rho, *z)).sum::<DVec3>() / weight
    }
}

/// Which stretches of time count.
pub type Kept<'a> = dyn Fn(usize) -> bool + 'a;

/// The measured mean of a bin.
#[derive(Debug, Clone, Copy)]
pub struct Found {
    /// Components along rho, the azimuth (e x rho) and e.
    pub flow: DVec3,
    /// Particles behind it.
    pub count: f64,
}

impl FlowMap {
    /// Empty; `reach` must lie within half the box.
    pub fn new(reach: f64, stretches: usize) -> Self {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let reach = reach.floor() as usize;
        Self { reach, stretches: vec![vec![Sum::default(); 2 * reach * reach]; stretches] }
    }

    /// Number of stretches.
    pub fn stretches(&self) -> usize {
        self.stretches.len()
    }

    /// Adds the fluid around the only squirmer of a periodic box as it is now, and returns the squirmer; waits for the GPU.
    pub fn take(&mut self, session: &Session, stretch: usize) -> Result<Squirmer, Trouble> {
        let raw = session.raw()?;
        let body = packed::unpack_squirmers(session.system(), &raw.squirmers)[0];
        let around = Around {
            centre: raw.squirmers[0].position,
            scale: DVec3::from_array(session.system().domain.size.map(|n| f64::from(n) / 4_294_967_296.0)),
            axis: body.axis(),
            reach: self.reach,
        };
        let threads = std::thread::available_parallelism().map_or(1, usize::from).min(16);
        let particles = (raw.positions.len() / 3).div_ceil(threads).max(1);
        let parts: Vec<Vec<Sum>> = std::thread::scope(|scope| {
            let chunks = raw.positions.chunks(3 * particles).zip(raw.velocities.chunks(3 * particles));
            let workers: Vec<_> = chunks.map(|(x, v)| scope.spawn(|| around.sums(x, v))).collect();
            workers.into_iter().filter_map(|w| w.join().ok()).collect()
        });
        for part in parts {
            self.stretches[stretch].iter_mut().zip(part).for_each(|(sum, more)| sum.add(more));
        }
        Ok(body)
    }

    /// The bins outside a body whose centres satisfy a condition on their distance from its centre.
    pub fn bins(&self, body: Spheroid, wanted: impl Fn(f64) -> bool) -> Vec<Bin> {
        const FINE: u32 = 6;
        let mut out = Vec::new();
        for index in 0..2 * self.reach * self.reach {
            let (row, column) = (index / self.reach, index % self.reach);
            let (low, bottom) = (column as f64, row as f64 - self.reach as f64);
            let inner = |k: u32| (f64::from(k) + 0.5) / f64::from(FINE);
            let all = (0..FINE).flat_map(|i| (0..FINE).map(move |j| (low + inner(i), bottom + inner(j))));
            let outside = |(rho, z): &(f64, f64)| (rho / body.across).powi(2) + (z / body.along).powi(2) > 1.0;
            let points: Vec<_> = all.filter(outside).map(|(rho, z)| (rho, z, rho)).collect();
            let bin = Bin { place: (low + 0.5, bottom + 0.5), points, index };
            if 2 * bin.points.len() > (FINE * FINE) as usize && wanted(bin.distance()) {
                out.push(bin);
            }
        }
        out
    }

    /// The mean flow in a bin from those stretches that `kept` names; nothing where no particle was.
    pub fn found(&self, bin: &Bin, kept: &Kept<'_>) -> Found {
        let mut sum = Sum::default();
        self.stretches.iter().enumerate().filter(|(i, _)| kept(*i)).for_each(|(_, s)| sum.add(s[bin.index]));
        Found { flow: sum.flow / sum.count.max(1.0), count: sum.count }
    }

    /// Error of each component of the mean flow in a bin, from the scatter of the stretches.
    pub fn error(&self, bin: &Bin) -> DVec3 {
        let means: Vec<DVec3> = (0..self.stretches()).map(|i| self.found(bin, &|k| k == i).flow).collect();
        let n = means.len() as f64;
        let mean = means.iter().sum::<DVec3>() / n;
        let squares: DVec3 = means.iter().map(|m| (*m - mean) * (*m - mean)).sum();
        (squares / (n * (n - 1.0).max(1.0))).map(f64::sqrt)
    }
}

/// Where the squirmer is.
struct Around {
    centre: [u32; 3],
    /// Cells per coordinate unit.
    scale: DVec3,
    axis: DVec3,
    reach: usize,
}

impl Around {
    fn sums(&self, positions: &[u32], velocities: &[f32]) -> Vec<Sum> {
        let mut out = vec![Sum::default(); 2 * self.reach * self.reach];
        let reach = self.reach as f64;
        for (x, v) in positions.chunks_exact(3).zip(velocities.chunks_exact(3)) {
            // The difference of two u32 coordinates, read as signed, is that to the nearest image.
            let turn = [0, 1, 2].map(|k| f64::from(x[k].wrapping_sub(self.centre[k]).cast_signed()));
            let r = DVec3::from_array(turn) * self.scale;
            let z = r.dot(self.axis);
            let radial = r - z * self.axis;
            let rho = radial.length();
            if rho >= reach || z.abs() >= reach || rho == 0.0 {
                continue;
            }
            let outwards = radial / rho;
            let velocity = DVec3::new(v[0].into(), v[1].into(), v[2].into());
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let index = ((z + reach) as usize).min(2 * self.reach - 1) * self.reach + rho as usize;
            out[index].count += 1.0;
            let azimuth = self.axis.cross(outwards);
            out[index].flow += DVec3::new(velocity.dot(outwards), velocity.dot(azimuth), velocity.dot(self.axis));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A particle one and a half cells ahead and two beside, across the side of the box.
    #[test]
    fn particles_fall_into_their_bins() {
        let unit = 4_294_967_296.0 / 16.0;
        let at = |c: f64| (c.rem_euclid(16.0) * unit) as u32;
        let around =
            Around { centre: [at(15.5), at(1.0), at(8.0)], scale: DVec3::splat(1.0 / unit), axis: DVec3::X, reach: 4 };
        let sums = around.sums(&[at(17.0), at(-1.0), at(8.0)], &[1.0, 2.0, 3.0]);
        let map = FlowMap { reach: 4, stretches: vec![sums] };
        let body = Spheroid { along: 1.0, across: 1.0 };
        let bins = map.bins(body, |_| true);
        let bin = bins.iter().find(|b| b.place == (2.5, 1.5) || b.place == (1.5, 1.5)).expect("a bin");
        let filled: Vec<_> = bins.iter().filter(|b| map.found(b, &|_| true).count > 0.0).collect();
        assert_eq!(filled.len(), 1, "{bin:?}");
        // Radially outwards is -y, e x rho is -z.
        assert!((map.found(filled[0], &|_| true).flow - DVec3::new(-2.0, -3.0, 1.0)).length() < 1e-6);
        assert!((filled[0].place.1 - 1.5).abs() < 1e-9);
    }

    #[test]
    fn bins_leave_the_body_out() {
        let map = FlowMap::new(6.0, 2);
        let body = Spheroid { along: 4.0, across: 2.0 };
        let volume: f64 = map.bins(body, |r| r < 6.0).iter().map(|b| b.place.0).sum();
        // Sum of rho over cells of one square a is volume/(2 pi): half a sphere's profile less the body's.
        let wanted = (6f64.powi(3) - 16.0) * 2.0 / 3.0;
        assert!((volume / wanted - 1.0).abs() < 0.1, "{volume} {wanted}");
        assert!(map.bins(body, |r| r < 1.9).is_empty());
    }
}
