//! Measures a cylinder from one RGB-D view.
pub mod camera;
pub mod error;
pub mod geometry;
pub mod start;
