//! The structs that the library writes: results of a fit, and what is asked about it.
//!
//! A struct whose first field is `struct_size`, and one of which arrays are written, only ever grows at its end.

use super::constants::cylfuse_start;
use super::outcomes::{
    cylfuse_detection_phase, cylfuse_end_source, cylfuse_end_state, cylfuse_limb_status, cylfuse_phase,
    cylfuse_result_flags, cylfuse_termination,
};
use super::structs::cylfuse_cylinder;

/// What was pushed into one view, and what was left out by reason.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_counts {
    /// The room in bytes; as output the bytes that were filled.
    pub struct_size: u32,
    /// The view that the counts are of.
    pub view: u32,
    /// Points and pixels that were pushed.
    pub points_given: u64,
    /// Points that a fit uses.
    pub points_used: u64,
    /// Left out: a coordinate or weight is not finite.
    pub dropped_not_finite: u64,
    /// Left out: the weight is 0.
    pub dropped_zero_weight: u64,
    /// Left out: the mask is 0 there.
    pub dropped_outside_mask: u64,
    /// Left out: no depth was measured there.
    pub dropped_no_depth: u64,
    /// Left out: the depth is below `min_depth` or above `max_depth`.
    pub dropped_out_of_range: u64,
    /// Left out: the camera model has no ray for the pixel.
    pub dropped_outside_camera: u64,
    /// Left out: the mask is set there, but the colour camera sees something nearer. Only with a depth camera of its own.
    pub dropped_hidden: u64,
    /// Edge segments that were pushed; `segments_used` of a result says how many count.
    pub segments_given: u64,
}

/// The outcome of a fit with the numbers to judge it, whatever shape was fitted. NaN stands for what does not apply.
/// The shape itself is in a struct of its own: `cylfuse_cylinder_estimate`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_result {
    /// The room in bytes; as output the bytes that were filled.
    pub struct_size: u32,
    /// Warnings, `CYLFUSE_RESULT_FLAGS_...` by bit; 0 when there are none.
    pub flags: cylfuse_result_flags,
    /// Why the iteration ended.
    pub termination: cylfuse_termination,
    /// Iterations: linear systems that were solved.
    pub iterations: u32,
    /// Solves whose step was rejected.
    pub rejected_steps: u32,
    /// Limb lines that were located in the images and took part, at most 2 a view.
    pub limbs_located: u32,
    /// Edge segments that were pushed.
    pub segments_given: u32,
    /// Edge segments that took part.
    pub segments_used: u32,
    /// Points that were pushed; `cylfuse_fitter_counts` says why some were left out.
    pub points_given: u64,
    /// Points that took part.
    pub points_used: u64,
    /// How many points with independent noise the points of all views are worth: the noise of neighbours in a depth
    /// image is alike.
    pub independent_points: f64,
    /// Standard deviation of the points from the surface by their median, unit of length: points beyond some of it lose
    /// their weight in the objective ROBUST.
    pub point_deviation: f64,
    /// Root mean square distance of the points from the surface, unit of length.
    pub point_rms: f64,
    /// Root mean square distance of the given endpoints from the limb lines in ideal pixels; NaN without edges.
    pub edge_rms_pixels: f64,
    /// The part of the points on the wall that the camera sees; NaN when the origin is no camera.
    pub near_wall_fraction: f64,
    /// Cost of the start, unit of length squared.
    pub initial_cost: f64,
    /// Cost of the outcome, unit of length squared.
    pub cost: f64,
    /// E_P: mean squared distance of the points from the surface, unit of length squared.
    pub energy_points: f64,
    /// E_L: mean squared distance of the back-projected endpoints from the limb lines, unit of length squared;
    /// NaN without exactly two usable segments.
    pub energy_edges: f64,
    /// The edge weight that was used, 0 when no edges count; NaN where the objective has none.
    pub edge_weight: f64,
    /// Condition number of the Jacobian at the outcome, in units of the size of the data; may be infinite.
    pub condition: f64,
    /// Norm of half the gradient of the cost at the end, as far as the limits leave it free, in units of the size of
    /// the data.
    pub gradient_norm: f64,
    /// Norm of the last accepted step, in units of the size of the data.
    pub step_norm: f64,
    /// The last damping.
    pub lambda: f64,
    /// Wall-clock seconds to find the start.
    pub seconds_start: f64,
    /// Wall-clock seconds to iterate.
    pub seconds_solve: f64,
    /// Wall-clock seconds of the whole fit.
    pub seconds_total: f64,
}

