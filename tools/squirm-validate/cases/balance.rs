//! The balance of momentum, force and torque with free squirmers.

use crate::case::{Case, Control, Outcome, Part, Row, Size, Trouble};
use crate::measure::{Fluid, wall_impulses};
use crate::rig::{Planned, Rig, advance, sound};
use crate::rules::viscosity;
use crate::swimmer::{Swimmer, settling, squirmers};
use glam::DVec3;
use squirm::gpu::Session;
use squirm::math::mobility::Friction;
use squirm::state::start::nearest_image;

/// The case.
pub const CASE: Case = Case {
    name: "balance",
    title: "Balance of momentum, force and torque",
    about: "A crowd of pullers, pushers and oblate neutral squirmers swims, meets and bounces, in a periodic box and in a slit whose walls' \
            momentum is booked. The momentum of everything stays what it was; what is left are roundings, which grow with the root of the number \
            of collisions. No fluid particle is ever inside a body. A single free squirmer is free of force and torque on average: the force \
            that is recorded in each of many successive steps is the change of its momentum in that step, so that its mean over the \
            time T is of order sqrt(M)/T, and the mean is given in units of the friction at the swim speed.",
    remarks: "",
    sheets: &[],
    parts,
    controls: &[
        Control {
            name: "held",
            about: "squirmers do not take up what the fluid gives them",
            part: "periodic",
            spoil: |plan| plan.system.species.iter_mut().for_each(|s| s.held = true),
        },
        Control {
            name: "no-hits",
            about: "particles fly through squirmers",
            part: "periodic",
            spoil: |plan| plan.stages.retain(|s| s.entry.kind != "squirmer-collide"),
        },
    ],
};

fn parts(size: Size) -> Vec<Part> {
    let crowd = |name: &'static str, pipeline: &'static str| {
        Part::new(name, move |rig| {
            let sets = match rig.size {
                Size::Quick => vec!["box.size=[14,12,14]".to_owned(), "squirmers.puller.count=4".to_owned()]
                    .into_iter()
                    .chain(["squirmers.pusher.count=3", "squirmers.disc.count=2"].map(str::to_owned))
                    .collect(),
                Size::Full => vec!["box.size=[48,24,48]".to_owned(), "squirmers.puller.count=96".to_owned()]
                    .into_iter()
                    .chain(["squirmers.pusher.count=64", "squirmers.disc.count=40"].map(str::to_owned))
                    .collect::<Vec<_>>(),
            };
            conserved(rig, name, &rig.plan(pipeline, &sets)?)
        })
    };
    let mut out = vec![crowd("periodic", "balance"), Part::new("free", free)];
    if size == Size::Full {
        out.push(crowd("slit", "balance-slit"));
    }
    out
}

/// Momentum of fluid, squirmers and walls.
fn momentum(planned: &Planned, session: &Session, fluid: &Fluid) -> Result<DVec3, Trouble> {
    let bodies = squirmers(session)?;
    let mass = |species: usize| f64::from(planned.system.species[species].ghosts(&planned.system.fluid));
    let swimming: DVec3 = bodies.iter().map(|s| mass(s.species) * s.velocity).sum();
    let walls = match planned.system.domain.walls {
        Some(_) => wall_impulses(session)?.iter().sum(),
        None => DVec3::ZERO,
    };
    Ok(fluid.momentum() + swimming + walls)
}

/// Particles inside a body, by more than the rounding of single precision.
fn trapped(planned: &Planned, session: &Session, fluid: &Fluid) -> Result<usize, Trouble> {
    let system = &planned.system;
    let bodies: Vec<_> = squirmers(session)?
        .into_iter()
        .map(|s| {
            let shape = system.species[s.species].spheroid();
            (s.position, s.orientation.inverse(), shape.radius(), DVec3::new(shape.across, shape.across, shape.along))
        })
        .collect();
    let inside = |r: DVec3| {
        bodies.iter().any(|(centre, back, radius, axes)| {
            let arm = nearest_image(&system.domain, r - *centre);
            arm.length_squared() < radius * radius && ((*back * arm) / *axes).length_squared() < 1.0 - 1e-5
        })
    };
    let places: Vec<DVec3> = fluid.particles().map(|(r, _)| r).collect();
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(16);
    Ok(std::thread::scope(|scope| {
        let count = |part: &[DVec3]| part.iter().filter(|r| inside(**r)).count();
        let chunks = places.chunks(places.len().div_ceil(threads).max(1));
        let workers: Vec<_> = chunks.map(|part| scope.spawn(move || count(part))).collect();
        workers.into_iter().filter_map(|w| w.join().ok()).sum()
    }))
}

