//! Finders of a start for the iteration: points alone, no camera, no edges.
//!
//! [`moments`] minimises an algebraic error over the whole cloud in microseconds and is exact for points
//! without noise; it has no defence against outliers. [`ransac`] has, and takes milliseconds.

pub mod moments;
pub mod ransac;

#[cfg(test)]
mod clouds;
