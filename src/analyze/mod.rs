//! (being built)
pub mod statistics;
