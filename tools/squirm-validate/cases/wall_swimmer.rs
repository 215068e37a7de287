//! The attraction of pushers to a wall, and the repulsion of pullers.

use crate::case::{Case, Control, Outcome, Part, Row, Size, Trouble};
use crate::measure::{Fluid, wall_impulses};
use crate::rig::{Planned, Rig, advance, sound};
use crate::rules::viscosity;
use crate::swimmer::settling;
use glam::{DMat4, DVec3, DVec4};
use squirm::analyze::statistics::{Estimate, blocked};
use squirm::math::flow::SquirmerFlow;
use squirm::state::System;
use std::f64::consts::{PI, TAU};

/// The case.
pub const CASE: Case = Case {
    name: "wall-swimmer",
    title: "Pusher and puller beside a wall",
    about: "A stresslet p = 8 pi eta C4 parallel to a no-slip wall at the height y drifts with v_y = -3p/(64 pi eta y^2) (Berke et al. 2008): \
            pushers are attracted, pullers repelled. A drifting body leaves its height and turns, so a sphere is held, with so little \
            of the swimming mode (beta = +-100) that its flow is the stresslet and the source quadrupole on it, C4 (1 + R^2/6 laplacian). \
            Its drift between the two walls is that of a point stresslet (waves along the walls, as Liron and Mochon 1976) with its \
            periodic images, which take some of the drift away, and with the size of the sphere by Blake's images (1971) in the nearer \
            wall and Faxen's law. The force is that drift times the friction between the walls, found in the same way. What the \
            body received is what fluid and walls have lost: exact at every step. Half the difference \
            of pusher and puller is free of what inertia and compression do to both alike.",
    remarks: "",
    sheets: &[],
    parts,
    controls: &[Control {
        name: "puller-for-pusher",
        about: "beta has the wrong sign",
        part: "sphere",
        spoil: |plan| plan.system.species.iter_mut().for_each(|s| s.beta = -s.beta),
    }],
};

fn parts(size: Size) -> Vec<Part> {
    let (sets, steps): (&'static [&'static str], u64) = match size {
        Size::Quick => (
            &[
                "box.size=[12,12,12]",
                "fluid.density=10",
                "squirmers.swimmer.semi_axes={across=2.0,along=2.0}",
                "squirmers.swimmer.b1=0.008",
                "squirmers.swimmer.poses=[[6,4,6,1,0,0]]",
            ],
            1500,
        ),
        Size::Full => (&["box.size=[24,20,24]", "squirmers.swimmer.b1=0.0035"], 100_000),
    };
    vec![Part::new("sphere", move |rig| measure(rig, sets, steps))]
}

/// Velocity towards +y at (x, y, z) of the image of a point force 8 pi eta along x at (0, h, 0) above a wall at y = 0 (Blake, Proc.
/// Camb. Phil. Soc. 70, 303, 1971).
fn image_of_force(r: DVec3, h: f64) -> f64 {
    let from = r + h * DVec3::Y;
    let d = from.length();
    let (x, y) = (from.x, from.y);
    -x * y / d.powi(3) + 2.0 * h * x * ((3.0 * y * y - 3.0 * h * y) / d.powi(5) + 1.0 / d.powi(3))
}

/// The same for a stresslet along x with the flow (3 cos^2 - 1) r/r^3.
fn image_of_stresslet(r: DVec3, h: f64) -> f64 {
    let step = 1e-3 * h * DVec3::X;
    (image_of_force(r - step, h) - image_of_force(r + step, h)) / (2e-3 * h)
}

/// Drift towards +y, divided by C4, of a force-free sphere with the flow (1 + R^2/6 laplacian) of that stresslet, at the height h:
/// Faxen's law for the images of both terms.
fn drift(radius: f64, h: f64) -> f64 {
    let step = 0.03 * h;
    let factor = radius * radius / 6.0 / (step * step);
    // The source moves across by as much as the point moves back.
    let felt = |shift: DVec3, h: f64, point: DVec3| image_of_stresslet(point - shift, h);
    let laplacian = |f: &dyn Fn(DVec3) -> f64| {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        f(DVec3::ZERO) + factor * axes.iter().map(|a| f(step * *a) + f(-step * *a) - 2.0 * f(DVec3::ZERO)).sum::<f64>()
    };
    laplacian(&|source: DVec3| {
        let level = DVec3::new(source.x, 0.0, source.z);
        laplacian(&|point: DVec3| felt(level, h + source.y, h * DVec3::Y + point))
    })
}

