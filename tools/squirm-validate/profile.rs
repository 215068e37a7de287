//! The velocity along x across a slit, frame by frame, and the line or the parabola through it.

use crate::case::Trouble;
use crate::measure::Fluid;
use crate::rig::advance;
use squirm::analyze::statistics::blocked;
use squirm::gpu::Session;

/// Bins per cell across the slit.
const FINENESS: usize = 2;
/// Cells at a wall reach into it, and so do the collisions of particles within one cell of it: fits leave them out.
const MARGIN: f64 = 1.0;

/// Mean velocities of the slices of a slit, in sqrt(kT/m), for every frame.
pub struct Profile {
    height: f64,
    bins: usize,
    frames: Vec<Vec<f64>>,
}

impl Profile {
    /// An empty profile of a slit of this height in a.
    pub fn new(height: u32) -> Self {
        Self { height: height.into(), bins: height as usize * FINENESS, frames: Vec::new() }
    }

    /// Enters the fluid of this moment.
    pub fn enter(&mut self, fluid: &Fluid) {
        self.frames.push(fluid.slices(self.bins).iter().map(|s| s.velocity.x / s.count.max(1.0)).collect());
    }

    /// Advances the session by `frames` times `every` steps and enters the fluid each time.
    pub fn follow(&mut self, session: &mut Session, frames: usize, every: u64) -> Result<(), Trouble> {
        for _ in 0..frames {
            advance(session, every)?;
            self.enter(&Fluid::of(session)?);
        }
        Ok(())
    }

    fn width(&self) -> f64 {
        self.height / self.bins as f64
    }

    /// Height of a bin's centre above the middle of the slit.
    fn offset(&self, bin: usize) -> f64 {
        (bin as f64 + 0.5) * self.width() - self.height / 2.0
    }

    fn inner(&self) -> Vec<usize> {
        (0..self.bins)
            .filter(|b| self.offset(*b).abs() + self.width() / 2.0 < self.height / 2.0 - MARGIN + 1e-9)
            .collect()
    }

    /// Height above the low wall, mean velocity and its error, for every bin.
    pub fn points(&self) -> Vec<(f64, f64, f64)> {
        let point = |bin: usize| {
            let found = blocked(&self.frames.iter().map(|f| f[bin]).collect::<Vec<_>>());
            (self.offset(bin) + self.height / 2.0, found.mean, found.error)
        };
        (0..self.bins).map(point).collect()
    }

    /// Of every frame the parabola u = a + b x + c x^2 with x from the middle: (a, c). The bins are symmetric: b drops out.
    pub fn parabolas(&self) -> Vec<[f64; 2]> {
        let inner = self.inner();
        // A bin's mean velocity is that of x^2, which is width^2/12 more than the square of its centre.
        let squares: Vec<f64> = inner.iter().map(|b| self.offset(*b).powi(2) + self.width().powi(2) / 12.0).collect();
        let n = inner.len() as f64;
        let (s2, s4) = squares.iter().fold((0.0, 0.0), |(a, b), q| (a + q, b + q * q));
        let fit = |frame: &Vec<f64>| {
            let (u0, u2) =
                inner.iter().zip(&squares).fold((0.0, 0.0), |(a, b), (k, q)| (a + frame[*k], b + q * frame[*k]));
            let determinant = n * s4 - s2 * s2;
            [(s4 * u0 - s2 * u2) / determinant, (n * u2 - s2 * u0) / determinant]
        };
        self.frames.iter().map(fit).collect()
    }

    /// Of every frame the straight line u = a + b x with x from the middle: (a, b).
    pub fn lines(&self) -> Vec<[f64; 2]> {
        let inner = self.inner();
        let n = inner.len() as f64;
        let s2: f64 = inner.iter().map(|b| self.offset(*b).powi(2)).sum();
        let fit = |frame: &Vec<f64>| {
            let (u0, u1) = inner.iter().fold((0.0, 0.0), |(a, b), k| (a + frame[*k], b + self.offset(*k) * frame[*k]));
            [u0 / n, u1 / s2]
        };
        self.frames.iter().map(fit).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exact bin means of a cubic: the odd part must not reach the parabola, nor the even part the line.
    #[test]
    fn a_parabola_and_a_line_are_found_exactly() {
        let mut profile = Profile::new(12);
        let mean = |k: usize, p: i32| {
            let (low, high) = (profile.offset(k) - 0.25, profile.offset(k) + 0.25);
            (high.powi(p + 1) - low.powi(p + 1)) / (f64::from(p + 1) * 0.5)
        };
        let frame = (0..24).map(|k| 0.3 + 0.02 * mean(k, 1) - 0.007 * mean(k, 2)).collect();
        profile.frames.push(frame);
        assert_eq!(profile.inner().len(), 20);
        let [top, curvature] = profile.parabolas()[0];
        assert!((top - 0.3).abs() < 1e-12 && (curvature + 0.007).abs() < 1e-12, "{top} {curvature}");
        assert!((profile.lines()[0][1] - 0.02).abs() < 1e-12);
        assert!((profile.points()[0].0 - 0.25).abs() < 1e-12);
    }
}