/// The cylinder that a fit found, how certain it is, and where the iteration started.
///
/// Deviations and covariance are those of the noise of the data, with the weights that were used and the correlation
/// of neighbouring depths. With the method FUSED and the objective ROBUST they also have the errors that all points of a
/// view share and `depth_shared` of the options states: by default 0.2 % of the depth, as a bend of the profile, an offset
/// and a tilt. Errors of the calibration, the registration and a scale of the depth are not in them. All
/// deviations of the interface are standard deviations: for an expanded uncertainty with the coverage factor k = 2,
/// as calibration certificates state it, multiply by 2. NaN for RANSAC and EBERLY, for an edge weight of 1, and where
/// the data do not determine the number.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_cylinder_estimate {
    /// The room in bytes; as output the bytes that were filled.
    pub struct_size: u32,
    /// How the start was found.
    pub start_kind: cylfuse_start,
    /// The cylinder, its axis point the one nearest to the middle of the points.
    pub model: cylfuse_cylinder,
    /// The cylinder that the iteration started from, moved into the limits.
    pub start_model: cylfuse_cylinder,
    /// Standard deviation of the radius, unit of length.
    pub radius_deviation: f64,
    /// Standard deviation of the direction in radians: the tilt in the plane in which it is least certain.
    pub direction_deviation: f64,
    /// Standard deviation of the position of the axis across itself, at `model.point` and in the direction in which it
    /// is least certain, unit of length.
    pub position_deviation: f64,
    /// The radius by the curvature of the points alone, unit of length; NaN without segments or limbs, and where the
    /// points alone determine no cylinder.
    pub radius_from_points: f64,
    /// Its standard deviation.
    pub radius_from_points_deviation: f64,
    /// The radius by the limbs, with distance and tilt of the axis from the points, unit of length; NaN likewise.
    pub radius_from_limbs: f64,
    /// Its standard deviation.
    pub radius_from_limbs_deviation: f64,
    /// `radius_from_points` minus `radius_from_limbs` in standard deviations of the difference; beyond 4 the flag
    /// POINTS_AND_LIMBS_DISAGREE is set.
    pub radius_z_score: f64,
    /// Covariance of (`model.point`, `model.direction`, `model.radius`), 7 x 7, symmetric, of rank 5; `[7 * i + j]` is
    /// that of the numbers i and j.
    pub covariance: [f64; 49],
}

/// What the data determine at a cylinder: the singular values of the stacked Jacobian of the five degrees of
/// freedom, in units of the size of the data.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_cylinder_diagnosis {
    /// The room in bytes; as output the bytes that were filled.
    pub struct_size: u32,
    /// How many singular values stand out of the rounding error; 5 when everything is determined.
    pub rank: u32,
    /// Singular values, the largest first.
    pub singular_values: [f64; 5],
    /// Largest over smallest singular value; may be infinite.
    pub condition: f64,
    /// How the step along which the residuals change least moves the axis at the middle of the points, in the unit of
    /// length.
    pub weakest_shift: [f64; 3],
    /// How that step tilts the axis, in radians towards this vector.
    pub weakest_tilt: [f64; 3],
    /// How that step changes the radius, in the unit of length. Shift and radius over the size of the data and the tilt
    /// have a joint norm of 1.
    pub weakest_radius: f64,
}

/// What became of the pixels of a completion.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_completion {
    /// The room in bytes; as output the bytes that were filled.
    pub struct_size: u32,
    /// The view whose pixels were completed.
    pub view: u32,
    /// Points or pixels that were written; after `CYLFUSE_STATUS_BUFFER_TOO_SMALL` the capacity that is needed.
    pub count: u64,
    /// Pixels of the mask whose ray meets the cylinder.
    pub hits: u64,
    /// Pixels of the mask whose ray passes the cylinder by.
    pub misses: u64,
    /// Pixels of the mask for which the camera model has no ray.
    pub outside_camera: u64,
    /// Hits whose depth does not fit the pixel format: written as 0 and not in `count`. Hits whose point does not fit the
    /// scalar: as if there were none.
    pub out_of_range: u64,
}

