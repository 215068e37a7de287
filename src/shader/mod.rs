//! WGSL: structs shared with Rust, composition of a stage's module from its files, reflection of what a kernel binds.

pub mod beside;
pub mod compose;
mod entry;
pub mod fuse;
pub mod in_turn;
pub mod lanes;
pub mod members;
pub mod reflect;
pub mod shared;
pub mod small;
pub mod split;

pub use beside::{Side, compatible, side_by_side, usual};
pub use compose::compose;
pub use fuse::{ENTRY, Over, Part, Rare, Route, after_the_shift, fuse, settings_name};
pub use in_turn::in_turn;
pub use lanes::Lanes;
pub use members::Members;
pub use reflect::{Access, Binding, Module, ShaderError};
pub use shared::Shared;
pub use small::{Phase, apart, one_workgroup};
pub use split::split;
