//! Every case, in the order of the report.

mod body_diffusion;
mod body_temperature;
mod clusters;
mod drag;
mod jeffery;
mod orientation;
mod swinging;
mod two_pullers;
mod viscosity;

use crate::case::Case;

/// All of them.
pub const ALL: &[Case] = &[
    viscosity::CASE,
    body_diffusion::CASE,
    orientation::CASE,
    body_temperature::CASE,
    drag::CASE,
    jeffery::CASE,
    swinging::CASE,
    two_pullers::CASE,
    clusters::CASE,
];
