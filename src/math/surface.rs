//! The slip velocity on a spheroidal squirmer, in spheroidal coordinates.

use super::spheroid::Spheroid;
use glam::DVec3;

/// Strengths of a squirmer's slip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slip {
    /// Swimming mode.
    pub b1: f64,
    /// B2 / B1.
    pub beta: f64,
    /// Rotlet dipole.
    pub rotlet: f64,
}

impl Slip {
    /// Slip velocity at the surface point `s`, both in body axes (z along e): u = -B1 (1 + beta zeta)(e_zeta . e) e_zeta
    /// (Theers, Westphal, Gompper, Winkler, Soft Matter 12, 7372, 2016) and the rotlet dipole C2 zeta (rho/across) e_phi.
    /// The meridian is (rho, z) = (across sqrt(1-zeta^2), along zeta); e_zeta is its tangent.
    #[must_use]
    pub fn at(&self, shape: Spheroid, s: DVec3) -> DVec3 {
        let zeta = s.z / shape.along;
        let rho = s.x.hypot(s.y);
        let (e_rho, e_phi) = if rho > 0.0 {
            (DVec3::new(s.x, s.y, 0.0) / rho, DVec3::new(-s.y, s.x, 0.0) / rho)
        } else {
            (DVec3::X, DVec3::Y)
        };
        let sine = (1.0 - zeta * zeta).max(0.0).sqrt();
        let e_zeta = (-shape.across * zeta * e_rho + shape.along * sine * DVec3::Z).normalize();
        -self.b1 * (1.0 + self.beta * zeta) * e_zeta.z * e_zeta + self.rotlet * zeta * rho / shape.across * e_phi
    }
}
