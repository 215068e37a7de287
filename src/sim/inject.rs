//! Faults made on purpose, so that tests can see what a run makes of them.

use crate::gpu::Session;
use std::str::FromStr;

/// What breaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Breakage {
    /// The velocity of a particle becomes a number that is none.
    Nan,
    /// The velocity of a particle becomes infinite.
    Infinity,
    /// The GPU goes.
    Lost,
}

/// A fault made on purpose after a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Injection {
    /// What breaks.
    pub what: Breakage,
    /// After how many steps.
    pub step: u64,
}

impl FromStr for Injection {
    type Err = String;

    /// Reads `nan@STEP`, `infinity@STEP` or `lost@STEP`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (what, step) = text.split_once('@').ok_or("it must be WHAT@STEP")?;
        let what = match what {
            "nan" => Breakage::Nan,
            "infinity" => Breakage::Infinity,
            "lost" => Breakage::Lost,
            other => return Err(format!("`{other}` is none of nan, infinity, lost")),
        };
        let step = step.parse().map_err(|_| format!("`{step}` is no number of steps"))?;
        Ok(Self { what, step })
    }
}

impl Injection {
    /// Breaks it. Of the particles the one in the middle of memory is taken.
    pub fn apply(self, session: &Session) {
        let middle = session.particles() / 2;
        let spoil = |value: f32| session.write_at("velocities_yz", 8 * middle, &value.to_le_bytes());
        match self.what {
            Breakage::Nan => spoil(f32::NAN),
            Breakage::Infinity => spoil(f32::INFINITY),
            Breakage::Lost => session.lose(),
        }
    }
}
