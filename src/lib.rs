//! Measures a cylinder from one RGB-D view.

// Pointers are for the C interface; everything else is safe code.
#![deny(unsafe_code)]

pub mod camera;
pub mod completion;
pub mod error;
pub mod extent;
#[allow(unsafe_code)]
pub mod ffi;
pub mod fitter;
pub mod geometry;
pub mod observations;
pub mod residuals;
pub mod solver;
pub mod start;
