//! Energy spectrum of the fluid's velocity, with the floor that thermal noise alone would give.

use super::grid::{Fluid, Grid};
use super::kinds::Definition;
use super::plot::{Chart, Curve, Scale};
use super::statistics::Estimate;
use super::stretches::Stretches;
use super::table::{Table, line};
use super::{AnalyzeError, Analyzer, Report};
use crate::params;
use crate::wire::{Kind, Snapshot};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::TAU;
use std::sync::Arc;

params! {
    /// Energy spectrum E(k) of the fluid's velocity, and the thermal noise in it. From the mean velocities u of the
    /// blocks: the sum of E(k) times the width of the bins, over all k > 0, is the mean of |u - mean u|^2/2. Wave
    /// vectors lie along periodic axes only: between walls the spectrum is that of the layers of blocks in x and z,
    /// averaged over y. The noise floor is that of a fluid at rest in equilibrium, whose blocks have independent
    /// velocities of variance kT/(n m) per component with n particles. The largest k, beyond pi/block, are those of the
    /// corners of the grid.
    pub struct SpectrumOptions {
        /// Temperature of the fluid, for the noise floor.
        pub temperature: f64 = 1.0; "kT", Float { min: 0.0, max: 1e6 };
    }
}

/// The analyzer behind `squirm-analyze spectrum`.
pub struct Spectrum {
    options: SpectrumOptions,
    grid: Option<Grid>,
    waves: Option<Waves>,
    /// Energy in every bin of k, then that of the mean flow, of all, and the mean of 1/n.
    sums: Stretches,
}

impl Definition for Spectrum {
    const NAME: &'static str = "spectrum";
    const TOPICS: &'static [Kind] = &[Kind::Fields];
    type Options = SpectrumOptions;

    fn new(options: SpectrumOptions) -> Self {
        Self { options, grid: None, waves: None, sums: Stretches::default() }
    }
}

/// The transform and the bin of every mode.
struct Waves {
    /// The axes that are transformed, with their transforms.
    axes: Vec<(usize, Arc<dyn Fft<f64>>)>,
    /// Width of the bins of k in 1/a; bin i is about i times this.
    width: f64,
    /// Bin of each block of the transformed grid; 0 is the mean flow.
    bins: Vec<usize>,
    /// Of each bin, the number of modes of one layer and the sum of their |k|.
    modes: Vec<(f64, f64)>,
}

impl Waves {
    fn new(grid: &Grid) -> Result<Self, AnalyzeError> {
        let axes: Vec<usize> = (0..3).filter(|k| grid.space.periodic(*k)).collect();
        if let Some(axis) = axes.iter().find(|k| grid.blocks[**k] as f64 * grid.block != grid.space.edge[**k]) {
            let (edge, block) = (grid.space.edge[*axis], grid.block);
            return Err(AnalyzeError::TooLittle(format!(
                "blocks of {block} a do not divide the edge of {edge} a: a spectrum needs blocks of one size; record fields with another `block`"
            )));
        }
        let width = TAU / axes.iter().map(|k| grid.space.edge[*k]).fold(0.0, f64::max);
        let (mut bins, mut modes) = (Vec::with_capacity(grid.len()), Vec::new());
        let layers = if grid.space.walls { grid.blocks[1] as f64 } else { 1.0 };
        for index in 0..grid.len() {
            let place = grid.at(index);
            let square = axes.iter().map(|axis| {
                let (i, n) = (place[*axis], grid.blocks[*axis]);
                let i = if 2 * i > n { i as f64 - n as f64 } else { i as f64 };
                (TAU * i / grid.space.edge[*axis]).powi(2)
            });
            let k = square.sum::<f64>().sqrt();
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let bin = (k / width).round() as usize;
            if modes.len() <= bin {
                modes.resize(bin + 1, (0.0, 0.0));
            }
            modes[bin].0 += 1.0 / layers;
            modes[bin].1 += k / layers;
            bins.push(bin);
        }
        let mut planner = FftPlanner::new();
        let axes = axes.into_iter().map(|axis| (axis, planner.plan_fft_forward(grid.blocks[axis]))).collect();
        Ok(Self { axes, width, bins, modes })
    }

    /// Transforms along every periodic axis in turn.
    fn transform(&self, grid: &Grid, values: &mut [Complex<f64>]) {
        for (axis, fft) in &self.axes {
            let (n, stride) = (grid.blocks[*axis], grid.blocks[..*axis].iter().product::<usize>());
            let mut line = vec![Complex::default(); n];
            let mut scratch = vec![Complex::default(); fft.get_inplace_scratch_len()];
            for start in (0..values.len()).filter(|i| grid.at(*i)[*axis] == 0) {
                (0..n).for_each(|i| line[i] = values[start + i * stride]);
                fft.process_with_scratch(&mut line, &mut scratch);
                (0..n).for_each(|i| values[start + i * stride] = line[i]);
            }
        }
    }
}

