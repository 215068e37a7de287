//! Swim speeds against Stokes flow: shapes, active stress, box and Reynolds number.

use crate::case::{Case, Control, Curve, Outcome, Part, Row, Sheet, Size, Trouble};
use crate::rig::Rig;
use crate::rules::viscosity;
use crate::swimmer::{Swimmer, swim_speed, together};
use squirm::analyze::statistics::Estimate;

/// The case.
pub const CASE: Case = Case {
    name: "swimming",
    title: "Swim speed",
    about: "One squirmer in a periodic cube without total momentum swims at U_L = U0 - (2/3) B1 V/L^3, with U0 of Keller and Wu (1977) \
            and the backflow of its source dipole. The speed is that of displacements along the axis; diffusion leaves an error of \
            sqrt(2 D/T), D = kT/(zeta eta), after the time T. At a given speed U the number of steps for a given relative error goes as \
            1/(zeta eta h U^2), and eta h = 0.043 gamma depends on the density alone: a denser fluid is a quieter one. Its steps \
            cost nothing more as long as a GPU is not full, so the boxes have up to 50 particles per cell; in larger ones \
            density and cost balance. The viscous time step h = 0.02 makes Re = U b/nu small. What limits U: a neutral squirmer's \
            flow is irrotational and has no Stokes pressure, so that neither inertia nor compressibility matters and B1 may be 0.1. \
            For pushers and pullers Re must be small, and so must be the relative compression nu B2/(b kT). \
            Both shift pushers and pullers in opposite directions in the first order, so the mean of the two is what is held against U_L; half \
            their difference is reported, with beta Re and the compression. Inertia alone would make it -0.15 beta Re for spheres in \
            a large box (Wang and Ardekani 2012; Khair and Chisholm 2014; Re = gamma U0 R/eta).",
    remarks: "Pullers are faster and pushers slower at h = 0.02, the other way round at h = 0.1. Two effects explain \
              it: the fluid is a gas, whose density gives way to the flow's pressure by C = nu B2/(b kT), and inertia. \
              For 2 x 2 x 4 the half difference is 0.27(2) C - 0.035(4) beta Re, fitted to six runs \
              (chi^2 = 2.1 for 4 degrees of freedom): the one at half the temperature has twice the C at the same Re, \
              and is 0.035(9) larger; those at longer time steps have less C and more Re, and change the sign. Inertia \
              alone would give -0.15 beta Re for a sphere in a large box; here the box is four lengths wide. The mean \
              of both is U_L. Rows of single pushers and pullers miss where C is 0.2 or beta Re above 1.",
    sheets: &[
        Sheet {
            name: "swimming-shape",
            title: "Speed of neutral squirmers without backflow",
            x: "aspect b_z/b_x",
            y: "(<V.e> + (2/3) B1 V/L^3) / B1",
            logarithmic: false,
        },
        Sheet {
            name: "swimming-beta",
            title: "Speed of pushers and pullers",
            x: "beta",
            y: "<V.e> / U_L",
            logarithmic: false,
        },
        Sheet {
            name: "swimming-box",
            title: "Speed of a sphere of R = 4 in boxes",
            x: "L / a",
            y: "<V.e> / B1",
            logarithmic: false,
        },
    ],
    parts,
    controls: &[
        Control {
            name: "slip-reversed",
            about: "the slip velocity has the wrong sign",
            part: "shape-2x4",
            spoil: |plan| plan.system.species.iter_mut().for_each(|s| s.b1 = -s.b1),
        },
        Control {
            name: "no-ghosts",
            about: "squirmers hold no virtual particles",
            part: "shape-2x4",
            spoil: |plan| plan.stages.retain(|s| s.entry.kind != "squirmer-fill"),
        },
    ],
};

