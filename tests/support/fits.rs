//! Fits whose time and instructions are measured.
// Each test program uses a part. A measurement that can't run should stop.
#![allow(dead_code, clippy::unwrap_used)]

use crate::frames::Inputs;
use crate::support::{Noise, camera, can, fitter_with, intrinsics, limb_segments, visible_points};
use cylfuse::camera::Camera;
use cylfuse::fitter::{Fitter, ObjectiveKind, Options, StartKind};
use cylfuse::geometry::Cylinder;
use cylfuse::observations::{DepthRange, DepthView, Frame, ImageView};
use cylfuse::scene::{Detector, DetectorOptions};
use nalgebra::{Vector2, Vector3};

/// The options of a fit on one core.
pub fn on_one_core(options: Options) -> Options {
    Options { threads: 1, ..options }
}

/// Points of a can with a noise of 1 mm along the ray.
pub fn noisy_points(count: usize) -> Vec<[f64; 3]> {
    noisy_points_by(count, &mut Noise::new(1))
}

fn noisy_points_by(count: usize, noise: &mut Noise) -> Vec<[f64; 3]> {
    let mut cloud = visible_points(&can(), &Vector3::zeros(), count);
    for point in &mut cloud {
        let stretch = 1.0 + 0.0015 * noise.normal();
        point.iter_mut().for_each(|x| *x *= stretch);
    }
    cloud
}

/// A noisy can: those points, half a pixel on the edges.
pub fn noisy(points: usize, edges: bool, options: Options) -> Fitter {
    let truth = can();
    let mut noise = Noise::new(1);
    let cloud = noisy_points_by(points, &mut noise);
    let mut segments = limb_segments(&truth, &camera());
    for q in segments.iter_mut().flat_map(|segment| &mut segment.endpoints) {
        *q += noise.vector().xy() * 0.5;
    }
    let mut fitter = fitter_with(&cloud);
    fitter.set_intrinsics(intrinsics()).unwrap();
    if edges {
        fitter.push_edges(&segments).unwrap();
    }
    fitter.set_start(Some(
        Cylinder::new(truth.axis.point * 1.01, Vector3::new(0.25, 0.9, 0.25), truth.radius * 1.1).unwrap(),
    ));
    fitter.set_options(on_one_core(options)).unwrap();
    fitter
}

/// A frame of 4,211 points on a cylinder.
pub fn frame() -> Inputs {
    Inputs::read(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/frames/r40_a20_f0"))
}

/// A frame of five cylinders on a table, with or without its image.
pub fn scene(image: bool) -> Frame {
    let inputs = Inputs::read(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/scene"));
    let mut frame = Frame::new(Camera::new(inputs.intrinsics).unwrap());
    let depth = DepthView::from_u16(&inputs.depth, inputs.size, inputs.depth_scale).unwrap();
    frame.set_depth(&depth, &DepthRange::default()).unwrap();
    if image {
        frame.set_image(&ImageView::from_u8(&inputs.image, inputs.size).unwrap()).unwrap();
    }
    frame
}

/// The points of that frame.
pub fn cloud_of_scene() -> Vec<[f64; 3]> {
    let frame = scene(false);
    let (camera, depth) = (frame.camera().unwrap(), frame.depth().unwrap());
    let pixels = (0..depth.height()).flat_map(|row| (0..depth.width()).map(move |column| (column, row)));
    let point = |(column, row): (usize, usize)| {
        let ray = camera.unproject(&Vector2::new(column as f64, row as f64))?;
        Some((ray * depth.depth(column, row)?).into())
    };
    pixels.filter_map(point).collect()
}

/// A detector on one core.
pub fn detector() -> Detector {
    let mut detector = Detector::new();
    let fit = on_one_core(Options::default());
    detector.set_options(DetectorOptions { fit, threads: 1, ..DetectorOptions::default() }).unwrap();
    detector
}

/// A fitter with that frame, with or without its image and edges.
pub fn framed(image: bool, edges: bool) -> Fitter {
    let inputs = frame();
    let mut fitter = inputs.fitter();
    if edges {
        fitter.push_edges(&inputs.edges).unwrap();
    }
    if image {
        inputs.push_image(&mut fitter);
    }
    fitter.set_options(on_one_core(Options::default())).unwrap();
    fitter
}

/// The same from the last fit, with or without edges.
pub fn followed(edges: bool) -> Fitter {
    let mut fitter = framed(true, edges);
    fitter.set_options(on_one_core(Options { start: StartKind::Last, ..Options::default() })).unwrap();
    fitter
}

/// The options of the paper's objective.
pub fn paper(start: StartKind) -> Options {
    Options { objective: ObjectiveKind::Paper, start, ..Options::default() }
}
