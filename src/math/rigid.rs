//! Free rotation of a symmetric top, exact for any time step.

use glam::{DQuat, DVec3};

/// Moments of inertia of a rigid body with a symmetry axis e (z of its body frame).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Top {
    /// About e.
    pub along: f64,
    /// About any axis through the centre of mass across e.
    pub across: f64,
}

impl Top {
    /// Angular velocity in the lab of a body with this orientation and angular momentum:
    /// Omega = L/I_across + (1/I_along - 1/I_across)(L.e) e.
    #[must_use]
    pub fn angular_velocity(&self, orientation: DQuat, angular_momentum: DVec3) -> DVec3 {
        let e = orientation * DVec3::Z;
        angular_momentum / self.across + self.excess_spin(angular_momentum.dot(e)) * e
    }

    /// Kinetic energy of the rotation.
    #[must_use]
    pub fn energy(&self, orientation: DQuat, angular_momentum: DVec3) -> f64 {
        0.5 * angular_momentum.dot(self.angular_velocity(orientation, angular_momentum))
    }

    /// Orientation after the time `t` without torque: the axis precesses about the fixed L at the rate |L|/I_across while the body
    /// turns about e by what is left (Landau and Lifshitz, Mechanics, section 33). No step size enters.
    #[must_use]
    pub fn turn(&self, orientation: DQuat, angular_momentum: DVec3, t: f64) -> DQuat {
        let e = orientation * DVec3::Z;
        let precession = DQuat::from_scaled_axis(angular_momentum * (t / self.across));
        let spin = DQuat::from_rotation_z(self.excess_spin(angular_momentum.dot(e)) * t);
        (precession * orientation * spin).normalize()
    }

    /// Rate of turning about e on top of L/I_across.
    fn excess_spin(&self, l_along: f64) -> f64 {
        l_along * (1.0 / self.along - 1.0 / self.across)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TOP: Top = Top { along: 2.0, across: 5.0 };

    fn pose() -> (DQuat, DVec3) {
        (DQuat::from_scaled_axis(DVec3::new(0.3, -1.1, 0.4)), DVec3::new(1.0, 0.5, -2.0))
    }

    #[test]
    fn rotation_about_the_symmetry_axis_has_the_rate_of_its_own_inertia() {
        let q = TOP.turn(DQuat::IDENTITY, DVec3::new(0.0, 0.0, 3.0), 0.4);
        assert!(q.abs_diff_eq(DQuat::from_rotation_z(3.0 / 2.0 * 0.4), 1e-14), "{q}");
    }

    #[test]
    fn rotation_across_the_axis_tumbles() {
        let q = TOP.turn(DQuat::IDENTITY, DVec3::new(3.0, 0.0, 0.0), 0.4);
        assert!(q.abs_diff_eq(DQuat::from_rotation_x(3.0 / 5.0 * 0.4), 1e-14), "{q}");
    }

    #[test]
    fn the_axis_precesses_about_l_with_l_over_inertia_across() {
        let (q, l) = pose();
        let period = std::f64::consts::TAU * TOP.across / l.length();
        let e = q * DVec3::Z;
        assert!((TOP.turn(q, l, period) * DVec3::Z - e).length() < 1e-13);
        let half = TOP.turn(q, l, period / 2.0) * DVec3::Z;
        let n = l.normalize();
        assert!((half - (2.0 * n.dot(e) * n - e)).length() < 1e-13);
    }

    #[test]
    fn the_turn_starts_with_the_angular_velocity() {
        let (q, l) = pose();
        let dt = 1e-5;
        let turned = TOP.turn(q, l, dt) * TOP.turn(q, l, -dt).inverse();
        assert!((turned.to_scaled_axis() / (2.0 * dt) - TOP.angular_velocity(q, l)).length() < 1e-8);
    }

    proptest! {
        #[test]
        fn energy_norm_and_composition(t in 0.0..50.0f64, l in prop::array::uniform3(-3.0..3.0f64), q in prop::array::uniform3(-2.0..2.0f64), along in 0.5..9.0) {
            let top = Top { along, across: 3.0 };
            let (l, q) = (DVec3::from_array(l), DQuat::from_scaled_axis(DVec3::from_array(q)));
            let end = top.turn(q, l, t);
            prop_assert!((end.length() - 1.0).abs() < 1e-14);
            prop_assert!((top.energy(end, l) - top.energy(q, l)).abs() < 1e-11);
            // L in the lab is constant, so the body's own equation of motion holds if two part turns make the whole.
            let parts = top.turn(top.turn(q, l, 0.3 * t), l, 0.7 * t);
            prop_assert!((parts.dot(end).abs() - 1.0).abs() < 1e-11);
        }
    }
}
