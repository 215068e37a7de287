//! Steric forces between spheroids and at walls: contact distance of Paramonov and Yaliraki, repulsion of Lennard-Jones type.

use super::spheroid::Spheroid;
use glam::{DMat3, DVec3};

/// Default of the margin added to both semi-axes for steric forces only, in a: fluid fits between touching bodies.
pub const SAFETY: f64 = 0.25;
/// Default of the repulsion's length, in a.
pub const SIGMA: f64 = 0.5;
/// Default of the repulsion's strength, in kT.
pub const EPSILON: f64 = 5.0;

/// A spheroid with a direction in the lab.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Semi-axes, margin included.
    pub shape: Spheroid,
    /// The unit vector e.
    pub axis: DVec3,
}

impl Body {
    /// across^2 1 + (along^2 - across^2) e e^T: the surface is s^T A^(-1) s = 1.
    fn matrix(&self) -> DMat3 {
        let (x2, z2) = (self.shape.across.powi(2), self.shape.along.powi(2));
        let e = self.axis;
        DMat3::from_diagonal(DVec3::splat(x2)) + DMat3::from_cols(e * e.x, e * e.y, e * e.z) * (z2 - x2)
    }
}

/// A distance and its derivatives with respect to motions of the two bodies. Turns are infinitesimal rotation vectors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Directional distance d: 0 at contact, negative in overlap; away from contact a little more than the true gap.
    pub gap: f64,
    /// Derivative with respect to the position of body B, or minus that of body A.
    pub by_shift: DVec3,
    /// Derivative with respect to a turn of A.
    pub by_turn_a: DVec3,
    /// Derivative with respect to a turn of B.
    pub by_turn_b: DVec3,
}

/// Distance of B from A, `r` pointing from the centre of A to that of B (Paramonov and Yaliraki, J. Chem. Phys. 123, 194111, 2005):
/// d = |R| (1 - F^(-1/2)) with the contact function of Perram and Wertheim, J. Comput. Phys. 58, 409 (1985),
/// F = max over lambda of lambda (1 - lambda) R^T [(1 - lambda) A + lambda B]^(-1) R. None if the centres coincide.
#[must_use]
pub fn contact(a: &Body, b: &Body, r: DVec3) -> Option<Contact> {
    let distance = r.length();
    if distance < 1e-9 * (a.shape.radius() + b.shape.radius()) {
        return None;
    }
    let (ma, mb) = (a.matrix(), b.matrix());
    let lambda = maximum(ma, mb, r);
    let x = lambda * (1.0 - lambda) * (((1.0 - lambda) * ma + lambda * mb).inverse() * r);
    let f = r.dot(x);
    let root = f.sqrt();
    let k = distance / (f * root);
    Some(Contact {
        gap: distance * (1.0 - 1.0 / root),
        by_shift: r / distance * (1.0 - 1.0 / root) + k * x,
        by_turn_a: -(k / lambda) * (ma * x).cross(x),
        by_turn_b: -(k / (1.0 - lambda)) * (mb * x).cross(x),
    })
}

/// The lambda of the contact function: zero of its derivative Y^T [(1 - lambda)^2 A - lambda^2 B] Y with
/// Y = [(1 - lambda) A + lambda B]^(-1) R, which falls monotonically; by regula falsi (Illinois form) in a bracket.
fn maximum(a: DMat3, b: DMat3, r: DVec3) -> f64 {
    let slope = |l: f64| {
        let y = ((1.0 - l) * a + l * b).inverse() * r;
        y.dot(((1.0 - l).powi(2) * a - l * l * b) * y)
    };
    let (mut low, mut high) = ((0.0, slope(0.0)), (1.0, slope(1.0)));
    let mut kept = 0;
    for _ in 0..100 {
        let l = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let s = slope(l);
        if s == 0.0 || high.0 - low.0 < 1e-15 || l <= low.0 || l >= high.0 {
            return l;
        }
        // Halving the value at an end that stays twice makes the bracket shrink from both sides.
        if s > 0.0 {
            low = (l, s);
            if kept == 1 {
                high.1 /= 2.0;
            }
            kept = 1;
        } else {
            high = (l, s);
            if kept == -1 {
                low.1 /= 2.0;
            }
            kept = -1;
        }
    }
    0.5 * (low.0 + high.0)
}

