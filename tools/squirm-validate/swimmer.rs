//! A single squirmer in a periodic cube: what is set, what theory says of it, and how it is followed.

use crate::case::Trouble;
use crate::rig::{Planned, Rig, advance, sound};
use crate::rules::viscosity;
use glam::{DQuat, DVec3};
use squirm::analyze::statistics::{Estimate, blocked};
use squirm::gpu::Session;
use squirm::math::mobility::Friction;
use squirm::math::spheroid::Spheroid;
use squirm::state::start::nearest_image;
use squirm::state::{Squirmer, System, packed};
use std::f64::consts::{PI, TAU};

/// A squirmer, its box and its fluid, as they vary between parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swimmer {
    /// Semi-axis across the axis, a.
    pub across: f64,
    /// Semi-axis along the axis, a.
    pub along: f64,
    /// Swimming mode.
    pub b1: f64,
    /// Active stress.
    pub beta: f64,
    /// Edge of the cube, a.
    pub edge: u32,
    /// Particles per cell.
    pub density: u32,
    /// Time step, tau.
    pub dt: f64,
    /// Temperature of the fluid, kT.
    pub temperature: f64,
    /// Random numbers.
    pub seed: u32,
}

impl Swimmer {
    /// Overrides for a pipeline whose one species is called `swimmer`. It is put into the far corner of the box, where its neighbourhood
    /// crosses three sides.
    pub fn sets(&self) -> Vec<String> {
        let Self { across, along, b1, beta, edge, density, dt, temperature, seed } = *self;
        let corner = 0.9 * f64::from(edge);
        vec![
            format!("run.seed={seed}"),
            format!("run.dt={dt:?}"),
            format!("box.size=[{edge},{edge},{edge}]"),
            format!("fluid.density={density}"),
            format!("fluid.temperature={temperature:?}"),
            format!("squirmers.swimmer.semi_axes={{across={across:?},along={along:?}}}"),
            format!("squirmers.swimmer.b1={b1:?}"),
            format!("squirmers.swimmer.beta={beta:?}"),
            format!("squirmers.swimmer.poses=[[{corner},{},{},0.3,0.5,0.8]]", corner - 1.0, corner + 0.5),
        ]
    }

    /// The shape.
    pub fn shape(&self) -> Spheroid {
        Spheroid { along: self.along, across: self.across }
    }

    /// Speed in Stokes flow in its periodic box, U_L.
    pub fn speed(&self) -> f64 {
        self.shape().swim_speed_periodic(self.b1, f64::from(self.edge).powi(3))
    }

    /// In tables.
    pub fn name(&self) -> String {
        let Self { across, along, b1, beta, edge, density, dt, temperature, .. } = self;
        let cold = if *temperature == 1.0 { String::new() } else { format!(", kT = {temperature}") };
        format!(
            "{across} x {across} x {along}, B1 = {b1}, beta = {beta}, L = {edge}, {density} per cell, h = {dt}{cold}"
        )
    }
}

/// Steps in which the flow of the longest wavelength decays by e^-3.
pub fn settling(system: &System) -> u64 {
    let k = TAU / f64::from(system.domain.size.into_iter().max().unwrap_or(1));
    let rate = k * k * viscosity(system) / system.fluid.density;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let steps = (3.0 / (rate * system.run.dt)).ceil() as u64;
    steps
}

/// Friction of a body along its axis in a periodic cube, divided by the viscosity: the point force of Hasimoto (J. Fluid Mech. 5, 317,
/// 1959) and the next term, exact for spheres, with the body's volume.
pub fn friction_periodic(shape: Spheroid, edge: f64) -> f64 {
    let free = Friction::of(shape).along;
    let mobility = 1.0 / free - 2.837_297 / (6.0 * PI * edge) + shape.volume() / (edge.powi(3) * free);
    1.0 / mobility
}

/// The squirmers as they are; waits for the GPU.
pub fn squirmers(session: &Session) -> Result<Vec<Squirmer>, Trouble> {
    let mut states = session.read("squirmers")?;
    states.truncate(session.system().squirmer_count() as usize);
    Ok(packed::unpack_squirmers(session.system(), &states))
}

/// Small rotation that turns one orientation into the other, as a vector in radians.
pub fn turn(from: DQuat, to: DQuat) -> DVec3 {
    let q = to * from.inverse();
    2.0 * q.w.signum() * DVec3::new(q.x, q.y, q.z)
}

/// Speed of the only squirmer along its axis, from displacements: its instantaneous velocity is thermal, with sqrt(kT/M).
///
/// Readings are 100 steps apart, which is long against the relaxation of its velocity; what correlation remains the blocks find.
pub fn swim_speed(rig: &Rig, planned: &Planned, steps: u64) -> Result<Estimate, Trouble> {
    let state = rig.start(planned)?;
    let mut session = rig.session(planned, &state)?;
    advance(&mut session, settling(&planned.system))?;
    let every = rig.pick(25, 100);
    let time = every as f64 * planned.system.run.dt;
    let mut before = squirmers(&session)?[0];
    let mut series = Vec::new();
    for _ in 0..steps / every {
        advance(&mut session, every)?;
        let now = squirmers(&session)?[0];
        let moved = nearest_image(&planned.system.domain, now.position - before.position);
        series.push(moved.dot((now.axis() + before.axis()).normalize()) / time);
        before = now;
    }
    sound(&session)?;
    Ok(blocked(&series))
}

/// Mean of independent estimates of one quantity, each weighing the same, with their own errors.
pub fn together(found: &[Estimate]) -> Estimate {
    let n = found.len() as f64;
    Estimate {
        mean: found.iter().map(|e| e.mean).sum::<f64>() / n,
        error: found.iter().map(|e| e.error * e.error).sum::<f64>().sqrt() / n,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_in_a_large_box_has_the_friction_of_stokes() {
        let sphere = Spheroid { along: 2.0, across: 2.0 };
        assert!((friction_periodic(sphere, 1e6) / (12.0 * PI) - 1.0).abs() < 1e-5);
        // Hasimoto's series at a volume share of 0.001: 1 - 1.7601 c^(1/3) + c = 0.8250 of the mobility.
        let edge = (sphere.volume() / 0.001).cbrt();
        assert!((12.0 * PI / friction_periodic(sphere, edge) - 0.825).abs() < 1e-4);
    }

    #[test]
    fn a_turn_is_a_rotation_vector() {
        let from = DQuat::from_rotation_x(0.7);
        let wanted = DVec3::new(0.01, -0.02, 0.005);
        let to = DQuat::from_scaled_axis(wanted) * from;
        assert!((turn(from, to) - wanted).length() < 1e-5);
        assert!((turn(from, -to) - wanted).length() < 1e-5);
    }

    #[test]
    fn estimates_together_are_sharper() {
        let both = together(&[Estimate { mean: 1.0, error: 0.3 }, Estimate { mean: 2.0, error: 0.4 }]);
        assert!((both.mean - 1.5).abs() < 1e-12 && (both.error - 0.25).abs() < 1e-12);
    }
}
