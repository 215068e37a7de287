//! What 32-bit floats, 32-bit positions and fixed-point sums do to long runs and large boxes.

use crate::case::{Case, Control, Outcome, Part, Row, Size, Trouble};
use crate::measure::{Fluid, counted, row};
use crate::rig::{Rig, advance, sound};
use crate::rules;
use glam::DVec3;
use squirm::analyze::statistics::{Estimate, blocked, independent};
use squirm::gpu::Session;
use squirm::math::fixed::Scales;
use squirm::math::rng::{Draw, Purpose};
use squirm::state::{Domain, Particle, State};

/// The case.
pub const CASE: Case = Case {
    name: "precision",
    title: "Numerical precision",
    about: "Velocities are 32-bit floats, positions 32-bit fractions of the box, and sums over cells 32-bit integers. Measured: the drift of \
            energy and momentum over a very long run without a thermostat; the flight of free particles in long boxes \
            against the exact path, for slow particles on average and for thermal ones at worst; the largest sums of any cell \
            against the range of their words; and whether runs with other seeds agree.",
    remarks: "",
    sheets: &[],
    parts,
    controls: &[Control {
        name: "long-step",
        about: "the time step is 1 % longer than meant",
        part: "flight-1000",
        spoil: |plan| plan.system.run.dt *= 1.01,
    }],
};

fn parts(size: Size) -> Vec<Part> {
    let flight = |length: u32| Part::new(format!("flight-{length}"), move |rig| flight(rig, length));
    let range = |density: u32| Part::new(format!("range-{density}"), move |rig| range(rig, density));
    match size {
        Size::Quick => vec![flight(1000), range(10)],
        Size::Full => {
            vec![Part::new("drift", drift), flight(300), flight(1000), range(10), range(50), Part::new("seeds", seeds)]
        }
    }
}

/// Steps of the long run.
const LONG: u64 = 1_000_000;

fn drift(rig: &Rig) -> Result<Outcome, Trouble> {
    const STRETCHES: u64 = 20;
    let planned = rig.plan("precision", &rules::ENERGY.sets())?;
    let mut session = rig.session(&planned, &rig.start(&planned)?)?;
    let first = Fluid::of(&session)?;
    let mut energies = vec![first.energy()];
    for _ in 0..STRETCHES {
        advance(&mut session, LONG / STRETCHES)?;
        energies.push(Fluid::of(&session)?.energy());
    }
    sound(&session)?;
    let last = Fluid::of(&session)?;
    let setup = format!("{}, {LONG} steps", described(&planned.system.domain, 10));
    let drifts: Vec<f64> = energies.windows(2).map(|e| (e[1] - e[0]) * STRETCHES as f64 / energies[0]).collect();
    let momentum = (last.momentum() - first.momentum()).length() / last.len() as f64;
    let momentum = Row {
        note: "the exact figure of this run; a random walk of roundings would be some 3e-6".into(),
        ..row(
            ("momentum gained per particle / sqrt(m kT)", &setup),
            counted(momentum),
            (Some(0.0), 1e-5),
            "rounding of f32",
        )
    };
    let energy = ("energy drift / energy", setup.as_str());
    let temperature = ("temperature at the end over that at the start", setup.as_str());
    let ratio = last.temperature() / first.temperature();
    Ok(Outcome {
        rows: vec![
            row(energy, independent(&drifts), (Some(0.0), 1e-3), "rounding of f32"),
            row(temperature, counted(ratio), (Some(1.0), 1e-3), "rounding of f32"),
            momentum,
        ],
        curves: Vec::new(),
    })
}

fn described(domain: &Domain, density: u32) -> String {
    let [x, y, z] = domain.size;
    format!("{}, {x} x {y} x {z}, {density} per cell", rules::ENERGY.title)
}

