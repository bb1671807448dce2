//! The bodies of a scene, each in its own frame, and where rays meet them.

use nalgebra::Vector3;

/// A body in its own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A body turned about the z axis, the origin at its middle: a cylinder where both radii are the same, else a
    /// frustum.
    Turned {
        /// The radii at z = −length / 2 and z = length / 2.
        radii: [f64; 2],
        /// The length along z.
        length: f64,
        /// The radius of the hole through it, less than both radii; `None` for a closed body.
        bore: Option<f64>,
    },
    /// A box by half of its edges.
    Box {
        /// Half of the edges along x, y, z.
        half: Vector3<f64>,
    },
    /// A sphere about the origin.
    Sphere {
        /// The radius.
        radius: f64,
    },
    /// The plane z = 0 without an end.
    Plane,
}

/// What of a body a ray met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Part {
    /// The surface that makes it what it is: the lateral surface of what is turned, all of other bodies.
    Body,
    /// A flat end, closed or a ring.
    Cap,
    /// The wall of the hole.
    Inner,
}

/// Which face a ray met.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Face {
    Lateral,
    Bore,
    End,
    /// Of a box: the axis across it.
    Side(usize),
    Sphere,
    Plane,
}

impl Face {
    pub fn part(self) -> Part {
        match self {
            Face::End => Part::Cap,
            Face::Bore => Part::Inner,
            Face::Lateral | Face::Side(_) | Face::Sphere | Face::Plane => Part::Body,
        }
    }
}

impl Shape {
    /// The radius of a ball about the origin that holds the body; `None` where there is none.
    pub(super) fn bound(&self) -> Option<f64> {
        match self {
            Shape::Turned { radii, length, .. } => Some(libm::hypot(0.5 * length, radii[0].max(radii[1]))),
            Shape::Box { half } => Some(half.norm()),
            Shape::Sphere { radius } => Some(*radius),
            Shape::Plane => None,
        }
    }

    /// The least t > 0 with `from` + t · `along` on the surface, and the face there.
    pub(super) fn meet(&self, from: &Vector3<f64>, along: &Vector3<f64>) -> Option<(f64, Face)> {
        // From the point of the ray nearest to the middle all numbers are of the size of the body: nothing cancels.
        let shift = if *self == Shape::Plane { 0.0 } else { -from.dot(along) / along.norm_squared() };
        let mut ray = Ray { from: from + along * shift, along: *along, least: -shift, met: None };
        match self {
            Shape::Turned { radii, length, bore } => {
                ray.meet_turned(*radii, *length, Face::Lateral);
                if let Some(bore) = bore {
                    ray.meet_turned([*bore; 2], *length, Face::Bore);
                }
                ray.meet_ends(*radii, *length, bore.unwrap_or(0.0));
            }
            Shape::Box { half } => ray.meet_box(half),
            Shape::Sphere { radius } => ray.meet_sphere(*radius),
            Shape::Plane => ray.offer(-from.z / along.z, Face::Plane),
        }
        ray.met.map(|(t, face)| (t + shift, face))
    }

    /// The unit normal at a point of a face, outward from the material.
    pub(super) fn normal(&self, face: Face, at: &Vector3<f64>) -> Vector3<f64> {
        match (face, self) {
            (Face::Lateral, Shape::Turned { radii, length, .. }) => {
                let across = at.xy().norm();
                Vector3::new(at.x / across, at.y / across, (radii[0] - radii[1]) / length).normalize()
            }
            (Face::Bore, _) => -Vector3::new(at.x, at.y, 0.0).normalize(),
            (Face::Side(axis), _) => {
                let mut normal = Vector3::zeros();
                normal[axis] = at[axis].signum();
                normal
            }
            (Face::Sphere, _) => at.normalize(),
            (Face::End, _) => Vector3::z() * at.z.signum(),
            (Face::Lateral | Face::Plane, _) => Vector3::z(),
        }
    }

    /// Two coordinates on a face, in units of length: what is printed on the surface follows them.
    pub(super) fn surface_coordinates(&self, face: Face, at: &Vector3<f64>) -> [f64; 2] {
        match (face, self) {
            (Face::Lateral | Face::Bore, Shape::Turned { radii, .. }) => {
                [libm::atan2(at.y, at.x) * 0.5 * (radii[0] + radii[1]), at.z]
            }
            (Face::Side(0), _) => [at.y, at.z],
            (Face::Side(1), _) => [at.x, at.z],
            (Face::Sphere, Shape::Sphere { radius }) => [libm::atan2(at.y, at.x) * radius, at.z],
            _ => [at.x, at.y],
        }
    }
}

/// A ray that looks for the first face.
struct Ray {
    from: Vector3<f64>,
    along: Vector3<f64>,
    /// Faces count beyond this.
    least: f64,
    met: Option<(f64, Face)>,
}

impl Ray {
    fn offer(&mut self, t: f64, face: Face) {
        if t > self.least && self.met.is_none_or(|(first, _)| t < first) {
            self.met = Some((t, face));
        }
    }

