//! Spheroids: volume, surface, inertia, slip velocity and swim speed.

use glam::DVec3;
use std::f64::consts::PI;

/// Semi-axes of a spheroid with the symmetry axis e; its body frame has e along z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spheroid {
    /// Semi-axis along the axis e, in a.
    pub along: f64,
    /// Semi-axes perpendicular to e, in a.
    pub across: f64,
}

impl Spheroid {
    /// Volume in a^3.
    #[must_use]
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.along * self.across * self.across
    }

    /// Surface area in a^2.
    #[must_use]
    pub fn surface_area(&self) -> f64 {
        let (z, x) = (self.along, self.across);
        let stretch = if z > x {
            let eccentricity = (1.0 - (x / z).powi(2)).sqrt();
            z / x * eccentricity.asin() / eccentricity
        } else if z < x {
            let eccentricity = (1.0 - (z / x).powi(2)).sqrt();
            (z / x).powi(2) * eccentricity.atanh() / eccentricity
        } else {
            1.0
        };
        2.0 * PI * x * x * (1.0 + stretch)
    }

    /// Moments of inertia of a homogeneous body of this mass: about e, and about any axis through the centre across e.
    #[must_use]
    pub fn inertia(&self, mass: f64) -> (f64, f64) {
        let (z2, x2) = (self.along.powi(2), self.across.powi(2));
        (0.4 * mass * x2, 0.2 * mass * (x2 + z2))
    }

    /// The spheroid with both semi-axes longer by `margin` (not the parallel surface at that distance, which is a little larger).
    #[must_use]
    pub fn grown(&self, margin: f64) -> Self {
        Self { along: self.along + margin, across: self.across + margin }
    }

    /// The longer semi-axis: radius of the sphere around the body.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.along.max(self.across)
    }

    /// Whether a point of the body frame lies inside.
    #[must_use]
    pub fn inside(&self, s: DVec3) -> bool {
        let scaled = s / DVec3::new(self.across, self.across, self.along);
        scaled.length_squared() < 1.0
    }

    /// Outward unit normal at the surface point `s` (from the centre) of the body with axis `e`.
    #[must_use]
    pub fn normal(&self, s: DVec3, e: DVec3) -> DVec3 {
        let axial = s.dot(e) * e;
        ((s - axial) / self.across.powi(2) + axial / self.along.powi(2)).normalize()
    }

    /// Slip velocity at the surface point `s` (from the centre) of the body with axis `e`, without trigonometric functions:
    /// -(B1 + B2 zeta) [e - (n.e) n] + C2 zeta (e x s)/across, zeta = (s.e)/along.
    ///
    /// The tangential part is the surface velocity of Theers, Westphal, Gompper and Winkler, Soft Matter 12, 7372 (2016),
    /// -(B1 + B2 zeta)(e_zeta.e) e_zeta, which on a sphere is that of Lighthill and Blake; the azimuthal part is a rotlet
    /// dipole, odd along the axis, so that it exerts no net torque.
    #[must_use]
    pub fn slip(&self, b1: f64, b2: f64, rotlet: f64, s: DVec3, e: DVec3) -> DVec3 {
        let n = self.normal(s, e);
        let zeta = s.dot(e) / self.along;
        -(b1 + b2 * zeta) * (e - n.dot(e) * n) + rotlet * zeta / self.across * e.cross(s)
    }

    /// Speed of a force-free squirmer in unbounded Stokes flow (Keller and Wu, J. Fluid Mech. 80, 259, 1977): with
    /// tau = along/c and c^2 = along^2 - across^2, U0 = B1 tau [tau - (tau^2 - 1) acoth tau]; for an oblate body tau is imaginary.
    #[must_use]
    pub fn swim_speed(&self, b1: f64) -> f64 {
        // x = 1/tau^2. The closed forms lose digits like epsilon/x; the power series does not.
        let x = 1.0 - (self.across / self.along).powi(2);
        b1 * if x.abs() < 0.1 {
            (0..20).rev().fold(0.0, |sum, k| sum * x + 2.0 / f64::from((2 * k + 1) * (2 * k + 3)))
        } else if x > 0.0 {
            let tau = x.sqrt().recip();
            tau * (tau - (tau * tau - 1.0) * tau.recip().atanh())
        } else {
            let lambda = (-x).sqrt().recip();
            lambda * ((lambda * lambda + 1.0) * lambda.recip().atan() - lambda)
        }
    }

    /// Swim speed in a periodic cube of this volume whose total momentum is zero. A free squirmer is a source dipole of strength
    /// (2/3) B1 across^2 along, whose backflow takes (2/3) B1 V/L^3 off the speed.
    #[must_use]
    pub fn swim_speed_periodic(&self, b1: f64, volume_of_box: f64) -> f64 {
        self.swim_speed(b1) - 2.0 / 3.0 * b1 * self.volume() / volume_of_box
    }

    /// Vorticity at the surface of the flow that the second squirming mode makes, as a constant A:
    /// omega = A u/sqrt(across^2 zeta^2 + along^2 (1 - zeta^2)) with the slip u at zeta; A = -3 for a sphere.
    ///
    /// From the stream function F3(tau) zeta (1 - zeta^2) of Keller and Wu 1977: A = sqrt(tau^2 - 1) F3''/F3' at the surface,
    /// F3' = (3 tau^2 - 1) acoth tau - 3 tau; for an oblate body tau is imaginary.
    #[must_use]
    pub fn second_mode_vorticity(&self) -> f64 {
        // x = 1/tau^2; near the sphere by F3' = sum 4 (k - 1)/((2k + 1)(2k - 1)) tau^(1 - 2k) from k = 2 on.
        let x = 1.0 - (self.across / self.along).powi(2);
        let ratio = if x.abs() < 0.1 {
            let series = |factor: fn(f64) -> f64| {
                (2..22).rev().fold(0.0, |sum, k| {
                    let k = f64::from(k);
                    sum * x + factor(k) * 4.0 * (k - 1.0) / ((2.0 * k + 1.0) * (2.0 * k - 1.0))
                })
            };
            series(|k| 1.0 - 2.0 * k) / series(|_| 1.0)
        } else if x > 0.0 {
            let tau = x.sqrt().recip();
            let acoth = tau.recip().atanh();
            let slope = (3.0 * tau * tau - 1.0) * acoth - 3.0 * tau;
            tau * (6.0 * tau * acoth - (3.0 * tau * tau - 1.0) / (tau * tau - 1.0) - 3.0) / slope
        } else {
            let lambda = (-x).sqrt().recip();
            let acot = lambda.recip().atan();
            let slope = 3.0 * lambda - (3.0 * lambda * lambda + 1.0) * acot;
            lambda * (3.0 + (3.0 * lambda * lambda + 1.0) / (1.0 + lambda * lambda) - 6.0 * lambda * acot) / slope
        };
        ratio * (1.0 - x).sqrt()
    }

    /// Half the body's extent along a lab direction with which e has the cosine `e_y`.
    #[must_use]
    pub fn half_height(&self, e_y: f64) -> f64 {
        (self.across.powi(2) * (1.0 - e_y * e_y) + self.along.powi(2) * e_y * e_y).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const fn shape(across: f64, along: f64) -> Spheroid {
        Spheroid { along, across }
    }

    /// Integral of f over polar angles by Gauss-like midpoints in zeta = cos(theta).
    fn mean_over_zeta(f: impl Fn(f64) -> f64) -> f64 {
        let n = 20_000;
        (0..n).map(|i| f(-1.0 + (f64::from(i) + 0.5) * 2.0 / f64::from(n))).sum::<f64>() / f64::from(n)
    }

    #[test]
    fn sphere_and_spheroid_measures() {
        let sphere = shape(2.0, 2.0);
        assert!((sphere.volume() - 32.0 / 3.0 * PI).abs() < 1e-12);
        assert!((sphere.surface_area() - 16.0 * PI).abs() < 1e-12);
        assert_eq!(sphere.inertia(5.0), (8.0, 8.0));
        assert!((shape(3.0, 6.0).volume() - 226.194_671).abs() < 1e-5);
        assert_eq!(shape(3.0, 6.0).half_height(0.0), 3.0);
        assert_eq!(shape(3.0, 6.0).half_height(1.0), 6.0);
    }

    /// dS = 2 pi across sqrt(across^2 zeta^2 + along^2 (1 - zeta^2)) dzeta for s = (across sin, along cos), zeta = cos.
    #[test]
    fn surface_area_is_the_integral() {
        for s in [shape(3.0, 6.0), shape(6.0, 3.0), shape(2.0, 2.001), shape(2.0, 1.999)] {
            let integral = 4.0
                * PI
                * s.across
                * mean_over_zeta(|z| (s.across.powi(2) * z * z + s.along.powi(2) * (1.0 - z * z)).sqrt());
            assert!((s.surface_area() / integral - 1.0).abs() < 1e-8, "{s:?}");
        }
    }

    #[test]
    fn swim_speeds_of_known_aspects() {
        let known = [(1.0, 0.6667), (1.5, 0.7670), (2.0, 0.8264), (3.0, 0.8913), (4.0, 0.9246)];
        for (aspect, speed) in known.into_iter().chain([(0.5, 0.4728), (1.0 / 3.0, 0.3646)]) {
            assert!((shape(2.0, 2.0 * aspect).swim_speed(1.0) - speed).abs() < 5e-5, "{aspect}");
        }
    }

    #[test]
    fn swim_speed_is_continuous_at_the_edges_of_the_series() {
        for x in [0.1f64, -0.1] {
            let speed = |x: f64| shape((1.0 - x).sqrt(), 1.0).swim_speed(1.0);
            let (inner, outer) = (speed(x * (1.0 - 1e-12)), speed(x * (1.0 + 1e-12)));
            assert!((inner - outer).abs() < 1e-11, "{inner} {outer}");
        }
    }

    /// The traction on a translating ellipsoid is F (n.s)/(3V), so the reciprocal theorem gives U = - the mean of the slip over
    /// the unit sphere that parametrises the surface (Stone and Samuel, Phys. Rev. Lett. 77, 4102, 1996, for spheres).
    #[test]
    fn swim_speed_follows_from_the_reciprocal_theorem() {
        for s in [shape(3.0, 3.0), shape(3.0, 6.0), shape(6.0, 3.0), shape(2.0, 2.01), shape(1.0, 8.0)] {
            let mean = mean_over_zeta(|z| {
                let point = DVec3::new(s.across * (1.0 - z * z).sqrt(), 0.0, s.along * z);
                s.slip(0.3, -0.7, 0.2, point, DVec3::Z).z
            });
            assert!((s.swim_speed(0.3) + mean).abs() < 1e-5, "{s:?}: {} {mean}", s.swim_speed(0.3));
        }
    }

    #[test]
    fn slip_of_a_sphere_is_that_of_lighthill_and_blake() {
        let (theta, b1, b2, c2) = (0.7f64, 0.3, 0.2, 0.1);
        let s = 2.0 * DVec3::new(theta.sin(), 0.0, theta.cos());
        let e_theta = DVec3::new(theta.cos(), 0.0, -theta.sin());
        let slip = shape(2.0, 2.0).slip(b1, b2, c2, s, DVec3::Z);
        let polar = b1 * theta.sin() + b2 * theta.sin() * theta.cos();
        assert!((slip - polar * e_theta - c2 * theta.cos() * theta.sin() * DVec3::Y).length() < 1e-15);
    }

    #[test]
    fn periodic_images_slow_a_squirmer_down() {
        let s = shape(2.0, 4.0);
        let loss = s.swim_speed(0.3) - s.swim_speed_periodic(0.3, 1000.0);
        assert!((loss - 0.2 * s.volume() / 1000.0).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn slip_is_tangential(across in 0.5..9.0, along in 0.5..9.0, p in prop::array::uniform3(-1.0..1.0f64), e in prop::array::uniform3(-1.0..1.0f64)) {
            let (p, e) = (DVec3::from_array(p), DVec3::from_array(e));
            prop_assume!(p.length() > 0.1 && e.length() > 0.1);
            let (p, e, s) = (p.normalize(), e.normalize(), shape(across, along));
            // The unit vector p, stretched along and across e, is a point of the surface.
            let point = across * (p - p.dot(e) * e) + along * p.dot(e) * e;
            prop_assert!(s.slip(0.3, 0.2, 0.1, point, e).dot(s.normal(point, e)).abs() < 1e-12);
        }

        #[test]
        fn inside_agrees_with_the_stretched_sphere(across in 0.5..9.0, along in 0.5..9.0, p in prop::array::uniform3(-2.0..2.0f64)) {
            let p = DVec3::from_array(p);
            prop_assume!((p.length() - 1.0).abs() > 1e-9);
            prop_assert_eq!(shape(across, along).inside(p * DVec3::new(across, across, along)), p.length() < 1.0);
        }
    }
}
