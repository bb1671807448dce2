//! The infinite cylinder: distance, rays, walls, comparison.

use super::line::{Line, rejection};
use crate::error::{Error, Result, positive};
use nalgebra::Vector3;

/// An infinite cylinder: an axis and a radius, five degrees of freedom.
///
/// Invariant of a cylinder made by [`Cylinder::new`]: the direction has unit length, the radius is positive
/// and every number is finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// The axis.
    pub axis: Line,
    /// The radius, in the unit of length of the data.
    pub radius: f64,
}

/// How two cylinders differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CylinderComparison {
    /// Angle between the axes in [0, π/2], sign-free.
    pub angle: f64,
    /// Shortest distance between the two axes.
    pub axis_distance: f64,
    /// (second radius − first radius) / first radius.
    pub radius_relative: f64,
}

/// How many points lie on the wall that faces an observer, out of how many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Walls {
    /// Points on the wall that an observer at the origin sees.
    pub visible: usize,
    /// All points.
    pub total: usize,
}

impl Walls {
    /// The part of the points on the visible wall; 1 when there are no points.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        if self.total == 0 { 1.0 } else { self.visible as f64 / self.total as f64 }
    }
}

impl Cylinder {
    /// A cylinder from an axis point, an axis direction of any length, and a radius.
    ///
    /// # Errors
    /// `InvalidArgument` when a number is not finite, the direction vanishes, or the radius is not positive.
    pub fn new(point: Vector3<f64>, direction: Vector3<f64>, radius: f64) -> Result<Self> {
        if !point.iter().all(|x| x.is_finite()) {
            return Err(Error::argument("axis point", format!("{:?}", point.as_slice()), "be finite"));
        }
        let norm = direction.norm();
        if !(norm > 0.0 && norm.is_finite()) {
            let given = format!("{:?}", direction.as_slice());
            return Err(Error::argument("axis direction", given, "be finite and not zero"));
        }
        positive("radius", radius)?;
        Ok(Self { axis: Line::new(point, direction), radius })
    }

    /// This cylinder with the largest component of the direction of its axis positive, so that the same cylinder always reads the
    /// same.
    #[must_use]
    pub fn with_canonical_direction(self) -> Self {
        Self { axis: self.axis.with_canonical_direction(), ..self }
    }

    /// Signed distance of a point from the surface, negative inside: ‖m − p × d̂‖ − r, the paper's e_i.
    #[must_use]
    pub fn distance(&self, p: &Vector3<f64>) -> f64 {
        self.axis.distance(p) - self.radius
    }

    /// Distance of the origin from the axis, ‖c‖.
    #[must_use]
    pub fn distance_of_axis_from_origin(&self) -> f64 {
        self.axis.nearest_to_origin().norm()
    }

    /// Whether an observer at the origin stands inside the cylinder (r ≥ ‖c‖): it has no limbs then.
    #[must_use]
    pub fn contains_origin(&self) -> bool {
        self.radius >= self.distance_of_axis_from_origin()
    }

    /// Whether the cap of an end at a position along the axis, from the axis point, is seen from the origin; `outward` (± 1) is the
    /// direction along the axis that leads out of the cylinder there.
    #[must_use]
    pub fn end_faces_origin(&self, position: f64, outward: f64) -> bool {
        outward * (self.axis.point.dot(&self.axis.direction) + position) < 0.0
    }

    /// The two parameters t of the ray t · `ray` from the origin where it meets the surface, in ascending
    /// order; `None` when it passes by or runs parallel to the axis.
    #[inline]
    #[must_use]
    pub fn intersect_ray(&self, ray: &Vector3<f64>) -> Option<(f64, f64)> {
        let d = &self.axis.direction;
        let c = self.axis.nearest_to_origin();
        // Everything in the plane across the axis: |t k − c|² = r².
        let k = rejection(ray, d);
        let a = k.norm_squared();
        let b = k.dot(&c);
        let kxc = k.cross(&c).norm_squared();
        // b² − a (|c|² − r²) without the cancellation, by Lagrange's identity.
        let discriminant = a * self.radius * self.radius - kxc;
        if !(a > 0.0 && discriminant >= 0.0) {
            return None;
        }
        let root = discriminant.sqrt();
        // Vieta: the root of larger size first, the other from the product of both.
        let large = if b >= 0.0 { b + root } else { b - root };
        let product = c.norm_squared() - self.radius * self.radius;
        let (t1, t2) = if large == 0.0 { (0.0, 0.0) } else { (large / a, product / large) };
        Some((t1.min(t2), t1.max(t2)))
    }

    /// The point where a ray from the origin first meets the surface in front of the observer. From inside
    /// the pipe that is its far wall.
    #[inline]
    #[must_use]
    pub fn first_hit(&self, ray: &Vector3<f64>) -> Option<Vector3<f64>> {
        let (near, far) = self.intersect_ray(ray)?;
        let t = if near > 0.0 { near } else { far };
        (t > 0.0).then(|| ray * t)
    }

    /// Counts the points on the wall that an observer at the origin sees: the near wall from outside (the
    /// outward normal points towards the observer), the far wall from inside (it points away).
    pub fn visible_wall(&self, points: impl Iterator<Item = Vector3<f64>>) -> Walls {
        let inside = self.contains_origin();
        let d = self.axis.direction;
        let mut walls = Walls::default();
        for p in points {
            let outward = rejection(&(p - self.axis.point), &d);
            walls.total += 1;
            walls.visible += usize::from((outward.dot(&p) < 0.0) != inside);
        }
        walls
    }

