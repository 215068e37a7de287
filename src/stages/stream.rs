//! stream: the ballistic motion of the fluid, with walls (Malevanets and Kapral, J. Chem. Phys. 110, 8605, 1999).

use super::{Finding, Gravity, Phase, Stage};
use crate::buffers::Extent;
use crate::shader::Rare;
use crate::state::scene::Scene;
use crate::state::{Domain, Particle, System, Walls};
use crate::{params, shared};
use glam::DVec3;

params! {
    /// Moves every fluid particle freely for one time step (Malevanets and Kapral, J. Chem. Phys. 110, 8605, 1999): half
    /// of the body force's kick, the flight, the other half. Walls reverse the velocity relative to their own (bounce-back,
    /// no-slip) or mirror it (slip) where and when the particle meets them; the momentum handed over is summed.
    pub struct Stream {}
}

shared! {
    /// No parameters.
    pub struct StreamSettings {
        /// Not used.
        pad: u32,
    }
}

impl Stage for Stream {
    const KIND: &'static str = "stream";
    const WGSL: &'static str = include_str!("../../shaders/stages/stream.wgsl");
    const EACH: &'static [(&'static str, &'static str)] = &[("stream", "streamed")];
    const RARE: &'static [Rare] =
        &[Rare { entry: "stream", of: Extent::WallCells, condition: "meets_wall", otherwise: "flown" }];
    const PHASES: &'static [Phase] = &[Phase { entry: "stream", over: Extent::Particles }];
    type Params = Self;
    type Uniform = StreamSettings;

    fn check(_: &Self, system: &System) -> Vec<Finding> {
        let reach = 12.0 * system.fluid.temperature.sqrt() * system.run.dt;
        let shortest = f64::from(system.domain.size.into_iter().min().unwrap_or(0));
        if reach < shortest / 2.0 {
            return Vec::new();
        }
        vec![Finding {
            gravity: Gravity::Warning,
            field: "",
            message: format!(
                "a particle of twelve times the thermal speed flies {reach:.1} a in one step, half of the box"
            ),
            help: "take a smaller `dt` or a larger box".into(),
        }]
    }

    fn uniform(_: &Self, _: &System) -> StreamSettings {
        StreamSettings::default()
    }

    fn reference(_: &Self, system: &System, scene: &mut Scene) {
        for particle in &mut scene.state.particles {
            let handed = fly(system, particle, system.run.dt);
            scene.wall_impulses[0] += handed[0];
            scene.wall_impulses[1] += handed[1];
        }
    }
}

/// Moves one particle by `duration` and returns the momentum handed to the low and the high wall. The motion is reversible:
/// a second flight of minus the duration leads back and returns minus the momentum.
pub(super) fn fly(system: &System, particle: &mut Particle, duration: f64) -> [DVec3; 2] {
    let half_kick = DVec3::from_array(system.fluid.acceleration) * duration / 2.0;
    let mut handed = [DVec3::ZERO; 2];
    particle.velocity += half_kick;
    let mut left = duration;
    while let Some((time, wall)) = next_wall(&system.domain, particle, left) {
        particle.position += particle.velocity * time;
        handed[wall] += bounce(&system.domain, wall, particle);
        left -= time;
    }
    particle.position = wrap(&system.domain, particle.position + particle.velocity * left);
    particle.velocity += half_kick;
    handed
}

/// When, and which wall (0 low, 1 high) the particle meets within `duration`, which may be negative.
pub(super) fn next_wall(domain: &Domain, particle: &Particle, duration: f64) -> Option<(f64, usize)> {
    domain.walls.as_ref()?;
    let rises = particle.velocity.y * duration > 0.0;
    let plane = if rises { f64::from(domain.size[1]) } else { 0.0 };
    let end = particle.position.y + particle.velocity.y * duration;
    let beyond = if rises { end >= plane } else { end < plane };
    beyond.then(|| ((plane - particle.position.y) / particle.velocity.y, usize::from(rises)))
}

/// The particle's velocity after it met the wall, and the momentum that the wall received.
pub(super) fn bounce(domain: &Domain, wall: usize, particle: &mut Particle) -> DVec3 {
    let before = particle.velocity;
    let walls = domain.walls.as_ref().expect("a wall was met");
    let moving = wall_velocity(walls, wall);
    let relative = before - moving;
    let reflected = match walls.condition.as_str() {
        "slip" => DVec3::new(relative.x, -relative.y, relative.z),
        _ => -relative,
    };
    particle.velocity = moving + reflected;
    before - particle.velocity
}

/// Velocity of the low (0) or the high (1) wall.
pub(super) fn wall_velocity(walls: &Walls, wall: usize) -> DVec3 {
    DVec3::from_array([walls.velocity_low, walls.velocity_high][wall])
}

/// The image of a position in the box; between walls y is confined instead.
pub(super) fn wrap(domain: &Domain, position: DVec3) -> DVec3 {
    let mut wrapped = position;
    for axis in 0..3 {
        let length = f64::from(domain.size[axis]);
        if axis == 1 && domain.walls.is_some() {
            wrapped.y = position.y.clamp(0.0, length.next_down());
        } else {
            wrapped[axis] = position[axis].rem_euclid(length);
            // A tiny negative number rounds up to the whole length.
            if wrapped[axis] >= length {
                wrapped[axis] = 0.0;
            }
        }
    }
    wrapped
}
