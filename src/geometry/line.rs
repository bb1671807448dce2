//! Three representations of a line in space and the conversions between them.

use super::rotation::{any_orthogonal, exp_so2, exp_so3};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// A line by a point on it and its direction.
///
/// Invariant: `direction` has unit length to rounding. `point` is any point of the line: keep it near the
/// data, because the distance between the two costs digits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// A point on the line.
    pub point: Vector3<f64>,
    /// Unit vector along the line; its sign has no meaning.
    pub direction: Vector3<f64>,
}

impl Line {
    /// The line through `point` along `direction`, which need not have unit length but must not vanish.
    #[must_use]
    pub fn new(point: Vector3<f64>, direction: Vector3<f64>) -> Self {
        Self { point, direction: direction.normalize() }
    }

    /// This line with the largest component of its direction positive, so that the same line always reads the same.
    #[must_use]
    pub fn with_canonical_direction(self) -> Self {
        let direction = self.direction;
        Self { direction: if direction[direction.iamax()] < 0.0 { -direction } else { direction }, ..self }
    }

    /// Where along the line the point nearest to `p` lies, from `point` on.
    #[inline]
    #[must_use]
    pub fn position_of(&self, p: &Vector3<f64>) -> f64 {
        (p - self.point).dot(&self.direction)
    }

    /// The point at a position along the line.
    #[inline]
    #[must_use]
    pub fn at(&self, position: f64) -> Vector3<f64> {
        self.point + self.direction * position
    }

    /// The point of the line nearest to `p`.
    #[must_use]
    pub fn nearest_to(&self, p: &Vector3<f64>) -> Vector3<f64> {
        self.at(self.position_of(p))
    }

    /// The point c of the line nearest to the origin.
    #[inline]
    #[must_use]
    pub fn nearest_to_origin(&self) -> Vector3<f64> {
        // Subtracting twice removes what rounding leaves along the direction when the point is far away.
        rejection(&rejection(&self.point, &self.direction), &self.direction)
    }

    /// Where the ray `t · ray` from the origin passes nearest to the line: t, not finite for a ray along the line.
    #[must_use]
    pub fn nearest_on_ray(&self, ray: &Vector3<f64>) -> f64 {
        let across = rejection(ray, &self.direction);
        across.dot(&self.point) / across.norm_squared()
    }

    /// Distance of `p` from the line, ‖(p − point) × direction‖.
    #[must_use]
    pub fn distance(&self, p: &Vector3<f64>) -> f64 {
        (p - self.point).cross(&self.direction).norm()
    }

    /// Shortest distance between two lines.
    #[must_use]
    pub fn distance_to_line(&self, other: &Line) -> f64 {
        let normal = self.direction.cross(&other.direction);
        let between = other.point - self.point;
        let sine = normal.norm();
        // Rounding turns the common normal by ε / sine: of nearly parallel lines any point gives the distance
        // better than their normal.
        if sine < 1e-8 { self.distance(&other.point) } else { (between.dot(&normal) / sine).abs() }
    }

    /// Angle between two lines in [0, π/2], whatever the signs of their directions.
    #[must_use]
    pub fn angle(&self, other: &Line) -> f64 {
        let sine = self.direction.cross(&other.direction).norm();
        // atan2 keeps small angles exact where acos loses half the digits.
        sine.atan2(self.direction.dot(&other.direction).abs())
    }
}

/// A line by Plücker coordinates {m, d̂}: the moment m = c × d̂ (5) and the direction.
///
/// Invariant: `direction` has unit length and `moment` is orthogonal to it; ‖m‖ is the distance of the line
/// from the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PluckerLine {
    /// Moment about the origin.
    pub moment: Vector3<f64>,
    /// Unit vector along the line.
    pub direction: Vector3<f64>,
}

impl From<Line> for PluckerLine {
    fn from(line: Line) -> Self {
        Self { moment: line.nearest_to_origin().cross(&line.direction), direction: line.direction }
    }
}

impl From<PluckerLine> for Line {
    /// c = d̂ × m (8): the point is the one nearest to the origin.
    fn from(line: PluckerLine) -> Self {
        Self { point: line.direction.cross(&line.moment), direction: line.direction }
    }
}

/// A line by the orthonormal representation of the paper (6): U ∈ SO(3) holds the directions of the moment,
/// of the line and their product; W ∈ SO(2) holds the ratio of ‖m‖ to 1 (one unit of length of the data).
///
/// Invariant: both matrices are rotations to rounding. A line through the origin has m = 0: W is then a
/// quarter turn, u₁ is any unit vector orthogonal to the line, and the four degrees of freedom of the
/// tangent collapse to three; iterate with [`Chart::Local`](super::Chart::Local) there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrthonormalLine {
    /// U = [m̂ | d̂ | m̂ × d̂].
    pub u: Matrix3<f64>,
    /// W = [[cos φ, −sin φ], [sin φ, cos φ]] with (cos φ, sin φ) = (‖m‖, 1) / √(‖m‖² + 1).
    pub w: Matrix2<f64>,
}

