//! The stages' f64 references against laws and hand-made answers: what the shaders are later compared with must be right.

mod cells;
mod flight;
mod ghosts;
mod wall_shear;

use glam::{DQuat, DVec3};
use squirm::math::draws::normals;
use squirm::math::rng::{Draw, Purpose};
use squirm::stages::apply::Apply;
use squirm::stages::cell_reduce::CellReduce;
use squirm::stages::shift_grid::ShiftGrid;
use squirm::stages::{self, Stage};
use squirm::state::scene::Scene;
use squirm::state::{Domain, Fluid, Init, Particle, Run, SemiAxes, Species, Squirmer, State, System, Walls};

/// A periodic box of still fluid without squirmers.
fn system(size: [u32; 3], dt: f64) -> System {
    System {
        run: Run { seed: 5, steps: 1, dt, live: true },
        domain: Domain { size, walls: None },
        fluid: Fluid { density: 10.0, temperature: 1.0, acceleration: [0.0; 3] },
        species: Vec::new(),
        init: Init { from: None },
    }
}

fn walls(condition: &str) -> Option<Walls> {
    Some(Walls {
        axis: "y".into(),
        condition: condition.into(),
        velocity_low: [0.2, 0.0, -0.1],
        velocity_high: [-0.3, 0.0, 0.4],
    })
}

fn species(along: f64, across: f64) -> Species {
    Species {
        name: "squirmer".into(),
        count: 1,
        semi_axes: SemiAxes { along, across },
        offset: 0.0,
        force: [0.0; 3],
        b1: 0.0,
        beta: 0.0,
        rotlet: 0.0,
        passive: false,
        held: false,
        start: "listed".into(),
        poses: None,
    }
}

fn squirmer(position: DVec3) -> Squirmer {
    Squirmer {
        species: 0,
        position,
        orientation: DQuat::IDENTITY,
        velocity: DVec3::ZERO,
        angular_momentum: DVec3::ZERO,
    }
}

/// Reproducible uniform and normal numbers: the i-th particle of set `set`.
fn random(set: u32, i: u32) -> (DVec3, DVec3) {
    let draw = Draw::new(99, Purpose::Start, 0);
    let u = draw.uniforms(set, i, 0);
    (DVec3::new(u[0], u[1], u[2]), normals(draw.uniforms(set, i, 1)))
}

/// `count` particles uniform in the box, of unit thermal speed.
fn gas(system: &System, set: u32, count: u32) -> Vec<Particle> {
    let size = DVec3::from_array(system.domain.size.map(f64::from));
    let particle = |i| {
        let (u, n) = random(set, i);
        Particle { position: u * size, velocity: n }
    };
    (0..count).map(particle).collect()
}

fn scene(particles: Vec<Particle>, squirmers: Vec<Squirmer>) -> Scene {
    Scene { state: State { step: 3, particles, squirmers }, ..Scene::default() }
}

/// The stages of one collision in their order, from the grid shift to what the ghosts receive.
fn collide(system: &System, scene: &mut Scene, stages: &[(&str, squirm::params::Values)]) {
    ShiftGrid::reference(&ShiftGrid {}, system, scene);
    CellReduce::reference(&CellReduce {}, system, scene);
    for (kind, values) in stages {
        let entry = stages::find(kind).expect("a stage of this kind");
        (entry.reference)(values, system, scene);
    }
    Apply::reference(&Apply {}, system, scene);
    for (kind, values) in stages {
        let entry = stages::find(kind).expect("a stage of this kind");
        (entry.reference_receive)(values, system, scene);
    }
}

fn momentum(particles: &[Particle]) -> DVec3 {
    particles.iter().map(|p| p.velocity).sum()
}

fn angular_momentum(particles: &[Particle]) -> DVec3 {
    particles.iter().map(|p| p.position.cross(p.velocity)).sum()
}

fn energy(particles: &[Particle]) -> f64 {
    particles.iter().map(|p| p.velocity.length_squared()).sum()
}

fn assert_near(found: DVec3, expected: DVec3, tolerance: f64) {
    assert!((found - expected).length() < tolerance, "{found} instead of {expected}");
}

/// What the stage of this kind, with its defaults, has to say of the system: the fields concerned.
fn findings(kind: &str, system: &System) -> Vec<&'static str> {
    let entry = stages::find(kind).expect("a stage of this kind");
    let values = squirm::params::Values::defaults(&(entry.fields)());
    (entry.check)(&values, system).into_iter().map(|f| f.field).collect()
}

#[test]
fn checks_warn_of_what_cannot_work_and_of_nothing_else() {
    let mut good = system([32, 32, 32], 0.02);
    good.domain.walls = walls("no-slip");
    good.species = vec![species(6.0, 3.0)];
    for entry in stages::REGISTRY {
        assert_eq!(findings(entry.kind, &good), [""; 0], "{}", entry.kind);
    }
    let mut thin = good.clone();
    thin.fluid.density = 1.0;
    assert_eq!(findings("restore-thermostat", &thin), [""]);
    thin.species = vec![species(1.0, 1.0)];
    assert_eq!(findings("squirmer-fill", &thin), ["ghosts"]);
    let mut slippery = good.clone();
    slippery.domain.walls = walls("slip");
    assert_eq!(findings("wall-ghosts", &slippery), [""]);
    let mut hasty = good;
    hasty.run.dt = 2.0;
    assert_eq!(findings("stream", &hasty), [""]);
    assert_eq!(findings("squirmer-collide", &hasty), [""]);
}
