//! Friction of spheroids in Stokes flow, prolate, oblate and everything between.

use super::spheroid::Spheroid;
use std::f64::consts::PI;

/// Friction coefficients divided by the dynamic viscosity eta: force = -zeta eta V, torque = -zeta eta Omega.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// Translation along the axis e, in a.
    pub along: f64,
    /// Translation across e, in a.
    pub across: f64,
    /// Rotation about e, in a^3.
    pub spin: f64,
    /// Rotation about an axis across e, in a^3.
    pub tumble: f64,
}

impl Friction {
    /// Friction of a spheroid with no-slip surface in an unbounded fluid.
    ///
    /// Perrin, J. Phys. Radium 5, 497 (1934), written with the ellipsoid integrals chi = int ds/D and alpha_i = int ds/((a_i^2 + s) D),
    /// D^2 = prod (a_i^2 + s), s from 0 to infinity:
    /// zeta_i = 16 pi/(chi + a_i^2 alpha_i), zeta_R,i = (16 pi/3)(a_j^2 + a_k^2)/(a_j^2 alpha_j + a_k^2 alpha_k), sum alpha_i = 2/D(0).
    #[must_use]
    pub fn of(shape: Spheroid) -> Self {
        let Spheroid { along: b, across: a } = shape;
        let (t, u) = shape_integrals(1.0 - (a / b).powi(2));
        let chi = 2.0 * t / b;
        let alpha_along = 2.0 * u / b.powi(3);
        let alpha_across = 1.0 / (a * a * b) - alpha_along / 2.0;
        let (along2, across2) = (b * b * alpha_along, a * a * alpha_across);
        Self {
            along: 16.0 * PI / (chi + along2),
            across: 16.0 * PI / (chi + across2),
            spin: 16.0 * PI / 3.0 * (2.0 * a * a) / (2.0 * across2),
            tumble: 16.0 * PI / 3.0 * (a * a + b * b) / (across2 + along2),
        }
    }
}

/// T(x) = atanh(sqrt x)/sqrt x and U(x) = (T - 1)/x for x = 1 - (across/along)^2: positive for prolate, negative for oblate
/// shapes (where atanh turns into atan). Both are the same analytic function through x = 0, the sphere: T = sum x^n/(2n+1).
#[must_use]
pub(crate) fn shape_integrals(x: f64) -> (f64, f64) {
    if x.abs() < 0.1 {
        // 0.1^20/41 is far below the rounding of the leading term.
        let u = (0..20).rev().fold(0.0, |sum, n| sum * x + 1.0 / f64::from(2 * n + 3));
        return (1.0 + x * u, u);
    }
    let root = x.abs().sqrt();
    let t = if x > 0.0 { root.atanh() } else { root.atan() } / root;
    (t, (t - 1.0) / x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() < relative, "{value} is not {expected}");
    }

    fn friction(across: f64, along: f64) -> Friction {
        Friction::of(Spheroid { along, across })
    }

    /// Perrin's closed form for prolate spheroids in the eccentricity, written independently of the code above.
    fn prolate(across: f64, along: f64) -> [f64; 4] {
        let e = (1.0 - (across / along).powi(2)).sqrt();
        let log = ((1.0 + e) / (1.0 - e)).ln();
        let (e2, e3) = (e * e, e.powi(3));
        [
            16.0 * PI * along * e3 / ((1.0 + e2) * log - 2.0 * e),
            32.0 * PI * along * e3 / (2.0 * e + (3.0 * e2 - 1.0) * log),
            32.0 / 3.0 * PI * along.powi(3) * e3 * (1.0 - e2) / (2.0 * e - (1.0 - e2) * log),
            32.0 / 3.0 * PI * along.powi(3) * e3 * (2.0 - e2) / ((1.0 + e2) * log - 2.0 * e),
        ]
    }

    #[test]
    fn prolate_shapes_follow_the_closed_form() {
        for (across, along) in [(3.0, 6.0), (2.0, 6.0), (1.0, 1.5), (2.0, 10.0)] {
            let f = friction(across, along);
            for (value, expected) in [f.along, f.across, f.spin, f.tumble].into_iter().zip(prolate(across, along)) {
                close(value, expected, 1e-12);
            }
        }
    }

    /// Values from numerical elliptic integrals, to the digits given there.
    #[test]
    fn known_numbers() {
        let f = friction(3.0, 6.0);
        close(f.along, 68.08, 1e-4);
        close(f.across, 77.97, 1e-4);
        close(f.tumble, 2042.4, 1e-4);
        close(f.spin, 1094.8, 1e-4);
        let thin = friction(2.0, 6.0);
        close(1.0 / thin.along, 0.01889, 4e-4);
        close(1.0 / thin.across, 0.01535, 4e-4);
        close(1.0 / thin.spin, 0.002216, 4e-4);
        close(1.0 / thin.tumble, 0.000708, 1e-3);
        let oblate = friction(6.0, 3.0);
        close(oblate.along, 102.4, 1e-3);
        close(oblate.across, 89.65, 1e-3);
        close(oblate.spin, 3827.0, 1e-3);
        close(oblate.tumble, 3072.0, 1e-3);
    }

    #[test]
    fn the_sphere_is_stokes_and_its_neighbourhood_is_smooth() {
        let f = friction(2.0, 2.0);
        for (value, expected) in
            [(f.along, 12.0 * PI), (f.across, 12.0 * PI), (f.spin, 64.0 * PI), (f.tumble, 64.0 * PI)]
        {
            close(value, expected, 1e-14);
        }
        // Either side of where the series hands over to the closed form, the slope is of order one.
        for edge in [0.1, -0.1_f64] {
            let across = |x: f64| (1.0 - x).sqrt();
            let (inside, outside) =
                (friction(across(edge * (1.0 - 1e-9)), 1.0), friction(across(edge * (1.0 + 1e-9)), 1.0));
            close(inside.along, outside.along, 1e-8);
            close(inside.tumble, outside.tumble, 1e-8);
        }
    }

    #[test]
    fn a_thin_disc_tends_to_its_known_limit() {
        // Edgewise 32/3 a, broadside 16 a, rotation 32/3 a^3 (Happel and Brenner, Low Reynolds Number Hydrodynamics).
        let f = friction(1.0, 1e-6);
        close(f.along, 16.0, 1e-5);
        close(f.across, 32.0 / 3.0, 1e-5);
        close(f.spin, 32.0 / 3.0, 1e-5);
        close(f.tumble, 32.0 / 3.0, 1e-5);
    }
}
