//! Planes.

use super::Cylinder;
use nalgebra::{Matrix3, Vector3};

/// A plane about a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    point: Vector3<f64>,
    pub normal: Vector3<f64>,
    /// Of the points that it was found from.
    pub covariance: Matrix3<f64>,
}

impl Plane {
    /// Across the direction from the axis of a cylinder to a point, through the point.
    pub fn tangent(cylinder: &Cylinder, point: Vector3<f64>) -> Self {
        let normal = (point - cylinder.axis.nearest_to(&point)).normalize();
        Self { point, normal, covariance: Matrix3::zeros() }
    }

    /// Through three points; `None` where they lie on a line.
    pub fn through([a, b, c]: [Vector3<f64>; 3]) -> Option<Self> {
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        Some(Self { point: a, normal, covariance: Matrix3::zeros() })
    }

    /// The plane that lies nearest to some points; `None` for none of them.
    pub fn nearest<'a>(points: impl Iterator<Item = &'a Vector3<f64>> + Clone) -> Option<Self> {
        let count = points.clone().count() as f64;
        let point = points.clone().sum::<Vector3<f64>>() / count;
        let square = |p: &Vector3<f64>| (p - point) * (p - point).transpose();
        let covariance = points.map(square).sum::<Matrix3<f64>>() / count;
        let eigen = (count > 0.0).then(|| covariance.symmetric_eigen())?;
        let normal = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into();
        Some(Self { point, normal, covariance })
    }

    /// How far a point is from it.
    pub fn distance(&self, p: &Vector3<f64>) -> f64 {
        (p - self.point).dot(&self.normal).abs()
    }
}
