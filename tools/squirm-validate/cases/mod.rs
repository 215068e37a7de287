//! Every case, in the order of the report.

mod viscosity;

use crate::case::Case;

/// All of them.
pub const ALL: &[Case] = &[viscosity::CASE];
