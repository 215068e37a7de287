//! Every case, in the order of the report.

mod balance;
mod body_diffusion;
mod body_temperature;
mod clusters;
mod conservation;
mod couette;
mod drag;
mod equilibrium;
mod flow_field;
mod isotropy;
mod jeffery;
mod orientation;
mod poiseuille;
mod precision;
mod rotlet;
mod self_diffusion;
mod stall;
mod swimming;
mod swinging;
mod two_pullers;
mod viscosity;
mod wall_swimmer;

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
    body_diffusion::CASE,
    orientation::CASE,
    body_temperature::CASE,
    drag::CASE,
    jeffery::CASE,
    swimming::CASE,
    flow_field::CASE,
    stall::CASE,
    rotlet::CASE,
    wall_swimmer::CASE,
    balance::CASE,
    swinging::CASE,
    two_pullers::CASE,
    clusters::CASE,
    precision::CASE,
];
