//! Rigid motions between frames of coordinates.

use super::cylinder::Cylinder;
use super::line::Line;
use crate::error::{Error, Result};
use nalgebra::{Matrix3, Vector3};

/// How far a matrix may be from a rotation: files carry six digits and more. It is made one to rounding.
const ROTATION_TOLERANCE: f64 = 1e-4;

/// A motion x ↦ R x + t from one frame of coordinates to another.
///
/// Invariant: R is a rotation to rounding, and every number is finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidMotion {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
    /// Whether the motion leaves everything where it is: most views have that one, and all points ask.
    identity: bool,
}

impl Default for RigidMotion {
    fn default() -> Self {
        Self::identity()
    }
}

impl RigidMotion {
    /// The motion that leaves everything where it is.
    #[must_use]
    pub fn identity() -> Self {
        Self { rotation: Matrix3::identity(), translation: Vector3::zeros(), identity: true }
    }

    /// The motion of a rotation, which may be off by 1e-4 and is made exact, and a translation in the unit of length of
    /// the data.
    ///
    /// # Errors
    /// `InvalidArgument` when a number is not finite or the matrix is no rotation.
    pub fn new(rotation: Matrix3<f64>, translation: Vector3<f64>) -> Result<Self> {
        if !translation.iter().all(|x| x.is_finite()) {
            return Err(Error::argument("translation", format!("{:?}", translation.as_slice()), "be finite"));
        }
        let off = (rotation.transpose() * rotation - Matrix3::identity()).amax();
        if !(off <= ROTATION_TOLERANCE && rotation.determinant() > 0.0) {
            let given = format!("{:?}", rotation.transpose().as_slice());
            let requirement = "be a rotation, given row by row: orthogonal to 1e-4, with the determinant 1";
            return Err(Error::argument("rotation", given, requirement));
        }
        let exact = rotation == Matrix3::identity();
        let parts = rotation.svd(true, true);
        let (Some(u), Some(v)) = (parts.u, parts.v_t) else {
            return Err(Error::Numerical { what: "the rotation has no singular values" });
        };
        let identity = exact && translation == Vector3::zeros();
        Ok(Self { rotation: if exact { rotation } else { u * v }, translation, identity })
    }

    /// R.
    #[must_use]
    pub fn rotation(&self) -> &Matrix3<f64> {
        &self.rotation
    }

    /// t.
    #[must_use]
    pub fn translation(&self) -> &Vector3<f64> {
        &self.translation
    }

    /// The motion back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        // 0 − x and not −x: no negative zeros for the identity.
        Self {
            rotation,
            translation: Vector3::zeros() - rotation * self.translation,
            identity: self.identity,
        }
    }

    /// A point in the other frame.
    #[must_use]
    pub fn point(&self, point: &Vector3<f64>) -> Vector3<f64> {
        if self.identity { *point } else { self.rotation * point + self.translation }
    }

    /// A direction in the other frame.
    #[must_use]
    pub fn direction(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        if self.identity { *direction } else { self.rotation * direction }
    }

    /// A line in the other frame.
    #[must_use]
    pub fn line(&self, line: &Line) -> Line {
        Line { point: self.point(&line.point), direction: self.direction(&line.direction) }
    }

    /// A cylinder in the other frame.
    #[must_use]
    pub fn cylinder(&self, cylinder: &Cylinder) -> Cylinder {
        Cylinder { axis: self.line(&cylinder.axis), ..*cylinder }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LocalFrame, Tangent, exp_so3};
    use super::*;

    fn motion() -> RigidMotion {
        let rotation = exp_so3(&Vector3::new(0.3, -0.7, 1.1));
        RigidMotion::new(rotation, Vector3::new(0.4, -0.1, 2.0)).unwrap()
    }

    #[test]
    fn there_and_back_is_where_it_was() {
        let motion = motion();
        let p = Vector3::new(0.1, 0.2, 0.7);
        assert!((motion.inverse().point(&motion.point(&p)) - p).norm() < 1e-15);
        assert_eq!(RigidMotion::identity().inverse(), RigidMotion::identity());
        let cylinder = Cylinder::new(p, Vector3::new(0.4, 0.8, 0.3), 0.07).unwrap();
        let q = Vector3::new(-0.3, 0.5, 1.0);
        let moved = motion.cylinder(&cylinder).distance(&motion.point(&q));
        assert!((moved - cylinder.distance(&q)).abs() < 1e-15);
    }

    #[test]
    fn a_moved_frame_keeps_its_tangent() {
        let cylinder = Cylinder::new(Vector3::new(0.1, -0.2, 0.9), Vector3::y(), 0.07).unwrap();
        let frame = LocalFrame::new(&cylinder, &Vector3::new(0.3, 0.1, 0.8), 0.05);
        let step = Tangent::new(0.1, -0.2, 0.3, 0.05, -0.4);
        let (first, second) =
            (motion().cylinder(&frame.retract(&step)), frame.moved(&motion()).retract(&step));
        let difference = first.compare(&second);
        assert!(difference.angle < 1e-15 && difference.axis_distance < 1e-15);
        assert_eq!(first.radius, second.radius);
    }

    #[test]
    fn what_is_no_rotation_is_refused_and_what_is_nearly_one_is_mended() {
        let zero = Vector3::zeros();
        for bad in
            [Matrix3::zeros(), Matrix3::identity() * 1.01, -Matrix3::identity(), Matrix3::repeat(f64::NAN)]
        {
            let error = RigidMotion::new(bad, zero).unwrap_err().to_string();
            assert!(error.starts_with("rotation is [") && error.contains("row by row"), "{error}");
        }
        assert!(RigidMotion::new(Matrix3::identity(), Vector3::new(0.0, f64::INFINITY, 0.0)).is_err());
        let rough = motion().rotation.map(|x| (x * 1e5).round() / 1e5);
        let mended = *RigidMotion::new(rough, zero).unwrap().rotation();
        assert!((mended.transpose() * mended - Matrix3::identity()).norm() < 1e-14);
    }
}
