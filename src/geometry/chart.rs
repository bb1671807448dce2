//! Charts of the five degrees of freedom of a cylinder for optimisation.
//!
//! Every Jacobian of the library is taken with respect to the tangent of [`LocalFrame`]: for a residual e,
//! J = lim (e(frame.retract(δ)) − e(frame.retract(0))) / δ for δ → 0. The frame sits on the axis at the
//! point nearest to the data, so it is regular wherever the axis runs: through the origin of coordinates,
//! far from it, or around an observer inside the pipe. The orthonormal chart of the paper is reached by a
//! 5 × 5 matrix, its derivative in the local tangent.

use super::cylinder::Cylinder;
use super::line::{Line, OrthonormalLine};
use super::motion::RigidMotion;
use super::rotation::{any_orthogonal, rotate_direction};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// A step δ of the five degrees of freedom.
pub type Tangent = SVector<f64, 5>;

/// The derivative of one tangent in another.
pub type TangentMap = SMatrix<f64, 5, 5>;

/// Which coordinates an iteration steps in. Both reach the same optima.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Chart {
    /// Shift and tilt of the axis at the data, in units of the size of the data: regular everywhere, and the
    /// same iterates in metres and millimetres.
    #[default]
    Local,
    /// {U Exp(δθ), W Exp(δφ), r + δr} of the paper, about the origin of coordinates and in the unit of length
    /// of the data: singular for an axis through the origin.
    Orthonormal,
}

/// Coordinates at one cylinder: the axis is z, the axis point nearest to the data is the origin, and lengths
/// are in units of `unit`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalFrame {
    /// The cylinder, its axis point moved to the one nearest to the data.
    pub cylinder: Cylinder,
    /// First direction across the axis.
    pub u: Vector3<f64>,
    /// Second direction across the axis; (u, v, d̂) is right-handed.
    pub v: Vector3<f64>,
    /// The length that counts as 1 in tangents and residuals.
    pub unit: f64,
}

impl LocalFrame {
    /// The frame of `cylinder` for data around `data_center`.
    #[must_use]
    pub fn new(cylinder: &Cylinder, data_center: &Vector3<f64>, unit: f64) -> Self {
        let (u, v) = any_orthogonal(&cylinder.axis.direction);
        let axis = Line { point: cylinder.axis.nearest_to(data_center), ..cylinder.axis };
        Self { cylinder: Cylinder { axis, ..*cylinder }, u, v, unit }
    }

    /// The frame in other coordinates. A step moves it there as it does here, so that a residual in other coordinates
    /// has its Jacobian in the same tangent.
    #[must_use]
    pub fn moved(&self, motion: &RigidMotion) -> Self {
        Self {
            cylinder: motion.cylinder(&self.cylinder),
            u: motion.direction(&self.u),
            v: motion.direction(&self.v),
            unit: self.unit,
        }
    }

    /// The cylinder at a step δ = (shift along u, shift along v, tilt towards u, tilt towards v, change of
    /// radius); shifts and radius in units of `unit`, tilts in radians along the great circle.
    #[must_use]
    pub fn retract(&self, delta: &Tangent) -> Cylinder {
        let Line { point, direction } = self.cylinder.axis;
        Cylinder {
            axis: Line {
                point: point + (self.u * delta[0] + self.v * delta[1]) * self.unit,
                direction: rotate_direction(&direction, &(self.u * delta[2] + self.v * delta[3])),
            },
            radius: self.cylinder.radius + delta[4] * self.unit,
        }
    }

    /// The step to another cylinder: the inverse of [`LocalFrame::retract`] to first order. The sign of its
    /// direction has no meaning.
    #[must_use]
    pub fn difference(&self, other: &Cylinder) -> Tangent {
        let axis = &self.cylinder.axis;
        // Where the other axis crosses the plane across this one at its point.
        let along =
            (axis.point - other.axis.point).dot(&axis.direction) / other.axis.direction.dot(&axis.direction);
        let shift = other.axis.at(along) - axis.point;
        let tilt = other.axis.direction * other.axis.direction.dot(&axis.direction).signum();
        Tangent::new(
            shift.dot(&self.u) / self.unit,
            shift.dot(&self.v) / self.unit,
            tilt.dot(&self.u),
            tilt.dot(&self.v),
            (other.radius - self.cylinder.radius) / self.unit,
        )
    }

    /// The rotation from space to the frame, rows u, v, d̂.
    #[must_use]
    pub fn rotation(&self) -> Matrix3<f64> {
        Matrix3::from_rows(&[
            self.u.transpose(),
            self.v.transpose(),
            self.cylinder.axis.direction.transpose(),
        ])
    }