impl OrthonormalLine {
    /// {U Exp(δθ), W Exp(δφ)}: the retraction of the paper on the four degrees of freedom of the line.
    #[must_use]
    pub fn retract(&self, delta_theta: &Vector3<f64>, delta_phi: f64) -> Self {
        Self { u: self.u * exp_so3(delta_theta), w: self.w * exp_so2(delta_phi) }
    }

    /// ‖m‖ = W₁₁ / W₂₁ (7). Negative when a step has carried the line through the origin.
    #[must_use]
    pub fn moment_norm(&self) -> f64 {
        self.w[(0, 0)] / self.w[(1, 0)]
    }
}

impl From<PluckerLine> for OrthonormalLine {
    fn from(line: PluckerLine) -> Self {
        let norm = line.moment.norm();
        let u1 = if norm > 0.0 { line.moment / norm } else { any_orthogonal(&line.direction).0 };
        let u = Matrix3::from_columns(&[u1, line.direction, u1.cross(&line.direction)]);
        let length = norm.hypot(1.0);
        let (c, s) = (norm / length, 1.0 / length);
        Self { u, w: Matrix2::new(c, -s, s, c) }
    }
}

impl From<OrthonormalLine> for PluckerLine {
    /// m = ‖m‖ u₁, d̂ = u₂ (7).
    fn from(line: OrthonormalLine) -> Self {
        Self { moment: line.u.column(0) * line.moment_norm(), direction: line.u.column(1).normalize() }
    }
}

impl From<Line> for OrthonormalLine {
    fn from(line: Line) -> Self {
        PluckerLine::from(line).into()
    }
}

impl From<OrthonormalLine> for Line {
    fn from(line: OrthonormalLine) -> Self {
        PluckerLine::from(line).into()
    }
}

/// The part of a vector across a unit vector.
#[inline]
pub(crate) fn rejection(vector: &Vector3<f64>, direction: &Vector3<f64>) -> Vector3<f64> {
    vector - direction * vector.dot(direction)
}

/// Signed distance of a point of a plane from the line through two others.
pub(crate) fn across(line: &[Vector2<f64>; 2], q: &Vector2<f64>) -> f64 {
    (line[1] - line[0]).normalize().perp(&(q - line[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines() -> Vec<Line> {
        vec![
            Line::new(Vector3::new(0.1, -0.2, 0.7), Vector3::new(0.3, 0.9, -0.1)),
            Line::new(Vector3::new(0.0, 0.0, 2.0), Vector3::new(1.0, 0.0, 0.0)),
            Line::new(Vector3::new(-30.0, 400.0, 900.0), Vector3::new(0.1, 0.2, 0.9)),
            Line::new(Vector3::zeros(), Vector3::new(0.4, -0.1, 0.9)),
        ]
    }

    #[test]
    fn conversions_come_back_to_the_same_line() {
        for line in lines() {
            let scale = 1.0 + line.point.norm();
            let plucker = PluckerLine::from(line);
            assert!(plucker.moment.dot(&plucker.direction).abs() < 1e-14 * scale);
            assert!((plucker.moment.norm() - line.distance(&Vector3::zeros())).abs() < 1e-13 * scale);
            let orthonormal = OrthonormalLine::from(plucker);
            assert!((orthonormal.u.transpose() * orthonormal.u - Matrix3::identity()).norm() < 1e-14);
            assert!((orthonormal.w.transpose() * orthonormal.w - Matrix2::identity()).norm() < 1e-15);
            for back in [Line::from(plucker), Line::from(orthonormal)] {
                assert!(line.distance(&back.point) < 1e-12 * scale * scale, "{line:?} {back:?}");
                assert!(line.angle(&back) < 1e-14);
                assert!((back.point - line.nearest_to_origin()).norm() < 1e-12 * scale * scale);
            }
        }
    }

    #[test]
    fn no_other_point_of_a_ray_is_nearer_to_a_line() {
        let ray = Vector3::new(0.2, -0.1, 1.0);
        for line in lines() {
            let t = line.nearest_on_ray(&ray);
            let nearest = line.distance(&(ray * t));
            let scale = 1.0 + t.abs();
            assert!(line.distance(&(ray * (t + 0.01 * scale))) > nearest);
            assert!(line.distance(&(ray * (t - 0.01 * scale))) > nearest);
        }
    }

    #[test]
    fn distances_between_lines_agree_with_hand_computed_ones() {
        let x = Line::new(Vector3::zeros(), Vector3::x());
        let y = Line::new(Vector3::new(5.0, 1.0, 3.0), Vector3::y());
        assert!((x.distance_to_line(&y) - 3.0).abs() < 1e-15);
        assert!((x.angle(&y) - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        let parallel = Line::new(Vector3::new(9.0, 3.0, 4.0), -Vector3::x());
        assert!((x.distance_to_line(&parallel) - 5.0).abs() < 1e-15);
        assert_eq!(x.angle(&parallel), 0.0);
        let almost = Line::new(Vector3::new(9.0, 3.0, 4.0), Vector3::new(1.0, 1e-11, -2e-11));
        assert!((x.distance_to_line(&almost) - 5.0).abs() < 1e-9);
    }
}