/// What one wave number k along the walls adds at a point force 8 pi eta across a slit of this height, at the height h: velocity, and
/// slope of that velocity along y. The free part of the velocity, 2 pi/k, is left out.
///
/// After Liron and Mochon, J. Eng. Math. 10, 287 (1976): the added v(y) is a combination of exp(-ky), ky exp(-ky) and their mirrors
/// that takes the free flow 2 pi (1 + k|d|) exp(-k|d|)/k, d = y - h, and its slope to zero at both walls.
fn wave(k: f64, h: f64, height: f64) -> (f64, f64) {
    let modes = |y: f64| {
        let (low, high) = ((-k * y).exp(), (-k * (height - y)).exp());
        let (a, b) = (k * y, k * (height - y));
        let value = DVec4::new(low, a * low, high, b * high);
        (value, k * DVec4::new(-low, (1.0 - a) * low, high, (b - 1.0) * high))
    };
    let free = |d: f64| (TAU * (1.0 + k * d) * (-k * d).exp() / k, TAU * k * d * (-k * d).exp());
    let ((bottom, bottom_slope), (top, top_slope)) = (modes(0.0), modes(height));
    let ((below, rise), (over, fall)) = (free(h), free(height - h));
    let matrix = DMat4::from_cols(bottom, bottom_slope, top, top_slope).transpose();
    let share = matrix.inverse() * DVec4::new(-below, -rise, -over, fall);
    let (value, change) = modes(h);
    (share.dot(value), share.dot(change))
}

/// What walls and periodic images do to the point force, in a slit whose period along both walls is `edge`: velocity, and slope of the velocity
/// along y, that they add at the force.
///
/// Alone in the slit, the integral over k. With images the sum over the waves of the box, in which the uniform one is missing, since nothing
/// flows across the slit on average; what the sum over the whole flow has more than the integral is the images, and a factor
/// exp(-k^2 s^2) makes both converge without touching images further away than some s.
fn slit(h: f64, height: f64, edge: f64) -> (f64, f64) {
    const POINTS: u32 = 4000;
    const SMOOTH: f64 = 0.06;
    let soft = |k: f64| (-(k * SMOOTH * edge).powi(2)).exp();
    let step = 20.0 / h.min(height - h) / f64::from(POINTS);
    let (mut velocity, mut slope) = (0.0, 0.0);
    for i in 0..POINTS {
        let k = (f64::from(i) + 0.5) * step;
        velocity += wave(k, h, height).0 * k * step / TAU;
    }
    let fine = 8.0 / (SMOOTH * edge) / f64::from(POINTS);
    for i in 0..POINTS {
        let k = (f64::from(i) + 0.5) * fine;
        velocity -= soft(k) * (wave(k, h, height).0 + TAU / k) * k * fine / TAU;
    }
    for x in -16i32..=16 {
        for z in -16i32..=16 {
            let k = TAU / edge * f64::from(x).hypot(f64::from(z));
            if k > 0.0 {
                let (v, s) = wave(k, h, height);
                velocity += soft(k) * (v + TAU / k) / (edge * edge);
                slope += s / (edge * edge);
            }
        }
    }
    (velocity, slope)
}

/// Force on the held sphere towards +y that theory wants.
fn expected(system: &System) -> f64 {
    let species = &system.species[0];
    let (radius, shape) = (species.semi_axes.across, species.spheroid());
    let height = species.poses.as_ref().map_or(0.0, |p| p[0][1]);
    let depth = f64::from(system.domain.size[1]);
    let c4 = SquirmerFlow::new(shape, species.b1, species.b1 * species.beta).far_field();
    let (velocity, slope) = slit(height, depth, f64::from(system.domain.size[0]));
    // The next terms of both are those of the walls one by one.
    let cubic = |y: f64| 0.5 * (radius / y).powi(3);
    let mobility = 1.0 + 0.75 * radius * velocity + cubic(height) + cubic(depth - height);
    let friction = 6.0 * PI * viscosity(system) * radius / mobility;
    // By reciprocity the stresslet xx is felt as the force strains its place along x, which is half of the strain along y.
    friction * c4 * -0.5 * slope * drift(radius, height) / drift(1e-3 * radius, height)
}

