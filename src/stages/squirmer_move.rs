//! squirmer-move: rigid-body motion of the squirmers and the steric forces among them and at walls.

use super::{Finding, Gravity, Phase, Stage};
use crate::buffers::Extent::{Binned, Bins, SquirmerParts, Squirmers};
use crate::buffers::Sizes;
use crate::math::rigid::Top;
use crate::math::steric::{self, Body, Repulsion};
use crate::state::scene::{Load, Motion, Scene};
use crate::state::start::{nearest_image, wrap};
use crate::state::{Squirmer, System};
use crate::{params, shared};
use glam::DVec3;

params! {
    /// Moves the squirmers through one step as rigid bodies: position Verlet for the centres, exact free rotation, and between
    /// the two halves of each substep the steric forces of neighbours and walls.
    pub struct SquirmerMove {
        /// Substeps of one collision step.
        pub substeps: u32 = 1u32; "", Integer { min: 1, max: 1000 };
        /// Length of the repulsion.
        pub sigma: f64 = steric::SIGMA; "a", Float { min: 0.01, max: 10.0 };
        /// Strength of the repulsion.
        pub epsilon: f64 = steric::EPSILON; "kT", Float { min: 0.0, max: 1000.0 };
        /// Added to both semi-axes for steric forces only, so that fluid fits between two bodies.
        pub safety: f64 = steric::SAFETY; "a", Float { min: 0.0, max: 10.0 };
        /// Largest force between two bodies; deeper overlaps feel no more.
        pub max_force: f64 = 1000.0; "kT/a", Float { min: 1.0, max: 1e6 };
    }
}

shared! {
    /// What the kernels of squirmer-move know of their parameters.
    pub struct SquirmerMoveSettings {
        /// Half a substep.
        half_step: f32,
        /// What one half substep counts in the step's means: 1/(2 substeps).
        share: f32,
        /// Added to both semi-axes.
        safety: f32,
        /// Length of the repulsion.
        sigma: f32,
        /// Strength of the repulsion.
        epsilon: f32,
        /// Distance from which on there is no force.
        cutoff: f32,
        /// Distance of centres from which on there is no force between any two squirmers.
        reach: f32,
        /// Largest force of one contact.
        max_force: f32,
        /// Largest torque of one contact.
        max_torque: f32,
        /// Scale of the fixed-point force: 64 contacts at the largest force fit.
        force_scale: f32,
        /// Scale of the fixed-point torque.
        torque_scale: f32,
        /// Invocations that share the partners of one squirmer.
        parts: u32,
    }
}

impl SquirmerMove {
    fn repulsion(&self) -> Repulsion {
        Repulsion { sigma: self.sigma, epsilon: self.epsilon, max_force: self.max_force }
    }

    fn radius(&self, system: &System) -> f64 {
        system.species.iter().map(|s| s.spheroid().radius() + self.safety).fold(0.0, f64::max)
    }

    /// Distance of centres from which on two squirmers of this system exert no force on each other.
    #[must_use]
    pub fn reach(&self, system: &System) -> f64 {
        2.0 * self.radius(system) + self.repulsion().cutoff()
    }
}

