//! Frames of the twin by structured light, and fits to them. A program that takes this part takes `frames`, too.
#![allow(dead_code, clippy::unwrap_used)]

use super::frames::Inputs;
use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::fitter::FitResult;
use cylfuse::twin::{
    Capture, CaptureOptions, DEPTH_UNIT, DepthSensor, PictureOptions, Scene, StructuredLight, capture,
};

pub const SIZE: (usize, usize) = (640, 480);

/// A pinhole of some focal length in pixels.
pub fn intrinsics(focal: f64) -> Intrinsics {
    let (width, height) = (SIZE.0 as u32, SIZE.1 as u32);
    Intrinsics { width, height, fx: focal, fy: focal, cx: 319.5, cy: 239.5, distortion: Distortion::None }
}

/// What the twin sees of a scene.
pub fn captured(scene: &Scene, focal: f64, seed: u64) -> Capture {
    let options = CaptureOptions {
        camera: Camera::new(intrinsics(focal)).unwrap(),
        picture: PictureOptions::default(),
        sensor: DepthSensor::StructuredLight(StructuredLight::default()),
        registered: true,
    };
    capture(scene, &options, seed).unwrap()
}

/// The fit within a mask, with the image and without edges.
pub fn fit_within(frame: &Capture, focal: f64, mask: Vec<u8>) -> FitResult {
    let inputs = Inputs {
        intrinsics: intrinsics(focal),
        size: SIZE,
        depth: frame.depth.clone(),
        depth_scale: DEPTH_UNIT,
        mask,
        image: frame.image.clone(),
        edges: Vec::new(),
    };
    let mut fitter = inputs.fitter();
    inputs.push_image(&mut fitter);
    fitter.fit().unwrap()
}
