//! Starts for the iteration: cylinders found without one.

pub mod limbs;
pub mod moments;
pub mod ransac;

#[cfg(test)]
mod clouds;