fn conserved(rig: &Rig, name: &str, planned: &Planned) -> Result<Outcome, Trouble> {
    let state = rig.start(planned)?;
    let mut session = rig.session(planned, &state)?;
    let before = momentum(planned, &session, &Fluid::of(&session)?)?;
    let steps = rig.pick(200, 6000);
    let (mut most, mut inside) = (0.0f64, 0);
    for _ in 0..10 {
        advance(&mut session, steps / 10)?;
        let fluid = Fluid::of(&session)?;
        most = most.max((momentum(planned, &session, &fluid)? - before).length() / fluid.len() as f64);
        inside += trapped(planned, &session, &fluid)?;
    }
    sound(&session)?;
    let share = 1.0 - planned.system.fluid_volume() / planned.system.domain.volume();
    let count = planned.system.squirmer_count();
    let row = |quantity: &str, measured: f64, tolerance: f64, source: &str| Row {
        quantity: quantity.into(),
        setup: format!("{name}: {count} squirmers, {:.0} % of the volume, {steps} steps", 100.0 * share),
        measured,
        error: 0.0,
        expected: Some(0.0),
        tolerance,
        source: source.into(),
        note: String::new(),
    };
    let rows = vec![
        row("largest change of momentum per fluid particle", most, 1e-6, "action and reaction"),
        row("fluid particles inside bodies, ten frames", inside as f64, 0.5, "impermeable bodies"),
    ];
    Ok(Outcome { rows, curves: Vec::new() })
}

/// Mean force and torque on a free squirmer from the record of every step.
fn free(rig: &Rig) -> Result<Outcome, Trouble> {
    let swimmer = Swimmer {
        across: 2.0,
        along: 4.0,
        b1: 0.1,
        beta: 3.0,
        edge: rig.pick(12, 16),
        density: 10,
        dt: 0.05,
        temperature: 1.0,
        seed: 1,
    };
    let planned = rig.plan("swimming", &swimmer.sets())?;
    let system = &planned.system;
    let state = rig.start(&planned)?;
    let mut session = rig.session(&planned, &state)?;
    advance(&mut session, settling(system))?;
    let mass = f64::from(system.species[0].ghosts(&system.fluid));
    let steps = rig.pick(200u32, 12_000);
    let first = squirmers(&session)?[0];
    let (mut force, mut torque) = (DVec3::ZERO, DVec3::ZERO);
    for _ in 0..steps {
        session.advance(1, false);
        let load = session.read::<f32>("fluid_force")?;
        let at = |k: usize| DVec3::new(load[k].into(), load[k + 1].into(), load[k + 2].into());
        force += at(0);
        torque += at(4);
    }
    sound(&session)?;
    let last = squirmers(&session)?[0];
    let time = f64::from(steps) * system.run.dt;
    let friction = Friction::of(swimmer.shape());
    let units =
        [friction.along * viscosity(system) * swimmer.speed(), friction.tumble * viscosity(system) * swimmer.b1 / 4.0];
    let gained = [mass * (last.velocity - first.velocity), last.angular_momentum - first.angular_momentum];
    // What a free body gains in a long time is the difference of two independent thermal momenta.
    let (_, across) = swimmer.shape().inertia(mass);
    let scatter = [(2.0 * mass).sqrt(), (2.0 * across).sqrt()];
    let mut rows = Vec::new();
    let sums = [("force", force, "zeta eta U_L"), ("torque", torque, "zeta_R eta B1/b")];
    for (k, (name, sum, unit)) in sums.into_iter().enumerate() {
        let row = |quantity: String, measured: f64, error: f64, expected: f64, tolerance: f64| Row {
            quantity,
            setup: format!("free: {}, {steps} steps", swimmer.name()),
            measured,
            error,
            expected: Some(expected),
            tolerance,
            source: "free body".into(),
            note: String::new(),
        };
        let mean = sum / f64::from(steps);
        let largest = mean.abs().max_element() / units[k];
        rows.push(row(
            format!("mean {name} / ({unit}), largest component"),
            largest,
            scatter[k] / time / units[k],
            0.0,
            rig.pick(0.3, 0.05),
        ));
        let left = (sum * system.run.dt - gained[k]).length() / scatter[k];
        rows.push(row(format!("recorded {name} x time, less what was gained, / thermal"), left, 0.0, 0.0, 0.01));
    }
    Ok(Outcome { rows, curves: Vec::new() })
}
