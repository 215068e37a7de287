//! The collision rules that are held against theory.

use squirm::graph::Plan;
use squirm::math::transport::{Rule, Transport};
use squirm::params::Value;

/// A collision rule of the fluid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Collision {
    /// In names of parts.
    pub name: &'static str,
    /// In the report.
    pub title: &'static str,
    /// Mode of restore-thermostat.
    pub mode: &'static str,
    /// Whether cells conserve angular momentum.
    pub conserved: bool,
}

/// SRD-a, which keeps the energy.
pub const MINUS: Collision = Collision { name: "srd-a", title: "SRD-a", mode: "energy", conserved: false };
/// SRD-a with the Maxwell-Boltzmann-scaling thermostat.
pub const MINUS_THERMOSTAT: Collision =
    Collision { name: "srd-a-thermostat", title: "SRD-a, thermostat", mode: "thermostat", conserved: false };
/// SRD+a, which keeps the energy.
pub const ENERGY: Collision = Collision { name: "energy", title: "SRD+a, energy", mode: "energy", conserved: true };
/// SRD+a with a thermostat of what is neither momentum nor angular momentum.
pub const THERMOSTAT: Collision =
    Collision { name: "thermostat", title: "SRD+a, thermostat", mode: "thermostat", conserved: true };

/// Those that every property of the fluid at rest is measured with.
pub const ALL: [Collision; 3] = [MINUS, ENERGY, THERMOSTAT];

/// Kinematic viscosities of an independent f64 code (16 x 16 x 32, 1 to 2 %): rule, density, h, nu.
pub const INDEPENDENT: [(&str, f64, f64, f64); 7] = [
    ("srd-a", 10.0, 0.05, 1.643),
    ("srd-a", 10.0, 0.02, 3.964),
    ("energy", 10.0, 0.05, 0.741),
    ("energy", 10.0, 0.02, 1.769),
    ("energy", 50.0, 0.02, 2.147),
    ("thermostat", 50.0, 0.02, 2.143),
    ("thermostat", 10.0, 0.02, 1.769),
];

impl Collision {
    /// What makes a pipeline file use this rule.
    pub fn sets(&self) -> Vec<String> {
        vec![
            format!("stage.restore-thermostat.mode={}", self.mode),
            format!("stage.restore-thermostat.angular_momentum={}", self.conserved),
        ]
    }

    /// Transport coefficients by molecular chaos at 10 particles per cell, temperature 1 and 130 degrees.
    pub fn transport(&self, dt: f64) -> Transport {
        Rule { density: 10.0, temperature: 1.0, dt, angle: 130.0, angular_momentum: self.conserved }.transport()
    }
}

/// A box of this size.
pub fn size_set([x, y, z]: [u32; 3]) -> String {
    format!("box.size=[{x},{y},{z}]")
}

/// Runs SRD-a where SRD+a is meant: a spoiled plan.
pub fn without_angular_momentum(plan: &mut Plan) {
    for stage in plan.stages.iter_mut().filter(|s| s.entry.kind == "restore-thermostat") {
        stage.values.set("angular_momentum", Value::Boolean(false));
    }
}
