//! Every case, in the order of the report.

mod flow_field;
mod rotlet;
mod swimming;
pub mod viscosity;

use crate::case::Case;

/// All of them.
pub const ALL: &[Case] = &[viscosity::CASE, swimming::CASE, flow_field::CASE, rotlet::CASE];
