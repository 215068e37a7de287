//! restore-thermostat: what the rotation lost, angular momentum above all, and the temperature.

use super::{Finding, Gravity, Phase, Stage};
use crate::buffers::Extent;
use crate::math::draws::gamma;
use crate::math::linear::pseudo_inverse;
use crate::math::rng::{Draw, Purpose, fifth, unit};
use crate::state::System;
use crate::state::scene::{Moments, Operator, Scene, outer};
use crate::{params, shared};
use glam::{DMat3, DVec3};

params! {
    /// Gives each cell back the angular momentum that the rotation lost, by a rigid rotation (Noguchi and Gompper, Phys.
    /// Rev. E 78, 016706, 2008), and sets the energy of what is left, the velocities relative to that rigid motion. Torques
    /// on squirmers need it: without angular momentum the fluid's stress is not symmetric.
    pub struct RestoreThermostat {
        /// thermostat: that energy is drawn anew from its law at the fluid's temperature (Huang et al., J. Comput. Phys. 229,
        /// 168, 2010); driven and active fluids need it. energy: it is kept, so that each cell conserves energy exactly.
        /// angular-momentum-only: it is left as it comes out, and the temperature drifts.
        pub mode: String = "thermostat"; "", Choice(&["thermostat", "energy", "angular-momentum-only"]);
        /// Whether angular momentum is given back at all.
        pub angular_momentum: bool = true; "", Boolean;
    }
}

shared! {
    /// What to restore.
    pub struct RestoreThermostatSettings {
        /// 0 energy, 1 thermostat, 2 angular momentum only.
        mode: u32,
        /// 1 if angular momentum is restored.
        angular_momentum: u32,
        /// Not used.
        pad0: u32,
        /// Not used.
        pad1: u32,
    }
}

impl Stage for RestoreThermostat {
    const KIND: &'static str = "restore-thermostat";
    const WGSL: &'static str = include_str!("../../shaders/stages/restore-thermostat.wgsl");
    const EACH: &'static [(&'static str, &'static str)] = &[("restore", "restored")];
    const PHASES: &'static [Phase] = &[Phase { entry: "restore", over: Extent::Cells }];
    const AFTER: &'static [&'static str] = &["rotate"];
    type Params = Self;
    type Uniform = RestoreThermostatSettings;

    fn places(params: &Self) -> bool {
        params.angular_momentum
    }

    fn energies(params: &Self) -> bool {
        params.angular_momentum || params.mode == "thermostat"
    }

    fn check(params: &Self, system: &System) -> Vec<Finding> {
        let mut findings = Vec::new();
        if params.mode == "angular-momentum-only" && !params.angular_momentum {
            findings.push(Finding {
                gravity: Gravity::Error,
                field: "angular_momentum",
                message: "there is nothing left to restore".into(),
                help: "set `angular_momentum = true`, choose another mode, or remove this stage".into(),
            });
        }
        if system.fluid.density < 3.0 {
            let density = system.fluid.density;
            findings.push(Finding {
                gravity: Gravity::Warning,
                field: "",
                message: format!("at {density} particles per cell many cells hold none, one or two, which have few or no degrees of freedom left"),
                help: "take a fluid density of at least 5".into(),
            });
        }
        findings
    }

    fn uniform(params: &Self, _: &System) -> RestoreThermostatSettings {
        let mode = match Energy::of(params) {
            Energy::Kept => 0,
            Energy::Drawn => 1,
            Energy::Left => 2,
        };
        RestoreThermostatSettings { mode, angular_momentum: params.angular_momentum.into(), pad0: 0, pad1: 0 }
    }

    fn reference(params: &Self, system: &System, scene: &mut Scene) {
        let [first, next] = [Purpose::Collision, Purpose::Thermostat]
            .map(|purpose| Draw::new(system.run.seed, purpose, scene.state.step));
        for (cell, moments) in (0u32..).zip(&scene.moments) {
            let operator = &mut scene.operators[cell as usize];
            // Twice the energy to scale to, for a number of degrees of freedom.
            let attempt = |i| match i {
                0 => {
                    let words = first.words(cell, 0, 0);
                    [unit(words[2]), unit(words[3]), fifth(words)]
                }
                _ => {
                    let [a, b, c, _] = next.uniforms(cell, i, 0);
                    [a, b, c]
                }
            };
            let drawn = |dof: f64| 2.0 * system.fluid.temperature * gamma(dof / 2.0, attempt);
            *operator = match Relative::of(moments) {
                Some(relative) if params.angular_momentum => {
                    relative.with_angular_momentum(operator.a, Energy::of(params), drawn)
                }
                Some(relative) => relative.energy_alone(operator.a, Energy::of(params), drawn),
                None => Operator::default(),
            };
        }
    }
}

