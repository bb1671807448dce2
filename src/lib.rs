//! Measures a cylinder (a pipe, a can, a shaft, a trunk) from one RGB-D view: axis, radius and visible extent.
//!
//! Two sources that fail differently are fused. Depth is metric but noisy, fattened and missing near the
//! silhouette of a curved surface; the two limb lines in the image are sharp but know no scale. The method
//! starts from Zhang, Liu, Wang, "Edge–Point Cloud Fusion for Geometric Fitting of Cylinder Parameters Using
//! Single-View RGB-D Data", Sensors 2026, 26(5), 1687; numbers in parentheses are its equations.
//!
//! ```
//! use cylfuse::fitter::Fitter;
//! use cylfuse::observations::PointsView;
//!
//! // A quarter of a pipe of radius 0.5 along y.
//! let points: Vec<[f64; 3]> = (0..200)
//!     .map(|k| (0.008 * f64::from(k), 0.1 * f64::from(k % 7)))
//!     .map(|(angle, y)| [0.5 * angle.cos(), y, 2.0 - 0.5 * angle.sin()])
//!     .collect();
//! let mut fitter = Fitter::new();
//! fitter.push_points(&PointsView::from_f64(&points), None)?;
//! let result = fitter.fit()?;
//! assert!((result.cylinder.radius - 0.5).abs() < 1e-9);
//! # Ok::<(), cylfuse::error::Error>(())
//! ```
//!
//! # Conventions
//! The camera frame has x right, y down, z forward and its origin at the optical centre. Pixel centres lie at
//! integer coordinates. Angles are radians. Lengths come out in the unit that went in. Results have the same
//! bits from run to run and for any number of threads.
//!
//! # Where to begin
//! [`fitter::Fitter`] is the whole of it; [`observations`] are what it takes, [`fitter::FitResult`] is what it gives, and
//! [`extent`] and [`completion`] follow a fit; [`scene::Detector`] finds and fits all cylinders of a scene. [`ffi`] is the C
//! interface and, with the feature `opencv`, the module `opencv` takes its images; with the feature `twin`, the module `twin`
//! makes frames. `docs/architecture.md` shows the inside.

// Pointers are for the C interface; everything else is safe code.
#![deny(unsafe_code)]

// First, for its macro.
#[cfg(not(feature = "sensitivity"))]
#[macro_use]
mod constant;
#[cfg(feature = "sensitivity")]
#[macro_use]
pub mod constant;

pub mod camera;
pub mod completion;
pub mod detection;
#[cfg(not(feature = "sensitivity"))]
mod end_location;
#[cfg(feature = "sensitivity")]
pub mod end_location;
pub mod error;
pub mod extent;
#[allow(unsafe_code)]
pub mod ffi;
pub mod fitter;
pub mod geometry;
#[cfg(not(feature = "sensitivity"))]
mod limb_location;
#[cfg(feature = "sensitivity")]
pub mod limb_location;
pub mod memory;
pub mod noise;
pub mod observations;
#[cfg(feature = "opencv")]
pub mod opencv;
#[cfg(not(feature = "sensitivity"))]
mod parts;
#[cfg(feature = "sensitivity")]
pub mod parts;
pub mod plan;
mod residuals;
pub mod scene;
mod solver;
mod start;
mod statistics;
#[cfg(feature = "twin")]
pub mod twin;
mod workers;

/// Runs the Rust program of the README as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
