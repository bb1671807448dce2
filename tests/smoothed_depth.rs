//! Depth that filters smoothed, as many cameras deliver it: beside its limbs a body goes on into what lies behind it.
#![allow(clippy::unwrap_used, reason = "a test program")]

#[path = "support/frames.rs"]
mod frames;

use cylfuse::camera::Camera;
use cylfuse::observations::{DepthRange, DepthView, Frame, ImageView};
use cylfuse::scene::{Detector, DetectorOptions};
use std::path::Path;

/// Where nothing was measured the depth to the left, then the averages of 1/z over square windows.
fn smoothed(depth: &[u16], (width, height): (usize, usize), window: usize) -> Vec<u16> {
    let half = window / 2;
    let mut last = depth.iter().copied().find(|z| *z > 0).unwrap();
    let mut inverse = Vec::with_capacity(depth.len());
    for z in depth {
        last = if *z > 0 { *z } else { last };
        inverse.push(1.0 / f64::from(last));
    }
    let average = |x: usize, y: usize| {
        let columns = x.saturating_sub(half)..(x + half + 1).min(width);
        let rows = y.saturating_sub(half)..(y + half + 1).min(height);
        let count = rows.len() * columns.len();
        let row = |y: usize| &inverse[y * width..][columns.clone()];
        (count as f64 / rows.flat_map(row).sum::<f64>()).round() as u16
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| average(x, y)).collect()
}

#[test]
fn bodies_whose_limbs_are_smoothed_are_found() {
    let inputs = frames::Inputs::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/scene"));
    let radii = |depth: &[u16], use_image: bool| {
        let mut frame = Frame::new(Camera::new(inputs.intrinsics).unwrap());
        let depth = DepthView::from_u16(depth, inputs.size, inputs.depth_scale).unwrap();
        frame.set_depth(&depth, &DepthRange::default()).unwrap();
        frame.set_image(&ImageView::from_u8(&inputs.image, inputs.size).unwrap()).unwrap();
        let mut detector = Detector::new();
        detector.set_options(DetectorOptions { use_image, ..DetectorOptions::default() }).unwrap();
        let scene = detector.detect(&frame).unwrap();
        let radii = scene.cylinders.iter().map(|found| found.result.cylinder.radius);
        radii.collect::<Vec<f64>>()
    };
    assert_eq!(radii(&inputs.depth, true).len(), 5);
    // Four were found before.
    for (window, use_image) in [(7, false), (11, true)] {
        let found = radii(&smoothed(&inputs.depth, inputs.size, window), use_image);
        assert_eq!(found.len(), 5, "window of {window}, image: {use_image}: {found:.4?}");
    }
}
