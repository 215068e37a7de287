//! squirmer-collide: fluid particles bounce off the squirmers' moving, slipping surfaces.

use super::squirmer_fill::absorb;
use super::stream::{bounce, fly, next_wall, wrap};
use super::{Finding, Fused, Gravity, Phase, Stage};
use crate::buffers::Extent;
use crate::math::spheroid::Spheroid;
use crate::math::surface::Slip;
use crate::shader::Rare;
use crate::state::scene::{Load, Motion, Scene};
use crate::state::{Domain, Particle, Squirmer, System};
use crate::{params, shared};
use glam::{DQuat, DVec3};

params! {
    /// Particles whose flight met a squirmer repeat it and bounce where and when they meet: relative to the surface, which
    /// moves, turns and slips, the velocity reverses (Theers, Westphal, Gompper, Winkler, Soft Matter 12, 7372, 2016). The
    /// point is exact for a straight flight in the body's frame. The squirmers gain what the particles lose, after all
    /// bounces of the step.
    pub struct SquirmerCollide {
        /// Bounces of one particle, off squirmers and walls, that are followed within one step; a particle with more stays
        /// where the last one left it.
        pub max_hits: u32 = 8u32; "", Integer { min: 1, max: 64 };
    }
}

shared! {
    /// How far and how often particles are followed.
    pub struct SquirmerCollideSettings {
        /// Bounces followed.
        max_hits: u32,
        /// Half of the longest flight, in cells: how far from a squirmer's box its particles are looked for.
        margin: f32,
        /// A flight longer than this, in cells, may meet a squirmer of which the cell where it ends does not know.
        far: f32,
        /// What a flight may be longer than the last speed tells, in cells.
        slack: f32,
    }
}

impl Stage for SquirmerCollide {
    const KIND: &'static str = "squirmer-collide";
    const WGSL: &'static str = include_str!("../../shaders/stages/squirmer-collide.wgsl");
    const EACH: &'static [(&'static str, &'static str)] = &[("collide", "bounced"), ("clear_map", "map_cleared")];
    const RARE: &'static [Rare] =
        &[Rare { entry: "collide", of: Extent::Squirmers, condition: "may_bounce", otherwise: "" }];
    const PHASES: &'static [Phase] = &[
        Phase { entry: "clear_map", over: Extent::Cells },
        Phase { entry: "mark_map", over: Extent::SquirmerColumns },
        Phase { entry: "collide", over: Extent::Particles },
        Phase { entry: "absorb", over: Extent::Squirmers },
    ];
    // The map is empty in the beginning and emptied after its use, together with other work for all cells.
    const FUSED: Option<Fused> = Some(Fused {
        wgsl: &[Self::WGSL],
        ahead: &[],
        instead: &[
            ("clear_map", &[]),
            (
                "absorb",
                &[
                    Phase { entry: "absorb", over: Extent::Squirmers },
                    Phase { entry: "clear_map", over: Extent::Cells },
                ],
            ),
        ],
    });
    const OWN: &'static [&'static str] = &["absorb"];
    const AFTER: &'static [&'static str] = &["squirmer-move", "stream"];
    type Params = Self;
    type Uniform = SquirmerCollideSettings;

    fn check(_: &Self, system: &System) -> Vec<Finding> {
        let flight = system.fluid.temperature.sqrt() * system.run.dt;
        let coarse = |shape: Spheroid| flight > 0.25 * shape.along.min(shape.across);
        let finding = |name: &str| Finding {
            gravity: Gravity::Warning,
            field: "",
            message: format!("a thermal particle flies {flight:.2} a in one step, a good part of species `{name}`"),
            help: "take a smaller `dt` or larger squirmers".into(),
        };
        system.species.iter().filter(|s| coarse(s.spheroid())).map(|s| finding(&s.name)).collect()
    }

    fn uniform(params: &Self, system: &System) -> SquirmerCollideSettings {
        // Below the speed limit of twelve times the thermal speed no flight is longer than twice this.
        let margin = 6.0 * system.run.dt * system.fluid.temperature.sqrt();
        // A wall may have turned it around in a frame that moves, and half a kick of the body force came after it.
        let speed = |v: [f64; 3]| DVec3::from_array(v).length();
        let walls =
            system.domain.walls.iter().flat_map(|w| [w.velocity_low, w.velocity_high]).map(speed).fold(0.0, f64::max);
        let faster = 2.0 * walls + speed(system.fluid.acceleration) * system.run.dt / 2.0;
        // Squirmers move, too: less than a sixth of the margin.
        let (far, slack) = (margin / 1.2, faster * system.run.dt);
        #[allow(clippy::cast_possible_truncation)]
        let [margin, far, slack] = [margin, far, slack].map(|x| x as f32);
        SquirmerCollideSettings { max_hits: params.max_hits, margin, far, slack }
    }

    fn reference(params: &Self, system: &System, scene: &mut Scene) {
        let bodies = bodies(system, scene);
        let mut gained = vec![Load::default(); bodies.len()];
        for i in 0..scene.state.particles.len() {
            let mut particle = scene.state.particles[i];
            let mut handed = fly(system, &mut particle, -system.run.dt);
            let half_kick = DVec3::from_array(system.fluid.acceleration) * system.run.dt / 2.0;
            particle.velocity += half_kick;
            let mut flight =
                Flight { domain: &system.domain, bodies: &bodies, particle, met: false, gained: &mut gained };
            let walls = flight.follow(system.run.dt, params.max_hits);
            if !flight.met {
                continue;
            }
            particle = flight.particle;
            particle.velocity += half_kick;
            particle.position = wrap(&system.domain, particle.position);
            scene.state.particles[i] = particle;
            for wall in 0..2 {
                handed[wall] += walls[wall];
                scene.wall_impulses[wall] += handed[wall];
            }
        }
        scene.loads = vec![Load::default(); bodies.len()];
        for (owner, load) in gained.into_iter().enumerate() {
            absorb(system, scene, owner, load);
        }
    }
}

