//! A spheroid that tumbles in shear flow.

use crate::bodies::{Track, Tracks};
use crate::case::{Case, Control, Curve, Outcome, Part, Row, Sheet, Size, Trouble};
use crate::measure::Fluid;
use crate::rig::{Planned, Rig, advance};
use crate::rules::viscosity;
use squirm::analyze::statistics::{Estimate, blocked, independent};
use squirm::math::mobility::Friction;
use squirm::state::start::start;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The case.
pub const CASE: Case = Case {
    name: "jeffery",
    title: "Orbits of Jeffery",
    about: "Passive prolate bodies of aspect 2 in the middle of a slit whose walls slide past each other: planar Couette flow of the \
            rate G, taken from the fluid's profile in the middle half. A spheroid of aspect r turns with the period \
            2 pi (r + 1/r)/G whichever orbit it is on (Jeffery, Proc. R. Soc. A 102, 161, 1922). Measured is the time between \
            two moments at which the axis crosses the gradient's direction, half a period. h = 0.02 (quick: 0.05): at a given \
            Reynolds number gamma G b^2/eta the Peclet number G/D_R grows as the square of the viscosity, so that the orbit outruns the \
            Brownian rotation; to first order in Re the period stays (Einarsson et al., Phys. Fluids 27, 063301, 2015). Half turns \
            in which the axis came within 18 degrees of the vorticity do not count: there noise turns the projection. The slit \
            is five body lengths high (two in the quick run, where the walls slow the body a little).",
    remarks: "",
    sheets: &[Sheet {
        name: "jeffery",
        title: "Turning of a prolate body in shear flow",
        x: "angle between the axis and the flow / pi",
        y: "angular velocity / G",
        logarithmic: false,
    }],
    parts,
    controls: &[Control {
        name: "walls-at-rest",
        about: "nothing shears the fluid",
        part: "prolate",
        spoil: |plan| {
            if let Some(walls) = &mut plan.system.domain.walls {
                (walls.velocity_low, walls.velocity_high) = ([0.0; 3], [0.0; 3]);
            }
        },
    }],
};

/// Cosine with the vorticity beyond which a half turn does not count.
const POLAR: f64 = 0.95;

fn parts(_: Size) -> Vec<Part> {
    vec![Part::new("prolate", measure)]
}

fn measure(rig: &Rig) -> Result<Outcome, Trouble> {
    let sets: Vec<String> = rig.pick(
        vec![
            "run.dt=0.05".into(),
            "box.size=[12,12,10]".into(),
            "squirmers.body.count=1".into(),
            "squirmers.body.semi_axes={along=3.0,across=1.5}".into(),
            "squirmers.body.poses=[[6,6,5,1,0,0]]".into(),
        ],
        Vec::new(),
    );
    let planned = rig.plan("couette-bodies", &sets)?;
    let system = &planned.system;
    let (height, rate) = intended(&planned)?;
    let mut state = start(&planned.plan.system)?;
    state.particles.iter_mut().for_each(|p| p.velocity.x += rate * (p.position.y - height / 2.0));
    let mut session = rig.session(&planned, &state)?;
    drop(state);
    advance(&mut session, rig.pick(100, 2000))?;
    let (rounds, stretch) = rig.pick((8, 750), (210, 3000));
    let mut rates = vec![];
    let mut tracks = Tracks::default();
    for _ in 0..rounds {
        let more = Tracks::follow(&mut session, stretch, rig.pick(25, 50))?;
        tracks.extend(more);
        rates.push(shear(&Fluid::of(&session)?, height));
    }
    let found = blocked(&rates);
    let shape = system.species[0].spheroid();
    let aspect = |s: squirm::math::spheroid::Spheroid| s.along / s.across;
    let eta = viscosity(system);
    let reynolds = system.fluid.density * rate * shape.radius().powi(2) / eta;
    let peclet = rate * eta * Friction::of(shape).tumble;
    let setup = format!(
        "{} x {} in {}, h = {}, G = {:.4}({:.0}e-4), Re = {reynolds:.2}, G/D_R = {peclet:.0}",
        shape.across,
        shape.along,
        system.domain.size.map(|n| n.to_string()).join(" x "),
        system.run.dt,
        found.mean,
        found.error * 1e4
    );
    let halves: Vec<f64> = tracks.bodies.iter().flat_map(|t| half_turns(t, tracks.spacing)).collect();
    if halves.len() < 2 {
        return Err(format!("only {} half turns", halves.len()).into());
    }
    let half = independent(&halves);
    let period = 2.0 * half.mean * found.mean / TAU;
    let error = period * ((half.error / half.mean).powi(2) + (found.error / found.mean).powi(2)).sqrt();
    let r = aspect(shape);
    let expected = r + r.recip();
    let row = Row {
        quantity: "period G/(2 pi)".into(),
        setup,
        measured: period,
        error,
        expected: Some(expected),
        tolerance: 0.05 * expected,
        source: "Jeffery 1922".into(),
        note: format!("{} half turns", halves.len()),
    };
    Ok(Outcome { rows: vec![row], curves: vec![curve(&tracks, found.mean, r)] })
}

/// Height of the slit and the rate that its walls are meant to give.
fn intended(planned: &Planned) -> Result<(f64, f64), Trouble> {
    let domain = &planned.system.domain;
    let walls = domain.walls.as_ref().ok_or("the slit has no walls")?;
    let height = f64::from(domain.size[1]);
    Ok((height, (walls.velocity_high[0] - walls.velocity_low[0]) / height))
}

