//! Spheroidal squirmers in a fluid of millions of particles, by multi-particle collision dynamics on any GPU, or on none.
//!
//! README.md says what the program does; ARCHITECTURE.md has the map of this library. Modules may use only those below them
//! (`tests/tidy.rs` enforces it). From a pipeline file to a finished run:
//!
//! ```no_run
//! use squirm::{config, sim};
//! use std::path::Path;
//!
//! struct Quiet;
//! impl sim::Watch for Quiet {
//!     fn begin(&mut self, _adapter: &str, _steps: u64) {}
//!     fn progress(&mut self, _done: u64) {}
//! }
//!
//! let text = std::fs::read_to_string("pipelines/quickstart.toml").expect("the file is there");
//! let loaded = config::load("quickstart.toml", &text, &[], Path::new("pipelines")).unwrap_or_else(|f| panic!("{f}"));
//! let options = sim::Options { out: "runs/mine".into(), ..sim::Options::default() };
//! let summary = sim::run(&loaded.plan, &options, &mut Quiet).expect("it runs");
//! println!("{summary}");
//! ```
//!
//! - [`config`] reads pipeline files into a [`graph::Plan`]; [`mod@params`] declares what they may say, [`diag`] what is wrong.
//! - [`stages`] has the physics, one file per stage; [`shader`] and [`buffers`] what their WGSL is made of.
//! - [`gpu`] runs a plan; [`sim`] runs it to its end and keeps the books; [`mod@bench`] measures its speed.
//! - [`state`] is the simulated system on the host, [`math`] its mathematics and theory.
//! - [`checkpoint`] keeps what a run needs to go on.
//! - [`wire`] is the layout of snapshots, [`sink`] where they go, [`recording`] files of them, which [`mod@replay`] publishes again, [`export`] makes of
//!   them what other people's tools read, [`analyze`] what reads them again.
#![deny(missing_docs)]
#![deny(unsafe_code)]

pub mod analyze;
pub mod bench;
pub mod buffers;
pub mod checkpoint;
pub mod config;
pub mod diag;
pub mod export;
pub mod gpu;
pub mod graph;
pub mod math;
pub mod params;
pub mod recording;
pub mod replay;
pub mod shader;
pub mod sim;
pub mod sink;
pub mod stages;
pub mod state;
pub mod wire;
