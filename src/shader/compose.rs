//! Composition of one WGSL module from a stage's file, the library files it includes and the structs it shares with Rust.
