//! Every stage on the adapter against its f64 reference from the same words, and what whole steps must keep.

mod apply;
mod bench;
mod bricks;
mod cell_reduce;
mod collision;
mod conservation;
mod energy_bias;
mod fused;
mod motion;
mod parts;
mod restore_thermostat;
#[path = "../rig/mod.rs"]
mod rig;
mod rng;
mod room;
mod rotate;
mod shift_grid;
mod sort_reorder;
mod squirmer_collide;
mod squirmer_crowd;
mod squirmer_fill;
mod stream;
mod units;
mod wall_ghosts;
