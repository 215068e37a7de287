//! The flow of a rotlet dipole on a sphere.

use crate::case::{Case, Control, Curve, Outcome, Part, Row, Sheet, Size, Trouble};
use crate::flow_map::{Bin, FlowMap, Kept, Watched, watch};
use crate::rig::Rig;
use crate::swimmer::Swimmer;
use squirm::analyze::statistics::{blocked, jackknife};

/// The case.
pub const CASE: Case = Case {
    name: "rotlet",
    title: "Rotlet dipole",
    about: "A sphere whose halves turn against each other, slip C2 sin(th) cos(th) about the axis (after the counter-rotation of \
            bacteria, Qi et al. 2022), drags the fluid with u_phi = C2 (R/r)^3 sin(th) cos(th), the azimuthal Stokes flow of that \
            symmetry, and neither swims nor spins. The flow is averaged over bins that go with the body; the amplitude is that of \
            the theory's flow in the measured one up to L/3, where the images add less than 1 %.",
    remarks: "",
    sheets: &[Sheet {
        name: "rotlet",
        title: "Azimuthal flow of a rotlet dipole at 45 degrees from the axis",
        x: "r / R",
        y: "u_phi / C2",
        logarithmic: false,
    }],
    parts,
    controls: &[Control {
        name: "turned-the-other-way",
        about: "the rotlet dipole has the wrong sign",
        part: "sphere",
        spoil: |plan| plan.system.species.iter_mut().for_each(|s| s.rotlet = -s.rotlet),
    }],
};

fn parts(size: Size) -> Vec<Part> {
    let sphere = Swimmer {
        across: 3.0,
        along: 3.0,
        b1: 0.0,
        beta: 0.0,
        edge: 24,
        density: 20,
        dt: 0.02,
        temperature: 1.0,
        seed: 1,
    };
    let (sphere, rotlet, frames, every) = match size {
        Size::Quick => (Swimmer { across: 2.0, along: 2.0, edge: 10, density: 10, ..sphere }, 0.6, 100, 10),
        Size::Full => (sphere, 0.3, 2500, 20),
    };
    vec![Part::new("sphere", move |rig| measure(rig, &sphere, rotlet, (frames, every)))]
}

/// sin(th) cos(th) (R/r)^3, averaged over a bin.
fn profile(bin: &Bin, radius: f64) -> f64 {
    bin.mean(|rho, z| glam::DVec3::splat(rho * z * radius.powi(3) / rho.hypot(z).powi(5))).x
}

/// C2 as the bins between two distances have it.
fn strength(map: &FlowMap, bins: &[Bin], radius: f64, kept: &Kept<'_>) -> f64 {
    let (mut product, mut square) = (0.0, 0.0);
    for bin in bins {
        let (found, theory) = (map.found(bin, kept), profile(bin, radius));
        product += found.count * found.flow.y * theory;
        square += found.count * theory * theory;
    }
    product / square
}

fn measure(rig: &Rig, sphere: &Swimmer, rotlet: f64, (frames, every): (usize, u64)) -> Result<Outcome, Trouble> {
    let mut sets = sphere.sets();
    sets.push(format!("squirmers.swimmer.rotlet={rotlet:?}"));
    let planned = rig.plan("rotlet", &sets)?;
    let Watched { map, spins, .. } = watch(rig, &planned, frames, every)?;
    let (radius, shape) = (sphere.across, sphere.shape());
    let estimate = |bins: &[Bin]| {
        let f = |kept: &Kept<'_>| strength(&map, bins, radius, kept) / rotlet;
        (f(&|_| true), jackknife(map.stretches(), map.stretches(), f))
    };
    let outer = f64::from(sphere.edge) / rig.pick(2.3, 3.0);
    let row = |quantity: &str, (measured, error): (f64, f64), expected: f64, tolerance: f64| Row {
        quantity: quantity.into(),
        setup: format!("sphere, R = {radius}, C2 = {rotlet}, L = {}, {} per cell", sphere.edge, sphere.density),
        measured,
        error,
        expected: Some(expected),
        tolerance,
        source: "azimuthal Stokes flow".into(),
        note: String::new(),
    };
    let spin = blocked(&spins);
    let unit = rotlet / radius;
    let rows = vec![
        // The small body of a quick run is four cells across.
        row("amplitude of u_phi / C2", estimate(&map.bins(shape, |r| r < outer)), 1.0, rig.pick(0.2, 0.1)),
        row("spin / (C2/R)", (spin.mean / unit, spin.error / unit), 0.0, rig.pick(0.1, 0.02)),
    ];
    let mut points = Vec::new();
    let mut inner = radius;
    while inner + 1.0 <= outer {
        let shell = map.bins(shape, |r| (inner..inner + 1.0).contains(&r));
        let (found, error) = estimate(&shell);
        let r = (inner + 0.5) / radius;
        points.push((r, 0.5 * found / r.powi(3), 0.5 * error / r.powi(3)));
        inner += 1.0;
    }
    let guide = (0..=50).map(|i| 1.0 + f64::from(i) * (outer / radius - 1.0) / 50.0).map(|r| (r, 0.5 / r.powi(3)));
    let curve = Curve {
        sheet: "rotlet".into(),
        name: format!("R = {radius}"),
        points,
        guide: guide.collect(),
        guide_name: "(R/r)^3/2".into(),
    };
    Ok(Outcome { rows, curves: vec![curve] })
}