impl Stage for SquirmerMove {
    const KIND: &'static str = "squirmer-move";
    const WGSL: &'static str = include_str!("../../shaders/stages/squirmer-move.wgsl");
    const PHASES: &'static [Phase] = &[
        Phase { entry: "drift_first", over: Squirmers },
        Phase { entry: "clear_bins", over: Bins },
        Phase { entry: "fill_bins", over: Binned },
        Phase { entry: "force", over: SquirmerParts },
        Phase { entry: "kick_drift", over: Squirmers },
    ];
    const OWN: &'static [&'static str] = &["drift_first", "fill_bins", "kick_drift"];
    type Params = Self;
    type Uniform = SquirmerMoveSettings;

    fn repetitions(params: &Self) -> u32 {
        params.substeps
    }

    fn check(params: &Self, system: &System) -> Vec<Finding> {
        let mut findings = Vec::new();
        let mut warn = |field, message, help: &str| {
            findings.push(Finding { gravity: Gravity::Warning, field, message, help: help.into() });
        };
        let reach = params.reach(system);
        let periodic = [true, system.domain.walls.is_none(), true];
        let shortest =
            (0..3).filter(|a| periodic[*a]).map(|a| f64::from(system.domain.size[a])).fold(f64::MAX, f64::min);
        if !system.species.is_empty() && shortest < 2.0 * reach {
            warn(
                "",
                format!(
                    "squirmers feel only the nearest image of each other, but within the steric reach of {reach:.2} a \
                     a box of {shortest} a may hold two"
                ),
                "make the box longer, or the squirmers smaller",
            );
        }
        for species in system.species.iter().filter(|s| s.offset > params.safety) {
            warn(
                "safety",
                format!(
                    "the surface that the fluid meets lies {} a outside species `{}`, steric forces only {} a: two bodies may \
                     claim the same fluid",
                    species.offset, species.name, params.safety
                ),
                "raise `safety` to the species' `offset` at least",
            );
        }
        // Verlet is unstable from omega h = 2 on; at contact U'' is 456 epsilon/sigma^2, and the reduced mass is M/2.
        let lightest = system
            .species
            .iter()
            .filter(|s| !s.held)
            .map(|s| f64::from(s.ghosts(&system.fluid)))
            .fold(f64::MAX, f64::min);
        let stiffness = 456.0 * params.epsilon / params.sigma.powi(2);
        let substep = system.run.dt / f64::from(params.substeps);
        if substep * (2.0 * stiffness / lightest).sqrt() > 1.0 {
            warn(
                "substeps",
                format!("substeps of {substep:.3} tau are too long for contacts this stiff"),
                "raise `substeps`",
            );
        }
        findings
    }

    #[allow(clippy::cast_possible_truncation)]
    fn uniform(params: &Self, system: &System) -> SquirmerMoveSettings {
        let max_torque = 4.0 * params.max_force * params.radius(system).max(1.0);
        let scale = |limit: f64| (2f64.powi(31) / (64.0 * limit)).log2().floor().exp2() / 2.0;
        let substeps = f64::from(params.substeps);
        SquirmerMoveSettings {
            half_step: (0.5 * system.run.dt / substeps) as f32,
            share: (0.5 / substeps) as f32,
            safety: params.safety as f32,
            sigma: params.sigma as f32,
            epsilon: params.epsilon as f32,
            cutoff: params.repulsion().cutoff() as f32,
            reach: params.reach(system) as f32,
            max_force: params.max_force as f32,
            max_torque: max_torque as f32,
            force_scale: scale(params.max_force) as f32,
            torque_scale: scale(max_torque) as f32,
            parts: Sizes::parts(system.squirmer_count().into()) as u32,
        }
    }

    fn reference(params: &Self, system: &System, scene: &mut Scene) {
        let rest = |s: &Squirmer| Motion {
            position: s.position,
            orientation: s.orientation,
            drift: DVec3::ZERO,
            spin: DVec3::ZERO,
        };
        scene.motions = scene.state.squirmers.iter().map(rest).collect();
        let substeps = f64::from(params.substeps);
        let substep = system.run.dt / substeps;
        for _ in 0..params.substeps {
            drift(system, scene, 0.5 * substep, 0.5 / substeps);
            scene.steric = forces(params, system, &scene.state.squirmers);
            for (squirmer, load) in scene.state.squirmers.iter_mut().zip(&scene.steric) {
                let species = &system.species[squirmer.species];
                if !species.held {
                    squirmer.velocity += (load.force + DVec3::from_array(species.force)) * substep
                        / f64::from(species.ghosts(&system.fluid));
                    squirmer.angular_momentum += load.torque * substep;
                }
            }
            drift(system, scene, 0.5 * substep, 0.5 / substeps);
        }
    }
}

/// Free motion for the time `t`, which counts with the weight `share` in the step's mean velocities.
fn drift(system: &System, scene: &mut Scene, t: f64, share: f64) {
    for (squirmer, motion) in scene.state.squirmers.iter_mut().zip(&mut scene.motions) {
        let species = &system.species[squirmer.species];
        if species.held {
            continue;
        }
        let (along, across) = species.hull().inertia(f64::from(species.ghosts(&system.fluid)));
        let top = Top { along, across };
        // The middle of the turn stands for its mean: exact to second order in the angle.
        let middle = top.turn(squirmer.orientation, squirmer.angular_momentum, 0.5 * t);
        motion.drift += share * squirmer.velocity;
        motion.spin += share * top.angular_velocity(middle, squirmer.angular_momentum);
        squirmer.position = wrap(&system.domain, squirmer.position + squirmer.velocity * t);
        squirmer.orientation = top.turn(squirmer.orientation, squirmer.angular_momentum, t);
    }
}

