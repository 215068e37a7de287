//! Pure mathematics in f64: geometry and theory of spheroids, transport coefficients, random numbers, fixed point.

pub mod draws;
pub mod fixed;
pub mod flow;
pub mod linear;
pub mod mobility;
pub mod rigid;
pub mod rng;
pub mod spheroid;
pub mod steric;
pub mod surface;
pub mod transport;
