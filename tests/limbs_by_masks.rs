//! Limbs that the image alone does not tell from what is beside them, and the mask does.
#![cfg(feature = "twin")]
#![allow(clippy::unwrap_used, reason = "a test program")]

#[path = "support/frames.rs"]
mod frames;
#[path = "support/twin_frames.rs"]
mod twin_frames;

use cylfuse::fitter::FitResult;
use cylfuse::geometry::Cylinder;
use cylfuse::twin::{Capture, Kind, drawn_mask, random_scene};
use twin_frames::{SIZE, captured, fit_within};

const FOCAL: f64 = 569.6;

fn frame(kind: Kind, seed: u64) -> Capture {
    captured(&random_scene(kind, seed).unwrap(), FOCAL, seed)
}

/// The error of the radius in parts of the true one, and in its stated deviations.
fn errors(result: &FitResult, truth: &Cylinder) -> (f64, f64) {
    let error = (result.cylinder.radius - truth.radius).abs();
    (error / truth.radius, error / result.uncertainty.as_ref().unwrap().radius())
}

#[test]
fn an_edge_four_pixels_beside_a_limb_is_not_taken_for_it() {
    let frame = frame(Kind::Single, 83104);
    let result = fit_within(&frame, FOCAL, drawn_mask(&frame.body, SIZE, 83104));
    let (relative, deviations) = errors(&result, &frame.cylinders[0].truth.cylinder);
    assert!(relative < 0.05 && deviations < 2.0, "{relative} {deviations}");
}

#[test]
fn a_limb_that_few_blocks_show_counts_where_the_mask_has_it() {
    let frame = frame(Kind::Table, 81009);
    let mask: Vec<u8> = frame.labels.iter().map(|label| u8::from(*label == 2)).collect();
    let result = fit_within(&frame, FOCAL, mask);
    let seen = frame.cylinders.iter().find(|seen| seen.truth.object == 2).unwrap();
    let (relative, deviations) = errors(&result, &seen.truth.cylinder);
    assert!(result.limbs_located == 2 && relative < 0.005 && deviations < 2.0, "{relative} {deviations}");
}

/// What is left of a mask without the pixels that are nearer to its border than so many.
fn eroded(mask: &[bool], by: usize) -> Vec<u8> {
    let (width, height) = SIZE;
    let inside = |k: usize| {
        let (x, y) = (k % width, k / width);
        (by..width - by).contains(&x)
            && (by..height - by).contains(&y)
            && (y - by..=y + by).all(|y| (x - by..=x + by).all(|x| mask[y * width + x]))
    };
    (0..width * height).map(|k| u8::from(inside(k))).collect()
}

#[test]
fn a_mask_far_within_the_outline_does_not_hide_the_limbs() {
    for seed in [83101, 83102, 83103, 83105] {
        let frame = frame(Kind::Single, seed);
        let result = fit_within(&frame, FOCAL, eroded(&frame.body, 5));
        let (relative, deviations) = errors(&result, &frame.cylinders[0].truth.cylinder);
        assert!(result.limbs_located == 2 && relative < 0.005, "{seed}: {relative} {deviations}");
    }
}
