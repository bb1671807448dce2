//! Tests of the constants.

use super::super::outcomes::cylfuse_result_flags;
use super::*;
use crate::fitter::Flags;

#[test]
fn unknown_constants_are_named_with_their_field() {
    let error = cylfuse_method(7).read("options.method").unwrap_err();
    assert_eq!(
        error.to_string(),
        "options.method is 7; it must be 0 (FUSED), 1 (POINTS), 2 (RANSAC) or 3 (EBERLY)"
    );
}

#[test]
fn the_flags_are_those_of_the_library() {
    use cylfuse_result_flags as F;
    let here = [
        F::EDGES_IGNORED,
        F::SEGMENTS_UNUSABLE,
        F::EDGES_CROSS,
        F::EDGES_COINCIDE,
        F::EDGES_BEHIND,
        F::SCALE_HELD,
        F::WEAK_RADIUS,
        F::RESOLUTION_LOST,
        F::NOT_CONVERGED,
        F::HIDDEN_WALL,
        F::CAMERA_INSIDE,
        F::POINTS_NOT_FINITE,
        F::POINTS_AND_LIMBS_DISAGREE,
        F::RADIUS_AT_LIMIT,
        F::AXIS_AT_LIMIT,
        F::UNCERTAINTY_UNKNOWN,
        F::DEPTH_SHIFTED,
        F::MASK_ENDS_WITH_DEPTH,
        F::POOR_FIT,
        F::BODY_TAPERS,
        F::MASK_DISAGREES,
    ];
    let there: Vec<u32> = Flags::all().iter().map(|flag| flag.bits()).collect();
    assert_eq!(here.map(|flag| flag.0).as_slice(), there);
}