/// The visible piece of the cylinder: `end` = `start` + `length` * direction of the model.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_extent {
    /// The room in bytes; as output the bytes that were filled.
    pub struct_size: u32,
    /// What the end against the direction is.
    pub start_state: cylfuse_end_state,
    /// What the end along the direction is.
    pub end_state: cylfuse_end_state,
    /// What the position of the start was taken from.
    pub start_source: cylfuse_end_source,
    /// What the position of the end was taken from.
    pub end_source: cylfuse_end_source,
    /// The view that determines the start best.
    pub start_view: u32,
    /// The view that determines the end best.
    pub end_view: u32,
    /// 1 when the limbs of the model were taken as good to a fraction of a pixel in these views, so that the bias of
    /// the mask was read off at them; else 0.
    pub limbs_known: u32,
    /// The end against the direction, a point on the axis.
    pub start: [f64; 3],
    /// The end along the direction, a point on the axis.
    pub end: [f64; 3],
    /// The middle of the ends.
    pub center: [f64; 3],
    /// The distance of the ends.
    pub length: f64,
    /// Standard deviation of the position of the start along the axis, for a model without error; NaN for an extreme
    /// position. Of a start that is not SEEN it is that of the visible piece: the cylinder may well go on.
    pub start_deviation: f64,
    /// The same for the end.
    pub end_deviation: f64,
    /// Standard deviation of the length together with the uncertainty of the fit, of the visible piece. This and what
    /// follows is NaN for a model that was given, for extreme positions and when the fit has no uncertainty.
    pub length_deviation: f64,
    /// Covariance of `start`, 3 x 3, symmetric, unit of length squared.
    pub start_covariance: [f64; 9],
    /// Covariance of `end`.
    pub end_covariance: [f64; 9],
    /// Covariance of `center`.
    pub center_covariance: [f64; 9],
}

/// The state of a running fit, before each iteration.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_progress {
    /// Size of this struct in the library: fields beyond it are not there.
    pub struct_size: u32,
    /// What the fit is doing.
    pub phase: cylfuse_phase,
    /// Iterations so far. Begins again at 0 with every start that is tried and every robust round.
    pub iteration: u32,
    /// Maximum number of iterations.
    pub max_iterations: u32,
    /// The lowest cost so far, unit of length squared; infinite in the phase START.
    pub cost: f64,
    /// The damping of the next step; 0 in the phase START.
    pub lambda: f64,
    /// The best cylinder so far, valid until the callback returns; NULL in the phase START.
    pub cylinder: *const cylfuse_cylinder,
}

/// A limb of the cylinder in the image of one view: where it was located, or why it was not.
///
/// An element of the array that `cylfuse_fitter_limbs` writes.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_limb {
    /// The view, from 0.
    pub view: u32,
    /// The limb, 0 or 1, in the order of `cylfuse_cylinder_project`.
    pub limb: u32,
    /// Whether the limb was located, or why not.
    pub status: cylfuse_limb_status,
    /// How many pieces of it `cylfuse_fitter_limb_samples` lists.
    pub samples: u32,
    /// x1 y1 x2 y2: the two points of the located line whose errors across it are independent and equally large,
    /// in ideal pixels. They need not lie on the part that was seen. NaN when the limb was not located.
    pub line: [f64; 4],
    /// Standard deviation of either point across the line, in ideal pixels; NaN when the limb was not located.
    pub deviation: f64,
}

/// What a short piece of a limb in the image says.
///
/// An element of the array that `cylfuse_fitter_limb_samples` writes.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_limb_sample {
    /// The view, from 0.
    pub view: u32,
    /// The limb that it belongs to, 0 or 1, in the order of `cylfuse_cylinder_project`.
    pub limb: u32,
    /// Where the limb is seen, x and y in pixels of the (distorted) image.
    pub pixel: [f64; 2],
    /// Standard deviation across the limb in ideal pixels, by the noise of the image only.
    pub deviation: f64,
    /// Its part in the line, from 1 down to 0 for a refused sample.
    pub weight: f64,
}

/// A sample on the arc of an end of the cylinder in the image.
///
/// An element of the array that `cylfuse_fitter_end_samples` writes.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_end_sample {
    /// The view, from 0.
    pub view: u32,
    /// 0 for the start of the extent, 1 for its end.
    pub end: u32,
    /// Where the arc is seen, x and y in pixels of the (distorted) image.
    pub pixel: [f64; 2],
    /// The unit vector across the arc in the image, away from the surface.
    pub normal: [f64; 2],
    /// Standard deviation along `normal`, in pixels.
    pub deviation: f64,
}

/// How far a detector is.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_detection_progress {
    /// The size of this struct in the library that calls: later fields exist when it is large enough.
    pub struct_size: u32,
    /// What it is doing.
    pub phase: cylfuse_detection_phase,
    /// Cylinders that are fitted.
    pub fits_done: u32,
    /// Cylinders to fit; 0 before the search.
    pub fits: u32,
}

/// A cylinder of a scene. Elements of an array: their size is an argument of the call, and only ever grows.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_detection {
    /// The probability that there is a cylinder.
    pub score: f64,
    /// Pixels of its region; points for a cloud. Of a cloud that was seen from its origin the fit takes those within 0.7
    /// radii of the axis, where these are most: next to limbs sensors draw points out.
    pub pixels: u64,
    /// The cylinder that was fitted, as in its `cylfuse_cylinder_estimate`.
    pub model: cylfuse_cylinder,
}