    /// The cylinder at a step (δθ, δφ, δr) of the orthonormal chart.
    #[must_use]
    pub fn retract_orthonormal(&self, delta: &Tangent) -> Cylinder {
        let line = OrthonormalLine::from(self.cylinder.axis);
        let moved = line.retract(&Vector3::new(delta[0], delta[1], delta[2]), delta[3]);
        Cylinder { axis: moved.into(), radius: self.cylinder.radius + delta[4] }
    }

    /// The derivative of the local tangent in the orthonormal one, so that J_orthonormal = J_local · T.
    #[must_use]
    pub fn orthonormal_tangent_map(&self) -> TangentMap {
        let line = OrthonormalLine::from(self.cylinder.axis);
        let moment_norm = line.moment_norm();
        let u1 = line.u.column(0).into_owned();
        let u3 = line.u.column(2).into_owned();
        let axis = &self.cylinder.axis;
        // Where the local frame sits on the axis, measured from the point nearest to the origin.
        let along = (axis.point - axis.nearest_to_origin()).dot(&axis.direction);

        let mut map = TangentMap::zeros();
        for k in 0..4 {
            // U Exp(δθ): δu₂ = δθ₁ u₃ − δθ₃ u₁, δu₃ = δθ₂ u₁ − δθ₁ u₂, and c = −‖m‖ u₃;
            // W Exp(δφ): δ‖m‖ = −(‖m‖² + 1) δφ.
            let (delta_direction, delta_nearest) = match k {
                0 => (u3, Vector3::zeros()),
                1 => (Vector3::zeros(), -u1 * moment_norm),
                2 => (-u1, Vector3::zeros()),
                _ => (Vector3::zeros(), u3 * (moment_norm * moment_norm + 1.0)),
            };
            let delta_point = (delta_nearest + delta_direction * along) / self.unit;
            map[(0, k)] = delta_point.dot(&self.u);
            map[(1, k)] = delta_point.dot(&self.v);
            map[(2, k)] = delta_direction.dot(&self.u);
            map[(3, k)] = delta_direction.dot(&self.v);
        }
        map[(4, 4)] = 1.0 / self.unit;
        map
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_charts_agree_with_central_differences() {
        let cylinder =
            Cylinder::new(Vector3::new(0.1, -0.2, 0.9), Vector3::new(0.4, 0.8, 0.3), 0.07).unwrap();
        let frame = LocalFrame::new(&cylinder, &Vector3::new(0.3, 0.1, 0.8), 0.05);
        assert!((frame.rotation().determinant() - 1.0).abs() < 1e-14);
        let map = frame.orthonormal_tangent_map();
        let h = 1e-6;
        for k in 0..5 {
            let step = Tangent::ith(k, h);
            let local = (frame.difference(&frame.retract(&step)) - frame.difference(&frame.retract(&-step)))
                / (2.0 * h);
            assert!((local - Tangent::ith(k, 1.0)).norm() < 1e-8, "{k} {local}");
            let orthonormal = (frame.difference(&frame.retract_orthonormal(&step))
                - frame.difference(&frame.retract_orthonormal(&-step)))
                / (2.0 * h);
            assert!((orthonormal - map.column(k)).norm() < 1e-7 * map.norm(), "{k} {orthonormal}");
        }
    }

    #[test]
    fn a_zero_step_stays_in_both_charts() {
        let cylinder = Cylinder::new(Vector3::new(1.0, 2.0, 3.0), Vector3::y(), 0.5).unwrap();
        let frame = LocalFrame::new(&cylinder, &Vector3::new(1.0, 5.0, 3.0), 2.0);
        for moved in [frame.retract(&Tangent::zeros()), frame.retract_orthonormal(&Tangent::zeros())] {
            let difference = cylinder.compare(&moved);
            assert!(difference.angle < 1e-15 && difference.axis_distance < 1e-14);
            assert_eq!(moved.radius, 0.5);
        }
    }

    #[test]
    fn the_local_frame_is_regular_where_the_axis_passes_through_the_origin() {
        let cylinder = Cylinder::new(Vector3::zeros(), Vector3::x(), 0.5).unwrap();
        let frame = LocalFrame::new(&cylinder, &Vector3::zeros(), 1.0);
        let moved = frame.retract(&Tangent::new(0.1, 0.0, 0.0, 0.0, 0.0));
        assert!((moved.axis.point.norm() - 0.1).abs() < 1e-15);
    }
}
