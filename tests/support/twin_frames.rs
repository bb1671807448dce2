//! Frames of the twin by structured light, and fits to them. A program that takes this part takes `frames`, too.
#![allow(dead_code, clippy::unwrap_used)]

use super::frames::Inputs;
use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::fitter::{FitResult, Fitter};
use cylfuse::geometry::RigidMotion;
use cylfuse::observations::EdgeSegment;
use cylfuse::twin::{
    Body, Capture, CaptureOptions, DEPTH_UNIT, DepthSensor, Material, PictureOptions, Scene, Shape,
    StructuredLight, capture,
};
use nalgebra::{Matrix3, Vector3};

pub const SIZE: (usize, usize) = (640, 480);

/// A pinhole of some focal length in pixels.
pub fn intrinsics(focal: f64) -> Intrinsics {
    let (width, height) = (SIZE.0 as u32, SIZE.1 as u32);
    Intrinsics { width, height, fx: focal, fy: focal, cx: 319.5, cy: 239.5, distortion: Distortion::None }
}

/// A turned body, object 1, in front of a wall. Its axis lies across the view, along x.
pub fn turned_before_wall(radii: [f64; 2], length: f64) -> Scene {
    let turned = Shape::Turned { radii, length, bore: None };
    let rotation = Matrix3::from_columns(&[Vector3::y(), Vector3::z(), Vector3::x()]);
    let body = |object, shape, rotation, z| Body {
        object,
        shape,
        pose: RigidMotion::new(rotation, Vector3::new(0.0, 0.0, z)).unwrap(),
        material: Material { albedo: if object == 0 { 0.9 } else { 0.4 }, ..Material::default() },
        measured: false,
    };
    let bodies = vec![body(1, turned, rotation, 0.7), body(0, Shape::Plane, Matrix3::identity(), 1.0)];
    Scene { bodies, lamp: Vector3::new(0.2, -0.3, -0.3), ambient: 0.5, ..Scene::default() }
}

/// What the twin sees of a scene by structured light.
pub fn captured(scene: &Scene, focal: f64, seed: u64) -> Capture {
    captured_by(DepthSensor::StructuredLight(StructuredLight::default()), scene, focal, seed)
}

/// What the twin sees of a scene by some sensor.
pub fn captured_by(sensor: DepthSensor, scene: &Scene, focal: f64, seed: u64) -> Capture {
    let camera = Camera::new(intrinsics(focal)).unwrap();
    let options = CaptureOptions { camera, picture: PictureOptions::default(), sensor, registered: true };
    capture(scene, &options, seed).unwrap()
}

/// The fit within a mask, with the image and without edges.
pub fn fit_within(frame: &Capture, focal: f64, mask: Vec<u8>) -> FitResult {
    fit_with_edges(frame, focal, mask, &[])
}

/// The fit within a mask, with the image and edges.
pub fn fit_with_edges(frame: &Capture, focal: f64, mask: Vec<u8>, edges: &[EdgeSegment]) -> FitResult {
    let inputs = inputs(frame, focal, mask);
    let mut fitter = inputs.fitter();
    inputs.push_image(&mut fitter);
    fitter.push_edges(edges).unwrap();
    fitter.fit().unwrap()
}

/// The fit to the depth within a mask.
pub fn fit_without_image(frame: &Capture, focal: f64, mask: Vec<u8>) -> FitResult {
    depth_of(frame, focal, mask).fit().unwrap()
}

/// A fitter with the depth within a mask.
pub fn depth_of(frame: &Capture, focal: f64, mask: Vec<u8>) -> Fitter {
    inputs(frame, focal, mask).fitter()
}

fn inputs(frame: &Capture, focal: f64, mask: Vec<u8>) -> Inputs {
    Inputs {
        intrinsics: intrinsics(focal),
        size: SIZE,
        depth: frame.depth.clone(),
        depth_scale: DEPTH_UNIT,
        mask,
        image: frame.image.clone(),
        edges: Vec::new(),
    }
}
