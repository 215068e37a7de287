//! Density, velocity and temperature across a slit, or along any axis of a box.

use super::grid::{Fluid, Grid};
use super::kinds::Definition;
use super::plot::{Chart, Curve, Scale};
use super::space::Space;
use super::statistics::Estimate;
use super::stretches::Stretches;
use super::table::Table;
use super::{AnalyzeError, Analyzer, Report};
use crate::params;
use crate::wire::{Kind, Particles, Snapshot};
use std::fmt::Write;

params! {
    /// Density, velocity and temperature of the fluid across the slit. Density and velocity are those of the layers of
    /// blocks of the fields; where a squirmer is, there is no fluid. The temperature is not in the fields: it is taken
    /// from recorded or published particles, where there are any, as the variance of their velocities about the mean of
    /// each bin. A shear G adds (G bin)^2/36 to it.
    pub struct ProfileOptions {
        /// The axis along which to look: y is across a slit.
        pub axis: String = "y"; "", Choice(&["x", "y", "z"]);
        /// Width of the bins of the temperature.
        pub bin: f64 = 1.0; "a", Float { min: 0.01, max: 1000.0 };
    }
}

/// The analyzer behind `squirm-analyze profile`.
#[derive(Debug)]
pub struct Profile {
    options: ProfileOptions,
    grid: Option<Grid>,
    /// Of every layer of blocks: mass, momentum along x, y and z.
    layers: Stretches,
    space: Option<Space>,
    /// Of every bin: three times the particles less one, squares of their velocities about the mean.
    bins: Stretches,
}

impl Definition for Profile {
    const NAME: &'static str = "profile";
    const TOPICS: &'static [Kind] = &[Kind::Fields];
    const EXTRAS: &'static [Kind] = &[Kind::Particles];
    type Options = ProfileOptions;

    fn new(options: ProfileOptions) -> Self {
        Self { options, grid: None, layers: Stretches::default(), space: None, bins: Stretches::default() }
    }
}

impl Profile {
    fn axis(&self) -> usize {
        ["x", "y", "z"].iter().position(|a| *a == self.options.axis).unwrap_or(1)
    }

    /// Ends of a bin of the temperature; the last one may be cut by the end of the box.
    fn ends(&self, space: &Space, bin: usize) -> (f64, f64) {
        let width = self.options.bin;
        (bin as f64 * width, ((bin + 1) as f64 * width).min(space.edge[self.axis()]))
    }

    fn enter_fluid(&mut self, fluid: &Fluid) {
        let (axis, grid) = (self.axis(), &fluid.grid);
        if self.layers.snapshots() == 0 {
            self.layers = Stretches::new(4 * grid.blocks[axis]);
        }
        let sums = self.layers.begin();
        for index in 0..grid.len() {
            let place = grid.at(index);
            let held = fluid.held(place);
            let momentum = held.mass * held.velocity;
            for (k, value) in [held.mass, momentum.x, momentum.y, momentum.z].into_iter().enumerate() {
                sums[4 * place[axis] + k] += value;
            }
        }
    }

    fn enter_particles(&mut self, space: &Space, particles: &Particles) {
        let axis = self.axis();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let count = (space.edge[axis] / self.options.bin - 1e-9).ceil().max(1.0) as usize;
        if self.bins.snapshots() == 0 {
            self.bins = Stretches::new(2 * count);
        }
        // Number, sums of the velocities and of their squares.
        let mut moments = vec![[0.0f64; 5]; count];
        for (place, velocity) in particles.position.iter().zip(&particles.velocity) {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let bin = ((f64::from(place[axis]) / self.options.bin) as usize).min(count - 1);
            let v = velocity.map(f64::from);
            let add = [1.0, v[0], v[1], v[2], v[0] * v[0] + v[1] * v[1] + v[2] * v[2]];
            moments[bin].iter_mut().zip(add).for_each(|(sum, value)| *sum += value);
        }
        let sums = self.bins.begin();
        for (i, [n, x, y, z, squares]) in moments.into_iter().enumerate().filter(|(_, m)| m[0] > 1.0) {
            sums[2 * i] += 3.0 * (n - 1.0);
            sums[2 * i + 1] += squares - (x * x + y * y + z * z) / n;
        }
    }
}

impl Analyzer for Profile {
    fn topics(&self) -> Vec<Kind> {
        Self::TOPICS.to_vec()
    }

    fn extras(&self) -> Vec<Kind> {
        Self::EXTRAS.to_vec()
    }

