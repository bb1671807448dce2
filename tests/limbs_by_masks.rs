//! Limbs that the image alone does not tell from what is beside them, and the mask does.
#![cfg(feature = "twin")]
#![allow(clippy::unwrap_used, reason = "a test program")]

use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::fitter::{FitResult, Fitter};
use cylfuse::geometry::Cylinder;
use cylfuse::observations::{DepthRange, DepthView, ImageView, MaskView};
use cylfuse::twin::{
    Capture, CaptureOptions, DEPTH_UNIT, DepthSensor, Kind, PictureOptions, StructuredLight, capture,
    drawn_mask, random_scene,
};

const SIZE: (usize, usize) = (640, 480);

fn frame(kind: Kind, seed: u64) -> (Intrinsics, Capture) {
    let (width, height) = (SIZE.0 as u32, SIZE.1 as u32);
    let distortion = Distortion::None;
    let intrinsics = Intrinsics { width, height, fx: 569.6, fy: 569.6, cx: 319.5, cy: 239.5, distortion };
    let options = CaptureOptions {
        camera: Camera::new(intrinsics).unwrap(),
        picture: PictureOptions::default(),
        sensor: DepthSensor::StructuredLight(StructuredLight::default()),
        registered: true,
    };
    (intrinsics, capture(&random_scene(kind, seed).unwrap(), &options, seed).unwrap())
}

fn fit(intrinsics: Intrinsics, frame: &Capture, mask: &[u8]) -> FitResult {
    let mut fitter = Fitter::new();
    fitter.set_intrinsics(intrinsics).unwrap();
    let depth = DepthView::from_u16(&frame.depth, SIZE, DEPTH_UNIT).unwrap();
    let mask = MaskView::from_u8(mask, SIZE).unwrap();
    fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
    fitter.push_image(&ImageView::from_u8(&frame.image, SIZE).unwrap()).unwrap();
    fitter.fit().unwrap()
}

/// The error of the radius in parts of the true one, and in its stated deviations.
fn errors(result: &FitResult, truth: &Cylinder) -> (f64, f64) {
    let error = (result.cylinder.radius - truth.radius).abs();
    (error / truth.radius, error / result.uncertainty.as_ref().unwrap().radius())
}

#[test]
fn an_edge_four_pixels_beside_a_limb_is_not_taken_for_it() {
    let (intrinsics, frame) = frame(Kind::Single, 83104);
    let result = fit(intrinsics, &frame, &drawn_mask(&frame.body, SIZE, 83104));
    let (relative, deviations) = errors(&result, &frame.cylinders[0].truth.cylinder);
    assert!(relative < 0.05 && deviations < 2.0, "{relative} {deviations}");
}

#[test]
fn a_limb_that_few_blocks_show_counts_where_the_mask_has_it() {
    let (intrinsics, frame) = frame(Kind::Table, 81009);
    let mask: Vec<u8> = frame.labels.iter().map(|label| u8::from(*label == 2)).collect();
    let result = fit(intrinsics, &frame, &mask);
    let seen = frame.cylinders.iter().find(|seen| seen.truth.object == 2).unwrap();
    let (relative, deviations) = errors(&result, &seen.truth.cylinder);
    assert!(result.limbs_located == 2 && relative < 0.005 && deviations < 2.0, "{relative} {deviations}");
}
