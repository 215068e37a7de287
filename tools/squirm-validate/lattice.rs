//! Flows of the periodic images of a singularity in a cube (Hasimoto, J. Fluid Mech. 5, 317, 1959).
//!
//! The periodic flow without mean is a sum over waves; what they are with the factor (1 + k^2/4x^2) exp(-k^2/4x^2), x = 8/L, differs from
//! the true one only near the singularities. Taking the free flow with the same factor off leaves the images alone, as smooth as
//! they are. The distance to the images must be above L/2.

use glam::DVec3;
use std::f64::consts::PI;

/// A cubic lattice.
pub struct Lattice {
    edge: f64,
    /// Half of all wave vectors, since k and -k give the same.
    waves: Vec<DVec3>,
}

impl Lattice {
    /// Of this edge.
    pub fn new(edge: f64) -> Self {
        // exp(-k^2/4x^2) at n = 11 is 1e-8.
        const MOST: i32 = 11;
        let mut waves = Vec::new();
        for x in 0..=MOST {
            for y in -MOST..=MOST {
                for z in -MOST..=MOST {
                    let ahead = x > 0 || y > 0 || (y == 0 && z > 0);
                    if ahead && x * x + y * y + z * z <= MOST * MOST {
                        waves.push(2.0 * PI / edge * DVec3::new(x.into(), y.into(), z.into()));
                    }
                }
            }
        }
        Self { edge, waves }
    }

    fn sharpness(&self) -> f64 {
        8.0 / self.edge
    }

    /// Sum over all waves of `amplitude`, which is even under k -> -k, over the volume.
    fn sum(&self, amplitude: impl Fn(DVec3, f64) -> DVec3) -> DVec3 {
        let x = 4.0 * self.sharpness().powi(2);
        let sum: DVec3 = self.waves.iter().map(|k| amplitude(*k, k.length_squared() / x)).sum();
        2.0 / self.edge.powi(3) * sum
    }

    /// Flow of the images of a stresslet of axis `e` whose own flow is (3 cos^2 - 1) r/r^3, at `r` from it.
    pub fn stresslet(&self, e: DVec3, r: DVec3) -> DVec3 {
        let waves = self.sum(|k, s| {
            let transverse = e - k * (k.dot(e) / k.length_squared());
            8.0 * PI / k.length_squared() * (1.0 + s) * (-s).exp() * k.dot(e) * k.dot(r).sin() * transverse
        });
        // -(e.grad) of the smoothed point force (laplacian - grad grad) B, B' = erf(x r), by central differences.
        let x = self.sharpness();
        let force = |r: DVec3| {
            let distance = r.length();
            let (whole, density) = (erf(x * distance) / distance, gauss(x, distance));
            (density + whole) * e + (whole - density) / (distance * distance) * r.dot(e) * r
        };
        let step = 1e-4 * self.edge;
        let own = (force(r - step * e) - force(r + step * e)) / (2.0 * step);
        waves - own
    }

    /// Flow of the images of a source dipole along `e` whose own flow is (3 cos r/r - e)/r^3, at `r` from it, with the uniform backflow that
    /// leaves no momentum to the fluid and the force-free swimmer of which this is the far field.
    pub fn dipole(&self, e: DVec3, r: DVec3) -> DVec3 {
        let waves = self.sum(|k, s| -4.0 * PI / k.length_squared() * (-s).exp() * k.dot(e) * k.dot(r).cos() * k);
        let (x, distance) = (self.sharpness(), r.length());
        let (whole, density) = (erf(x * distance) / distance, gauss(x, distance));
        // Of phi = erf(x r)/r.
        let slope = (density - whole) / distance;
        let curvature = -2.0 * x * x * density - 2.0 * slope / distance;
        let own = slope / distance * e + (curvature - slope / distance) / (distance * distance) * r.dot(e) * r;
        waves - own - 4.0 * PI / self.edge.powi(3) * e
    }
}

/// Derivative of erf(x r) by r.
fn gauss(x: f64, r: f64) -> f64 {
    2.0 * x / PI.sqrt() * (-(x * r).powi(2)).exp()
}

/// Error function: the series of positive terms exp(-x^2) sum 2^n x^(2n+1)/(2n+1)!!.
fn erf(x: f64) -> f64 {
    if x.abs() > 6.0 {
        return x.signum();
    }
    let (mut term, mut sum) = (x, x);
    for n in 1..200 {
        term *= 2.0 * x * x / f64::from(2 * n + 1);
        sum += term;
    }
    2.0 / PI.sqrt() * (-x * x).exp() * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    const EDGE: f64 = 10.0;

    fn stresslet(e: DVec3, r: DVec3) -> DVec3 {
        let c = r.normalize().dot(e);
        (3.0 * c * c - 1.0) * r / r.length().powi(3)
    }

    fn dipole(e: DVec3, r: DVec3) -> DVec3 {
        (3.0 * r.dot(e) / r.length_squared() * r - e) / r.length().powi(3)
    }

    #[test]
    fn error_function() {
        for (x, value) in
            [(0.0, 0.0), (0.5, 0.520_499_877_8), (1.0, 0.842_700_792_9), (2.0, 0.995_322_265_0), (4.0, 1.0)]
        {
            assert!((erf(x) - value).abs() < 2e-8, "{x}: {}", erf(x));
        }
    }

    /// The flow and its images together are the same on opposite faces of the box.
    #[test]
    fn the_whole_flow_is_periodic() {
        let lattice = Lattice::new(EDGE);
        let e = DVec3::new(0.3, 0.5, 0.8).normalize();
        for place in [DVec3::new(5.0, 1.3, -2.2), DVec3::new(5.0, -4.0, 3.0), DVec3::new(5.0, 0.0, 0.4)] {
            let other = place - EDGE * DVec3::X;
            let whole = |r| stresslet(e, r) + lattice.stresslet(e, r);
            assert!((whole(place) - whole(other)).length() < 1e-4 * stresslet(e, place).length(), "{place}");
            let whole = |r| dipole(e, r) + lattice.dipole(e, r);
            assert!((whole(place) - whole(other)).length() < 1e-4 * dipole(e, place).length(), "{place}");
        }
    }

    /// A free swimmer of dipole strength B1 R^3/3 loses (2/3) B1 V/L^3.
    #[test]
    fn the_backflow_at_the_swimmer_is_known() {
        let found = Lattice::new(EDGE).dipole(DVec3::Z, DVec3::new(0.05, 0.0, 0.0));
        let wanted = -8.0 * PI / 3.0 / EDGE.powi(3);
        assert!((found - wanted * DVec3::Z).length() < 1e-3 * wanted.abs(), "{found} {wanted}");
    }

    #[test]
    fn images_do_not_shift_but_strain() {
        let lattice = Lattice::new(EDGE);
        let near = DVec3::new(0.4, 0.3, 0.2);
        let (ahead, behind) = (lattice.stresslet(DVec3::Z, near), lattice.stresslet(DVec3::Z, -near));
        assert!((ahead + behind).length() < 1e-9 && ahead.length() > 1e-4);
    }
}
