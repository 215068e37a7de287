//! Spheroids: volume, inertia, slip velocity and swim speed.

/// Semi-axes of a spheroid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spheroid {
    /// Semi-axis along the axis e, in a.
    pub along: f64,
    /// Semi-axes perpendicular to e, in a.
    pub across: f64,
}

impl Spheroid {
    /// Volume in a^3.
    #[must_use]
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.along * self.across * self.across
    }
}
