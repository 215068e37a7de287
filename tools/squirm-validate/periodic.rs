//! Stokes flow about a body in a periodic cube: mobility, diffusion, and how diffusion coefficients grow to their final values.

use crate::neighbours::{Neighbours, arrived};
use squirm::math::mobility::Friction;
use squirm::math::spheroid::Spheroid;
use std::f64::consts::{PI, TAU};

/// The Madelung constant of Hasimoto's correction for a simple cubic lattice.
const HASIMOTO: f64 = 2.837_297;

/// A neutrally buoyant spheroid in a periodic cube of fluid; kT = 1.
#[derive(Debug, Clone, Copy)]
pub struct PeriodicBody {
    /// The surface on which the fluid does not slip.
    pub shape: Spheroid,
    /// Edge of the cube in a.
    pub edge: f64,
    /// Mass density of the fluid.
    pub density: f64,
    /// Dynamic viscosity in sqrt(m kT)/a^2.
    pub viscosity: f64,
}

/// Mobilities, which are diffusion coefficients for kT = 1.
#[derive(Debug, Clone, Copy)]
pub struct Mobility {
    /// Translation along the axis e, in a^2/tau.
    pub along: f64,
    /// Translation across e.
    pub across: f64,
    /// Rotation about e, in 1/tau.
    pub spin: f64,
    /// Rotation about an axis across e.
    pub tumble: f64,
}

impl PeriodicBody {
    /// Mobilities at long times. Translation: Perrin's friction and Hasimoto's correction (J. Fluid Mech. 5, 317, 1959). Its next term is
    /// the quadratic part of the images' flow, (2 r^2 - r r)/(15 eta V) times the force, averaged over where on the surface the force
    /// acts and where it is felt (each <r_i r_i> = a_i^2/3); for a sphere 4 pi/3 R^2/L^2 of Hasimoto's first.
    /// Rotation: the uniform counter-rotation that periodicity takes away.
    pub fn mobility(&self) -> Mobility {
        let (friction, eta, l) = (Friction::of(self.shape), self.viscosity, self.edge);
        let squares = 3.0 * self.square_radius();
        let images = |axis: f64| {
            2.0 / 45.0 * (2.0 * squares - axis * axis) / (eta * l.powi(3)) - HASIMOTO / (6.0 * PI * eta * l)
        };
        let counter_rotation = -1.0 / (6.0 * eta * l.powi(3));
        Mobility {
            along: 1.0 / (friction.along * eta) + images(self.shape.along),
            across: 1.0 / (friction.across * eta) + images(self.shape.across),
            spin: 1.0 / (friction.spin * eta) + counter_rotation,
            tumble: 1.0 / (friction.tumble * eta) + counter_rotation,
        }
    }

    /// What other free bodies of this kind have taken off the translation at the lags `from..to`, as the mean over directions: each is
    /// taken as a rigid sphere of its volume (see [`arrived`]).
    pub fn hindrance(&self, neighbours: &Neighbours, lags: (f64, f64)) -> f64 {
        let nu = self.viscosity / self.density;
        self.stiffness() * neighbours.sum(|r| arrived(r, nu, lags) / r.powi(4))
    }

    /// The same at long times.
    pub fn long_hindrance(&self, neighbours: &Neighbours) -> f64 {
        self.stiffness() * neighbours.sum(|r| r.powi(-4))
    }

    /// What one neighbour takes off, times r^4.
    fn stiffness(&self) -> f64 {
        let cubed = self.shape.volume() / (4.0 / 3.0 * PI);
        5.0 / 4.0 * cubed / (6.0 * PI * self.viscosity)
    }

    /// What translation along and across e still lacks, as a mean over the times `from..to`: the flow that a body leaves behind decays
    /// mode by mode, and drags it along until then (Alder and Wainwright, Phys. Rev. A 1, 18, 1970; in periodic boxes the integral over
    /// modes is a sum). The body feels a mode's mean over its surface (Faxen), which for a neutrally buoyant sphere is also the next order
    /// in time (Hauge and Martin-Loef, J. Stat. Phys. 7, 259, 1973).
    pub fn missing_translation(&self, (from, to): (f64, f64)) -> (f64, f64) {
        let nu = self.viscosity / self.density;
        let lacking = |moves: fn(f64) -> f64| {
            let sum = self.modes(|k2| {
                let rate = nu * k2;
                self.seen(k2, moves) * ((-rate * from).exp() - (-rate * to).exp()) / (rate * rate)
            });
            sum / (self.density * self.edge.powi(3) * (to - from))
        };
        // How much of a unit velocity is transverse to a wave vector whose square cosine with e is given.
        (lacking(|mu2| 1.0 - mu2), lacking(|mu2| f64::midpoint(1.0, mu2)))
    }

    /// Mean over the body's orientations of what a mode of the wave number k moves it: the square of the mode's mean over the surface.
    fn seen(&self, k2: f64, moves: fn(f64) -> f64) -> f64 {
        const STEPS: u32 = 16;
        let (b2, a2) = (self.shape.along.powi(2), self.shape.across.powi(2));
        let at = |i: u32| {
            let mu2 = ((f64::from(i) + 0.5) / f64::from(STEPS)).powi(2);
            moves(mu2) * (-k2 * (a2 + (b2 - a2) * mu2) / 3.0).exp()
        };
        (0..STEPS).map(at).sum::<f64>() / f64::from(STEPS)
    }

