//! Checkpoint files: named sections of bytes, believed only if every byte of the file is right, and never lost while a new one is written.
//!
//! docs/reliability.md has the layout and the rules. What the sections hold is the business of [`crate::sim`].

mod configuration;
mod container;
mod store;

pub use configuration::{decisive, differences};
pub use container::{Damage, Sections, VERSION, decode, encode};
pub use store::{CURRENT, Found, PREVIOUS, TEMPORARY, Unreadable, WriteError, load, put_aside, write};
