//! Every case, in the order of the report.

mod balance;
mod flow_field;
mod rotlet;
mod stall;
mod swimming;
pub mod viscosity;
mod wall_swimmer;

use crate::case::Case;

/// All of them.
pub const ALL: &[Case] =
    &[viscosity::CASE, balance::CASE, swimming::CASE, stall::CASE, flow_field::CASE, rotlet::CASE, wall_swimmer::CASE];
