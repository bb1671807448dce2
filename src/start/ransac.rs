//! temporary
use crate::error::{Error, Result};
use crate::geometry::Cylinder;
use nalgebra::Vector3;
/// o
#[derive(Default)]
pub struct RansacOptions {
    /// a
    pub max_iterations: usize,
    /// a
    pub threshold: f64,
    /// a
    pub confidence: f64,
    /// a
    pub seed: u64,
    /// a
    pub radius_min: f64,
    /// a
    pub radius_max: f64,
}
/// o
pub struct RansacFit {
    /// a
    pub cylinder: Cylinder,
}
/// o
pub fn ransac(
    _: &[Vector3<f64>],
    _: Option<&[Vector3<f64>]>,
    _: bool,
    _: &RansacOptions,
) -> Result<RansacFit> {
    Err(Error::NoStart { reason: "todo".into() })
}
