//! Starts.
pub mod limbs;
pub mod moments;
pub mod ransac;
