//! Scenes as the twin takes them.

use crate::truths::Truths;
use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::observations::{DepthRange, DepthView, Frame, ImageView};
use cylfuse::twin::{CaptureOptions, DEPTH_UNIT, DepthSensor, Kind, PictureOptions, capture, random_scene};

const SIZE: (usize, usize) = (640, 480);

/// The camera of all scenes.
pub fn camera() -> Camera {
    let (width, height) = (SIZE.0 as u32, SIZE.1 as u32);
    let distortion = Distortion::None;
    Camera::new(Intrinsics { width, height, fx: 570.0, fy: 570.0, cx: 319.5, cy: 239.5, distortion }).unwrap()
}

/// A frame of a scene with the noise of another seed, and what is true of it.
pub fn capture_frame(kind: Kind, sensor: DepthSensor, seed: u64, noise: u64) -> (Frame, Truths) {
    let scene = random_scene(kind, seed).unwrap();
    let picture = PictureOptions::default();
    let options = CaptureOptions { camera: camera(), picture, sensor, registered: true };
    let captured = capture(&scene, &options, noise).unwrap();
    let mut frame = Frame::new(camera());
    let depth = DepthView::from_u16(&captured.depth, SIZE, DEPTH_UNIT).unwrap();
    frame.set_depth(&depth, &DepthRange::default()).unwrap();
    frame.set_image(&ImageView::from_u8(&captured.image, SIZE).unwrap()).unwrap();
    (frame, Truths::new(&scene, &captured))
}