fn parts(size: Size) -> Vec<Part> {
    let neutral = |across, along, edge, density| Swimmer {
        across,
        along,
        b1: 0.1,
        beta: 0.0,
        edge,
        density,
        dt: 0.02,
        temperature: 1.0,
        seed: 1,
    };
    if size == Size::Quick {
        let prolate = Swimmer { b1: 0.25, ..neutral(2.0, 4.0, 12, 10) };
        return vec![shape_part(prolate, 1, 1200)];
    }
    // Across, along, edge, steps of each of three seeds for an error of 0.6 %.
    let shapes = [
        (4.0, 2.0, 20, 31_000),
        (3.0, 3.0, 16, 25_000),
        (2.5, 3.75, 16, 25_000),
        (2.0, 4.0, 16, 40_000),
        (3.0, 6.0, 24, 18_000),
        (2.0, 6.0, 24, 20_000),
    ];
    let mut out: Vec<Part> = shapes
        .into_iter()
        .map(|(across, along, edge, steps)| shape_part(neutral(across, along, edge, 50), 3, steps))
        .collect();
    let prolate = neutral(2.0, 4.0, 16, 50);
    for (beta, b1, steps) in [(1.0, 0.1, 15_000), (3.0, 0.05, 40_000), (5.0, 0.04, 60_000)] {
        out.push(pair_part(format!("beta-{beta}"), Swimmer { b1, beta, ..prolate }, steps));
    }
    // A longer time step has less viscosity: more inertia and less compression. A colder fluid has more compression alone.
    let strong = Swimmer { b1: 0.04, beta: 5.0, ..prolate };
    for (dt, steps) in [(0.05, 40_000), (0.1, 75_000)] {
        out.push(pair_part(format!("beta-5-{dt}"), Swimmer { dt, ..strong }, steps));
    }
    out.push(pair_part("beta-5-cold".into(), Swimmer { temperature: 0.5, ..strong }, 40_000));
    let sphere = neutral(4.0, 4.0, 16, 50);
    out.push(box_part(sphere, 30_000));
    out.push(box_part(Swimmer { edge: 24, ..sphere }, 36_000));
    out.push(box_part(Swimmer { edge: 48, density: 20, b1: 0.15, ..sphere }, 48_000));
    let sphere = neutral(3.0, 3.0, 16, 50);
    for (name, b1, steps) in [("slow", 0.05, 80_000), ("fast", 0.2, 20_000)] {
        let swimmer = Swimmer { b1, ..sphere };
        out.push(Part::new(format!("reynolds-neutral-{name}"), move |rig| {
            Ok(Outcome { rows: vec![plain(rig, &swimmer, measure(rig, swimmer, 1, steps)?)?], curves: Vec::new() })
        }));
    }
    for (name, b1, steps) in [("slow", 0.03, 70_000), ("fast", 0.1, 20_000)] {
        out.push(pair_part(format!("reynolds-{name}"), Swimmer { b1, beta: 3.0, ..sphere }, steps));
    }
    out
}

/// Speed in units of U_L, from runs that differ in their random numbers only.
fn measure(rig: &Rig, swimmer: Swimmer, seeds: u32, steps: u64) -> Result<Estimate, Trouble> {
    let mut found = Vec::new();
    for seed in 1..=seeds {
        let planned = rig.plan("swimming", &Swimmer { seed, ..swimmer }.sets())?;
        let speed = swim_speed(rig, &planned, steps)?;
        found.push(Estimate { mean: speed.mean / swimmer.speed(), error: speed.error / swimmer.speed() });
    }
    Ok(together(&found))
}

/// Re = gamma U0 b/eta with the semi-axis along.
fn reynolds(rig: &Rig, swimmer: &Swimmer) -> Result<f64, Trouble> {
    let system = rig.plan("swimming", &swimmer.sets())?.system;
    Ok(swimmer.shape().swim_speed(swimmer.b1) * swimmer.along * system.fluid.density / viscosity(&system))
}

/// A row that wants U_L.
fn plain(rig: &Rig, swimmer: &Swimmer, found: Estimate) -> Result<Row, Trouble> {
    Ok(Row {
        quantity: "<V.e> / U_L".into(),
        setup: format!("{}; Re = {:.2}", swimmer.name(), reynolds(rig, swimmer)?),
        measured: found.mean,
        error: found.error,
        expected: Some(1.0),
        tolerance: 0.03,
        source: "Keller and Wu 1977".into(),
        note: String::new(),
    })
}