    fn take(&mut self, snapshot: &Snapshot<'_>) -> Result<(), AnalyzeError> {
        if snapshot.kind() == Kind::Particles {
            let space = Space::of(&snapshot.header);
            if *self.space.get_or_insert(space) != space {
                return Err(AnalyzeError::changed());
            }
            self.enter_particles(&space, &Particles::decode(snapshot)?);
        } else {
            let fluid = Fluid::read(snapshot, &mut self.grid)?;
            self.enter_fluid(&fluid);
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<Report, AnalyzeError> {
        let Some(grid) = &self.grid else { return Err(AnalyzeError::nothing(Kind::Fields)) };
        let layers = self.found_layers(grid);
        let bins = self.space.map(|space| self.found_bins(&space)).unwrap_or_default();
        let name = &self.options.axis;
        let mut files = vec![
            ("profile.csv".into(), layers_csv(name, &layers)),
            ("density.svg".into(), self.density_chart(&layers).svg()?),
            ("velocity.svg".into(), self.velocity_chart(&layers).svg()?),
        ];
        let mut summary = layers_table(name, &layers);
        let _ = write!(
            summary,
            "{} snapshots of the fields, {} of particles",
            self.layers.snapshots(),
            self.bins.snapshots()
        );
        if bins.is_empty() {
            summary += ": no temperature, which needs particles (record = [\"particles\"] with a fraction)\n";
        } else {
            summary.push('\n');
            files.push(("temperature.csv".into(), bins_csv(name, &bins)));
            files.push(("temperature.svg".into(), self.temperature_chart(&bins).svg()?));
        }
        Ok(Report { summary, files })
    }
}

/// What was found in a layer of blocks.
struct Layer {
    /// Its middle.
    at: f64,
    density: Estimate,
    velocity: [Estimate; 3],
}

impl Profile {
    fn found_layers(&self, grid: &Grid) -> Vec<Layer> {
        let axis = self.axis();
        let area: f64 = (0..3).filter(|k| *k != axis).map(|k| grid.space.edge[k]).product();
        let layer = |i: usize| {
            let (low, high) = grid.ends(axis, i);
            let (mass, volume) = (self.layers.mean(4 * i), area * (high - low));
            Layer {
                at: f64::midpoint(low, high),
                density: Estimate { mean: mass.mean / volume, error: mass.error / volume },
                velocity: [1, 2, 3].map(|k| self.layers.ratio(4 * i + k, 4 * i)),
            }
        };
        (0..grid.blocks[axis]).map(layer).collect()
    }

    /// Middle of every bin, and its temperature.
    fn found_bins(&self, space: &Space) -> Vec<(f64, Estimate)> {
        let bin = |i: usize| {
            let (low, high) = self.ends(space, i);
            (f64::midpoint(low, high), self.bins.ratio(2 * i + 1, 2 * i))
        };
        (0..self.bins.width() / 2).map(bin).filter(|(_, t)| t.mean.is_finite()).collect()
    }

    fn chart(&self, title: &str, y: &str, curves: Vec<Curve>) -> Chart {
        Chart {
            title: title.into(),
            x: format!("{} [a]", self.options.axis),
            y: y.into(),
            scale: Scale::Linear,
            curves,
        }
    }

    fn density_chart(&self, layers: &[Layer]) -> Chart {
        let points = layers.iter().map(|l| (l.at, l.density.mean, l.density.error)).collect();
        let curve = Curve { name: "fluid".into(), points, ..Curve::default() };
        self.chart("Density across the box", "density [m/a^3]", vec![curve])
    }

    fn velocity_chart(&self, layers: &[Layer]) -> Chart {
        let curve = |k: usize| Curve {
            name: ["v_x", "v_y", "v_z"][k].into(),
            points: layers.iter().map(|l| (l.at, l.velocity[k].mean, l.velocity[k].error)).collect(),
            ..Curve::default()
        };
        self.chart("Velocity across the box", "velocity [sqrt(kT/m)]", [0, 1, 2].map(curve).to_vec())
    }

    fn temperature_chart(&self, bins: &[(f64, Estimate)]) -> Chart {
        let points = bins.iter().map(|(at, t)| (*at, t.mean, t.error)).collect();
        let curve = Curve { name: "about the mean velocity of each bin".into(), points, ..Curve::default() };
        self.chart("Temperature across the box", "temperature [kT]", vec![curve])
    }
}

fn layers_csv(axis: &str, layers: &[Layer]) -> String {
    let velocity = ["x", "y", "z"].map(|k| format!("v_{k} [sqrt(kT/m)],error")).join(",");
    let mut table = Table::new(&format!("{axis} [a],density [m/a^3],error,{velocity}"));
    for l in layers {
        let [x, y, z] = l.velocity.map(Into::into);
        table.row(&[l.at.into(), l.density.into(), x, y, z]);
    }
    table.finish()
}

fn bins_csv(axis: &str, bins: &[(f64, Estimate)]) -> String {
    let mut table = Table::new(&format!("{axis} [a],temperature [kT],error"));
    bins.iter().for_each(|(at, t)| table.row(&[(*at).into(), (*t).into()]));
    table.finish()
}

fn layers_table(axis: &str, layers: &[Layer]) -> String {
    let head = format!("{axis} [a]");
    let mut text = format!("{head:>8} {:>24} {:>24}\n", "density [m/a^3]", "v_x [sqrt(kT/m)]");
    let shown = |e: Estimate| format!("{:.5} +- {:.5}", e.mean, e.error);
    for l in layers {
        let _ = writeln!(text, "{:>8.2} {:>24} {:>24}", l.at, shown(l.density), shown(l.velocity[0]));
    }
    text
}
