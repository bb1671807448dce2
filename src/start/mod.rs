//! Cylinders found without a start: the starts of the iteration, and the paper's baselines.
//!
//! [`limbs`] needs two limb segments and takes their sharpness; [`moments`] minimises an algebraic error over
//! the whole cloud and is exact for points without noise, but has no defence against outliers; [`ransac`]
//! has, and takes milliseconds.

pub mod limbs;
pub mod moments;
pub mod ransac;

#[cfg(test)]
mod clouds;