/// Distance of a body from a plane wall: `height` is that of its centre above the wall, `inward` the unit normal into the fluid.
/// The body's half height is W = sqrt(across^2 (1 - (e.n)^2) + along^2 (e.n)^2), and it touches at s = -A n/W.
/// `by_turn_a` is that of the wall: zero.
#[must_use]
pub fn wall_contact(body: &Body, height: f64, inward: DVec3) -> Contact {
    let half = body.shape.half_height(body.axis.dot(inward));
    let touching = body.matrix() * inward / -half;
    Contact { gap: height - half, by_shift: inward, by_turn_a: DVec3::ZERO, by_turn_b: touching.cross(inward) }
}

/// Whether the two bodies, `r` apart, come closer than `gap`.
#[must_use]
pub fn closer_than(a: &Body, b: &Body, r: DVec3, gap: f64) -> bool {
    // |R| F^(-1/2) is at most the sum of the radii and at least that of the inscribed spheres.
    let distance = r.length();
    let inner = a.shape.along.min(a.shape.across) + b.shape.along.min(b.shape.across);
    let outer = a.shape.radius() + b.shape.radius();
    distance < outer + gap && (distance < inner + gap || contact(a, b, r).is_none_or(|c| c.gap < gap))
}

/// Force and torque on a body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wrench {
    /// Force in kT/a.
    pub force: DVec3,
    /// Torque about the centre in kT.
    pub torque: DVec3,
}

/// U(d) = 4 epsilon [(sigma/(d + sigma))^12 - (sigma/(d + sigma))^6] + epsilon up to its minimum at d = (2^(1/6) - 1) sigma, 0 beyond;
/// forces stronger than `max_force` are scaled down to it, with their torques.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Repulsion {
    /// Length sigma in a.
    pub sigma: f64,
    /// Strength epsilon in kT.
    pub epsilon: f64,
    /// Largest force between two bodies in kT/a.
    pub max_force: f64,
}

impl Repulsion {
    /// Distance from which on there is no force.
    #[must_use]
    pub fn cutoff(&self) -> f64 {
        (2f64.powf(1.0 / 6.0) - 1.0) * self.sigma
    }

    /// U(d), without regard to `max_force`.
    #[must_use]
    pub fn potential(&self, gap: f64) -> f64 {
        if gap >= self.cutoff() {
            return 0.0;
        }
        let s6 = (self.sigma / (gap + self.sigma)).powi(6);
        4.0 * self.epsilon * (s6 * s6 - s6) + self.epsilon
    }

    /// -U'(d), at most `max_force`.
    #[must_use]
    pub fn strength(&self, gap: f64) -> f64 {
        if gap >= self.cutoff() {
            return 0.0;
        }
        if gap <= -self.sigma {
            return self.max_force;
        }
        let s6 = (self.sigma / (gap + self.sigma)).powi(6);
        (24.0 * self.epsilon / (gap + self.sigma) * (2.0 * s6 * s6 - s6)).min(self.max_force)
    }

    /// Forces and torques on A and on B, `r` pointing from A to B; none out of reach.
    #[must_use]
    pub fn between(&self, a: &Body, b: &Body, r: DVec3) -> Option<[Wrench; 2]> {
        if r.length() >= a.shape.radius() + b.shape.radius() + self.cutoff() {
            return None;
        }
        let contact = contact(a, b, r)?;
        let strength = self.capped(&contact)?;
        Some([
            Wrench { force: -strength * contact.by_shift, torque: strength * contact.by_turn_a },
            Wrench { force: strength * contact.by_shift, torque: strength * contact.by_turn_b },
        ])
    }

    /// Force and torque of a wall on a body whose centre is `height` above it.
    #[must_use]
    pub fn at_wall(&self, body: &Body, height: f64, inward: DVec3) -> Option<Wrench> {
        let contact = wall_contact(body, height, inward);
        let strength = self.capped(&contact)?;
        Some(Wrench { force: strength * contact.by_shift, torque: strength * contact.by_turn_b })
    }