    /// The same for rotation, which follows half the vorticity of a mode, averaged over the body.
    pub fn missing_rotation(&self, (from, to): (f64, f64)) -> f64 {
        let nu = self.viscosity / self.density;
        let sum = self.modes(|k2| {
            let rate = nu * k2;
            (-k2 * self.square_radius() / 5.0).exp() * ((-rate * from).exp() - (-rate * to).exp()) / rate
        });
        sum / (6.0 * self.viscosity * self.edge.powi(3) * (to - from))
    }

    /// Mean square distance from the centre of the points that a unit sphere becomes when it is stretched to the body.
    fn square_radius(&self) -> f64 {
        (2.0 * self.shape.across.powi(2) + self.shape.along.powi(2)) / 3.0
    }

    /// Sum over the wave vectors of the box but zero of a function of k^2 that has decayed at 24 pi/L.
    fn modes(&self, term: impl Fn(f64) -> f64) -> f64 {
        let step = (TAU / self.edge).powi(2);
        let mut sum = 0.0;
        for x in -12..=12_i32 {
            for y in -12..=12_i32 {
                for z in -12..=12_i32 {
                    let n = x * x + y * y + z * z;
                    sum += if n == 0 { 0.0 } else { term(step * f64::from(n)) };
                }
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere(edge: f64) -> PeriodicBody {
        PeriodicBody { shape: Spheroid { along: 3.0, across: 3.0 }, edge, density: 10.0, viscosity: 4.25 }
    }

    #[test]
    fn a_large_box_is_stokes() {
        let m = sphere(1e6).mobility();
        let expected = 1.0 / (6.0 * PI * 4.25 * 3.0);
        assert!((m.along / expected - 1.0).abs() < 1e-5, "{m:?}");
        assert!((m.spin * 8.0 * PI * 4.25 * 27.0 - 1.0).abs() < 1e-9, "{m:?}");
    }

    /// Hasimoto's series for the drag of a simple cubic lattice of volume fraction c: 1 - 1.7601 c^(1/3) + c.
    #[test]
    fn the_correction_is_the_series_in_the_volume_fraction() {
        let body = sphere(24.0);
        let c = body.shape.volume() / 24f64.powi(3);
        let ratio = body.mobility().along * 6.0 * PI * 4.25 * 3.0;
        assert!((ratio - (1.0 - 1.7601 * c.cbrt() + c)).abs() < 1e-4, "{ratio}");
    }

    /// A long body averages modes along itself away, which move it across: it lacks less across than along.
    #[test]
    fn a_long_body_remembers_more_along_itself() {
        let long = PeriodicBody { shape: Spheroid { along: 6.0, across: 3.0 }, ..sphere(32.0) };
        let (along, across) = long.missing_translation((30.0, 60.0));
        assert!(across < 0.97 * along && across > 0.85 * along, "{along} {across}");
        let (m, f) = (long.mobility(), Friction::of(long.shape));
        let (along, across) = (m.along - 1.0 / (4.25 * f.along), m.across - 1.0 / (4.25 * f.across));
        // (2/45)(2 54 - 36) and (2/45)(2 54 - 9) over eta V.
        let apart = (across - along) * 4.25 * 32f64.powi(3);
        assert!((apart - 2.0 / 45.0 * 27.0).abs() < 1e-9, "{apart}");
    }

    /// Before its flow has met that of its images, a body moves as in an unbounded fluid, where D lacks 4 t/(3 rho (4 pi nu t)^(3/2))
    /// and D_R lacks (2/3) t pi/(rho (4 pi nu t)^(5/2)), up to orders R^2/(nu t). So the sum lacks Hasimoto's correction, and all
    /// momentum moves with it, since the box as a whole stands still.
    #[test]
    fn tails_of_an_unbounded_fluid() {
        let body = PeriodicBody { shape: Spheroid { along: 0.5, across: 0.5 }, ..sphere(60.0) };
        let t = 100.0;
        let spread = 4.0 * PI * 0.425 * t;
        let unbounded = 4.0 / 3.0 * t / (10.0 * spread.powf(1.5));
        let expected = unbounded - HASIMOTO / (6.0 * PI * 4.25 * 60.0) + 2.0 / 3.0 * t / (10.0 * 60f64.powi(3));
        let (along, across) = body.missing_translation((t, t + 1e-3));
        assert!((along / expected - 1.0).abs() < 0.01, "{along} {expected}");
        assert!((across / expected - 1.0).abs() < 0.01, "{across} {expected}");
        let rotation = body.missing_rotation((t, t + 1e-3)) + 1.0 / (6.0 * 4.25 * 60f64.powi(3));
        let expected = 2.0 / 3.0 * t * PI / (10.0 * spread.powf(2.5));
        assert!((rotation / expected - 1.0).abs() < 0.02, "{rotation} {expected}");
    }
}
