//! What is read off the squirmers: their poses, how two of them stand to each other, and clusters of those that touch.

use crate::case::Trouble;
use glam::{DQuat, DVec3};
use squirm::analyze::clusters::sizes;
use squirm::analyze::space::Space;
use squirm::buffers::SquirmerState;
use squirm::gpu::Session;
use squirm::math::mobility::Friction;
use squirm::math::spheroid::Spheroid;
use squirm::math::steric::{Body, contact};
use squirm::math::transport::{Rule, Transport};
use squirm::state::{Domain, System, packed};

/// A squirmer at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swimmer {
    /// Shape, without the margin of the steric forces, and axis e.
    pub body: Body,
    /// Centre in a; crossings of the box are counted, so that it goes on steadily.
    pub position: DVec3,
}

/// All squirmers; waits for the GPU.
pub fn swimmers(session: &Session) -> Result<Vec<Swimmer>, Trouble> {
    let system = session.system();
    let edge = DVec3::from_array(system.domain.size.map(f64::from));
    let states = session.read::<SquirmerState>("squirmers")?;
    let one = |(species, s): (usize, &SquirmerState)| Swimmer {
        body: Body {
            shape: system.species[species].spheroid(),
            axis: DQuat::from_array(s.orientation.map(f64::from)).normalize() * DVec3::Z,
        },
        position: packed::unpack_position(&system.domain, s.position)
            + edge * DVec3::from_array(s.image.map(f64::from)),
    };
    // The buffer is longer than the list: its end is padding.
    Ok(system.squirmer_species().zip(&states).map(one).collect())
}

/// The box as analyzers see it.
fn space(domain: &Domain) -> Space {
    Space { edge: DVec3::from_array(domain.size.map(f64::from)), walls: domain.walls.is_some() }
}

/// How two squirmers stand to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Between their centres, in a.
    pub distance: f64,
    /// Directional distance of their surfaces (Paramonov and Yaliraki 2005), in a; negative in overlap.
    pub gap: f64,
    /// Angle between their axes in degrees; positive where the headings converge, so that the fronts are closer than the rears.
    pub angle: f64,
}

/// The pair of a squirmer with the nearest image of another.
pub fn pair(domain: &Domain, a: &Swimmer, b: &Swimmer) -> Pair {
    let r = space(domain).nearest(a.position, b.position);
    let distance = r.length();
    // Bodies whose centres coincide overlap as far as they can.
    let gap = contact(&a.body, &b.body, r).map_or(-a.body.shape.radius() - b.body.shape.radius(), |c| c.gap);
    let angle = a.body.axis.cross(b.body.axis).length().atan2(a.body.axis.dot(b.body.axis)).to_degrees();
    let opening = (b.body.axis - a.body.axis).dot(r);
    Pair { distance, gap, angle: if opening > 0.0 { -angle } else { angle } }
}

/// Sizes of the clusters, largest first; neighbours are closer than `reach` (in a).
pub fn clusters(domain: &Domain, all: &[Swimmer], reach: f64) -> Vec<usize> {
    let bodies: Vec<(Body, DVec3)> = all.iter().map(|s| (s.body, s.position)).collect();
    sizes(&space(domain), &bodies, reach)
}

/// Viscosity and the rest that the formula gives for this system's fluid of rotations by 130 degrees that keep angular momentum.
pub fn transport(system: &System) -> Transport {
    let (density, temperature, dt) = (system.fluid.density, system.fluid.temperature, system.run.dt);
    Rule { density, temperature, dt, angle: 130.0, angular_momentum: true }.transport()
}

/// Peclet number U0/(2 along D_R) of a swimmer in a fluid of viscosity eta, D_R = kT/(zeta_R eta) by Perrin's friction.
pub fn peclet(shape: Spheroid, b1: f64, viscosity: f64) -> f64 {
    shape.swim_speed(b1) * Friction::of(shape).tumble * viscosity / (2.0 * shape.along)
}

/// Reynolds number gamma U0 along/eta.
pub fn reynolds(shape: Spheroid, b1: f64, system: &System) -> f64 {
    system.fluid.density * shape.swim_speed(b1) * shape.along / transport(system).viscosity
}

#[cfg(test)]
mod tests {
    use super::*;
    use squirm::state::Walls;

    fn slit() -> Domain {
        let walls =
            Walls { axis: "y".into(), condition: "no-slip".into(), velocity_low: [0.0; 3], velocity_high: [0.0; 3] };
        Domain { size: [50, 7, 40], walls: Some(walls) }
    }

    fn swimmer(x: f64, z: f64, degrees: f64) -> Swimmer {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let body = Body { shape: Spheroid { along: 6.0, across: 3.0 }, axis: DVec3::new(cos, 0.0, sin) };
        Swimmer { body, position: DVec3::new(x, 3.5, z) }
    }

    #[test]
    fn a_wedge_has_its_angle_with_the_sign_of_its_tip() {
        let domain = slit();
        // One above the other in z: the lower one heads up, the upper one down.
        let closing = pair(&domain, &swimmer(10.0, 2.0, 10.0), &swimmer(10.0, 10.0, -15.0));
        assert!((closing.angle - 25.0).abs() < 1e-9 && (closing.distance - 8.0).abs() < 1e-12, "{closing:?}");
        let opening = pair(&domain, &swimmer(10.0, 2.0, -10.0), &swimmer(10.0, 10.0, 15.0));
        assert!((opening.angle + 25.0).abs() < 1e-9, "{opening:?}");
        // The same pair in the other order, and across the side of the box.
        let swapped = pair(&domain, &swimmer(10.0, 10.0, -15.0), &swimmer(10.0, 2.0, 10.0));
        assert!((swapped.angle - 25.0).abs() < 1e-9, "{swapped:?}");
        let across = pair(&domain, &swimmer(10.0, 36.0, 10.0), &swimmer(60.0, 4.0, -15.0));
        assert!((across.angle - 25.0).abs() < 1e-9 && (across.gap - closing.gap).abs() < 1e-9, "{across:?}");
    }

    #[test]
    fn surfaces_side_by_side_and_head_to_tail() {
        let domain = slit();
        let beside = pair(&domain, &swimmer(10.0, 2.0, 0.0), &swimmer(10.0, 9.0, 0.0));
        assert!((beside.gap - 1.0).abs() < 1e-9 && beside.angle.abs() < 1e-9, "{beside:?}");
        let behind = pair(&domain, &swimmer(10.0, 2.0, 0.0), &swimmer(24.0, 2.0, 0.0));
        assert!((behind.gap - 2.0).abs() < 1e-9, "{behind:?}");
        let against = pair(&domain, &swimmer(10.0, 2.0, 0.0), &swimmer(24.0, 2.0, 180.0));
        assert!((against.angle - 180.0).abs() < 1e-9, "{against:?}");
    }

    #[test]
    fn peclet_number_of_a_known_swimmer() {
        // U0 = 0.0413, D_R = 1/(2042.4 eta): 131 at eta = 18.59.
        let shape = Spheroid { along: 6.0, across: 3.0 };
        assert!((peclet(shape, 0.05, 18.59) - 131.0).abs() < 1.0);
    }
}
