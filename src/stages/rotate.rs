//! rotate: stochastic rotation of the velocities relative to their cell's mean
//! (Malevanets and Kapral, J. Chem. Phys. 110, 8605, 1999).

use super::{Finding, Gravity, Phase, Stage};
use crate::buffers::Extent;
use crate::math::draws::direction;
use crate::math::rng::{Draw, Purpose};
use crate::state::System;
use crate::state::scene::{Operator, Scene};
use crate::{params, shared};
use glam::{DMat3, DVec3};

params! {
    /// The collision: in each cell the velocities relative to the mean turn by one angle about one random axis, uniform
    /// on the sphere, new for each cell and step (Malevanets and Kapral, J. Chem. Phys. 110, 8605, 1999; Allahyarov and
    /// Gompper, Phys. Rev. E 66, 036702, 2002). Momentum and energy of each cell are kept, angular momentum is not: put
    /// restore-thermostat after it where squirmers turn.
    pub struct Rotate {
        /// Rotation angle. 130 gives a liquid-like fluid; the nearest angle whose sine and cosine fit f32 is taken.
        pub angle: f64 = 130.0; "degree", Float { min: 0.0, max: 180.0 };
        /// By what factor 1 - cos(angle) is larger, up to half a turn, in cells that hold ghosts. Ghosts at the velocity of a wall
        /// differ less from the fluid in the cell than fluid in their place would, and hold it back less: it stops 0.1 to 0.2 a
        /// behind the wall. With 1.22, half a turn at 130 degrees, it stops at the wall (SRD+a; 0.05 a behind it with
        /// SRD-a), in thermal equilibrium and without a memory of the shear. An alternative to ghosts that continue the shear:
        /// take one of the two. 1 is the published rule.
        pub grip: f64 = 1.0; "", Float { min: 1.0, max: 10.0 };
    }
}

/// Angle in degrees below which a collision takes less than a third of a relative velocity away: (2/3)(1 - cos alpha) = 1/3.
const SMALL_ANGLE: f64 = 60.0;

shared! {
    /// The rotation angles, of cells with and without ghosts.
    pub struct RotateSettings {
        /// Cosine.
        cos: f32,
        /// Sine.
        sin: f32,
        /// 1 - cosine, exactly.
        one_minus_cos: f32,
        /// Not used.
        pad: u32,
        /// Cosine in cells that hold ghosts.
        ghost_cos: f32,
        /// Sine in cells that hold ghosts.
        ghost_sin: f32,
        /// 1 - cosine in cells that hold ghosts, exactly.
        ghost_one_minus_cos: f32,
        /// Not used.
        pad1: u32,
    }
}

impl Stage for Rotate {
    const KIND: &'static str = "rotate";
    const WGSL: &'static str = include_str!("../../shaders/stages/rotate.wgsl");
    const EACH: &'static [(&'static str, &'static str)] = &[("rotate", "rotated")];
    const PHASES: &'static [Phase] = &[Phase { entry: "rotate", over: Extent::Cells }];
    const AFTER: &'static [&'static str] = &["cell-reduce", "wall-ghosts", "squirmer-fill"];
    type Params = Self;
    type Uniform = RotateSettings;

    fn check(params: &Self, _: &System) -> Vec<Finding> {
        let message = match params.angle {
            0.0 => "without a rotation particles never collide".into(),
            angle if angle < SMALL_ANGLE => format!(
                "a rotation by {angle} degrees hardly mixes the velocities in a cell: the fluid is more a gas than a liquid"
            ),
            _ => return Vec::new(),
        };
        vec![Finding {
            gravity: Gravity::Warning,
            field: "angle",
            message,
            help: "the angle is in degrees, not radians: take one between 90 and 180; 130 is usual".into(),
        }]
    }

    fn uniform(params: &Self, _: &System) -> RotateSettings {
        let [(cos, sin), (ghost_cos, ghost_sin)] = params.angles().map(unimodular);
        RotateSettings {
            cos,
            sin,
            one_minus_cos: 1.0 - cos,
            pad: 0,
            ghost_cos,
            ghost_sin,
            ghost_one_minus_cos: 1.0 - ghost_cos,
            pad1: 0,
        }
    }

    fn reference(params: &Self, system: &System, scene: &mut Scene) {
        let [angle, with_ghosts] = params.angles().map(|angle| {
            let (cos, sin) = unimodular(angle);
            f64::from(sin).atan2(f64::from(cos))
        });
        let draw = Draw::new(system.run.seed, Purpose::Collision, scene.state.step);
        scene.operators = (0u32..)
            .zip(&scene.moments)
            .map(|(cell, moments)| {
                if moments.count < 2.0 {
                    return Operator::default();
                }
                let u = draw.uniforms(cell, 0, 0);
                let angle = if moments.ghosts > 0.0 { with_ghosts } else { angle };
                let rotation = DMat3::from_axis_angle(direction(u[0], u[1]).normalize(), angle);
                let mean = moments.v / moments.count;
                Operator { a: rotation, w: DVec3::ZERO, b: mean - rotation * mean }
            })
            .collect();
    }
}

impl Rotate {
    /// The angles in cells without and with ghosts, in radians.
    fn angles(&self) -> [f64; 2] {
        let angle = self.angle.to_radians();
        let with_ghosts = 1.0 - self.grip * (1.0 - angle.cos());
        [angle, with_ghosts.max(-1.0).acos()]
    }
}

/// Cosine and sine in f32 of an angle very near the wanted one, with cos^2 + sin^2 as near 1 as the search finds: an excess
/// e would heat or cool the fluid by that fraction in every step. The cosine is a multiple of 2^-23, so that 1 - cos is
/// exact in f32.
fn unimodular(angle: f64) -> (f32, f32) {
    let spacing = 0.5f64.powi(23);
    let nearest = (angle.cos() / spacing).round();
    #[allow(clippy::cast_possible_truncation)]
    let candidate = |steps: i32| {
        let cos = ((nearest + f64::from(steps)) * spacing).clamp(-1.0, 1.0);
        let sin = (1.0 - cos * cos).sqrt() as f32;
        let excess = (cos * cos + f64::from(sin) * f64::from(sin) - 1.0).abs();
        (excess, cos as f32, sin)
    };
    let mut best = candidate(0);
    for distance in 1..=1000 {
        for steps in [-distance, distance] {
            let other = candidate(steps);
            if other.0 < best.0 {
                best = other;
            }
        }
    }
    (best.1, best.2)
}
