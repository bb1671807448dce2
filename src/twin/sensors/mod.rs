//! Depth sensors, each with its law and where that was published.

mod active_stereo;
mod infrared;
mod matching;
mod structured_light;
mod time_of_flight;

pub use active_stereo::ActiveStereo;
pub use structured_light::StructuredLight;
pub use time_of_flight::TimeOfFlight;

use super::scene::{Scene, Viewpoint};
use crate::camera::{Camera, Distortion, Intrinsics};
use crate::error::Result;
use crate::geometry::RigidMotion;
use crate::observations::DepthCamera;
use nalgebra::{Matrix3, Vector2, Vector3};

/// What measures depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DepthSensor {
    /// The exact depth at the centre of each pixel of the colour camera.
    Exact,
    /// Dots from a projector, matched with themselves.
    StructuredLight(StructuredLight),
    /// Modulated light.
    TimeOfFlight(TimeOfFlight),
    /// Two cameras and a projector of dots.
    ActiveStereo(ActiveStereo),
}

impl DepthSensor {
    /// The depth camera that the sensor has beside the colour camera; `None` where that is the same.
    ///
    /// # Errors
    /// Never for these numbers; the constructors check them.
    pub fn camera(&self) -> Result<Option<DepthCamera>> {
        let (focal_length, aside) = match self {
            DepthSensor::Exact => return Ok(None),
            DepthSensor::StructuredLight(_) => (575.0, -0.025),
            DepthSensor::TimeOfFlight(_) => (540.0, 0.032),
            DepthSensor::ActiveStereo(_) => (600.0, -0.035),
        };
        let camera = Camera::new(Intrinsics {
            width: 640,
            height: 480,
            fx: focal_length,
            fy: focal_length,
            cx: 319.5,
            cy: 239.5,
            distortion: Distortion::None,
        })?;
        let to_color = RigidMotion::new(Matrix3::identity(), Vector3::new(aside, 0.0, 0.0))?;
        Ok(Some(DepthCamera { camera, to_color }))
    }

    /// The depth z of each pixel of the depth camera in metres, row by row; 0 where none was measured.
    #[must_use]
    pub fn measure(&self, scene: &Scene, own: &DepthCamera, seed: u64) -> Vec<f32> {
        match self {
            DepthSensor::Exact => exact_depth(scene, own).into_iter().map(|z| z as f32).collect(),
            DepthSensor::StructuredLight(sensor) => sensor.measure(scene, own, seed),
            DepthSensor::TimeOfFlight(sensor) => sensor.measure(scene, own, seed),
            DepthSensor::ActiveStereo(sensor) => sensor.measure(scene, own, seed),
        }
    }
}

/// The depth z at the centre of each pixel of a camera, row by row; 0 where nothing is.
#[must_use]
pub fn exact_depth(scene: &Scene, own: &DepthCamera) -> Vec<f64> {
    let (width, height) = own.camera.size();
    let eye = Viewpoint::new(scene, *own.to_color.translation());
    let depth = |k: usize| {
        let ray = own.camera.unproject(&Vector2::new((k % width) as f64, (k / width) as f64))?;
        // Along a ray with z = 1 the depth is how many times the ray it is away.
        Some(eye.look(&own.to_color.direction(&ray))?.t)
    };
    (0..width * height).map(|k| depth(k).unwrap_or(0.0)).collect()
}