    /// The cylinder moved along the line of sight by two radii, away from an observer at the origin. Points on
    /// the far wall of this cylinder lie on the near wall of the other.
    #[must_use]
    pub fn mirrored_away(&self) -> Self {
        let c = self.axis.nearest_to_origin();
        let norm = c.norm();
        let away = if norm > 0.0 { c / norm } else { super::any_orthogonal(&self.axis.direction).0 };
        let point = self.axis.point + away * (2.0 * self.radius);
        Self { axis: Line { point, direction: self.axis.direction }, radius: self.radius }
    }

    /// How `other` differs from this cylinder.
    #[must_use]
    pub fn compare(&self, other: &Cylinder) -> CylinderComparison {
        CylinderComparison {
            angle: self.axis.angle(&other.axis),
            axis_distance: self.axis.distance_to_line(&other.axis),
            radius_relative: (other.radius - self.radius) / self.radius,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn oblique() -> Cylinder {
        Cylinder::new(Vector3::new(0.1, -0.2, 0.9), Vector3::new(0.4, 0.8, 0.3), 0.07).unwrap()
    }

    #[test]
    fn the_cap_that_is_turned_to_the_origin_is_seen() {
        // Seen is the end that the axis leads away from the origin. The axis passes beside it at the position -1.
        let cylinder = Cylinder::new(Vector3::new(0.0, 0.1, 1.0), Vector3::z(), 0.05).unwrap();
        let faces = |position: f64, outward: f64| cylinder.end_faces_origin(position, outward);
        assert!(faces(-0.2, -1.0) && !faces(0.2, 1.0));
        assert!(!faces(-1.1, -1.0) && faces(-1.1, 1.0));
    }

    #[test]
    fn distance_agrees_with_the_plucker_form() {
        let cylinder = oblique();
        let plucker = crate::geometry::line::PluckerLine::from(cylinder.axis);
        for p in [Vector3::new(0.3, 0.1, 0.5), Vector3::new(-2.0, 0.4, 7.0), cylinder.axis.point] {
            let by_moment = (plucker.moment - p.cross(&plucker.direction)).norm() - cylinder.radius;
            assert!((cylinder.distance(&p) - by_moment).abs() < 1e-14);
        }
    }

    #[test]
    fn rays_meet_the_surface_where_they_say() {
        let cylinder = oblique();
        let ray = cylinder.axis.point + Vector3::new(0.01, 0.02, -0.015);
        let (near, far) = cylinder.intersect_ray(&ray).unwrap();
        assert!(0.0 < near && near < far);
        for t in [near, far] {
            assert!(cylinder.distance(&(ray * t)).abs() < 1e-14);
        }
        assert_eq!(cylinder.first_hit(&ray).unwrap(), ray * near);
        assert!(cylinder.intersect_ray(&Vector3::new(1.0, 0.0, 0.0)).is_none());
        assert!(cylinder.intersect_ray(&cylinder.axis.direction).is_none());
        // Behind the observer both roots are negative.
        assert!(cylinder.first_hit(&-ray).is_none());
    }

    #[test]
    fn from_inside_the_first_hit_is_the_far_root() {
        let pipe = Cylinder::new(Vector3::new(0.02, 0.0, 0.0), Vector3::z(), 0.5).unwrap();
        assert!(pipe.contains_origin());
        let hit = pipe.first_hit(&Vector3::new(1.0, 0.0, 1.0)).unwrap();
        assert!((hit.x - 0.52).abs() < 1e-15 && hit.z > 0.0);
        let wall = pipe.visible_wall([hit].into_iter());
        assert_eq!(wall, Walls { visible: 1, total: 1 });
    }

    #[test]
    fn the_mirror_image_puts_far_wall_points_on_the_near_wall() {
        let cylinder = oblique();
        let ray = cylinder.axis.point;
        let (_, far) = cylinder.intersect_ray(&ray).unwrap();
        let p = ray * far;
        assert_eq!(cylinder.visible_wall([p].into_iter()).visible, 0);
        let mirrored = cylinder.mirrored_away();
        assert_eq!(mirrored.visible_wall([p].into_iter()).visible, 1);
    }

    #[test]
    fn bad_numbers_are_refused_with_their_value() {
        let p = Vector3::zeros();
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = Cylinder::new(p, Vector3::z(), radius).unwrap_err();
            assert!(error.to_string().contains(&format!("radius is {radius}")), "{error}");
        }
        assert!(Cylinder::new(p, Vector3::zeros(), 1.0).is_err());
        assert!(Cylinder::new(Vector3::new(f64::NAN, 0.0, 0.0), Vector3::z(), 1.0).is_err());
    }

    #[test]
    fn comparison_is_free_of_the_sign_of_the_direction() {
        let a = oblique();
        let mut b = a;
        b.axis.direction = -b.axis.direction;
        b.radius *= 1.01;
        let difference = a.compare(&b);
        assert!(difference.angle < 1e-15 && difference.axis_distance < 1e-15);
        assert!((difference.radius_relative - 0.01).abs() < 1e-12);
    }
}