/// A squirmer on its way through the step.
struct Body {
    /// Semi-axes along the body's x, y and z of the surface that the fluid meets.
    axes: DVec3,
    slip: Slip,
    start: Motion,
    /// From the centre at the beginning of the step to that at its end.
    displacement: DVec3,
    /// Orientation at the end of the step.
    orientation: DQuat,
}

fn bodies(system: &System, scene: &Scene) -> Vec<Body> {
    let body = |(i, squirmer): (usize, &Squirmer)| {
        let species = &system.species[squirmer.species];
        let hull = species.hull();
        // Without a stage that moves squirmers they rest.
        let rest = Motion {
            position: squirmer.position,
            orientation: squirmer.orientation,
            drift: DVec3::ZERO,
            spin: DVec3::ZERO,
        };
        let start = scene.motions.get(i).copied().unwrap_or(rest);
        Body {
            axes: DVec3::new(hull.across, hull.across, hull.along),
            slip: species.hull_slip(),
            start,
            displacement: nearest(&system.domain, squirmer.position - start.position),
            orientation: squirmer.orientation,
        }
    };
    scene.state.squirmers.iter().enumerate().map(body).collect()
}

/// The shortest image of a vector.
fn nearest(domain: &Domain, vector: DVec3) -> DVec3 {
    let mut shortest = vector;
    for axis in 0..3 {
        if axis != 1 || domain.walls.is_none() {
            let length = f64::from(domain.size[axis]);
            shortest[axis] -= length * (vector[axis] / length).round();
        }
    }
    shortest
}

impl Body {
    /// Centre and orientation at a fraction of the step.
    fn pose(&self, fraction: f64) -> (DVec3, DQuat) {
        let orientation = self.start.orientation.slerp(self.orientation, fraction);
        (self.start.position + fraction * self.displacement, orientation)
    }

    /// A vector from the centre in body axes, each in units of its semi-axis: the surface is the unit sphere.
    fn scaled(&self, orientation: DQuat, from_centre: DVec3) -> DVec3 {
        (orientation.inverse() * from_centre) / self.axes
    }

    /// The outward normal at the surface point `arm` from the centre, lab frame.
    fn normal(&self, orientation: DQuat, arm: DVec3) -> DVec3 {
        orientation * (self.scaled(orientation, arm) / self.axes).normalize()
    }

    /// Velocity of the surface at `arm` from the centre: V + Omega x s + u_sq(s).
    fn surface_velocity(&self, orientation: DQuat, arm: DVec3) -> DVec3 {
        let shape = Spheroid { along: self.axes.z, across: self.axes.x };
        let slip = orientation * self.slip.at(shape, orientation.inverse() * arm);
        self.start.drift + self.start.spin.cross(arm) + slip
    }
}

/// What a particle meets next.
#[derive(Clone, Copy)]
enum Event {
    Wall(usize),
    /// A squirmer, and the arm from its centre at that moment.
    Surface(usize, DVec3),
}

