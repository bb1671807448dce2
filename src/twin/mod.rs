//! A twin of an RGB-D camera: scenes of bodies, and frames of them as a camera would take them, with the truth.
//!
//! Bodies are cylinders, tubes, frustums, boxes, spheres and planes; rays meet them in closed form. The image has light,
//! shadow, texture, the blur of a lens and the noise of a sensor. Depth comes from a physical simulation of structured
//! light, time of flight or active stereo, so that it is fattened, missing, flying or quantised where that of a camera
//! is; each sensor names the sources of its law. The same seed gives the same bits on every machine.
//!
//! ```
//! use cylfuse::camera::{Camera, Distortion, Intrinsics};
//! use cylfuse::twin::{CaptureOptions, DepthSensor, Kind, PictureOptions, capture, random_scene};
//!
//! let camera = Camera::new(Intrinsics {
//!     width: 64, height: 48, fx: 57.0, fy: 57.0, cx: 31.5, cy: 23.5, distortion: Distortion::None,
//! })?;
//! let picture = PictureOptions::default();
//! let options = CaptureOptions { camera, picture, sensor: DepthSensor::Exact, registered: true };
//! let frame = capture(&random_scene(Kind::Table, 1)?, &options, 1)?;
//! assert!(frame.labels.iter().any(|object| *object > 0));
//! # Ok::<(), cylfuse::error::Error>(())
//! ```

mod annotation;
mod capture;
mod layouts;
mod picture;
mod random;
mod sampling;
mod scene;
mod sensors;
mod shape;

pub use annotation::{clipped, drawn_mask, hand_set, true_edges};
pub use capture::{Capture, CaptureOptions, DEPTH_UNIT, SeenCylinder, capture};
pub use layouts::{Kind, random_scene};
pub use picture::{PictureOptions, picture};
pub use random::{Purpose, Stream};
pub use scene::{Body, Hit, Material, Patch, Scene, Style, Texture, TrueCylinder, Viewpoint};
pub use sensors::{ActiveStereo, DepthSensor, StructuredLight, TimeOfFlight, exact_depth};
pub use shape::{Part, Shape};
