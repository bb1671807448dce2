//! Limbs of bodies that touch alike ones.
#![cfg(feature = "twin")]
#![allow(clippy::unwrap_used, reason = "a test program")]

#[path = "support/frames.rs"]
mod frames;
mod support;
#[path = "support/twin_frames.rs"]
mod twin_frames;

use cylfuse::camera::Camera;
use cylfuse::fitter::Flags;
use cylfuse::observations::{DepthRange, DepthView, Frame, ImageView};
use cylfuse::scene::Detector;
use cylfuse::twin::{Capture, DEPTH_UNIT, Kind, TrueCylinder, random_scene};
use twin_frames::{SIZE, captured, intrinsics};

const FOCAL: f64 = 569.6;

/// What leaves a verdict undecided.
const WARNINGS: [Flags; 7] = [
    Flags::POOR_FIT,
    Flags::WEAK_RADIUS,
    Flags::POINTS_AND_LIMBS_DISAGREE,
    Flags::DEPTH_SHIFTED,
    Flags::BODY_TAPERS,
    Flags::UNCERTAINTY_UNKNOWN,
    Flags::NOT_CONVERGED,
];

fn frame_of(capture: &Capture) -> Frame {
    let mut frame = Frame::new(Camera::new(intrinsics(FOCAL)).unwrap());
    let depth = DepthView::from_u16(&capture.depth, SIZE, DEPTH_UNIT).unwrap();
    frame.set_depth(&depth, &DepthRange::default()).unwrap();
    frame.set_image(&ImageView::from_u8(&capture.image, SIZE).unwrap()).unwrap();
    frame
}

/// Between rods that touch, the far edge of the dark groove was taken for the limb of the nearer one, with a deviation of a tenth of a pixel:
/// radii of three bodies were 2 to 8 % off, by 4 to 6 stated deviations, without a warning.
#[test]
fn an_edge_in_the_groove_between_two_bodies_is_no_certain_limb() {
    let (mut found, mut silent) = (0, Vec::new());
    for seed in [1017, 1018, 1033] {
        let capture = captured(&random_scene(Kind::Alike, seed).unwrap(), FOCAL, seed);
        for result in
            Detector::new().detect(&frame_of(&capture)).unwrap().cylinders.iter().map(|found| found.result)
        {
            let is_it = |truth: &TrueCylinder| {
                let change = truth.cylinder.compare(&result.cylinder);
                let off = result.cylinder.axis.distance(&truth.center);
                change.angle < 0.09
                    && off < 0.5 * truth.cylinder.radius
                    && change.radius_relative.abs() < 0.15
            };
            let Some(truth) = capture.cylinders.iter().map(|seen| &seen.truth).find(|truth| is_it(truth))
            else {
                continue;
            };
            found += 1;
            let radius = truth.cylinder.radius;
            let off = (result.cylinder.radius - radius).abs();
            let deviations = off / result.uncertainty.map_or(f64::INFINITY, |stated| stated.radius());
            let is_flagged = WARNINGS.iter().any(|flag| result.flags.contains(*flag));
            // One is off by 3.1, by chance: what an arc of its end says moves the search for its limbs.
            if deviations > 3.5 && off > 0.01 * radius && !is_flagged {
                silent.push((seed, off / radius, deviations));
            }
        }
    }
    assert!(found >= 12, "{found}");
    assert!(silent.is_empty(), "{silent:?}");
}
