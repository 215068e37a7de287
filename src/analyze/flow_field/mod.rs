//! The mean flow of the fluid: in the lab frame, and around squirmers in bins that go and turn with them.

mod body;
mod lab;

use super::grid::{Fluid, Grid};
use super::kinds::Definition;
use super::pairs::Pairs;
use super::statistics::Estimate;
use super::table::{Table, line};
use super::{AnalyzeError, Analyzer, Report};
use crate::params;
use crate::wire::{Kind, Snapshot, Squirmers};
use body::Body;
use lab::Lab;

params! {
    /// Mean flow of the fluid in the lab frame, and around the squirmers in the frame of their bodies. Lab frame: mass
    /// and momentum of a layer of blocks, or of all layers along an axis. Body frame: each block around a squirmer is
    /// entered by its middle at its distance rho from the swimming axis and its height z along it, nearest image,
    /// averaged about the axis over all squirmers of a species; components along rho, e x rho and e. Blocks with their
    /// middle inside the body are left out. The body frame needs fields and squirmers of the same steps.
    pub struct FlowFieldOptions {
        /// The axis along which the lab frame is looked at.
        pub look: String = "y"; "", Choice(&["x", "y", "z"]);
        /// Only the layer of blocks at this coordinate on that axis; left out, the average along it.
        pub at: Option<f64>; "a", Float { min: 0.0, max: 1e6 };
        /// Edge of the bins of the body frame; left out, that of the blocks.
        pub bin: Option<f64>; "a", Float { min: 0.01, max: 1000.0 };
        /// Largest rho and z of the body frame; left out, four times the longest semi-axis; at most half the shortest
        /// periodic edge.
        pub reach: Option<f64>; "a", Float { min: 0.1, max: 1e6 };
        /// Velocities of the body frame: lab, as they are; relative, less that of the squirmer.
        pub velocity: String = "lab"; "", Choice(&["lab", "relative"]);
    }
}

/// The analyzer behind `squirm-analyze flow-field`.
#[derive(Debug)]
pub struct FlowField {
    options: FlowFieldOptions,
    grid: Option<Grid>,
    lab: Lab,
    pairs: Pairs<Fluid, Squirmers>,
    bodies: Vec<Body>,
    paired: u64,
}

impl Definition for FlowField {
    const NAME: &'static str = "flow-field";
    const TOPICS: &'static [Kind] = &[Kind::Fields];
    const EXTRAS: &'static [Kind] = &[Kind::Squirmers];
    type Options = FlowFieldOptions;

    fn new(options: FlowFieldOptions) -> Self {
        let across = ["x", "y", "z"].iter().position(|a| *a == options.look).unwrap_or(1);
        let lab = Lab::new(across, options.at);
        Self { options, grid: None, lab, pairs: Pairs::default(), bodies: Vec::new(), paired: 0 }
    }
}

impl FlowField {
    fn relative(&self) -> bool {
        self.options.velocity == "relative"
    }

    fn enter(&mut self, fluid: &Fluid, squirmers: &Squirmers) -> Result<(), AnalyzeError> {
        if self.bodies.is_empty() {
            let bin = self.options.bin.unwrap_or(fluid.grid.block);
            let body = |species: &crate::wire::SpeciesRow| {
                let reach = self.options.reach.unwrap_or(4.0 * species.along.max(species.across));
                Body::new(species.clone(), bin, reach.min(fluid.grid.space.reach()))
            };
            self.bodies = squirmers.table.iter().map(body).collect();
        }
        if self.bodies.len() != squirmers.table.len() {
            return Err(AnalyzeError::changed());
        }
        let relative = self.relative();
        for (species, body) in self.bodies.iter_mut().enumerate() {
            body.enter(fluid, squirmers, species, relative);
        }
        self.paired += 1;
        Ok(())
    }
}

impl Analyzer for FlowField {
    fn topics(&self) -> Vec<Kind> {
        Self::TOPICS.to_vec()
    }

    fn extras(&self) -> Vec<Kind> {
        Self::EXTRAS.to_vec()
    }

    fn take(&mut self, snapshot: &Snapshot<'_>) -> Result<(), AnalyzeError> {
        let step = snapshot.header.step;
        let pair = if snapshot.kind() == Kind::Squirmers {
            self.pairs.second(step, Squirmers::decode(snapshot)?)
        } else {
            let fluid = Fluid::read(snapshot, &mut self.grid)?;
            self.lab.enter(&fluid)?;
            self.pairs.first(step, fluid)
        };
        match pair {
            Some((fluid, squirmers)) => self.enter(&fluid, &squirmers),
            None => Ok(()),
        }
    }

    fn finish(&mut self) -> Result<Report, AnalyzeError> {
        let Some(grid) = self.grid.filter(|_| self.lab.snapshots() > 0) else {
            return Err(AnalyzeError::nothing(Kind::Fields));
        };
        let mut files =
            vec![("lab.csv".to_owned(), self.lab.csv(&grid)?), ("lab.svg".to_owned(), self.lab.map(&grid).svg())];
        let snapshots = self.lab.snapshots();
        let mut summary = format!("{snapshots} snapshots of the fields, {} of them with squirmers\n", self.paired);
        let seen: Vec<&Body> = self.bodies.iter().filter(|b| b.seen() > 0.0).collect();
        if seen.is_empty() {
            summary += "no squirmers at the steps of the fields, so no body frame: record squirmers and fields in one [[output]]\n";
        } else {
            let velocity = ["v_rho", "v_phi", "v_z"].map(|k| format!("{k} [sqrt(kT/m)],error")).join(",");
            let mut table = Table::new(&format!("species,rho [a],z [a],{velocity},mass seen [m]"));
            seen.iter().for_each(|body| body.rows(&mut table));
            files.push(("body.csv".into(), table.finish()));
        }
        for (i, body) in seen.iter().enumerate() {
            let speed: Estimate = body.speed();
            summary += &line(&format!("{}: mean of V.e", body.species.name), speed, "sqrt(kT/m)");
            let name = if seen.len() == 1 { "body.svg".into() } else { format!("body-{}.svg", i + 1) };
            files.push((name, body.map(self.relative()).svg()));
        }
        Ok(Report { summary, files })
    }
}
