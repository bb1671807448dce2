//! Measures a cylinder from one RGB-D view.
pub mod camera;
pub mod completion;
pub mod error;
pub mod extent;
pub mod fitter;
pub mod geometry;
pub mod limb_location;
pub mod observations;
pub mod residuals;
pub mod solver;
pub mod start;