    /// x² + y² = (a + b z)² between the ends.
    fn meet_turned(&mut self, radii: [f64; 2], length: f64, face: Face) {
        let (o, d) = (&self.from, &self.along);
        let (a, b) = (0.5 * (radii[0] + radii[1]), (radii[1] - radii[0]) / length);
        let radius = a + b * o.z;
        let square = d.x * d.x + d.y * d.y - b * b * d.z * d.z;
        let half = o.x * d.x + o.y * d.y - radius * b * d.z;
        let constant = o.x * o.x + o.y * o.y - radius * radius;
        let (z, dz) = (o.z, d.z);
        for t in roots(square, half, constant).into_iter().flatten() {
            let height = z + t * dz;
            if height.abs() <= 0.5 * length && a + b * height > 0.0 {
                self.offer(t, face);
            }
        }
    }

    fn meet_ends(&mut self, radii: [f64; 2], length: f64, bore: f64) {
        for (radius, height) in [(radii[0], -0.5 * length), (radii[1], 0.5 * length)] {
            let t = (height - self.from.z) / self.along.z;
            let across = (self.from + self.along * t).xy().norm();
            if across <= radius && across >= bore {
                self.offer(t, Face::End);
            }
        }
    }

    fn meet_box(&mut self, half: &Vector3<f64>) {
        for axis in 0..3 {
            for side in [-half[axis], half[axis]] {
                let t = (side - self.from[axis]) / self.along[axis];
                let at = self.from + self.along * t;
                if (0..3).all(|other| other == axis || at[other].abs() <= half[other]) {
                    self.offer(t, Face::Side(axis));
                }
            }
        }
    }

    fn meet_sphere(&mut self, radius: f64) {
        let (o, d) = (&self.from, &self.along);
        let found = roots(d.norm_squared(), o.dot(d), o.norm_squared() - radius * radius);
        for t in found.into_iter().flatten() {
            self.offer(t, Face::Sphere);
        }
    }
}

/// The roots of a t² + 2 b t + c, by Vieta where a difference would cancel.
fn roots(a: f64, b: f64, c: f64) -> [Option<f64>; 2] {
    let discriminant = b * b - a * c;
    if !(discriminant >= 0.0) {
        return [None; 2];
    }
    let large = -(b + discriminant.sqrt().copysign(b));
    [large / a, c / large].map(|root| root.is_finite().then_some(root))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAN: Shape = Shape::Turned { radii: [0.1; 2], length: 0.4, bore: None };
    const TUBE: Shape = Shape::Turned { radii: [0.1; 2], length: 0.4, bore: Some(0.08) };

    #[test]
    fn rays_meet_the_faces_of_a_can() {
        let down = Vector3::new(0.0, 0.0, -1.0);
        assert_eq!(CAN.meet(&Vector3::new(0.05, 0.0, 1.0), &down), Some((0.8, Face::End)));
        assert_eq!(CAN.meet(&Vector3::new(0.11, 0.0, 1.0), &down), None);
        let (t, face) = CAN.meet(&Vector3::new(3.0, 0.0, 0.1), &-Vector3::x()).unwrap();
        assert!((t - 2.9).abs() < 1e-14 && face == Face::Lateral);
        // Away from it.
        assert_eq!(CAN.meet(&Vector3::new(3.0, 0.0, 0.1), &Vector3::x()), None);
    }

    #[test]
    fn a_tube_shows_its_wall_its_ring_and_what_is_behind() {
        let down = Vector3::new(0.0, 0.0, -1.0);
        assert_eq!(TUBE.meet(&Vector3::new(0.05, 0.0, 1.0), &down), None);
        assert_eq!(TUBE.meet(&Vector3::new(0.09, 0.0, 1.0), &down), Some((0.8, Face::End)));
        let (_, face) = TUBE.meet(&Vector3::new(0.0, 0.0, 0.5), &Vector3::new(0.2, 0.0, -1.0)).unwrap();
        assert_eq!(face, Face::Bore);
    }

    #[test]
    fn points_lie_on_the_surfaces_with_their_normals() {
        let cone = Shape::Turned { radii: [0.1, 0.05], length: 0.2, bore: None };
        let ball = Shape::Sphere { radius: 0.1 };
        let block = Shape::Box { half: Vector3::new(0.1, 0.05, 0.2) };
        let from = Vector3::new(0.3, -0.7, 0.4);
        for shape in [cone, ball, block, CAN] {
            let along = Vector3::new(0.01, 0.02, 0.03) - from;
            let (t, face) = shape.meet(&from, &along).unwrap();
            let at = from + along * t;
            let normal = shape.normal(face, &at);
            // A step along the tangent stays on the surface to second order, and meets it again.
            let tangent = normal.cross(&Vector3::new(0.3, 0.4, 0.5)).normalize() * 1e-5;
            let (again, _) = shape.meet(&(from + tangent), &along).unwrap();
            let step = from + tangent + along * again - at;
            assert!(step.dot(&normal).abs() < 1e-8, "{shape:?}: {step:?}");
            assert!((normal.norm() - 1.0).abs() < 1e-14 && normal.dot(&along) < 0.0);
        }
    }
}