impl Spectrum {
    fn enter(&mut self, fluid: &Fluid) -> Result<(), AnalyzeError> {
        let grid = &fluid.grid;
        let waves = match self.waves.take() {
            Some(waves) => waves,
            None => Waves::new(grid)?,
        };
        let bins = waves.modes.len();
        if self.sums.snapshots() == 0 {
            self.sums = Stretches::new(bins + 2);
        }
        let held: Vec<_> = (0..grid.len()).map(|i| fluid.held(grid.at(i))).collect();
        let count = grid.len() as f64;
        let sums = self.sums.begin();
        // Modes of one layer are normalised by its blocks, layers are averaged: the product is the number of all
        // blocks. The transform of a complex field has both of two real ones: |F(k)|^2 + |F(-k)|^2 is twice the sum of
        // their squares.
        let layer: f64 = waves.axes.iter().map(|(axis, _)| grid.blocks[*axis] as f64).product();
        let pairs: [Vec<Complex<f64>>; 2] = [
            held.iter().map(|h| Complex::new(h.velocity.x, h.velocity.y)).collect(),
            held.iter().map(|h| Complex::new(h.velocity.z, 0.0)).collect(),
        ];
        for mut values in pairs {
            waves.transform(grid, &mut values);
            for (value, bin) in values.iter().zip(&waves.bins) {
                sums[*bin] += 0.5 * value.norm_sqr() / (layer * count);
            }
        }
        sums[bins] += held.iter().map(|h| 0.5 * h.velocity.length_squared()).sum::<f64>() / count;
        // An empty block has no velocity, and so no noise.
        sums[bins + 1] += held.iter().filter(|h| h.mass > 0.0).map(|h| 1.0 / h.mass).sum::<f64>() / count;
        self.waves = Some(waves);
        Ok(())
    }
}

impl Analyzer for Spectrum {
    fn topics(&self) -> Vec<Kind> {
        Self::TOPICS.to_vec()
    }

    fn take(&mut self, snapshot: &Snapshot<'_>) -> Result<(), AnalyzeError> {
        let fluid = Fluid::read(snapshot, &mut self.grid)?;
        self.enter(&fluid)
    }

    fn finish(&mut self) -> Result<Report, AnalyzeError> {
        let (Some(grid), Some(waves)) = (&self.grid, &self.waves) else {
            return Err(AnalyzeError::nothing(Kind::Fields));
        };
        let bins = waves.modes.len();
        let layer: f64 = waves.axes.iter().map(|(axis, _)| grid.blocks[*axis] as f64).product();
        let noise = 1.5 * self.options.temperature * self.sums.mean(bins + 1).mean;
        let band = |bin: usize| {
            let (modes, sum) = waves.modes[bin];
            let found = self.sums.mean(bin);
            let energy = Estimate { mean: found.mean / waves.width, error: found.error / waves.width };
            Band { k: sum / modes, modes, energy, noise: noise * modes / layer / waves.width }
        };
        let bands: Vec<Band> = (1..bins).filter(|b| waves.modes[*b].0 > 0.0).map(band).collect();
        let (all, mean) = (self.sums.mean(bins), self.sums.mean(0));
        let mut summary = format!("{} snapshots of {} blocks\n", self.sums.snapshots(), grid.len());
        summary += &line("energy of the velocity field, mean |u|^2/2", all, "kT/m");
        summary += &line(
            if grid.space.walls { "of it, the mean flow of the layers" } else { "of it, the mean flow" },
            mean,
            "kT/m",
        );
        let floor = Estimate { mean: noise * (1.0 - 1.0 / layer), error: f64::NAN };
        summary += &format!("{:<44} {:>12.5} kT/m\n", "thermal noise, from kT and the particles", floor.mean);
        Ok(Report {
            summary,
            files: vec![("spectrum.csv".into(), csv(&bands)), ("spectrum.svg".into(), chart(&bands, grid).svg()?)],
        })
    }
}

/// One bin of k.
struct Band {
    k: f64,
    modes: f64,
    energy: Estimate,
    noise: f64,
}

fn csv(bands: &[Band]) -> String {
    let mut table = Table::new("k [1/a],E(k) [a kT/m],error,thermal noise [a kT/m],modes");
    for b in bands {
        table.row(&[b.k.into(), b.energy.into(), b.noise.into(), b.modes.into()]);
    }
    table.finish()
}

fn chart(bands: &[Band], grid: &Grid) -> Chart {
    let name = if grid.space.walls { "layers between the walls, k in x and z" } else { "k in x, y and z" };
    let curve = Curve {
        name: name.into(),
        points: bands.iter().map(|b| (b.k, b.energy.mean, b.energy.error)).collect(),
        guide: bands.iter().map(|b| (b.k, b.noise)).collect(),
        guide_name: "thermal noise".into(),
    };
    Chart {
        title: "Energy spectrum of the fluid".into(),
        x: "wave number k [1/a]".into(),
        y: "E(k) [a kT/m]".into(),
        scale: Scale::Logarithmic,
        curves: vec![curve],
    }
}