    /// -U', reduced so that the force -U' grad d is at most `max_force`.
    fn capped(&self, contact: &Contact) -> Option<f64> {
        let strength = self.strength(contact.gap);
        let limit = self.max_force / contact.by_shift.length();
        (strength > 0.0).then(|| strength.min(limit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;
    use proptest::prelude::*;

    const LAW: Repulsion = Repulsion { sigma: SIGMA, epsilon: EPSILON, max_force: 1e9 };

    fn body(across: f64, along: f64, axis: DVec3) -> Body {
        Body { shape: Spheroid { along, across }, axis: axis.normalize() }
    }

    fn pair() -> (Body, Body) {
        (body(3.0, 6.0, DVec3::new(0.3, 0.5, 0.9)), body(4.0, 2.5, DVec3::new(-0.7, 0.2, 0.4)))
    }

    fn turned(b: &Body, angle: DVec3) -> Body {
        Body { axis: DQuat::from_scaled_axis(angle) * b.axis, ..*b }
    }

    #[test]
    fn spheres_are_at_the_distance_of_their_surfaces() {
        let (a, b) = (body(2.0, 2.0, DVec3::X), body(0.7, 0.7, DVec3::Y));
        let r = DVec3::new(1.0, -2.0, 4.0);
        let c = contact(&a, &b, r).expect("centres differ");
        assert!((c.gap - (r.length() - 2.7)).abs() < 1e-13);
        assert!((c.by_shift - r.normalize()).length() < 1e-13);
        assert!(c.by_turn_a.length() < 1e-13 && c.by_turn_b.length() < 1e-13);
    }

    #[test]
    fn touching_bodies_have_distance_zero() {
        // End to end, side to side, end to side.
        let (a, b) = (body(3.0, 6.0, DVec3::X), body(2.0, 5.0, DVec3::X));
        let across = body(2.0, 5.0, DVec3::Z);
        for (b, r) in [(b, DVec3::X * 11.0), (b, DVec3::Y * 5.0), (across, DVec3::X * 8.0), (across, DVec3::Z * 8.0)] {
            let c = contact(&a, &b, r).expect("centres differ");
            assert!(c.gap.abs() < 1e-12, "{r}: {}", c.gap);
            assert!((c.by_shift - r.normalize()).length() < 1e-10);
        }
    }

    /// Tangent ellipsoids by construction: B's centre lies where the outward normal of A at s is the inward one of B.
    #[test]
    fn touching_oblique_bodies_have_distance_zero() {
        let (a, b) = pair();
        for n in [DVec3::new(0.2, -0.5, 0.7), DVec3::X, DVec3::new(-0.6, 0.1, -0.8)].map(DVec3::normalize) {
            // The point of a body with outward normal n is A n / W.
            let support = |b: &Body| b.matrix() * n / b.shape.half_height(b.axis.dot(n));
            let r = support(&a) + support(&b);
            let c = contact(&a, &b, r).expect("centres differ");
            assert!(c.gap.abs() < 1e-12, "{}", c.gap);
            // The force is along the common normal.
            assert!((c.by_shift.normalize() - n).length() < 1e-10);
        }
    }

    #[test]
    fn the_gap_grows_like_the_distance_of_centres_at_fixed_directions() {
        let (a, b) = pair();
        let r = DVec3::new(5.0, 6.0, 4.0);
        let far = contact(&a, &b, 2.0 * r).expect("centres differ");
        let near = contact(&a, &b, r).expect("centres differ");
        // d is the distance along the line of centres at fixed directions, so it grows by |r|.
        assert!((far.gap - near.gap - r.length()).abs() < 1e-12);
        assert!(contact(&a, &b, DVec3::ZERO).is_none());
    }

    #[test]
    fn potential_and_force_at_known_distances() {
        assert!((LAW.potential(0.0) - EPSILON).abs() < 1e-14);
        assert!((LAW.strength(0.0) - 24.0 * EPSILON / SIGMA).abs() < 1e-12);
        assert_eq!((LAW.potential(LAW.cutoff()), LAW.strength(LAW.cutoff())), (0.0, 0.0));
        let soft = Repulsion { max_force: 7.0, ..LAW };
        assert_eq!((soft.strength(-0.4), soft.strength(-3.0)), (7.0, 7.0));
    }

    #[test]
    fn capped_forces_keep_their_direction() {
        let (a, b) = pair();
        let r = DVec3::new(2.0, 3.0, 1.0);
        let soft = Repulsion { max_force: 7.0, ..LAW };
        let [on_a, on_b] = soft.between(&a, &b, r).expect("they overlap");
        assert_eq!(on_a.force, -on_b.force);
        assert!(on_b.force.length() <= 7.0 * (1.0 + 1e-12) && on_b.force.dot(r) > 0.0);
    }

    #[test]
    fn a_wall_touches_the_lowest_point() {
        let b = body(3.0, 6.0, DVec3::new(0.4, 0.5, 0.3));
        let c = wall_contact(&b, 7.0, DVec3::Y);
        let lowest = b.matrix() * DVec3::Y / b.shape.half_height(b.axis.y);
        assert!((c.gap - (7.0 - lowest.y)).abs() < 1e-12);
        let step = 1e-5;
        for turn in [DVec3::X, DVec3::Y, DVec3::Z] {
            let gap = |t: f64| wall_contact(&turned(&b, turn * t), 7.0, DVec3::Y).gap;
            assert!(((gap(step) - gap(-step)) / (2.0 * step) - c.by_turn_b.dot(turn)).abs() < 1e-8);
        }
        let upright = LAW.at_wall(&body(3.0, 6.0, DVec3::Y), 6.0, DVec3::Y).expect("it touches");
        assert!((upright.force - DVec3::Y * LAW.strength(0.0)).length() < 1e-9 && upright.torque.length() < 1e-9);
        assert!(LAW.at_wall(&b, 7.0, DVec3::Y).is_none());
    }

    proptest! {
        /// Force and torque are derivatives of U, and nothing turns when the pair turns as a whole.
        #[test]
        fn forces_are_gradients(
            size in prop::array::uniform4(1.0..5.0f64),
            ea in prop::array::uniform3(-1.0..1.0f64), eb in prop::array::uniform3(-1.0..1.0f64),
            n in prop::array::uniform3(-1.0..1.0f64), gap in -0.2..0.05f64,
        ) {
            let (ea, eb, n) = (DVec3::from_array(ea), DVec3::from_array(eb), DVec3::from_array(n));
            prop_assume!(ea.length() > 0.1 && eb.length() > 0.1 && n.length() > 0.1);
            let (a, b, n) = (body(size[0], size[1], ea), body(size[2], size[3], eb), n.normalize());
            let start = contact(&a, &b, n).expect("centres differ");
            let r = n * (1.0 - start.gap + gap);
            prop_assume!((gap - LAW.cutoff()).abs() > 1e-3);
            let [on_a, on_b] = LAW.between(&a, &b, r).expect("within reach");
            prop_assert_eq!(on_a.force, -on_b.force);
            let balance = on_a.torque + on_b.torque + r.cross(on_b.force);
            let size = on_b.force.length() * r.length();
            prop_assert!(balance.length() < 1e-9 * size, "{} of {}", balance, size);
            let energy = |a: &Body, b: &Body, r: DVec3| LAW.potential(contact(a, b, r).expect("centres differ").gap);
            let h = 1e-6;
            for u in [DVec3::X, DVec3::Y, DVec3::Z] {
                let force = -(energy(&a, &b, r + h * u) - energy(&a, &b, r - h * u)) / (2.0 * h);
                let torque_a = -(energy(&turned(&a, h * u), &b, r) - energy(&turned(&a, -h * u), &b, r)) / (2.0 * h);
                let torque_b = -(energy(&a, &turned(&b, h * u), r) - energy(&a, &turned(&b, -h * u), r)) / (2.0 * h);
                prop_assert!((force - on_b.force.dot(u)).abs() < 1e-5 * size + 1e-5);
                prop_assert!((torque_a - on_a.torque.dot(u)).abs() < 1e-5 * size + 1e-5);
                prop_assert!((torque_b - on_b.torque.dot(u)).abs() < 1e-5 * size + 1e-5);
            }
        }

        #[test]
        fn the_order_of_the_pair_does_not_matter(ea in prop::array::uniform3(-1.0..1.0f64), r in prop::array::uniform3(-9.0..9.0f64)) {
            let (ea, r) = (DVec3::from_array(ea), DVec3::from_array(r));
            prop_assume!(ea.length() > 0.1 && r.length() > 0.5);
            let (a, b) = (body(3.0, 6.0, ea), pair().1);
            let (ab, ba) = (contact(&a, &b, r).expect("apart"), contact(&b, &a, -r).expect("apart"));
            prop_assert!((ab.gap - ba.gap).abs() < 1e-11 * r.length());
            prop_assert!((ab.by_turn_a - ba.by_turn_b).length() < 1e-7);
            prop_assert_eq!(closer_than(&a, &b, r, 0.3), ab.gap < 0.3);
        }
    }
}