/// What becomes of the energy of the velocities relative to the rigid motion.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Energy {
    Kept,
    Drawn,
    Left,
}

impl Energy {
    fn of(params: &RestoreThermostat) -> Self {
        match params.mode.as_str() {
            "energy" => Self::Kept,
            "thermostat" => Self::Drawn,
            _ => Self::Left,
        }
    }
}

/// The second moments of one cell about its centre of mass, in its frame; x and w are positions and velocities there.
struct Relative {
    count: f64,
    centre: DVec3,
    mean: DVec3,
    /// sum x x^T.
    xx: DMat3,
    /// sum x w^T.
    xw: DMat3,
    /// sum |w|^2.
    energy: f64,
}

impl Relative {
    /// `None` if there are no relative velocities, or none that sums in f32 would show.
    fn of(moments: &Moments) -> Option<Self> {
        let count = moments.count;
        if count < 2.0 {
            return None;
        }
        let (centre, mean) = (moments.x / count, moments.v / count);
        let energy = moments.energy - count * mean.length_squared();
        if energy <= 1e-6 * moments.energy {
            return None;
        }
        Some(Self {
            count,
            centre,
            mean,
            xx: moments.xx - count * outer(centre, centre),
            xw: moments.xv - count * outer(centre, mean),
            energy,
        })
    }

    /// v' = mean + a (v - mean) + w x (x - centre), written about the cell's centre.
    fn operator(&self, a: DMat3, w: DVec3) -> Operator {
        Operator { a, w, b: self.mean - a * self.mean - w.cross(self.centre) }
    }

    /// Scales all relative velocities (Huang et al. 2010): 3 (N - 1) degrees of freedom.
    fn energy_alone(&self, rotation: DMat3, rule: Energy, drawn: impl Fn(f64) -> f64) -> Operator {
        if rule != Energy::Drawn {
            return self.operator(rotation, DVec3::ZERO);
        }
        let factor = (drawn(3.0 * (self.count - 1.0)) / self.energy).sqrt();
        self.operator(factor * rotation, DVec3::ZERO)
    }

    /// Splits w = omega x x + u, so that sum x x u = 0, before and after the rotation; keeps omega of before and scales u
    /// of after. Twice the energy of u is sum |w|^2 - omega . L.
    fn with_angular_momentum(&self, rotation: DMat3, rule: Energy, drawn: impl Fn(f64) -> f64) -> Operator {
        let spread = self.xx.x_axis.x + self.xx.y_axis.y + self.xx.z_axis.z;
        if spread < 1e-3 {
            return Operator::default();
        }
        let inverse = pseudo_inverse(DMat3::from_diagonal(DVec3::splat(spread)) - self.xx);
        let before = moment_of(self.xw);
        let after = moment_of(self.xw * rotation.transpose());
        let (omega, turned) = (inverse * before, inverse * after);
        let residual = self.energy - omega.dot(before);
        let rotated = self.energy - turned.dot(after);
        match rule {
            Energy::Left => self.operator(rotation, omega - turned),
            // A residual that rounding may have made has no direction to scale.
            Energy::Drawn if self.count < 3.0 && residual <= 1e-6 * self.energy => Operator::default(),
            _ if self.count < 3.0 => {
                // u of a pair lies along its line: the rotation and the projection can only turn its sign.
                let stretch = self.xw.x_axis.x + self.xw.y_axis.y + self.xw.z_axis.z;
                let stretch_after = (0..3).map(|i| self.xw.row(i).dot(rotation.row(i))).sum::<f64>();
                let sign = if stretch * stretch_after < 0.0 { -1.0 } else { 1.0 };
                let scale = if rule == Energy::Drawn { (drawn(1.0) / residual).sqrt() } else { 1.0 };
                let factor = sign * scale;
                self.operator(DMat3::from_diagonal(DVec3::splat(factor)), (1.0 - factor) * omega)
            }
            _ if rotated <= 1e-4 * self.energy => Operator::default(),
            _ => {
                let wanted = if rule == Energy::Drawn { drawn(3.0 * self.count - 6.0) } else { residual.max(0.0) };
                let factor = (wanted / rotated).sqrt();
                self.operator(factor * rotation, omega - factor * turned)
            }
        }
    }
}

/// sum x x w from sum x w^T.
fn moment_of(xw: DMat3) -> DVec3 {
    let entry = |i: usize, j: usize| xw.col(j)[i];
    DVec3::new(entry(1, 2) - entry(2, 1), entry(2, 0) - entry(0, 2), entry(0, 1) - entry(1, 0))
}
