//! Every case, in the order of the report.

mod conservation;
mod couette;
mod equilibrium;
mod isotropy;
mod poiseuille;
mod precision;
mod self_diffusion;
mod viscosity;

use crate::case::Case;

/// All of them.
pub const ALL: &[Case] = &[
    conservation::CASE,
    equilibrium::CASE,
    viscosity::CASE,
    isotropy::CASE,
    poiseuille::CASE,
    couette::CASE,
    self_diffusion::CASE,
    precision::CASE,
];
