//! What is no cylinder, and masks that are not where the cylinder is: their results have warnings, however small the stated
//! deviations are.
#![cfg(feature = "twin")]
#![allow(clippy::unwrap_used, reason = "a test program")]

#[path = "support/frames.rs"]
mod frames;
#[path = "support/twin_frames.rs"]
mod twin_frames;

use cylfuse::fitter::{Fitter, Flags};
use cylfuse::observations::PointsView;
use nalgebra::Vector3;
use twin_frames::{SIZE, captured, fit_within, turned_before_wall};

const FOCAL: f64 = 569.6;
const RADIUS: f64 = 0.04;

/// The warnings of the near half of a body along x, whose axis runs at height `middle(x)`, and whose surface is `radius(x, φ)` from
/// it at the angle φ from where it is nearest to the camera; with noise of some standard deviation.
fn warnings(middle: impl Fn(f64) -> f64, radius: impl Fn(f64, f64) -> f64, deviation: f64) -> Flags {
    warnings_of_arc((60, 2.4), middle, radius, deviation)
}

/// The same in so many rows across an arc of so many radians.
fn warnings_of_arc(
    (rows, arc): (usize, f64),
    middle: impl Fn(f64) -> f64,
    radius: impl Fn(f64, f64) -> f64,
    deviation: f64,
) -> Flags {
    let mut state = 1_u64;
    let mut noise = || {
        // Of four uniform numbers.
        let mut sum = 0.0;
        for _ in 0..4 {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            sum += (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        }
        deviation * sum / (1.0_f64 / 3.0).sqrt()
    };
    let mut point = |k: usize| {
        let (x, turn) =
            (0.16 * ((k / 40) as f64 / (rows - 1) as f64 - 0.5), arc * ((k % 40) as f64 / 39.0 - 0.5));
        let around = Vector3::new(0.0, turn.sin(), -turn.cos()) * (radius(x, turn) + noise());
        Vector3::new(x, middle(x), 0.8) + around
    };
    let points: Vec<[f64; 3]> = (0..40 * rows).map(|k| point(k).into()).collect();
    let mut fitter = Fitter::new();
    fitter.push_points(&PointsView::from_f64(&points), None).unwrap();
    fitter.fit().unwrap().flags
}

const NOISE: f64 = 0.0003;

#[test]
fn points_of_a_body_that_is_no_cylinder_are_a_poor_fit() {
    let round = |_: f64, _: f64| RADIUS;
    assert_eq!(warnings(|_| 0.0, round, NOISE), Flags::empty());
    // A tilt is none.
    assert_eq!(warnings(|x| 0.1 * x, round, NOISE), Flags::empty());
    let bent = warnings(|x| 1.2 * x * x, round, NOISE);
    let barrel = warnings(|_| 0.0, |x, _| RADIUS - x * x, NOISE);
    for (name, flags) in [("bent", bent), ("barrel", barrel)] {
        assert!(flags.contains(Flags::POOR_FIT), "{name}: {flags:?}");
    }
    // By less than noise and tolerances.
    assert_eq!(warnings(|x| 0.05 * x * x, round, NOISE), Flags::empty());
}

/// Of a box two sides are seen, which meet at an edge.
#[test]
fn points_of_a_box_are_a_poor_fit() {
    let side = |_: f64, turn: f64| RADIUS / (std::f64::consts::FRAC_PI_4 - turn.abs()).cos();
    for noise in [0.0, NOISE, 0.002] {
        let flags = warnings(|_| 0.0, side, noise);
        assert!(flags.contains(Flags::POOR_FIT), "{noise}: {flags:?}");
    }
}

/// A part of the points, taken in steps of their order, was two columns of 80 rows, which lie in two planes whatever the noise is.
#[test]
fn points_of_any_arc_of_a_cylinder_are_no_poor_fit() {
    for rows in [60, 80, 160] {
        for arc in [1.2, 1.8, 2.4, 3.1, 4.5, 6.2] {
            for noise in [0.0, NOISE, 0.001, 0.002, 0.003] {
                let flags = warnings_of_arc((rows, arc), |_| 0.0, |_, _| RADIUS, noise);
                assert!(!flags.contains(Flags::POOR_FIT), "{rows} {arc} {noise}: {flags:?}");
            }
        }
    }
}

#[test]
fn a_mask_beside_the_body_disagrees() {
    let mut frame = captured(&turned_before_wall([RADIUS; 2], 0.15), FOCAL, 1);
    let mask: Vec<u8> = frame.labels.iter().map(|label| u8::from(*label == 1)).collect();
    // Nothing to see, so that depth and mask alone tell of the body.
    frame.image.fill(100);
    let right = fit_within(&frame, FOCAL, mask.clone());
    assert_eq!(right.flags, Flags::empty(), "{:?}", right.uncertainty);
    // Half of the half width across the axis.
    frame.depth.rotate_right(16 * SIZE.0);
    let shifted = fit_within(&frame, FOCAL, mask);
    let (error, deviation) =
        (shifted.cylinder.radius - RADIUS, shifted.uncertainty.as_ref().unwrap().radius());
    assert!(shifted.flags.contains(Flags::MASK_DISAGREES), "{:?} {error} {deviation}", shifted.flags);
}
