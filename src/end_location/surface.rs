//! The visible lateral surface in the image: its generators and how they project.

use crate::camera::Camera;
use crate::geometry::{Cylinder, LimbFrame};
use nalgebra::{Vector2, Vector3};

/// The visible surface of a cylinder seen from outside. A place on it is an angle about the axis, 0 towards the
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
        axis.point + axis.direction * position + self.normal(angle) * *radius
    }

    /// Its pixel, when the camera model has one; it may lie outside the image.
    pub fn pixel(&self, angle: f64, position: f64) -> Option<Vector2<f64>> {
        self.camera.project(&self.point(angle, position))
    }

    /// The same for all positions on the generator at an angle.
    pub fn pixels(&self, angle: f64) -> impl Fn(f64) -> Option<Vector2<f64>> {
        let Cylinder { axis, radius } = self.cylinder;
        let from_axis = self.normal(angle) * *radius;
        move |position| self.camera.project(&(axis.point + axis.direction * position + from_axis))
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
        // Small against every curvature in the image, large against rounding.
        let step = 1e-3;
        let length = step * self.cylinder.radius;
        let generator =
            (self.pixel(angle, position + length)? - self.pixel(angle, position - length)?) / (2.0 * length);
        let tangent = self.pixel(angle + step, position)? - self.pixel(angle - step, position)?;
        let across = generator.perp(&tangent).abs() / tangent.norm();
        let along = generator.norm();
        (along > 0.0 && across.is_finite()).then_some(Crossing { along, across })
    }
}
