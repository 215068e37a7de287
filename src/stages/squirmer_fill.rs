//! squirmer-fill: virtual particles inside the squirmers, through which they take part in the collision.

use super::{Finding, Fused, Gravity, Phase, Stage};
use crate::buffers::Extent;
use crate::math::draws::{direction, normals};
use crate::math::linear::pseudo_inverse;
use crate::math::rng::{Draw, Purpose, seven};
use crate::state::scene::{Load, Scene, outer};
use crate::state::{Species, Squirmer, System};
use crate::{params, shared};
use glam::{DMat3, DVec3};

params! {
    /// Fills the squirmers with virtual particles of the fluid's density, new in each step, that move with the body, carry
    /// its slip velocity and have the fluid's temperature (Goetze, Noguchi, Gompper, Phys. Rev. E 76, 046705, 2007; Theers,
    /// Westphal, Gompper, Winkler, Soft Matter 12, 7372, 2016). They collide with the fluid in the cells that both share;
    /// the momentum and angular momentum that they gain go to the squirmer.
    pub struct SquirmerFill {
        /// published: thermal velocities as they are drawn, which leaves a squirmer a few per cent too hot. equipartition:
        /// the rigid motion of all ghosts of a squirmer is taken out of their thermal velocities, so that the body and its
        /// ghosts together are a sample at the fluid's temperature.
        pub ghosts: String = "equipartition"; "", Choice(&["equipartition", "published"]);
        /// continued: ghosts move as the squirmer's own flow, continued from the surface to where they are, so that they do not drag
        /// on it. constant: they carry the slip of the surface point in their direction from the centre, as published, which
        /// costs some per cent of the swim speed and more of the stresslet.
        pub slip: String = "continued"; "", Choice(&["continued", "constant"]);
    }
}

shared! {
    /// Which ghosts.
    pub struct SquirmerFillSettings {
        /// 1 if the thermal velocities have no rigid part.
        equipartition: u32,
        /// 1 if the slip is continued into the body as the flow outside goes on.
        continued: u32,
    }
}