fn shape_part(swimmer: Swimmer, seeds: u32, steps: u64) -> Part {
    Part::new(format!("shape-{}x{}", swimmer.across, swimmer.along), move |rig| {
        let found = measure(rig, swimmer, seeds, steps)?;
        let unit = swimmer.speed() / swimmer.b1;
        let backflow = swimmer.shape().swim_speed(1.0) - unit;
        let aspect = swimmer.along / swimmer.across;
        let guide = |i: i32| {
            let aspect = 0.4 + 0.05 * f64::from(i);
            (aspect, squirm::math::spheroid::Spheroid { along: aspect, across: 1.0 }.swim_speed(1.0))
        };
        // One of the parts brings the theory's line for all of them.
        let lead = aspect == 2.0 && swimmer.across == 2.0;
        let curve = Curve {
            sheet: "swimming-shape".into(),
            name: format!("{} x {}", swimmer.across, swimmer.along),
            points: vec![(aspect, found.mean * unit + backflow, found.error * unit)],
            guide: if lead { (0..=56).map(guide).collect() } else { Vec::new() },
            guide_name: if lead { "Keller and Wu".into() } else { String::new() },
        };
        Ok(Outcome { rows: vec![plain(rig, &swimmer, found)?], curves: vec![curve] })
    })
}

/// A squirmer and the one with the opposite active stress, two seeds of each.
fn pair_part(name: String, swimmer: Swimmer, steps: u64) -> Part {
    Part::new(name, move |rig| {
        let mirrored = Swimmer { beta: -swimmer.beta, ..swimmer };
        let (puller, pusher) = (measure(rig, swimmer, 2, steps)?, measure(rig, mirrored, 2, steps)?);
        let re = reynolds(rig, &swimmer)?;
        // nu = U0 b/Re, without thermal noise.
        let compression =
            swimmer.shape().swim_speed(swimmer.b1) * swimmer.beta * swimmer.b1 / (re * swimmer.temperature);
        let mut rows = Vec::new();
        for (one, found) in [(swimmer, puller), (mirrored, pusher)] {
            rows.push(Row { tolerance: 0.05, ..plain(rig, &one, found)? });
        }
        let mean = Estimate { mean: f64::midpoint(puller.mean, pusher.mean), ..together(&[puller, pusher]) };
        let setup = |row: Row| Row { setup: row.setup.replace("beta = ", "beta = +-"), ..row };
        rows.push(setup(Row { quantity: "mean of puller and pusher / U_L".into(), ..plain(rig, &swimmer, mean)? }));
        rows.push(setup(Row {
            quantity: "half of puller - pusher / U_L".into(),
            measured: 0.5 * (puller.mean - pusher.mean),
            expected: None,
            source: String::new(),
            note: format!("beta Re = {:.2}, compression nu B2/(b kT) = {compression:.3}", swimmer.beta * re),
            ..plain(rig, &swimmer, mean)?
        }));
        let points = vec![(-swimmer.beta, pusher.mean, pusher.error), (swimmer.beta, puller.mean, puller.error)];
        let range = 1.05 * swimmer.beta;
        let curve = Curve {
            sheet: "swimming-beta".into(),
            name: format!("{}: Re = {re:.2}", swimmer.name().replace(", beta = ", ", |beta| = ")),
            points,
            guide: vec![(-range, 1.0), (range, 1.0)],
            guide_name: "Keller and Wu".into(),
        };
        Ok(Outcome { rows, curves: vec![curve] })
    })
}

fn box_part(swimmer: Swimmer, steps: u64) -> Part {
    Part::new(format!("box-{}", swimmer.edge), move |rig| {
        let found = measure(rig, swimmer, 1, steps)?;
        let unit = swimmer.speed() / swimmer.b1;
        let lead = swimmer.edge == 16;
        let guide = |i: u32| (f64::from(i), Swimmer { edge: i, ..swimmer }.speed() / swimmer.b1);
        let curve = Curve {
            sheet: "swimming-box".into(),
            name: format!("L = {}, {} per cell", swimmer.edge, swimmer.density),
            points: vec![(f64::from(swimmer.edge), found.mean * unit, found.error * unit)],
            guide: if lead { (14..=50).map(guide).collect() } else { Vec::new() },
            guide_name: if lead { "U_L / B1".into() } else { String::new() },
        };
        Ok(Outcome { rows: vec![plain(rig, &swimmer, found)?], curves: vec![curve] })
    })
}