/// Free particles fly along x in a box of this length.
fn flight(rig: &Rig, length: u32) -> Result<Outcome, Trouble> {
    const PARTICLES: u32 = 8192;
    let steps = rig.pick(200, 1000);
    let sets = [rules::size_set([length, 4, 4]), "fluid.density=0.1".into()];
    let mut planned = rig.plan("precision", &sets)?;
    planned.plan.stages.retain(|s| s.entry.kind == "stream");
    let (domain, dt) = (planned.system.domain.clone(), planned.system.run.dt);
    // Half of the particles are as slow as a flow may be, the others thermal.
    let draw = Draw::new(1, Purpose::Start, 0);
    let particle = |i: u32| {
        let [x, y, z, speed] = draw.uniforms(i, 0, 0);
        let speed = if i.is_multiple_of(2) { 1e-5 + 2e-4 * speed } else { 4.0 * speed };
        let position = DVec3::new(x, y, z) * DVec3::from_array(domain.size.map(f64::from));
        Particle { position, velocity: speed * DVec3::X }
    };
    let state = State { particles: (0..PARTICLES).map(particle).collect(), ..State::default() };
    let mut session = rig.session(&planned, &state)?;
    let unit = f64::from(length) / 4_294_967_296.0;
    let mut path = Path { last: session.raw()?.positions, moved: vec![0; PARTICLES as usize] };
    // Between readings the fastest go less than half the box.
    for _ in 0..steps / 100 {
        advance(&mut session, 100)?;
        path.enter(&session)?;
    }
    let time = steps as f64 * dt;
    // The velocity that the adapter holds is the nearest f32.
    let velocities: Vec<f64> = session.raw()?.velocities.chunks_exact(3).map(|v| f64::from(v[0])).collect();
    let (mut slow, mut worst, mut still) = (Vec::new(), 0.0f64, 0u32);
    for (i, (moved, v)) in path.moved.iter().zip(&velocities).enumerate() {
        let moved = *moved as f64 * unit;
        if i.is_multiple_of(2) {
            slow.push(moved / (v * time) - 1.0);
            still += u32::from(moved <= 0.0);
        } else {
            worst = worst.max((moved - v * time).abs() / (unit * steps as f64));
        }
    }
    let setup = format!("L = {length}, h = {dt}, {steps} steps of free flight");
    let seen = |name: &str, value: f64| row((name, &setup), counted(value), (None, 0.0), "-");
    let judged = |name: &str, found: Estimate, tolerance: f64, source: &str| {
        row((name, &setup), found, (Some(0.0), tolerance), source)
    };
    Ok(Outcome {
        rows: vec![
            seen("unit of position / a", unit),
            judged(
                "relative error of the way, mean over speeds of 1e-5 to 2e-4",
                independent(&slow),
                1e-3,
                "rounding to the nearest",
            ),
            judged("particles of these that did not move forwards", counted(still.into()), 0.5, "exact"),
            // Half a unit by rounding the position; the displacement, of up to 5.7e6 units, is a product of three f32: 0.34 each.
            judged(
                "largest error per step of speeds up to 4, in units of position",
                counted(worst),
                1.6,
                "half a unit, and f32",
            ),
        ],
        curves: Vec::new(),
    })
}

/// Displacements along x in coordinate units.
struct Path {
    last: Vec<u32>,
    moved: Vec<i64>,
}

impl Path {
    fn enter(&mut self, session: &Session) -> Result<(), Trouble> {
        let now = session.raw()?.positions;
        for ((moved, a), b) in self.moved.iter_mut().zip(self.last.chunks_exact(3)).zip(now.chunks_exact(3)) {
            *moved += i64::from(b[0].wrapping_sub(a[0]).cast_signed());
        }
        self.last = now;
        Ok(())
    }
}

/// Kinds of moment words: name, first word, words, whether they have a sign.
const WORDS: [(&str, usize, usize, bool); 5] = [
    ("sum v", 1, 3, true),
    ("sum v^2", 4, 1, false),
    ("sum x", 6, 3, true),
    ("sum x x", 9, 6, true),
    ("sum x v", 15, 9, true),
];