/// One particle on its way through the step.
struct Flight<'a> {
    domain: &'a Domain,
    bodies: &'a [Body],
    particle: Particle,
    /// Whether a squirmer changed the flight.
    met: bool,
    /// Per squirmer, from all particles.
    gained: &'a mut [Load],
}

impl Flight<'_> {
    /// Flies for `duration`, bouncing; returns the momentum handed to the walls.
    fn follow(&mut self, duration: f64, max_hits: u32) -> [DVec3; 2] {
        let mut handed = [DVec3::ZERO; 2];
        let mut time = 0.0;
        self.leave(0.0, 1.0);
        for _ in 0..max_hits {
            let Some((wait, event)) = self.next_event(time, duration) else {
                self.particle.position += self.particle.velocity * (duration - time);
                break;
            };
            time += wait;
            match event {
                Event::Wall(wall) => {
                    self.particle.position += self.particle.velocity * wait;
                    handed[wall] += bounce(self.domain, wall, &mut self.particle);
                }
                Event::Surface(body, arm) => self.hit(body, arm, time / duration),
            }
        }
        self.leave(1.0, 1.0 + 1e-5);
        handed
    }

    /// From the centre of a body at a fraction of the step to the particle.
    fn arm(&self, body: &Body, fraction: f64) -> DVec3 {
        nearest(self.domain, self.particle.position - body.pose(fraction).0)
    }

    /// Puts a particle that is inside a squirmer onto its surface, scaled by `scale`.
    fn leave(&mut self, fraction: f64, scale: f64) {
        for body in self.bodies {
            let (_, orientation) = body.pose(fraction);
            let from_centre = self.arm(body, fraction);
            let depth = body.scaled(orientation, from_centre).length();
            if depth < 1.0 {
                self.met = true;
                self.particle.position += from_centre * (scale / depth - 1.0);
            }
        }
    }

    /// The earliest bounce between `time` and `duration`, and the wait for it.
    fn next_event(&self, time: f64, duration: f64) -> Option<(f64, Event)> {
        let rest = duration - time;
        let wall = next_wall(self.domain, &self.particle, rest).map(|(wait, wall)| (wait, Event::Wall(wall)));
        let surfaces = self.bodies.iter().enumerate().filter_map(|(i, body)| {
            let (share, arm) = self.contact(body, time / duration, rest)?;
            Some((share * rest, Event::Surface(i, arm)))
        });
        wall.into_iter().chain(surfaces).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Where the straight flight of the time `rest` in the body's frame first meets the surface: the share of the flight
    /// done by then, and the arm from the centre, lab frame. Solves |p + lambda d| = 1 for the entry.
    fn contact(&self, body: &Body, fraction: f64, rest: f64) -> Option<(f64, DVec3)> {
        let (_, orientation) = body.pose(fraction);
        let from = self.arm(body, fraction);
        let to = from + self.particle.velocity * rest - (1.0 - fraction) * body.displacement;
        let p = body.scaled(orientation, from);
        let d = body.scaled(body.orientation, to) - p;
        let c = p.length_squared() - 1.0;
        if c < 0.0 {
            let arm = from / p.length();
            let approach = self.particle.velocity - body.surface_velocity(orientation, arm);
            return (approach.dot(body.normal(orientation, arm)) < 0.0).then_some((0.0, arm));
        }
        let (a, b) = (d.length_squared(), p.dot(d));
        let discriminant = b * b - a * c;
        if b >= 0.0 || discriminant <= 0.0 {
            return None;
        }
        let share = c / (-b + discriminant.sqrt());
        if share >= 1.0 {
            return None;
        }
        let (_, there) = body.pose(fraction + share * (1.0 - fraction));
        Some((share, there * ((p + share * d) * body.axes)))
    }

    /// Bounces off a body at a fraction of the step: v' = -v + 2 u, u the surface's velocity.
    fn hit(&mut self, index: usize, arm: DVec3, fraction: f64) {
        let body = &self.bodies[index];
        let (centre, orientation) = body.pose(fraction);
        let old = self.particle.velocity;
        // The image of the centre that is nearest to the particle.
        let image = self.particle.position - centre - nearest(self.domain, self.particle.position - centre);
        self.particle.position = centre + image + arm;
        self.particle.velocity = -old + 2.0 * body.surface_velocity(orientation, arm);
        let impulse = old - self.particle.velocity;
        self.gained[index].force += impulse;
        self.gained[index].torque += arm.cross(impulse);
        self.met = true;
    }
}
