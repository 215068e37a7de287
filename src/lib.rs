//! Spheroidal squirmers in a fluid of millions of particles, by multi-particle collision dynamics on any GPU, or on none.
//!
//! ARCHITECTURE.md has the map; modules may use only those below them (`tests/tidy.rs` enforces it).
#![deny(missing_docs)]
#![deny(unsafe_code)]

pub mod analyze;
pub mod buffers;
pub mod config;
pub mod diag;
pub mod gpu;
pub mod graph;
pub mod math;
pub mod params;
pub mod shader;
pub mod sim;
pub mod sink;
pub mod stages;
pub mod state;
pub mod wire;