impl Stage for SquirmerFill {
    const KIND: &'static str = "squirmer-fill";
    const WGSL: &'static str = include_str!("../../shaders/stages/squirmer-fill.wgsl");
    const PHASES: &'static [Phase] = &[
        Phase { entry: "clear_sums", over: Extent::Squirmers },
        Phase { entry: "draw", over: Extent::SquirmerGhosts },
        Phase { entry: "prepare", over: Extent::Squirmers },
        Phase { entry: "fill", over: Extent::SquirmerGhosts },
    ];
    const RECEIVE: &'static [Phase] =
        &[Phase { entry: "receive", over: Extent::SquirmerGhosts }, Phase { entry: "absorb", over: Extent::Squirmers }];
    const FUSED: Option<Fused> = Some(Fused {
        wgsl: &[include_str!("../../shaders/fused/squirmer-fill.wgsl")],
        ahead: &[],
        instead: &[(
            "fill",
            &[Phase { entry: "tally", over: Extent::SquirmerGhosts }, Phase { entry: "gather", over: Extent::Cells }],
        )],
    });
    const BRICKED: Option<Fused> = Some(Fused {
        wgsl: &[
            include_str!("../../shaders/fused/squirmer-fill-kept.wgsl"),
            include_str!("../../shaders/fused/squirmer-fill-bricked.wgsl"),
        ],
        ahead: &[],
        instead: &[
            ("draw", &[Phase { entry: "draw", over: Extent::SquirmerGhosts }]),
            ("fill", &[Phase { entry: "enter", over: Extent::SquirmerGhosts }]),
            ("receive", &[Phase { entry: "receive", over: Extent::SquirmerGhosts }]),
        ],
    });
    const SHARED: &'static [&'static str] = &["gather"];
    const OWN: &'static [&'static str] = &["prepare", "absorb"];
    const AFTER: &'static [&'static str] = &["cell-reduce", "squirmer-collide", "wall-ghosts"];
    type Params = Self;
    type Uniform = SquirmerFillSettings;

    fn check(params: &Self, system: &System) -> Vec<Finding> {
        let few = |s: &&Species| params.ghosts == "equipartition" && s.ghosts(&system.fluid) < 10;
        let finding = |s: &Species| Finding {
            gravity: Gravity::Warning,
            field: "ghosts",
            message: format!("species `{}` has only {} ghosts per squirmer", s.name, s.ghosts(&system.fluid)),
            help: "take larger squirmers or a denser fluid, or `ghosts = \"published\"`".into(),
        };
        system.species.iter().filter(few).map(finding).collect()
    }

    fn uniform(params: &Self, _: &System) -> SquirmerFillSettings {
        SquirmerFillSettings {
            equipartition: (params.ghosts == "equipartition").into(),
            continued: (params.slip == "continued").into(),
        }
    }

    fn reference(params: &Self, system: &System, scene: &mut Scene) {
        scene.ghost_motion.clear();
        for owner in 0..scene.state.squirmers.len() {
            let ghosts = ghosts(params, system, scene, owner);
            let squirmer = &scene.state.squirmers[owner];
            let (mut linear, mut angular) = (squirmer.velocity, spin(system, squirmer));
            if params.ghosts == "equipartition" {
                // The rigid motion of the thermal velocities, written as a velocity at the squirmer's centre.
                let (mean, turning, centre) = rigid_part(&ghosts);
                linear -= mean - turning.cross(centre);
                angular -= turning;
            }
            scene.ghost_motion.push((linear, angular));
            for ghost in ghosts {
                let (cell, offset) = scene.locate(system, squirmer_position(scene, owner) + ghost.arm);
                if may_meet(system, scene, owner, ghost.arm - offset) {
                    scene.moments[cell].add_ghost(offset, ghost.velocity(linear, angular));
                }
            }
        }
    }

    fn reference_receive(params: &Self, system: &System, scene: &mut Scene) {
        scene.loads.resize(scene.state.squirmers.len(), Load::default());
        for owner in 0..scene.state.squirmers.len() {
            let (linear, angular) = scene.ghost_motion[owner];
            let mut gained = Load::default();
            for ghost in ghosts(params, system, scene, owner) {
                let before = ghost.velocity(linear, angular);
                let (cell, offset) = scene.locate(system, squirmer_position(scene, owner) + ghost.arm);
                if !may_meet(system, scene, owner, ghost.arm - offset) {
                    continue;
                }
                let impulse = scene.operators[cell].apply(offset, before) - before;
                gained.force += impulse;
                gained.torque += ghost.arm.cross(impulse);
            }
            absorb(system, scene, owner, gained);
        }
    }
}

impl SquirmerFill {
    /// All ghosts of a squirmer in the step that the reference has filled it for, those that meet nothing, too: where they are, seen from its
    /// centre, and their velocities.
    #[must_use]
    pub fn drawn(&self, system: &System, scene: &Scene, owner: usize) -> Vec<(DVec3, DVec3)> {
        let (linear, angular) = scene.ghost_motion[owner];
        ghosts(self, system, scene, owner).iter().map(|g| (g.arm, g.velocity(linear, angular))).collect()
    }
}

/// One virtual particle, seen from its squirmer's centre.
struct Ghost {
    arm: DVec3,
    slip: DVec3,
    thermal: DVec3,
}

impl Ghost {
    fn velocity(&self, linear: DVec3, angular: DVec3) -> DVec3 {
        linear + angular.cross(self.arm) + self.slip + self.thermal
    }
}

