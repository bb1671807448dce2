//! Starts for the iteration: cylinders found without one.

pub mod limbs;
