//! The slip velocity on a spheroidal squirmer, in spheroidal coordinates.

use super::spheroid::Spheroid;
use glam::DVec3;

/// Strengths of a squirmer's slip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slip {
    /// Swimming mode.
    pub b1: f64,
    /// Stresslet mode, B2 = beta B1.
    pub b2: f64,
    /// Rotlet dipole.
    pub rotlet: f64,
}

impl Slip {
    /// Slip velocity at the surface point `s`, both in body axes (z along e): u = -(B1 + B2 zeta)(e_zeta . e) e_zeta
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
        -(self.b1 + self.b2 * zeta) * e_zeta.z * e_zeta + self.rotlet * zeta * rho / shape.across * e_phi
    }

    /// The squirmer's own flow in the body's frame, continued from the surface point p, where it is the slip, to the point `s` inside: to
    /// first order in the depth, u = u(p) - depth du/dn with the gradients of Stokes flow at the surface. That of B1 is
    /// irrotational, du/dn = -kappa u with the curvature kappa of the meridian; that of B2 has the vorticity
    /// [`Spheroid::second_mode_vorticity`], which adds to it (both after Keller and Wu 1977); for the rotlet dipole
    /// du/dn = -3 kappa u with the curvature around the axis, exact for a sphere. p is the foot of the normal to first order.
    ///
    /// In a cell that the surface cuts, ghosts with this velocity stand for the fluid as it would go on behind the surface, so that
    /// the collision does not drag on the flow that the squirmer makes.
    #[must_use]
    pub fn inside(&self, shape: Spheroid, s: DVec3) -> DVec3 {
        let axes = DVec3::new(shape.across, shape.across, shape.along);
        let scaled = (s / axes).length().max(1e-6);
        let homothetic = s / scaled;
        let normal = (homothetic / (axes * axes)).normalize_or(DVec3::X);
        let depth = ((1.0 - scaled) * homothetic.dot(normal)).min(DEEPEST);
        let foot = s + depth * normal;
        let p = foot / (foot / axes).length().max(1e-6);
        let zeta = p.z / shape.along;
        let width = shape.across.powi(2) * zeta * zeta + shape.along.powi(2) * (1.0 - zeta * zeta);
        let meridian = shape.across * shape.along / width.powf(1.5);
        let around = (p / (axes * axes)).length_recip() / shape.across.powi(2);
        let mode = |b1: f64, b2: f64, rotlet: f64| Self { b1, b2, rotlet }.at(shape, p);
        (1.0 + meridian * depth) * mode(self.b1, 0.0, 0.0)
            + (1.0 + (meridian - shape.second_mode_vorticity() / width.sqrt()) * depth) * mode(0.0, self.b2, 0.0)
            + (1.0 + 3.0 * around * depth) * mode(0.0, 0.0, self.rotlet)
    }
}

/// Ghosts deeper than this, a cell's diagonal, meet no fluid.
const DEEPEST: f64 = 1.732_050_8;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::draws::direction;

    const SHAPES: [(f64, f64); 4] = [(3.0, 3.0), (6.0, 3.0), (2.0, 4.0), (9.0, 1.0)];

    /// Points over the whole surface, uniform for a sphere.
    fn points(shape: Spheroid, count: u32) -> impl Iterator<Item = DVec3> {
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        (0..count).map(move |i| {
            let u = direction((f64::from(i) + 0.5) / f64::from(count), f64::from(i) * golden);
            u * DVec3::new(shape.across, shape.across, shape.along)
        })
    }

    #[test]
    fn slip_is_the_axis_projected_on_the_surface() {
        for (along, across) in SHAPES {
            let shape = Spheroid { along, across };
            let slip = Slip { b1: 0.1, b2: -0.2, rotlet: 0.0 };
            for s in points(shape, 500).chain([DVec3::new(0.0, 0.0, along), DVec3::new(0.0, 0.0, -along)]) {
                let normal = (s / DVec3::new(across, across, along).powf(2.0)).normalize();
                let tangent = DVec3::Z - normal.z * normal;
                let expected = -0.1 * (1.0 - 2.0 * s.z / along) * tangent;
                assert!((slip.at(shape, s) - expected).length() < 1e-13, "{s}");
            }
        }
    }

    /// Lighthill (1952) and Blake (1971): a sphere swims with minus the mean slip, (2/3) B1.
    #[test]
    fn sphere_swims_along_its_axis() {
        let shape = Spheroid { along: 3.0, across: 3.0 };
        let slip = Slip { b1: 0.1, b2: 0.3, rotlet: 0.2 };
        let mean = points(shape, 20_000).map(|s| slip.at(shape, s)).sum::<DVec3>() / 20_000.0;
        assert!((mean + DVec3::Z * 0.2 / 3.0).length() < 1e-5, "{mean}");
    }

    #[test]
    fn rotlet_turns_the_halves_against_each_other() {
        let shape = Spheroid { along: 6.0, across: 3.0 };
        let slip = Slip { b1: 0.0, b2: 0.0, rotlet: 0.3 };
        let s = DVec3::new(3.0 * 0.8, 0.0, 6.0 * 0.6);
        assert!((slip.at(shape, s) - DVec3::Y * 0.3 * 0.6 * 0.8).length() < 1e-15);
        assert!((slip.at(shape, -s) - slip.at(shape, s)).length() < 1e-15);
        assert!((slip.at(shape, DVec3::new(s.x, 0.0, -s.z)) + slip.at(shape, s)).length() < 1e-15);
    }

    /// Against the known flow around the squirmer, by finite differences outside: the continuation has its slope.
    #[test]
    fn the_flow_goes_on_inside() {
        use crate::math::flow::SquirmerFlow;
        for (along, across) in [(3.0, 3.0), (6.0, 3.0), (2.0, 4.0), (3.0, 2.95)] {
            let shape = Spheroid { along, across };
            for slip in [Slip { b1: 0.1, b2: 0.0, rotlet: 0.0 }, Slip { b1: 0.0, b2: 0.1, rotlet: 0.0 }] {
                let flow = SquirmerFlow::new(shape, slip.b1, slip.b2);
                let swim = shape.swim_speed(slip.b1) * DVec3::Z;
                for p in points(shape, 60) {
                    let n = shape.normal(p, DVec3::Z);
                    let tangent = n.cross(DVec3::Z).cross(n).normalize_or_zero();
                    let body = |d: f64| (flow.velocity(p + d * n, DVec3::Z) - swim).dot(tangent);
                    let outside = (-3.0 * body(0.0) + 4.0 * body(1e-4) - body(2e-4)) / 2e-4;
                    let inside = (slip.inside(shape, p) - slip.inside(shape, p - 1e-4 * n)).dot(tangent) / 1e-4;
                    assert!((outside - inside).abs() < 2e-4 * 0.1, "{along} {across} {p}: {outside} {inside}");
                }
            }
        }
    }
}
