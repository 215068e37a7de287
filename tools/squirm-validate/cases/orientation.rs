//! How long a passive body remembers its direction.

use crate::bodies::{Tracks, periodic};
use crate::case::{Case, Control, Curve, Outcome, Part, Row, Sheet, Size, Trouble};
use crate::rig::{Rig, advance};
use crate::rules;
use squirm::analyze::statistics::{Estimate, blocked, jackknife, mean};

/// The case.
pub const CASE: Case = Case {
    name: "orientation",
    title: "Memory of the orientation",
    about: "Small prolate bodies, 1.5 across and 3 along, which turn quickly; h = 0.1, 10 particles per cell. D_R is half the growth \
            of the mean squared rotation about the axes across e, at lags too short for e to turn much, and what the memory of the \
            fluid still owes there is added (3 %). The correlations of the axis must then decay as <e(0).e(t)> = exp(-2 D_R t) and \
            <P2(e(0).e(t))> = exp(-6 D_R t) (Debye 1929): their rates come from the ratio of two values, so that inertia at \
            short times drops out. D_R itself is held against Perrin.",
    remarks: "",
    sheets: &[Sheet {
        name: "orientation",
        title: "Memory of the orientation of a prolate body",
        x: "2 D_R t for e, 6 D_R t for P2",
        y: "correlation",
        logarithmic: false,
    }],
    parts,
    controls: &[Control {
        name: "no-angular-momentum",
        about: "the fluid of SRD-a, twice as viscous, where SRD+a is meant",
        part: "prolate",
        spoil: rules::without_angular_momentum,
    }],
};

/// Lags in tau between which the mean squared rotation is taken: R^2/nu is 11 tau.
const SHORT: (f64, f64) = (8.0, 20.0);

fn parts(_: Size) -> Vec<Part> {
    vec![Part::new("prolate", measure)]
}

fn measure(rig: &Rig) -> Result<Outcome, Trouble> {
    let (edge, count) = rig.pick((12, 3), (24, 12));
    let sets = [
        format!("box.size=[{edge},{edge},{edge}]"),
        format!("squirmers.body.count={count}"),
        "squirmers.body.semi_axes={along=3.0,across=1.5}".into(),
    ];
    let planned = rig.plan("passive-bodies", &sets)?;
    let system = &planned.system;
    let theory = periodic(system);
    let mut session = rig.session(&planned, &rig.start(&planned)?)?;
    advance(&mut session, rig.pick(300, 2000))?;
    let tracks = Tracks::follow(&mut session, rig.pick(6000, 650_000), 20)?;
    let setup = format!("prolate 1.5 x 3, {count} in {edge}^3, h = {}", system.run.dt);
    let owed = theory.missing_rotation(SHORT);
    let found = blocked(&tracks.growth(SHORT).tumble);
    let rotation = Estimate { mean: found.mean + owed, error: found.error };
    let expected = theory.mobility().tumble;
    let mut rows = vec![Row {
        quantity: "D_R,perp / (1/tau)".into(),
        setup: setup.clone(),
        measured: rotation.mean,
        error: rotation.error,
        expected: Some(expected),
        tolerance: 0.1 * expected,
        source: "Perrin".into(),
        note: format!("with {owed:.1e} for the memory at lags {} to {}", SHORT.0, SHORT.1),
    }];
    // From where inertia is over, to where a third is left in theory; a quick run is too short for that.
    let ends = rig.pick([(10.0, 60.0), (10.0, 40.0)], [(20.0, 400.0), (20.0, 140.0)]);
    for (rank, between) in [1, 2].into_iter().zip(ends) {
        let ratio = rates(&tracks, rank, between, owed);
        rows.push(Row {
            quantity: format!("decay of {} / {} D_R", name(rank), decay(rank)),
            setup: format!("{setup}, lags {} to {}", between.0, between.1),
            measured: ratio.mean,
            error: ratio.error,
            // A quick run is too short to know an error from so few stretches: it only shows them.
            expected: rig.pick(None, Some(1.0)),
            tolerance: 0.1,
            source: "Debye 1929".into(),
            note: String::new(),
        });
    }
    let curves = [1, 2].into_iter().zip(ends).map(|(rank, e)| curve(&tracks, rank, 1.6 * e.1, rotation.mean)).collect();
    Ok(Outcome { rows, curves })
}

