//! Two swimmers that meet in a narrow slit.

use crate::case::{Case, Curve, Outcome, Part, Row, Sheet, Size, Trouble};
use crate::crowd::{Pair, pair, peclet, reynolds, swimmers, transport};
use crate::rig::{Planned, Rig, advance, sound};
use squirm::analyze::statistics::{Estimate, blocked};
use squirm::state::System;

/// The case.
pub const CASE: Case = Case {
    name: "two-pullers",
    title: "Two swimmers in a narrow slit",
    about: "Two prolate swimmers, semi-axes 6 along and 3 across, meet under 30 degrees in a slit of 7 a, between walls that let them \
            tilt by 14 degrees at most (`pipelines/two-pullers.toml`). h = 0.05, B1 = 0.08, but no more than 0.24/|beta|, so that the \
            surface stays below Mach 0.2; Reynolds number 0.52, Peclet number U0/(2 b D_R) = 86 at |beta| <= 3, both smaller in \
            proportion to B1 beyond. They are counted as together while their surfaces are less than 2 a apart. An angle is positive \
            where the headings converge. One run of 11 swimmer lengths for each beta: a pair that parts at the end of one run may \
            stay longer in another. Published (Theers, Westphal, Gompper and Winkler 2016, abstract): pullers swim together in a \
            stable state at a small constant angle, pushers scatter.",
    remarks: "",
    sheets: &[
        Sheet {
            name: "two-pullers-angle",
            title: "Pullers: angle between the axes, positive where the headings converge",
            x: "time / (2 b/U0)",
            y: "angle / degrees",
            logarithmic: false,
        },
        Sheet {
            name: "two-pullers-distance",
            title: "Pullers: distance of the centres",
            x: "time / (2 b/U0)",
            y: "distance / a",
            logarithmic: false,
        },
        Sheet {
            name: "two-pushers-distance",
            title: "Pushers: distance of the centres",
            x: "time / (2 b/U0)",
            y: "distance / a",
            logarithmic: false,
        },
    ],
    parts,
    controls: &[],
};

/// Largest gap between the surfaces of two that are together, in a.
const TOGETHER: f64 = 2.0;

fn parts(size: Size) -> Vec<Part> {
    let betas: &[f64] = match size {
        Size::Quick => &[3.0],
        Size::Full => &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, -1.0, -3.0, -6.0],
    };
    betas.iter().map(|beta| Part::new(format!("beta{beta}"), move |rig| measure(rig, *beta))).collect()
}

/// The pair at one moment.
struct Moment {
    /// In units of 2 b/U0.
    time: f64,
    pair: Pair,
    /// Advance of the middle of the pair along its mean heading since the last reading, in units of U0; 0 at the first one.
    speed: f64,
}

fn measure(rig: &Rig, beta: f64) -> Result<Outcome, Trouble> {
    let mut sets =
        vec![format!("squirmers.puller.beta={beta}"), format!("squirmers.puller.b1={}", 0.24 / beta.abs().max(3.0))];
    if rig.pick(true, false) {
        sets.push("box.size=[24,7,24]".into());
        sets.push("squirmers.puller.poses=[[12,3.5,8,0.96593,0,0.25882],[12,3.5,16,0.96593,0,-0.25882]]".into());
    }
    let planned = rig.plan("../two-pullers", &sets)?;
    let moments = follow(rig, &planned)?;
    Ok(outcome(&planned.system, beta, &moments))
}

/// Time in which a swimmer of the first species crosses its own length, tau.
fn length_time(system: &System) -> f64 {
    let species = &system.species[0];
    2.0 * species.semi_axes.along / species.spheroid().swim_speed(species.b1)
}

fn follow(rig: &Rig, planned: &Planned) -> Result<Vec<Moment>, Trouble> {
    let system = &planned.system;
    let (unit, dt) = (length_time(system), system.run.dt);
    let every = rig.pick(10, 100);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let readings = (rig.pick(0.12, 11.0) * unit / (dt * every as f64)).round() as u64;
    let speed_unit = system.species[0].spheroid().swim_speed(system.species[0].b1) * dt * every as f64;
    let mut session = rig.session(planned, &rig.start(planned)?)?;
    let mut before = swimmers(&session)?;
    let mut moments = vec![Moment { time: 0.0, pair: pair(&system.domain, &before[0], &before[1]), speed: 0.0 }];
    for k in 1..=readings {
        advance(&mut session, every)?;
        let now = swimmers(&session)?;
        let heading = (now[0].body.axis + now[1].body.axis).normalize_or_zero();
        let moved = now.iter().zip(&before).map(|(n, b)| n.position - b.position).sum::<glam::DVec3>() / 2.0;
        moments.push(Moment {
            time: (k * every) as f64 * dt / unit,
            pair: pair(&system.domain, &now[0], &now[1]),
            speed: moved.dot(heading) / speed_unit,
        });
        before = now;
    }
    sound(&session)?;
    Ok(moments)
}

