//! Stokes flow around a free spheroidal squirmer, in closed form.

use super::spheroid::Spheroid;
use glam::DVec3;

/// The flow of a force-free squirmer in an unbounded fluid at rest (Keller and Wu, J. Fluid Mech. 80, 259, 1977; stream function
/// in spheroidal coordinates as in Theers et al., Soft Matter 12, 7372, 2016), of its modes B1 and B2.
///
/// With s = tau (prolate) or lambda (oblate) and sign = +1 or -1, z = c s zeta, rho^2 = c^2 (s^2 - sign)(1 - zeta^2):
/// psi = C1 H2(s)(1 - zeta^2) + C3 [H3(s) - H3(s0)] zeta (1 - zeta^2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SquirmerFlow {
    shape: Spheroid,
    b1: f64,
    b2: f64,
}

/// H2, H2', H3 and H3' at s: (1 - zeta^2) H2 and zeta (1 - zeta^2) H3 are the decaying solutions.
#[derive(Debug, Clone, Copy)]
struct Decaying {
    h2: f64,
    d2: f64,
    h3: f64,
    d3: f64,
}

impl Decaying {
    fn at(s: f64, sign: f64) -> Self {
        let x = sign / (s * s);
        if x.abs() < 0.25 {
            // H2 = sum a_k x^k / s and H3 = sum_(k>=1) a_k x^k with a_k = 2/((2k+1)(2k+3)); the closed forms cancel here.
            let mut sums = [0.0; 3];
            for k in (0..30).rev() {
                let a = 2.0 / f64::from((2 * k + 1) * (2 * k + 3));
                let k = f64::from(k);
                sums = [sums[0] * x + a, sums[1] * x + (2.0 * k + 1.0) * a, sums[2] * x + k * a];
            }
            let h2 = sums[0] / s;
            // H3 without the term k = 0, which would cancel in s H2 - 2/3.
            let h3 = (1..30).rev().fold(0.0, |sum, k| (sum + 2.0 / f64::from((2 * k + 1) * (2 * k + 3))) * x);
            Self { h2, d2: -sums[1] / (s * s), h3, d3: -2.0 * sums[2] / s }
        } else {
            // sign * acoth(s) or acot(s), so that both shapes share one formula.
            let inverse = if sign > 0.0 { -s.recip().atanh() } else { s.recip().atan() };
            let p = s * s - sign;
            let h2 = p * inverse + sign * s;
            Self {
                h2,
                d2: 2.0 * (s * inverse + sign),
                h3: s * h2 - 2.0 / 3.0,
                d3: (3.0 * s * s - sign) * inverse + 3.0 * sign * s,
            }
        }
    }
}

impl SquirmerFlow {
    /// The flow of this body with these slip modes (B2 = beta B1).
    #[must_use]
    pub fn new(shape: Spheroid, b1: f64, b2: f64) -> Self {
        Self { shape, b1, b2 }
    }

    /// Strength of the far field: u_r -> C4 (3 cos^2 theta - 1)/r^2; positive for pushers. The stresslet is p = 8 pi eta C4.
    #[must_use]
    pub fn far_field(&self) -> f64 {
        match self.focal() {
            None => -0.5 * self.b2 * self.shape.along.powi(2),
            Some((c, sign)) => {
                let s0 = self.shape.along / c;
                let f = Decaying::at(s0, sign);
                self.b2 * s0 * c * c * f.h3 / f.d3
            }
        }
    }

    /// Velocity of the fluid at `r` from the centre of the squirmer with axis `e`, in the lab; `r` must not lie inside.
    #[must_use]
    pub fn velocity(&self, r: DVec3, e: DVec3) -> DVec3 {
        let z = r.dot(e);
        let radial = r - z * e;
        let rho = radial.length();
        let (u_rho, u_z) = match self.focal() {
            None => self.around_sphere(rho, z),
            Some((c, sign)) => self.around_spheroid(rho, z, c, sign),
        };
        u_z * e + if rho > 0.0 { radial * (u_rho / rho) } else { DVec3::ZERO }
    }

    /// Focal distance c, and +1 for a prolate or -1 for an oblate body; none if the two semi-axes agree to 1e-8.
    fn focal(&self) -> Option<(f64, f64)> {
        let squared = self.shape.along.powi(2) - self.shape.across.powi(2);
        (squared.abs() > 1e-8 * self.shape.along.powi(2)).then(|| (squared.abs().sqrt(), squared.signum()))
    }

    /// Blake, J. Fluid Mech. 46, 199 (1971), in the lab frame; x = R/r.
    fn around_sphere(&self, rho: f64, z: f64) -> (f64, f64) {
        let r = rho.hypot(z);
        let (sin, cos, x) = (rho / r, z / r, self.shape.along / r);
        let u_r =
            2.0 / 3.0 * self.b1 * x.powi(3) * cos + 0.5 * self.b2 * (x.powi(4) - x.powi(2)) * (3.0 * cos * cos - 1.0);
        let u_theta = self.b1 / 3.0 * x.powi(3) * sin + self.b2 * x.powi(4) * sin * cos;
        (u_r * sin + u_theta * cos, u_r * cos - u_theta * sin)
    }