fn name(rank: u32) -> &'static str {
    if rank == 1 { "<e.e>" } else { "<P2(e.e)>" }
}

/// l (l + 1): how fast spherical harmonics of rank l decay, in D_R.
fn decay(rank: u32) -> f64 {
    f64::from(rank * (rank + 1))
}

/// Correlation of the axis with itself a lag later, one value per origin of time.
fn correlation(tracks: &Tracks, rank: u32, lag: f64) -> Vec<f64> {
    let shift = tracks.moment(lag);
    let origins = tracks.len().saturating_sub(shift);
    let legendre = |x: f64| if rank == 1 { x } else { 1.5 * x * x - 0.5 };
    let mean_at = |i: usize| {
        let sum: f64 = tracks.bodies.iter().map(|b| legendre(b.axes[i].dot(b.axes[i + shift]))).sum();
        sum / tracks.bodies.len() as f64
    };
    (0..origins).map(mean_at).collect()
}

/// Rate at which the correlation decays between two lags, over that of the measured D_R; both from the same stretches.
fn rates(tracks: &Tracks, rank: u32, (from, to): (f64, f64), owed: f64) -> Estimate {
    // Twice the lag at least, as far as the run allows: what is left out must be longer than what it remembers.
    let blocks = (tracks.len() / (2 * tracks.moment(to))).clamp(4, 20);
    let (near, far) = (correlation(tracks, rank, from), correlation(tracks, rank, to));
    let growth = tracks.growth(SHORT).tumble;
    let n = far.len();
    let over = |series: &[f64], keep: &dyn Fn(usize) -> bool| {
        let kept: Vec<f64> = series.iter().take(n).enumerate().filter(|(i, _)| keep(*i)).map(|(_, v)| *v).collect();
        mean(&kept)
    };
    let ratio = |keep: &dyn Fn(usize) -> bool| {
        let rate = (over(&near, keep) / over(&far, keep)).ln() / (to - from);
        rate / (decay(rank) * (over(&growth, keep) + owed))
    };
    Estimate { mean: ratio(&|_| true), error: few(blocks) * jackknife(n, blocks, ratio) }
}

/// By how much the error from few stretches has to be larger to be exceeded three times as rarely as that from twenty: Student's t at 99.73 %.
fn few(blocks: usize) -> f64 {
    let t = match blocks {
        ..=4 => 9.2,
        5 => 6.6,
        6 => 5.5,
        7 => 4.9,
        8 | 9 => 4.5,
        10..=13 => 4.1,
        _ => 3.45,
    };
    t / 3.45
}

fn curve(tracks: &Tracks, rank: u32, longest: f64, rotation: f64) -> Curve {
    let lags = (1..=20).map(|k| longest * f64::from(k) / 20.0);
    let rate = decay(rank) * rotation;
    let point = |t: f64| {
        let found = blocked(&correlation(tracks, rank, t));
        (rate * t, found.mean, found.error)
    };
    let points: Vec<_> = lags.map(point).collect();
    Curve {
        sheet: "orientation".into(),
        name: name(rank).into(),
        guide: points.iter().map(|p| (p.0, (-p.0).exp())).collect(),
        guide_name: if rank == 1 { "exp(-2 D_R t)" } else { "exp(-6 D_R t)" }.into(),
        points,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::Track;
    use glam::DVec3;

    /// An axis that goes round at a constant rate: correlation cos(w t).
    #[test]
    fn correlations_of_a_steady_rotation() {
        let axes: Vec<DVec3> =
            (0..200).map(|i| DVec3::new(0.0, (0.1 * f64::from(i)).sin(), (0.1 * f64::from(i)).cos())).collect();
        let track = Track { positions: vec![DVec3::ZERO; 200], turns: vec![DVec3::ZERO; 200], axes };
        let tracks = Tracks { bodies: vec![track], spacing: 2.0, ..Tracks::default() };
        let first = correlation(&tracks, 1, 10.0);
        assert_eq!(first.len(), 195);
        assert!(first.iter().all(|c| (c - 0.5f64.cos()).abs() < 1e-12));
        assert!(correlation(&tracks, 2, 10.0).iter().all(|c| (c - (1.5 * 0.5f64.cos().powi(2) - 0.5)).abs() < 1e-12));
    }
}