/// Mean force on the held body towards +y.
fn force(rig: &Rig, planned: &Planned, steps: u64) -> Result<Estimate, Trouble> {
    let state = rig.start(planned)?;
    let mut session = rig.session(planned, &state)?;
    advance(&mut session, settling(&planned.system))?;
    let outside = |session: &_| -> Result<f64, Trouble> {
        Ok(Fluid::of(session)?.momentum().y + wall_impulses(session)?.iter().sum::<DVec3>().y)
    };
    let every = rig.pick(50, 500);
    let mut series = Vec::new();
    let mut before = outside(&session)?;
    for _ in 0..steps / every {
        advance(&mut session, every)?;
        let now = outside(&session)?;
        series.push((before - now) / (every as f64 * planned.system.run.dt));
        before = now;
    }
    sound(&session)?;
    Ok(blocked(&series))
}

fn measure(rig: &Rig, sets: &[&str], steps: u64) -> Result<Outcome, Trouble> {
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for (name, beta) in [("pusher", -100.0), ("puller", 100.0)] {
        let sets: Vec<String> =
            sets.iter().map(ToString::to_string).chain([format!("squirmers.swimmer.beta={beta:?}")]).collect();
        let planned = rig.plan("wall-swimmer", &sets)?;
        let (system, wanted) = (&planned.system, expected(&planned.system));
        let force = force(rig, &planned, steps)?;
        let species = &system.species[0];
        rows.push(Row {
            quantity: "force towards +y / (kT/a)".into(),
            setup: format!(
                "{name}: R = {}, B2 = {}, y = {} of {}, h = {}, {} per cell",
                species.semi_axes.across,
                species.b1 * beta,
                species.poses.as_ref().map_or(0.0, |p| p[0][1]),
                system.domain.size[1],
                system.run.dt,
                system.fluid.density,
            ),
            measured: force.mean,
            error: force.error,
            expected: None,
            tolerance: 0.2 * wanted.abs(),
            source: "Berke et al. 2008; Blake 1971".into(),
            note: format!("theory {wanted:.2}"),
        });
        found.push((force, wanted));
    }
    let ((push, wanted), (pull, _)) = (found[0], found[1]);
    rows.push(Row {
        quantity: "half of pusher - puller / theory".into(),
        setup: "force towards +y, both as above".into(),
        measured: 0.5 * (push.mean - pull.mean) / wanted,
        error: 0.5 * push.error.hypot(pull.error) / wanted.abs(),
        expected: Some(1.0),
        tolerance: 0.2,
        note: String::new(),
        ..rows[0].clone()
    });
    Ok(Outcome { rows, curves: Vec::new() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_stresslet_is_attracted() {
        for h in [2.0, 6.0] {
            assert!((drift(1e-3, h) + 3.0 / 8.0 / (h * h)).abs() < 1e-5, "{}", drift(1e-3, h));
        }
    }

    #[test]
    fn nothing_flows_through_the_wall() {
        let h = 3.0;
        for wall in [DVec3::new(1.0, 0.0, 0.5), DVec3::new(-4.0, 0.0, 2.0), DVec3::ZERO] {
            let r = wall - h * DVec3::Y;
            let own = (3.0 * r.x * r.x / r.length_squared() - 1.0) * r.y / r.length().powi(3);
            assert!((own + image_of_stresslet(wall, h)).abs() < 1e-5, "{wall}: {own}");
        }
    }

    /// 9/8 R/h of Lorentz for the friction, 3/8/h^2 for the stresslet.
    #[test]
    fn a_wide_slit_is_one_wall() {
        let (velocity, slope) = slit(2.0, 30.0, 30.0);
        assert!((velocity + 1.5 / 2.0).abs() < 0.02, "{velocity}");
        assert!((-0.5 * slope + 3.0 / 8.0 / 4.0).abs() < 2e-3, "{slope}");
    }

    /// The waves of a narrow box are short, and do not reach the walls: images take most of the drift away.
    #[test]
    fn images_along_the_wall_weaken_its_effect() {
        let drift = |edge: f64| -0.5 * slit(4.0, 12.0, edge).1;
        let (narrow, wide, wider) = (drift(8.0), drift(30.0), drift(40.0));
        assert!(narrow / wide > 0.0 && narrow / wide < 0.5, "{narrow} {wide}");
        assert!((wider / wide - 1.0).abs() < 0.05, "{wide} {wider}");
    }

    /// The size of the body is a correction, and goes as its square.
    #[test]
    fn the_body_has_a_size() {
        let (point, small, large) = (drift(1e-3, 6.0), drift(0.5, 6.0), drift(1.0, 6.0));
        let ratio = (large - point) / (small - point);
        assert!((ratio - 4.0).abs() < 0.1, "{ratio}");
        assert!((large / point - 1.0).abs() < 0.1);
    }
}
