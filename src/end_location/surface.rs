//! The visible lateral surface in the image: its generators and how they project.

use crate::camera::Camera;
use crate::geometry::{Cylinder, LimbFrame};
use nalgebra::{Vector2, Vector3};

/// The visible surface of a cylinder seen from outside. A position on it is an angle about the axis, 0 towards the
/// camera, and a position along the axis, from the axis point of the model.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface<'a> {
    pub camera: &'a Camera,
    pub cylinder: &'a Cylinder,
    pub frame: LimbFrame,
}

/// How the end circle at a position crosses one generator in the image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    /// Length of the generator in the image by length along the axis, pixels per unit.
    pub along: f64,
    /// The same for its part across the arc: how fast the arc moves sideways, pixels per unit. Never negative.
    pub across: f64,
}

impl<'a> Surface<'a> {
    /// `None` when the camera is inside the cylinder.
    pub fn new(camera: &'a Camera, cylinder: &'a Cylinder) -> Option<Self> {
        Some(Self { camera, cylinder, frame: LimbFrame::new(cylinder)? })
    }

    /// The direction from the axis to the generator at an angle, a unit vector.
    pub fn normal(&self, angle: f64) -> Vector3<f64> {
        self.frame.sideways * angle.sin() - self.frame.toward * angle.cos()
    }

    /// A point of the surface.
    pub fn point(&self, angle: f64, position: f64) -> Vector3<f64> {
        let Cylinder { axis, radius } = self.cylinder;
        axis.at(position) + self.normal(angle) * *radius
    }

    /// Its pixel, when the camera model has one; it may lie outside the image.
    pub fn pixel(&self, angle: f64, position: f64) -> Option<Vector2<f64>> {
        self.camera.project(&self.point(angle, position))
    }

    /// The generator at an angle.
    pub fn generator(&self, angle: f64) -> Generator<'a> {
        Generator { surface: *self, angle, from_axis: self.normal(angle) * self.cylinder.radius }
    }

    /// The angle of the limbs, at which the surface turns away: cos = r / ‖c‖.
    pub fn limb_angle(&self) -> f64 {
        self.frame.sin_gamma.acos()
    }

    /// Half the width of the visible surface in the image at a position, in pixels.
    pub fn half_width(&self, position: f64) -> Option<f64> {
        let limb = self.limb_angle();
        Some(0.5 * (self.pixel(limb, position)? - self.pixel(-limb, position)?).norm())
    }

    /// Angles of `count` generators, evenly spaced in the image over the given part (0 to 1) of the width.
    pub fn generators(&self, count: usize, part: f64) -> impl Iterator<Item = f64> + use<> {
        let limb_sine = self.limb_angle().sin();
        (0..count).map(move |k| {
            let across = 2.0 * (k as f64 + 0.5) / count as f64 - 1.0;
            (limb_sine * part * across).asin()
        })
    }

    /// How the end circle at a position crosses the generator at an angle.
    pub fn crossing(&self, angle: f64, position: f64) -> Option<Crossing> {
        self.generator(angle).crossing(position)
    }
}

/// A line of the surface along the axis. Its sine and cosine are found once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Generator<'a> {
    pub surface: Surface<'a>,
    pub angle: f64,
    /// From the axis to it.
    from_axis: Vector3<f64>,
}

/// How far from a generator, as an angle, its neighbours are at which the tangent of the end circle is taken, and how far along
/// the axis in radii: small against every curvature in the image, large against rounding.
const STEP: f64 = 1e-3;

impl Generator<'_> {
    /// A point of the surface.
    pub fn point(&self, position: f64) -> Vector3<f64> {
        let Cylinder { axis, .. } = self.surface.cylinder;
        axis.at(position) + self.from_axis
    }

    /// Its pixel, when the camera model has one; it may lie outside the image.
    pub fn pixel(&self, position: f64) -> Option<Vector2<f64>> {
        self.surface.camera.project(&self.point(position))
    }

    /// The pixels of several positions by their numbers x and y, not finite where the camera model has none.
    #[inline(always)]
    pub fn pixels(&self, positions: &[f64], x: &mut [f64], y: &mut [f64]) {
        let Cylinder { axis, .. } = self.surface.cylinder;
        self.surface.camera.project_line([&axis.point, &axis.direction, &self.from_axis], positions, x, y);
    }

    /// The pixel at a position on the generator beside it.
    pub fn pixel_beside(&self, position: f64) -> Option<Vector2<f64>> {
        self.surface.pixel(self.angle + STEP, position)
    }

    /// How the end circle at a position crosses it.
    pub fn crossing(&self, position: f64) -> Option<Crossing> {
        let length = STEP * self.surface.cylinder.radius;
        let generator = (self.pixel(position + length)? - self.pixel(position - length)?) / (2.0 * length);
        let tangent = self.pixel_beside(position)? - self.surface.pixel(self.angle - STEP, position)?;
        let across = generator.perp(&tangent).abs() / tangent.norm();
        let along = generator.norm();
        (along > 0.0 && across.is_finite()).then_some(Crossing { along, across })
    }
}
