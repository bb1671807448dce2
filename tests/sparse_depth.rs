//! Depth of a coarser grid that was moved to the image pixel by pixel: no measured pixel has a neighbour.
#![allow(clippy::unwrap_used, reason = "a test program")]

#[path = "support/frames.rs"]
mod frames;

use cylfuse::camera::Camera;
use cylfuse::observations::{DepthRange, DepthView, Frame, ImageView};
use cylfuse::scene::{Detector, DetectorOptions};
use std::path::Path;

#[test]
fn bodies_are_found_between_the_gaps() {
    let inputs = frames::Inputs::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/scene"));
    let radii = |spacing: usize, use_image: bool| {
        let pixel = |(k, depth): (usize, &u16)| {
            let (column, row) = (k % inputs.size.0, k / inputs.size.0);
            if column % spacing == 0 && row % spacing == 0 { *depth } else { 0 }
        };
        let depth: Vec<u16> = inputs.depth.iter().enumerate().map(pixel).collect();
        let mut frame = Frame::new(Camera::new(inputs.intrinsics).unwrap());
        let depth = DepthView::from_u16(&depth, inputs.size, inputs.depth_scale).unwrap();
        frame.set_depth(&depth, &DepthRange::default()).unwrap();
        frame.set_image(&ImageView::from_u8(&inputs.image, inputs.size).unwrap()).unwrap();
        let mut detector = Detector::new();
        detector.set_options(DetectorOptions { use_image, ..DetectorOptions::default() }).unwrap();
        let found = detector.detect(&frame).unwrap().cylinders;
        let mut radii: Vec<f64> = found.iter().map(|found| found.result.cylinder.radius).collect();
        radii.sort_by(f64::total_cmp);
        radii
    };
    for (use_image, tolerance) in [(true, 0.01), (false, 0.06)] {
        let dense = radii(1, use_image);
        for spacing in [2, 3] {
            // None were found before.
            let sparse = radii(spacing, use_image);
            assert_eq!(sparse.len(), dense.len(), "{use_image}, {spacing}: {sparse:.4?}, {dense:.4?}");
            let off = sparse.iter().zip(&dense).map(|(sparse, dense)| (sparse / dense - 1.0).abs());
            let off = off.fold(0.0, f64::max);
            assert!(off < tolerance, "{use_image}, {spacing}: {off}");
        }
    }
}