/// The ghosts of one squirmer in this step: points of the unit ball, stretched to the hull and turned with the body.
fn ghosts(params: &SquirmerFill, system: &System, scene: &Scene, owner: usize) -> Vec<Ghost> {
    let squirmer = &scene.state.squirmers[owner];
    let species = &system.species[squirmer.species];
    let shape = species.hull();
    let stretch = DVec3::new(shape.across, shape.across, shape.along);
    let slip = species.hull_slip();
    let draw = Draw::new(system.run.seed, Purpose::SquirmerGhost, scene.state.step);
    let owner = u32::try_from(owner).expect("squirmers are counted in u32");
    let ghost = |index| {
        let (u, motion) = seven(draw.words(owner, index, 0));
        let on_surface = stretch * direction(u[0], u[1]);
        let arm = u[2].cbrt() * on_surface;
        let slip = if params.slip == "continued" { slip.inside(shape, arm) } else { slip.at(shape, on_surface) };
        Ghost {
            arm: squirmer.orientation * arm,
            slip: squirmer.orientation * slip,
            thermal: system.fluid.temperature.sqrt() * normals(motion),
        }
    };
    (0..species.ghosts(&system.fluid)).map(ghost).collect()
}

/// Whether anything but a squirmer's own ghosts can be in a cell with its centre so far from the squirmer's: not if all of the cell lies inside the hull.
/// Collisions there change neither momentum nor angular momentum. A cell at c in units of the semi-axes b, with half diagonals h, has
/// |c + h|^2 <= |c|^2 + 2 c.h + 3/(4 b_min^2).
fn may_meet(system: &System, scene: &Scene, owner: usize, centre: DVec3) -> bool {
    let squirmer = &scene.state.squirmers[owner];
    let shape = system.species[squirmer.species].hull();
    let axes = DVec3::new(shape.across, shape.across, shape.along);
    let c = (squirmer.orientation.inverse() * centre) / axes;
    let corner = (squirmer.orientation * (c / axes)).abs().element_sum();
    c.length_squared() + corner + 0.75 / axes.min_element().powi(2) > 1.0
}

/// The rigid motion contained in the thermal velocities: mean velocity, angular velocity, centre of mass.
fn rigid_part(ghosts: &[Ghost]) -> (DVec3, DVec3, DVec3) {
    let count = ghosts.len() as f64;
    let centre = ghosts.iter().map(|g| g.arm).sum::<DVec3>() / count;
    let mean = ghosts.iter().map(|g| g.thermal).sum::<DVec3>() / count;
    let mut inertia = DMat3::ZERO;
    let mut angular_momentum = DVec3::ZERO;
    for ghost in ghosts {
        let arm = ghost.arm - centre;
        inertia += arm.length_squared() * DMat3::IDENTITY - outer(arm, arm);
        angular_momentum += arm.cross(ghost.thermal - mean);
    }
    (mean, pseudo_inverse(inertia) * angular_momentum, centre)
}

fn squirmer_position(scene: &Scene, owner: usize) -> DVec3 {
    scene.state.squirmers[owner].position
}

/// The angular velocity: the body is a homogeneous spheroid of its ghosts' mass.
pub(super) fn spin(system: &System, squirmer: &Squirmer) -> DVec3 {
    let species = &system.species[squirmer.species];
    let mass = f64::from(species.ghosts(&system.fluid));
    let (about_axis, about_others) = species.hull().inertia(mass);
    let axis = squirmer.axis();
    let along = axis * axis.dot(squirmer.angular_momentum);
    along / about_axis + (squirmer.angular_momentum - along) / about_others
}

/// Hands momentum and angular momentum to a squirmer and records them; a held one stays as it is.
pub(super) fn absorb(system: &System, scene: &mut Scene, owner: usize, gained: Load) {
    let squirmer = &mut scene.state.squirmers[owner];
    let species = &system.species[squirmer.species];
    if !species.held {
        squirmer.velocity += gained.force / f64::from(species.ghosts(&system.fluid));
        squirmer.angular_momentum += gained.torque;
    }
    scene.loads[owner].force += gained.force;
    scene.loads[owner].torque += gained.torque;
}
