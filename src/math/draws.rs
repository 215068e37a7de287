//! Random variates from the counter-based generator: normal, on the unit sphere, gamma, Poisson process.

use super::rng::Draw;
use glam::DVec3;
use std::f64::consts::TAU;

/// Three independent standard normals from four uniforms (Box and Muller, Ann. Math. Stat. 29, 610, 1958).
#[must_use]
pub fn normals(u: [f64; 4]) -> DVec3 {
    let [first, second] = [(-2.0 * u[0].ln()).sqrt(), (-2.0 * u[2].ln()).sqrt()];
    let (sin, cos) = (TAU * u[1]).sin_cos();
    DVec3::new(first * cos, first * sin, second * (TAU * u[3]).cos())
}

/// A direction uniform on the unit sphere: by Archimedes' theorem its z is uniform in (-1, 1).
#[must_use]
pub fn direction(u0: f64, u1: f64) -> DVec3 {
    let z = 2.0 * u0 - 1.0;
    let (sin, cos) = (TAU * u1).sin_cos();
    let rho = (1.0 - z * z).sqrt();
    DVec3::new(rho * cos, rho * sin, z)
}

/// A gamma variate of unit scale: half a squared normal for shape 1/2, else the rejection method of Marsaglia and Tsang,
/// ACM Trans. Math. Softw. 26, 363 (2000), for shapes of at least 1. Attempt i takes index i of `owner`.
///
/// # Panics
/// If `shape` is neither 1/2 nor at least 1.
#[must_use]
pub fn gamma(draw: &Draw, owner: u32, shape: f64) -> f64 {
    let attempt = |i| {
        let u = draw.uniforms(owner, i, 0);
        (normals(u).x, u[2])
    };
    if (shape - 0.5).abs() < 1e-9 {
        let (x, _) = attempt(0);
        return x * x / 2.0;
    }
    assert!(shape >= 1.0, "gamma variates of shape {shape} are not provided");
    let d = shape - 1.0 / 3.0;
    let c = 1.0 / (9.0 * d).sqrt();
    let mut i = 0;
    loop {
        let (x, u) = attempt(i);
        let v = (1.0 + c * x).powi(3);
        if v > 0.0 && u.ln() < x * x / 2.0 + d - d * v + d * v.ln() {
            return d * v;
        }
        i += 1;
    }
}

/// The points of a Poisson process of unit rate on `[0, length)`, as the four uniforms of each: the first of them made the
/// point's distance from the one before it, the others are free. Point i takes index i of `owner`.
pub fn arrivals(draw: Draw, owner: u32, length: f64) -> impl Iterator<Item = (u32, [f64; 4])> {
    let mut time = 0.0;
    (0u32..).map(move |i| (i, draw.uniforms(owner, i, 0))).take_while(move |(_, u)| {
        time -= u[0].ln();
        time < length
    })
}