/// The largest sums of any cell against the range of their words.
fn range(rig: &Rig, density: u32) -> Result<Outcome, Trouble> {
    let edge = rig.pick(8, 16);
    let mut sets = rules::THERMOSTAT.sets();
    sets.extend([rules::size_set([edge; 3]), format!("fluid.density={density}")]);
    let planned = rig.plan("precision", &sets)?;
    let mut session = rig.loose_session(&planned, &rig.start(&planned)?)?;
    let scales = Scales::new(planned.system.fluid.density, planned.system.fluid.temperature);
    let bit = scales.coarse_bit;
    let (mut largest, mut fullest, mut coarse, mut fastest) = ([0.0f64; WORDS.len()], 0u32, 0u32, 0.0f64);
    for _ in 0..rig.pick(50, 1000) {
        advance(&mut session, 5)?;
        for cell in session.read::<u32>("moments")?.chunks_exact(24) {
            fullest = fullest.max(cell[0] & ((1 << bit) - 1));
            coarse = coarse.max(cell[0] >> bit);
            for (share, (_, first, count, signed)) in largest.iter_mut().zip(WORDS) {
                for word in &cell[first..first + count] {
                    let used = if signed { 2.0 * f64::from(word.cast_signed()).abs() } else { f64::from(*word) };
                    *share = share.max(used / 4_294_967_296.0);
                }
            }
        }
        fastest = Fluid::of(&session)?.velocities().fold(fastest, |f, v| f.max(v.length()));
    }
    // A sum that wrapped would have raised a fault.
    sound(&session)?;
    let steps = session.step();
    let setup = format!("{edge} x {edge} x {edge}, {density} per cell, every fifth of {steps} steps");
    let shares = WORDS.iter().map(|w| w.0).zip(largest).chain([
        ("sum v^2, coarse", f64::from(coarse) / 2f64.powi(32 - bit.cast_signed())),
        ("number", f64::from(fullest) / f64::from(scales.max_count)),
        ("speed of a particle", fastest / scales.max_speed),
    ]);
    let rows = shares.map(|(name, share)| {
        let quantity = format!("largest {name}, share of its range");
        row((&quantity, &setup), counted(share), (Some(0.0), 0.9), "nothing overflows")
    });
    Ok(Outcome { rows: rows.collect(), curves: Vec::new() })
}

/// Four runs that differ in their seed only.
fn seeds(rig: &Rig) -> Result<Outcome, Trouble> {
    const SEEDS: u64 = 4;
    let mut found: Vec<[Estimate; 2]> = Vec::new();
    for seed in 1..=SEEDS {
        let mut sets = rules::THERMOSTAT.sets();
        sets.extend([rules::size_set([16; 3]), format!("run.seed={seed}")]);
        let planned = rig.plan("precision", &sets)?;
        let mut session = rig.session(&planned, &rig.start(&planned)?)?;
        advance(&mut session, 200)?;
        let (mut temperatures, mut kurtoses) = (Vec::new(), Vec::new());
        for _ in 0..512 {
            advance(&mut session, 10)?;
            let fluid = Fluid::of(&session)?;
            temperatures.push(fluid.temperature());
            kurtoses.push(fluid.kurtosis());
        }
        sound(&session)?;
        found.push([blocked(&temperatures), blocked(&kurtoses)]);
    }
    let names = ["temperature / kT", "kurtosis of a component"];
    let mut rows = Vec::new();
    for (k, name) in names.into_iter().enumerate() {
        for (seed, estimates) in (1..).zip(&found) {
            let setup = format!("{}, 16 x 16 x 16, seed {seed}", rules::THERMOSTAT.title);
            rows.push(row((name, &setup), estimates[k], (None, 1e-3), "-"));
        }
        let setup = format!("{}, 16 x 16 x 16, {SEEDS} seeds", rules::THERMOSTAT.title);
        let quantity = format!("largest difference from the mean in {name}, standard errors");
        let worst = farthest(&found.iter().map(|f| f[k]).collect::<Vec<_>>());
        // By chance one of four is 2.5 errors away in one of 20 cases, 4 in one of 4000.
        rows.push(row((&quantity, &setup), counted(worst), (Some(0.0), 4.0), "independent runs"));
    }
    Ok(Outcome { rows, curves: Vec::new() })
}

/// The largest difference from the mean of all, in units of its own error.
fn farthest(values: &[Estimate]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().map(|v| v.mean).sum::<f64>() / n;
    // The mean holds a share 1/n of the value itself.
    let error = |v: &Estimate| v.error * (1.0 - 1.0 / n).sqrt();
    values.iter().map(|v| (v.mean - mean).abs() / error(v)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_farthest_value_is_told_in_its_errors() {
        let value = |mean: f64| Estimate { mean, error: 0.5 };
        let found = farthest(&[value(1.0), value(1.0), value(1.0), value(5.0)]);
        assert!((found - 3.0 / (0.5 * 0.75f64.sqrt())).abs() < 1e-12, "{found}");
    }
}