/// The longest stretch in which a condition holds: its beginning and what follows its end.
fn longest(holds: &[bool]) -> (usize, usize) {
    let (mut best, mut begin) = ((0, 0), 0);
    for (i, held) in holds.iter().enumerate() {
        if !held {
            begin = i + 1;
        } else if i + 1 - begin > best.1 - best.0 {
            best = (begin, i + 1);
        }
    }
    best
}

fn outcome(system: &System, beta: f64, moments: &[Moment]) -> Outcome {
    let species = &system.species[0];
    let (shape, b1) = (species.spheroid(), species.b1);
    let eta = transport(system).viscosity;
    let setup = format!(
        "beta = {beta}, B1 = {b1:.3}, Re = {:.2}, Pe = {:.0}",
        reynolds(shape, b1, system),
        peclet(shape, b1, eta)
    );
    let row = |quantity: &str, found: Estimate, note: String| Row {
        quantity: quantity.into(),
        setup: setup.clone(),
        measured: found.mean,
        // What is too short for blocks has no error.
        error: if found.error.is_finite() { found.error } else { 0.0 },
        expected: None,
        tolerance: 0.0,
        source: "Theers et al. 2016".into(),
        note,
    };
    let holds: Vec<bool> = moments.iter().map(|m| m.pair.gap < TOGETHER).collect();
    let (begin, end) = longest(&holds);
    let interval = moments.get(1).map_or(0.0, |m| m.time);
    let alone = |mean: f64| Estimate { mean, error: 0.0 };
    let held = (end - begin).saturating_sub(1) as f64 * interval;
    let last = moments.last().map_or(0.0, |m| m.time);
    let fate = if end == moments.len() { "together at the end of the run" } else { "parted before the end of the run" };
    let mut rows = vec![row(
        "longest time together / (2 b/U0)",
        // No more digits than one run tells.
        alone((100.0 * held).round() / 100.0),
        format!("{fate}, which lasted {last:.1}; together for {:.0} % of it", 100.0 * share(&holds)),
    )];
    // The second half, in which the encounter itself is over.
    let settled = &moments[begin + (end - begin) / 2..end];
    if settled.len() >= 16 {
        let mean = |value: fn(&Moment) -> f64| blocked(&settled.iter().map(value).collect::<Vec<_>>());
        let when = "second half of the longest time together".to_owned();
        rows.push(row("angle between the axes / degrees", mean(|m| m.pair.angle), when.clone()));
        rows.push(row("distance of the centres / a", mean(|m| m.pair.distance), when.clone()));
        rows.push(row("speed of the pair / U0", mean(|m| m.speed), when));
    }
    let sheets: &[&str] =
        if beta > 0.0 { &["two-pullers-angle", "two-pullers-distance"] } else { &["two-pushers-distance"] };
    let curve = |sheet: &&str| Curve {
        sheet: (*sheet).into(),
        name: format!("beta = {beta}"),
        points: thinned(moments, if sheet.ends_with("angle") { |m| m.pair.angle } else { |m| m.pair.distance }),
        guide: Vec::new(),
        guide_name: String::new(),
    };
    Outcome { rows, curves: sheets.iter().map(curve).collect() }
}

fn share(holds: &[bool]) -> f64 {
    holds.iter().filter(|h| **h).count() as f64 / holds.len().max(1) as f64
}

/// At most about 80 points, each at one moment: means of angles would hide how they swing.
fn thinned(moments: &[Moment], value: fn(&Moment) -> f64) -> Vec<(f64, f64, f64)> {
    moments.iter().step_by((moments.len() / 80).max(1)).map(|m| (m.time, value(m), 0.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_stretch_is_found() {
        let of = |text: &str| longest(&text.chars().map(|c| c == 'x').collect::<Vec<_>>());
        assert_eq!(of(""), (0, 0));
        assert_eq!(of("..."), (0, 0));
        assert_eq!(of("xx.xxx.x"), (3, 6));
        assert_eq!(of(".xxxx"), (1, 5));
        assert_eq!(of("xx.xx"), (0, 2));
    }

    #[test]
    fn few_points_are_drawn() {
        let at = |k: u32| Moment {
            time: f64::from(k),
            pair: Pair { distance: 2.0 * f64::from(k), gap: 1.0, angle: 0.0 },
            speed: 1.0,
        };
        let moments: Vec<Moment> = (0..400).map(at).collect();
        let points = thinned(&moments, |m| m.pair.distance);
        assert_eq!((points.len(), points[1]), (80, (5.0, 10.0, 0.0)));
    }
}
