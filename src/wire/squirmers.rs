//! The `squirmers` message: one row per squirmer, and one per species.

use super::encode::message_bytes;
use super::header::padded;
use super::{Encoder, Kind, Snapshot, Stamp, WireError};

/// What a reader needs to know about one species.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SpeciesRow {
    /// Name, at most 32 bytes.
    pub name: String,
    /// Semi-axis along the swimming axis in a.
    pub along: f64,
    /// Semi-axes across it in a.
    pub across: f64,
    /// B1 in sqrt(kT/m).
    pub b1: f64,
    /// Active stress.
    pub beta: f64,
    /// Rotlet dipole C2 in sqrt(kT/m).
    pub rotlet: f64,
    /// Swimming speed U0 in sqrt(kT/m) that theory predicts in an unbounded fluid; NaN if unknown.
    pub u0: f64,
}

/// Every squirmer of a run at one moment; all columns have one length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Squirmers {
    /// Number of the squirmer, stable over the run.
    pub id: Vec<u32>,
    /// Row in `table`.
    pub species: Vec<u32>,
    /// Centre in a; in `[0, L)` on periodic axes.
    pub position: Vec<[f32; 3]>,
    /// Centre in a, followed through the periodic boundaries from the start of the run.
    pub unwrapped: Vec<[f64; 3]>,
    /// Swimming axis e, a unit vector.
    pub axis: Vec<[f32; 3]>,
    /// Quaternion x, y, z, w that turns body axes into lab axes; the body's z axis is e.
    pub orientation: Vec<[f32; 4]>,
    /// Velocity of the centre in sqrt(kT/m).
    pub velocity: Vec<[f32; 3]>,
    /// Angular velocity, lab frame, in 1/tau.
    pub angular_velocity: Vec<[f32; 3]>,
    /// Force on the body in kT/a.
    pub force: Vec<[f32; 3]>,
    /// Torque on the body about its centre in kT.
    pub torque: Vec<[f32; 3]>,
    /// The species.
    pub table: Vec<SpeciesRow>,
}

impl Squirmers {
    /// Length of the message of `n` squirmers of so many species.
    #[must_use]
    pub fn message_bytes(n: usize, species: usize) -> usize {
        let squirmers = [4, 4, 12, 24, 12, 16, 12, 12, 12, 12].map(|width| (width, n));
        let table = [32, 16, 8, 8, 8, 8].map(|width| (width, species));
        message_bytes(&[&squirmers[..], &table].concat())
    }

    /// The message.
    #[must_use]
    pub fn encode(&self, stamp: &Stamp) -> Vec<u8> {
        let names: Vec<[u8; 32]> = self.table.iter().map(|s| padded(&s.name)).collect();
        let axes: Vec<[f64; 2]> = self.table.iter().map(|s| [s.along, s.across]).collect();
        let pick = |value: fn(&SpeciesRow) -> f64| self.table.iter().map(|s| [value(s)]).collect::<Vec<[f64; 1]>>();
        Encoder::new(Kind::Squirmers, stamp)
            .rows(self.id.len(), self.id.len() as u64)
            .flat("id", "", 1, &self.id)
            .flat("species", "", 1, &self.species)
            .column("position", "a", &self.position)
            .column("unwrapped", "a", &self.unwrapped)
            .column("axis", "", &self.axis)
            .column("orientation", "", &self.orientation)
            .column("velocity", "sqrt(kT/m)", &self.velocity)
            .column("angular_velocity", "1/tau", &self.angular_velocity)
            .column("force", "kT/a", &self.force)
            .column("torque", "kT", &self.torque)
            .column("species.name", "", &names)
            .column("species.semi_axes", "a", &axes)
            .column("species.b1", "sqrt(kT/m)", &pick(|s| s.b1))
            .column("species.beta", "", &pick(|s| s.beta))
            .column("species.rotlet", "sqrt(kT/m)", &pick(|s| s.rotlet))
            .column("species.u0", "sqrt(kT/m)", &pick(|s| s.u0))
            .finish()
    }

    /// The squirmers of a message.
    ///
    /// # Errors
    /// If it is a message of another kind, or its columns do not fit together.
    pub fn decode(snapshot: &Snapshot<'_>) -> Result<Self, WireError> {
        snapshot.expect(Kind::Squirmers)?;
        let names = snapshot.texts::<32>("species.name")?;
        let axes = snapshot.rows::<f64, 2>("species.semi_axes")?;
        let [b1, beta, rotlet, u0] =
            ["b1", "beta", "rotlet", "u0"].map(|c| snapshot.values::<f64>(&format!("species.{c}")));
        let (b1, beta, rotlet, u0) = (b1?, beta?, rotlet?, u0?);
        let one_length = [axes.len(), b1.len(), beta.len(), rotlet.len(), u0.len()].iter().all(|n| *n == names.len());
        if !one_length {
            return Err(WireError::Malformed("the species' columns have different lengths".into()));
        }
        let species_row = |(i, name)| {
            let [along, across]: [f64; 2] = axes[i];
            SpeciesRow { name, along, across, b1: b1[i], beta: beta[i], rotlet: rotlet[i], u0: u0[i] }
        };
        let squirmers = Self {
            id: snapshot.values("id")?,
            species: snapshot.values("species")?,
            position: snapshot.rows("position")?,
            unwrapped: snapshot.rows("unwrapped")?,
            axis: snapshot.rows("axis")?,
            orientation: snapshot.rows("orientation")?,
            velocity: snapshot.rows("velocity")?,
            angular_velocity: snapshot.rows("angular_velocity")?,
            force: snapshot.rows("force")?,
            torque: snapshot.rows("torque")?,
            table: names.into_iter().enumerate().map(species_row).collect(),
        };
        squirmers.check()?;
        Ok(squirmers)
    }

    /// All columns have one length, and every species is in the table.
    fn check(&self) -> Result<(), WireError> {
        let vectors = [&self.position, &self.axis, &self.velocity, &self.angular_velocity, &self.force, &self.torque];
        let n = self.id.len();
        if self.species.len() != n
            || self.unwrapped.len() != n
            || self.orientation.len() != n
            || vectors.iter().any(|v| v.len() != n)
        {
            return Err(WireError::Malformed("the squirmers' columns have different lengths".into()));
        }
        match self.species.iter().find(|s| **s as usize >= self.table.len()) {
            Some(s) => Err(WireError::Malformed(format!("species {s} of {} in the table", self.table.len()))),
            None => Ok(()),
        }
    }
}