/// Least-squares slope of v_x over y in the middle half of the slit.
fn shear(fluid: &Fluid, height: f64) -> f64 {
    let (mut n, mut y1, mut y2, mut v1, mut vy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (r, v) in fluid.particles() {
        let y = r.y - height / 2.0;
        if y.abs() < height / 4.0 {
            n += 1.0;
            y1 += y;
            y2 += y * y;
            v1 += v.x;
            vy += v.x * y;
        }
    }
    (n * vy - y1 * v1) / (n * y2 - y1 * y1)
}

/// The angle by which the axis has turned with the shear, counted on past full turns, beginning at its angle from the flow.
fn angles(track: &Track) -> Vec<f64> {
    let mut angle = -track.axes.first().map_or(0.0, |e| e.y.atan2(e.x));
    let mut angles = vec![angle];
    for pair in track.axes.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        angle -= (a.x * b.y - a.y * b.x).atan2(a.x * b.x + a.y * b.y);
        angles.push(angle);
    }
    angles
}

/// Times between one crossing of the gradient's direction and the next, each counted when it is first reached.
fn half_turns(track: &Track, spacing: f64) -> Vec<f64> {
    let angles = angles(track);
    let mut next = ((angles[0] + 0.1 - FRAC_PI_2) / PI).ceil() * PI + FRAC_PI_2;
    let mut last: Option<f64> = None;
    let (mut halves, mut polar) = (Vec::new(), false);
    for i in 1..angles.len() {
        polar |= track.axes[i].z.abs() > POLAR;
        // A noisy projection may pass more than one in a moment.
        while angles[i] >= next {
            let part = (next - angles[i - 1]) / (angles[i] - angles[i - 1]);
            let now = spacing * ((i - 1) as f64 + part);
            if let Some(last) = last
                && !polar
            {
                halves.push(now - last);
            }
            last = Some(now);
            polar = false;
            next += PI;
        }
    }
    halves
}

/// Mean angular velocity against the angle from the flow, both in the plane of the shear, over G.
fn curve(tracks: &Tracks, rate: f64, aspect: f64) -> Curve {
    const BINS: usize = 16;
    let mut bins = vec![Vec::new(); BINS];
    for track in &tracks.bodies {
        for (angle, axis) in angles(track).windows(2).zip(&track.axes) {
            if axis.z.abs() <= POLAR {
                let turned = (-angle[0] / PI).rem_euclid(1.0);
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let bin = ((turned * BINS as f64) as usize).min(BINS - 1);
                bins[bin].push((angle[1] - angle[0]) / (tracks.spacing * rate));
            }
        }
    }
    let middle = |k: usize| (k as f64 + 0.5) / BINS as f64;
    let point = |(k, values): (usize, &Vec<f64>)| {
        let Estimate { mean, error } = blocked(values);
        (middle(k), mean, error)
    };
    let theory = |x: f64| {
        let (s, c) = (PI * x).sin_cos();
        ((aspect * s).powi(2) + c * c) / (aspect * aspect + 1.0)
    };
    Curve {
        sheet: "jeffery".into(),
        name: "prolate body".into(),
        points: bins.iter().enumerate().filter(|(_, v)| v.len() > 15).map(point).collect(),
        guide: (0..=64).map(|k| f64::from(k) / 64.0).map(|x| (x, theory(x))).collect(),
        guide_name: "Jeffery 1922".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Jeffery's orbit in the plane of the shear: tan(phi) = -tan(2 pi t/T)/r turned by a quarter.
    #[test]
    fn an_orbit_without_noise_has_its_period() {
        let (r, g, spacing) = (2.0_f64, 0.03, 1.0);
        let w = g / (r + r.recip());
        let axes: Vec<DVec3> = (0..3000)
            .map(|i| {
                let (s, c) = (w * spacing * f64::from(i)).sin_cos();
                DVec3::new(r * c, -s, 0.0).normalize()
            })
            .collect();
        let n = axes.len();
        let track = Track { axes, positions: vec![DVec3::ZERO; n], turns: vec![DVec3::ZERO; n] };
        let halves = half_turns(&track, spacing);
        assert_eq!(halves.len(), 10);
        assert!(halves.iter().all(|h| (h - PI * (r + r.recip()) / g).abs() < 0.1), "{halves:?}");
        let tracks = Tracks { bodies: vec![track], spacing, ..Tracks::default() };
        let curve = curve(&tracks, g, r);
        assert_eq!(curve.points.len(), 16);
        for (x, y, _) in curve.points {
            let (s, c) = (PI * x).sin_cos();
            assert!((y - ((r * s).powi(2) + c * c) / (r * r + 1.0)).abs() < 0.02, "{x} {y}");
        }
    }

    #[test]
    fn half_turns_near_the_vorticity_do_not_count() {
        let axes: Vec<DVec3> = (0..1000)
            .map(|i| {
                DVec3::new(0.1 * (0.05 * f64::from(i)).cos(), -0.1 * (0.05 * f64::from(i)).sin(), 0.99).normalize()
            })
            .collect();
        let n = axes.len();
        let track = Track { axes, positions: vec![DVec3::ZERO; n], turns: vec![DVec3::ZERO; n] };
        assert!(half_turns(&track, 1.0).is_empty());
    }
}