/// Steric force and torque on every squirmer, by all pairs.
fn forces(params: &SquirmerMove, system: &System, squirmers: &[Squirmer]) -> Vec<Load> {
    let law = params.repulsion();
    let bodies: Vec<Body> = squirmers
        .iter()
        .map(|s| Body { shape: system.species[s.species].spheroid().grown(params.safety), axis: s.axis() })
        .collect();
    let mut loads = vec![Load::default(); squirmers.len()];
    let mut add = |i: usize, wrench: steric::Wrench| {
        loads[i].force += wrench.force;
        loads[i].torque += wrench.torque;
    };
    for i in 0..squirmers.len() {
        for j in i + 1..squirmers.len() {
            let r = nearest_image(&system.domain, squirmers[j].position - squirmers[i].position);
            if let Some([on_i, on_j]) = law.between(&bodies[i], &bodies[j], r) {
                add(i, on_i);
                add(j, on_j);
            }
        }
        if system.domain.walls.is_some() {
            let y = squirmers[i].position.y;
            let height = f64::from(system.domain.size[1]) - y;
            for wrench in [law.at_wall(&bodies[i], y, DVec3::Y), law.at_wall(&bodies[i], height, DVec3::NEG_Y)] {
                add(i, wrench.unwrap_or_default());
            }
        }
    }
    loads
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{Params, Values};
    use crate::state::start::start;
    use crate::state::{Domain, Fluid, Init, Run, SemiAxes, Species, Walls};

    fn system(walled: bool, species: Vec<Species>) -> System {
        let walls = walled.then(|| Walls::from_values(&Values::defaults(&Walls::fields())));
        System {
            run: Run { seed: 3, steps: 1, dt: 0.02, live: true },
            domain: Domain { size: [24, 16, 24], walls },
            fluid: Fluid { density: 2.0, temperature: 4.0, acceleration: [0.0; 3] },
            species,
            init: Init { from: None },
        }
    }

    fn species(count: u32, along: f64, across: f64) -> Species {
        Species {
            name: "swimmer".into(),
            count,
            semi_axes: SemiAxes { along, across },
            b1: 0.0,
            beta: 0.0,
            rotlet: 0.0,
            offset: 0.0,
            force: [0.0; 3],
            passive: true,
            held: false,
            start: "random".into(),
            poses: None,
        }
    }

    fn stage() -> SquirmerMove {
        SquirmerMove { max_force: 1e6, ..SquirmerMove::from_values(&Values::defaults(&SquirmerMove::fields())) }
    }

    fn scene(system: &System) -> Scene {
        Scene { state: start(system).expect("there is room"), ..Scene::default() }
    }

    fn mass(system: &System, s: &Squirmer) -> f64 {
        f64::from(system.species[s.species].ghosts(&system.fluid))
    }

    /// Kinetic energy of both motions and the steric potential.
    fn energy(params: &SquirmerMove, system: &System, squirmers: &[Squirmer]) -> f64 {
        let law = params.repulsion();
        let body =
            |s: &Squirmer| Body { shape: system.species[s.species].spheroid().grown(params.safety), axis: s.axis() };
        let mut sum = 0.0;
        for (i, s) in squirmers.iter().enumerate() {
            let (along, across) = system.species[s.species].hull().inertia(mass(system, s));
            sum += 0.5 * mass(system, s) * s.velocity.length_squared();
            sum += Top { along, across }.energy(s.orientation, s.angular_momentum);
            for other in &squirmers[i + 1..] {
                let r = nearest_image(&system.domain, other.position - s.position);
                sum += law.potential(steric::contact(&body(s), &body(other), r).expect("apart").gap);
            }
            if system.domain.walls.is_some() {
                let top = f64::from(system.domain.size[1]) - s.position.y;
                sum += law.potential(steric::wall_contact(&body(s), s.position.y, DVec3::Y).gap);
                sum += law.potential(steric::wall_contact(&body(s), top, DVec3::NEG_Y).gap);
            }
        }
        sum
    }

    #[test]
    fn a_crowd_keeps_its_energy_and_momentum() {
        for walled in [false, true] {
            let system = system(walled, vec![species(8, 3.0, 2.0), species(8, 1.5, 2.5)]);
            let (params, mut scene) = (stage(), scene(&system));
            let before = energy(&params, &system, &scene.state.squirmers);
            let momentum = |s: &Scene| s.state.squirmers.iter().map(|q| mass(&system, q) * q.velocity).sum::<DVec3>();
            let p = momentum(&scene);
            let mut touched = 0;
            for _ in 0..1000 {
                SquirmerMove::reference(&params, &system, &mut scene);
                touched += scene.steric.iter().filter(|l| l.force != DVec3::ZERO).count();
                let after = energy(&params, &system, &scene.state.squirmers);
                // Verlet keeps the energy to O((omega h)^2): contacts reach omega h = 0.3 here.
                assert!((after / before - 1.0).abs() < 0.03, "{before} {after}");
            }
            assert!(touched > 100, "{touched}");
            if !walled {
                assert!((momentum(&scene) - p).length() < 1e-9);
            }
        }
    }

    #[test]
    fn one_squirmer_flies_straight_and_its_means_are_its_motion() {
        let mut system = system(false, vec![species(1, 3.0, 1.5)]);
        system.run.dt = 0.5;
        let params = SquirmerMove { substeps: 3, ..stage() };
        let mut scene = scene(&system);
        let velocity = DVec3::new(1.0, -2.0, 40.0);
        let before = Squirmer { velocity, angular_momentum: DVec3::new(3.0, 1.0, 2.0), ..scene.state.squirmers[0] };
        scene.state.squirmers[0] = before;
        SquirmerMove::reference(&params, &system, &mut scene);
        let (after, motion) = (&scene.state.squirmers[0], &scene.motions[0]);
        let moved = nearest_image(&system.domain, after.position - before.position - 0.5 * velocity);
        assert!(moved.length() < 1e-12);
        assert_eq!((motion.position, motion.orientation), (before.position, before.orientation));
        assert!((motion.drift - velocity).length() < 1e-12);
        let turned = (after.orientation * before.orientation.inverse()).to_scaled_axis();
        // The mean angular velocity is the turn over the step up to the square of the angle.
        assert!((motion.spin * 0.5 - turned).length() < 0.1 * turned.length().powi(3), "{} {turned}", motion.spin);
        assert_eq!(after.angular_momentum, before.angular_momentum);
    }

    #[test]
    fn held_squirmers_stay_and_feel_their_neighbours() {
        let listed = |held, y| Species {
            held,
            start: "listed".into(),
            poses: Some(vec![[12.0, y, 12.0, 1.0, 0.0, 0.0]]),
            ..species(1, 3.0, 2.0)
        };
        let system = system(false, vec![listed(true, 4.0), listed(false, 8.5)]);
        let mut scene = scene(&system);
        let free = &mut scene.state.squirmers[1];
        (free.velocity, free.angular_momentum) = (DVec3::ZERO, DVec3::ZERO);
        let held = scene.state.squirmers[0];
        SquirmerMove::reference(&stage(), &system, &mut scene);
        assert_eq!(scene.state.squirmers[0], held);
        assert_eq!(scene.motions[0].drift, DVec3::ZERO);
        // Side by side at contact with the margin: the force is 24 epsilon/sigma along the line of centres.
        assert!((scene.steric[0].force - DVec3::new(0.0, -240.0, 0.0)).length() < 1e-6, "{:?}", scene.steric[0]);
        assert_eq!(scene.steric[0].force, -scene.steric[1].force);
        assert!(scene.state.squirmers[1].velocity.y > 0.0);
    }

    #[test]
    fn fixed_point_sums_hold_64_contacts_at_the_cap() {
        for max_force in [1.0, 200.0, 1000.0, 1e6] {
            let system = system(false, vec![species(1, 6.0, 3.0)]);
            let s = SquirmerMove::uniform(&SquirmerMove { max_force, ..stage() }, &system);
            for (scale, limit) in [(s.force_scale, s.max_force), (s.torque_scale, s.max_torque)] {
                let sum = 64.0 * 1.001 * f64::from(scale) * f64::from(limit);
                assert!(sum < 2f64.powi(31) && 8.0 * sum > 2f64.powi(31), "{sum}");
            }
        }
    }

    #[test]
    fn small_boxes_and_long_substeps_are_warned_of() {
        let fields =
            |system: &System| SquirmerMove::check(&stage(), system).iter().map(|f| f.field).collect::<Vec<_>>();
        let mut quiet = system(true, vec![species(1, 3.0, 2.0)]);
        assert_eq!(fields(&quiet), [""; 0]);
        quiet.species[0].semi_axes.along = 6.0;
        assert_eq!(fields(&quiet), [""]);
        quiet.domain.size = [60, 60, 60];
        quiet.run.dt = 0.5;
        assert_eq!(fields(&quiet), ["substeps"]);
    }
}