    fn around_spheroid(&self, rho: f64, z: f64, c: f64, sign: f64) -> (f64, f64) {
        let (c2, s0) = (c * c, self.shape.along / c);
        let sum = rho * rho + z * z + sign * c2;
        let s = ((sum + (sum * sum - 4.0 * sign * c2 * z * z).max(0.0).sqrt()) / (2.0 * c2)).sqrt();
        let zeta = (z / (c * s)).clamp(-1.0, 1.0);
        let (p, q, g) = ((s * s - sign).sqrt(), (1.0 - zeta * zeta).sqrt(), (s * s - sign * zeta * zeta).sqrt());
        let (f, f0) = (Decaying::at(s, sign), Decaying::at(s0, sign));
        // On the surface psi = U0 rho^2/2 (the normal velocity), and the tangential velocity of the second mode is the slip.
        let c1 = self.shape.swim_speed(self.b1) * c2 * (s0 * s0 - sign) / (2.0 * f0.h2);
        let c3 = -self.b2 * s0 * c2 / f0.d3;
        let (a, da, b, db) = (c1 * f.h2, c1 * f.d2, c3 * (f.h3 - f0.h3), c3 * f.d3);
        let u_zeta = (da + db * zeta) * q / (c2 * g);
        let u_s = (2.0 * zeta * a - b * (1.0 - 3.0 * zeta * zeta)) / (c2 * g * p);
        ((u_s * s * q - u_zeta * zeta * p) / g, (u_s * zeta * p + u_zeta * s * q) / g)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXIS: DVec3 = DVec3::new(0.48, -0.64, 0.6);
    const SHAPES: [(f64, f64); 6] = [(3.0, 3.0), (3.0, 6.0), (6.0, 3.0), (2.0, 2.05), (2.0, 1.95), (1.0, 5.0)];

    fn flow(across: f64, along: f64) -> SquirmerFlow {
        SquirmerFlow::new(Spheroid { along, across }, 0.3, -0.5)
    }

    /// The point in the direction of `p` (a unit vector before the body is stretched), scaled out by `factor`.
    fn point(shape: Spheroid, p: DVec3, factor: f64) -> DVec3 {
        let axial = p.dot(AXIS) * AXIS;
        factor * (shape.across * (p - axial) + shape.along * axial)
    }

    fn directions() -> impl Iterator<Item = DVec3> {
        let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
        let sphere = (0..40).map(move |i| {
            let (z, angle) = (1.0 - (f64::from(i) + 0.5) / 20.0, golden * f64::from(i));
            let q = (1.0 - z * z).sqrt();
            DVec3::new(q * angle.cos(), q * angle.sin(), z)
        });
        sphere.chain([AXIS, -AXIS])
    }

    #[test]
    fn the_fluid_moves_with_the_surface() {
        for (across, along) in SHAPES {
            let f = flow(across, along);
            for p in directions() {
                let s = point(f.shape, p, 1.0);
                let wanted = f.shape.swim_speed(f.b1) * AXIS + f.shape.slip(f.b1, f.b2, 0.0, s, AXIS);
                let found = f.velocity(s, AXIS);
                assert!((found - wanted).length() < 1e-7, "{across} {along} {p}: {found} {wanted}");
            }
        }
    }

    #[test]
    fn the_fluid_is_incompressible() {
        for (across, along) in SHAPES {
            let f = flow(across, along);
            for p in directions() {
                for factor in [1.2, 2.0, 5.0] {
                    let r = point(f.shape, p, factor);
                    let h = 1e-4 * r.length();
                    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
                    let slope =
                        |a: usize| (f.velocity(r + h * axes[a], AXIS) - f.velocity(r - h * axes[a], AXIS)) / (2.0 * h);
                    let gradients = [0, 1, 2].map(slope);
                    let divergence = gradients[0].x + gradients[1].y + gradients[2].z;
                    let scale: f64 = gradients.iter().map(|g| g.length()).sum();
                    assert!(divergence.abs() < 1e-6 * scale + 1e-10, "{across} {along} {p}: {divergence} of {scale}");
                }
            }
        }
    }

    #[test]
    fn far_field_is_the_stresslet() {
        for (across, along) in SHAPES {
            let f = flow(across, along);
            for cos in [-1.0f64, -0.3, 0.0, 0.8] {
                let side = AXIS.any_orthonormal_vector();
                let n = cos * AXIS + (1.0 - cos * cos).sqrt() * side;
                let r = 1e5;
                let u_r = f.velocity(r * n, AXIS).dot(n) * r * r;
                let wanted = f.far_field() * (3.0 * cos * cos - 1.0);
                // The next term, the source dipole, is smaller by size/r.
                assert!((u_r - wanted).abs() < 1e-3 * f.far_field().abs(), "{across} {along} {cos}: {u_r} {wanted}");
            }
        }
        // B2 < 0 with B1 > 0 is a pusher.
        assert!(flow(3.0, 6.0).far_field() > 0.0);
    }

    #[test]
    fn far_field_of_known_aspects() {
        for (aspect, k) in [(1.0, 1.0), (1.5, 0.7132), (2.0, 0.5685), (3.0, 0.4216), (4.0, 0.3466)] {
            let f = SquirmerFlow::new(Spheroid { along: aspect, across: 1.0 }, 1.0, 2.0);
            assert!(
                (f.far_field() + aspect * aspect * k).abs() < 1e-4 * aspect * aspect,
                "{aspect}: {}",
                f.far_field()
            );
        }
    }

    #[test]
    fn nearly_spherical_bodies_flow_like_spheres() {
        let (sphere, near) = (flow(2.0, 2.0), flow(2.0, 2.0 + 1e-5));
        for p in directions() {
            let r = point(near.shape, p, 1.5);
            assert!((sphere.velocity(r, AXIS) - near.velocity(r, AXIS)).length() < 1e-5);
        }
    }
}
