//! Bodies whose radius changes along the axis are no cylinders, which two located limbs tell.
#![cfg(feature = "twin")]
#![allow(clippy::unwrap_used, reason = "a test program")]

#[path = "support/frames.rs"]
mod frames;
#[path = "support/twin_frames.rs"]
mod twin_frames;

use cylfuse::fitter::{FitResult, Flags};
use twin_frames::{captured, fit_within, turned_before_wall};

const FOCAL: f64 = 570.0;

/// Half the length of the body.
const HALF_LENGTH: f64 = 0.06;

/// The fit of a turned body in front of a wall, with mask and image. Its radius is 40 mm in the middle and grows by `slope`
/// along the axis, which lies across the view.
fn fit(slope: f64) -> FitResult {
    let radii = [-1.0, 1.0].map(|end| 0.04 + slope * HALF_LENGTH * end);
    let frame = captured(&turned_before_wall(radii, 2.0 * HALF_LENGTH), FOCAL, 1);
    fit_within(&frame, FOCAL, frame.labels.iter().map(|label| u8::from(*label == 1)).collect())
}

#[test]
fn a_body_that_tapers_is_flagged() {
    for slope in [0.0, 0.02, -0.05] {
        let result = fit(slope);
        let taper = result.taper.unwrap_or_else(|| panic!("{slope}: {:?}", result.flags));
        // The axis of the body is that of the camera's x, along which the largest component of a result is positive.
        assert!((taper.slope - slope).abs() < 0.1 * slope.abs() + 0.003, "{slope}: {taper:?}");
        assert_eq!(result.flags.contains(Flags::BODY_TAPERS), slope != 0.0, "{slope}: {:?}", result.flags);
    }
}

/// What turns by several of its deviations is less certain by as much.
#[test]
fn limbs_that_turn_against_each_other_weigh_less() {
    let results = [0.0, 0.03].map(fit);
    let [parallel, turned] = results.each_ref().map(|result| {
        assert_eq!(result.limbs_located, 2);
        result.uncertainty.as_ref().unwrap().radius()
    });
    let taper = results[1].taper.unwrap();
    assert!(taper.slope.abs() > 5.0 * taper.deviation, "{taper:?}");
    assert!(turned > 2.0 * parallel, "{parallel} {turned}");
}
