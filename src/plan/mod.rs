//! What a camera will measure of a cylinder that nobody has put before it yet.
//!
//! A [`Plan`] says where the cylinder stands and how noisy depth and image are. [`Plan::expected`] gives the standard
//! deviations of radius, direction, position and length by the covariance of the robust objective at the exact view. With the
//! feature `twin`, `Plan::trial` takes captures of the twin of an RGB-D camera instead and fits them.
//!
//! ```
//! use cylfuse::camera::{Camera, Distortion, Intrinsics};
//! use cylfuse::plan::{DepthNoise, Plan, StepNoise};
//!
//! let camera = Camera::new(Intrinsics {
//!     width: 640, height: 480, fx: 570.0, fy: 570.0, cx: 319.5, cy: 239.5, distortion: Distortion::None,
//! })?;
//! let depth = DepthNoise::structured_light(&camera);
//! let plan = |distance| Plan {
//!     distance,
//!     ..Plan::new(camera.clone(), depth)
//! };
//! let near = plan(0.7).expected()?;
//! let far = plan(1.4).expected()?;
//! assert!(near.total.radius < far.total.radius && near.scatter.radius < near.total.radius);
//! # Ok::<(), cylfuse::error::Error>(())
//! ```

mod expected;
mod noise;
#[cfg(feature = "twin")]
mod simulation;
#[cfg(test)]
mod tests;
mod view;

pub use expected::Expected;
pub use noise::{DepthNoise, StepNoise};
#[cfg(feature = "twin")]
pub use simulation::{Scatter, Trial};

use crate::camera::Camera;
use crate::error::{Error, Result, positive};
use crate::geometry::Cylinder;
use nalgebra::Vector3;

/// A tilt beyond this leaves hardly anything of the lateral surface to be seen, in radians: 80°.
const MOST_TILT: f64 = 1.4;

/// A cylinder before a camera, with the middle of its axis on the optical axis.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The camera of the image, on whose pixels the depth is.
    pub camera: Camera,
    /// From the camera to the middle of the axis, in metres.
    pub distance: f64,
    /// The radius in metres.
    pub radius: f64,
    /// The length in metres.
    pub length: f64,
    /// The angle between the axis and the plane of the image in radians: 0 when the cylinder is seen from the side.
    pub tilt: f64,
    /// The angle of the axis in the image from the vertical, in radians.
    pub turn: f64,
    /// The noise of the depth.
    pub depth: DepthNoise,
    /// The noise of the image where the cylinder ends in it.
    pub step: StepNoise,
}

/// Standard deviations of what is measured of a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviations {
    /// Of the radius in metres.
    pub radius: f64,
    /// Of the direction of the axis in radians, in the plane in which it is least certain.
    pub direction: f64,
    /// Of the position of the axis across itself in metres, at its middle and in the direction in which it is least
    /// certain.
    pub position: f64,
    /// Of the length in metres; `None` where an end lies outside the image.
    pub length: Option<f64>,
}

impl Plan {
    /// A can of radius 30 mm and length 100 mm at 0.7 m, tilted by 20° and turned by 24°, in an ordinary image.
    #[must_use]
    pub fn new(camera: Camera, depth: DepthNoise) -> Self {
        let [tilt, turn] = [20.0_f64, 24.0].map(f64::to_radians);
        let step = StepNoise::default();
        Self { camera, distance: 0.7, radius: 0.03, length: 0.1, tilt, turn, depth, step }
    }

    /// Checks the values.
    ///
    /// # Errors
    /// `InvalidArgument` that names the value and its limit.
    pub fn check(&self) -> Result<()> {
        let sizes = [("distance", self.distance), ("radius", self.radius), ("length", self.length)];
        for (name, value) in sizes {
            positive(name, value)?;
        }
        if !(self.tilt.abs() <= MOST_TILT) {
            return Err(Error::argument("tilt", self.tilt, format!("be from {} to {MOST_TILT}", -MOST_TILT)));
        }
        if !self.turn.is_finite() {
            return Err(Error::argument("turn", self.turn, "be finite"));
        }
        let depth = self.distance * self.tilt.cos();
        if !(self.radius < depth) {
            return Err(Error::argument(
                "radius",
                self.radius,
                format!("be less than {depth}, the distance of the axis from the camera"),
            ));
        }
        let nearest = self.distance - 0.5 * self.length * self.tilt.sin().abs() - self.radius;
        if !(nearest > 0.0) {
            let requirement = "be so short that the cylinder ends before the camera";
            return Err(Error::argument("length", self.length, requirement));
        }
        self.depth.check()?;
        self.step.check()
    }

    /// The cylinder in the frame of the camera.
    ///
    /// # Errors
    /// `InvalidArgument` where the radius is none.
    pub fn cylinder(&self) -> Result<Cylinder> {
        let (sine, cosine) = libm::sincos(self.turn);
        let (away, across) = libm::sincos(self.tilt);
        Cylinder::new(self.center(), Vector3::new(sine * across, cosine * across, away), self.radius)
    }

    /// The middle of the axis.
    #[must_use]
    pub fn center(&self) -> Vector3<f64> {
        Vector3::z() * self.distance
    }
}
