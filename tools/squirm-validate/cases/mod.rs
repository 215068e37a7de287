//! Every case, in the order of the report.

mod clusters;
mod swinging;
mod two_pullers;
mod viscosity;

use crate::case::Case;

/// All of them.
pub const ALL: &[Case] = &[viscosity::CASE, swinging::CASE, two_pullers::CASE, clusters::CASE];
