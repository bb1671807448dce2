//! What the numbers of a call that succeeded may be.

use cylfuse::ffi::*;

/// A number, finite.
#[track_caller]
pub fn finite(numbers: &[f64]) {
    assert!(numbers.iter().all(|x| x.is_finite()), "not finite: {numbers:?}");
}

/// A deviation or variance: finite and not negative, or NaN where it is unknown.
#[track_caller]
fn deviations(numbers: &[f64]) {
    assert!(numbers.iter().all(|x| x.is_nan() || (x.is_finite() && *x >= 0.0)), "no deviation: {numbers:?}");
}

/// Finite or, where something does not apply, NaN.
#[track_caller]
pub fn finite_or_nan(numbers: &[f64]) {
    assert!(!numbers.iter().any(|x| x.is_infinite()), "infinite: {numbers:?}");
}

#[track_caller]
pub fn model(model: &cylfuse_cylinder) {
    finite(&model.point);
    finite(&model.direction);
    let length = model.direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!((length - 1.0).abs() < 1e-9, "the direction has length {length}");
    assert!(model.radius.is_finite() && model.radius > 0.0, "radius {}", model.radius);
}

#[track_caller]
pub fn result(result: &cylfuse_result) {
    let r = result;
    finite(&[r.independent_points, r.point_deviation, r.point_rms, r.initial_cost, r.cost, r.energy_points]);
    finite(&[r.gradient_norm, r.step_norm, r.lambda, r.seconds_start, r.seconds_solve, r.seconds_total]);
    finite_or_nan(&[r.edge_rms_pixels, r.near_wall_fraction, r.energy_edges, r.edge_weight]);
    assert!(!(r.condition < 0.0), "condition {}", r.condition);
    assert!(r.points_used <= r.points_given && r.segments_used <= r.segments_given);
}

#[track_caller]
pub fn estimate(estimate: &cylfuse_cylinder_estimate) {
    let e = estimate;
    model(&e.model);
    model(&e.start_model);
    deviations(&[e.radius_deviation, e.direction_deviation, e.position_deviation]);
    deviations(&[e.radius_from_points_deviation, e.radius_from_limbs_deviation]);
    finite_or_nan(&[e.radius_from_points, e.radius_from_limbs, e.radius_z_score]);
    finite_or_nan(&e.covariance);
    let variances: Vec<f64> = (0..7).map(|k| e.covariance[8 * k]).collect();
    deviations(&variances);
}

#[track_caller]
pub fn extent(extent: &cylfuse_extent) {
    let e = extent;
    finite(&e.start);
    finite(&e.end);
    finite(&e.center);
    assert!(e.length.is_finite() && e.length >= 0.0, "length {}", e.length);
    deviations(&[e.start_deviation, e.end_deviation, e.length_deviation]);
    for covariance in [&e.start_covariance, &e.end_covariance, &e.center_covariance] {
        finite_or_nan(covariance);
        deviations(&[covariance[0], covariance[4], covariance[8]]);
    }
}
