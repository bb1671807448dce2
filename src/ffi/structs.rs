//! The structs of the interface. Fixed-width integers, doubles, sizes and pointers only, without padding.
//!
//! A struct whose first field is `struct_size` only ever grows at its end, and there zero means the behaviour
//! from before.

use super::constants::{
    cylfuse_chart, cylfuse_depth_format, cylfuse_distortion, cylfuse_edge_use, cylfuse_end_state,
    cylfuse_extent_rule, cylfuse_image_format, cylfuse_layout, cylfuse_method, cylfuse_near_wall,
    cylfuse_objective, cylfuse_phase, cylfuse_result_flags, cylfuse_scalar, cylfuse_start,
    cylfuse_termination,
};
use std::ffi::c_void;

/// An infinite cylinder, in the order of the coefficients of PCL's cylinder model. This struct never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_cylinder {
    /// A point on the axis, in the unit of length of the data.
    pub point: [f64; 3],
    /// The direction of the axis. As input of any length but 0, as output of length 1. Its sign has no meaning;
    /// the library gives the one with a positive largest component.
    pub direction: [f64; 3],
    /// The radius in the unit of length of the data, greater than 0.
    pub radius: f64,
}

/// What a short piece of a limb in the grey image says. This struct never changes.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_limb_sample {
    /// Where the limb is seen, x and y in pixels of the (distorted) image.
    pub pixel: [f64; 2],
    /// Standard deviation across the limb in ideal pixels, by the noise of the image only.
    pub sigma: f64,
    /// What the sample counted, from 1 down to 0 for a refused one.
    pub weight: f64,
    /// The limb that it belongs to, 0 or 1.
    pub limb: u32,
    /// Written as 0.
    pub reserved: u32,
}

/// A camera as a calibration gives it. Pixel centres are at integer coordinates, as in OpenCV.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_intrinsics {
    /// `sizeof(cylfuse_intrinsics)`.
    pub struct_size: u32,
    /// What the numbers in `distortion` mean.
    pub distortion_model: cylfuse_distortion,
    /// Width of the image in pixels, at least 1.
    pub width: u32,
    /// Height of the image in pixels, at least 1; both together at most 2^28 pixels.
    pub height: u32,
    /// Focal length in pixel widths, greater than 0.
    pub fx: f64,
    /// Focal length in pixel heights, greater than 0.
    pub fy: f64,
    /// Principal point in pixels from the centre of the first pixel, to the right.
    pub cx: f64,
    /// Principal point in pixels from the centre of the first pixel, down.
    pub cy: f64,
    /// Coefficients in the order of `distortion_model`; those that the model does not have are 0.
    pub distortion: [f64; 8],
}

/// A cloud in the caller's memory, organised (`height` > 1) or not. PCL: `data = &cloud[0].x`,
/// `point_stride = sizeof(PointT)`, width and height of the cloud.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_points_view {
    /// `sizeof(cylfuse_points_view)`.
    pub struct_size: u32,
    /// Type of the coordinates and weights.
    pub scalar: cylfuse_scalar,
    /// x of the first point; y and z follow it. Any alignment. May be NULL when there are no points.
    pub data: *const c_void,
    /// Columns of an organised cloud, or the number of points.
    pub width: usize,
    /// Rows of an organised cloud, or 1.
    pub height: usize,
    /// Bytes from a point to the next one in its row, negative too; 0 = 3 scalars.
    pub point_stride: isize,
    /// Bytes from a row to the next one, negative too; 0 = `width` * `point_stride`.
    pub row_stride: isize,
    /// Weight of the first point, 0 or greater; 0 drops the point. NULL = every weight is 1.
    pub weights: *const c_void,
    /// Bytes from a weight to the next one in its row; 0 = 1 scalar.
    pub weight_stride: isize,
    /// Bytes from a row of weights to the next one; 0 = `width` * `weight_stride`.
    pub weight_row_stride: isize,
    /// x of the normal at the first point; y and z follow it, in the type of the coordinates. Normals have any
    /// length and sign; one of length 0 or that is not finite counts as unknown. Only RANSAC uses them, and
    /// only when all points come with normals. NULL = unknown.
    pub normals: *const c_void,
    /// Bytes from a normal to the next one in its row; 0 = 3 scalars.
    pub normal_stride: isize,
    /// Bytes from a row of normals to the next one; 0 = `width` * `normal_stride`.
    pub normal_row_stride: isize,
}

/// A buffer for points in the caller's memory.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_points_out {
    /// `sizeof(cylfuse_points_out)`.
    pub struct_size: u32,
    /// Type of the coordinates.
    pub scalar: cylfuse_scalar,
    /// Where x of the first point goes; y and z follow it, whatever else is in the buffer stays. Any alignment.
    /// May be NULL when `capacity` is 0.
    pub data: *mut c_void,
    /// Points that the buffer holds.
    pub capacity: usize,
    /// Bytes from a point to the next one (in its row), negative too; 0 = 3 scalars.
    pub point_stride: isize,
    /// Bytes from a row to the next one when organised, negative too; 0 = width * `point_stride`. Must be 0 when
    /// packed.
    pub row_stride: isize,
    /// Packed or organised.
    pub layout: cylfuse_layout,
    /// Must be 0.
    pub reserved: u32,
}

/// A depth image in the caller's memory. The value is z, not the distance along the ray.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_depth_view {
    /// `sizeof(cylfuse_depth_view)`.
    pub struct_size: u32,
    /// Type of a pixel.
    pub format: cylfuse_depth_format,
    /// The first pixel of the first row. Any alignment.
    pub data: *const c_void,
    /// Columns; must be those of the intrinsics.
    pub width: u32,
    /// Rows; must be those of the intrinsics.
    pub height: u32,
    /// Bytes from a row to the next one, such as `step` of a `cv::Mat`, negative too; 0 = `width` *
    /// `pixel_stride`.
    pub row_stride: isize,
    /// Bytes from a pixel to the next one; 0 = the size of one.
    pub pixel_stride: isize,
    /// Length of one unit of the stored value, greater than 0: 0.001 for millimetres when the unit of length is
    /// the metre.
    pub scale: f64,
    /// The nearest depth that counts, in the unit of length, 0 or greater.
    pub min_depth: f64,
    /// The farthest depth that counts, in the unit of length; 0 = no limit.
    pub max_depth: f64,
}

/// A depth image to be written in the caller's memory. A pixel without depth becomes 0.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_depth_out {
    /// `sizeof(cylfuse_depth_out)`.
    pub struct_size: u32,
    /// Type of a pixel. A depth beyond the range of `uint16_t` becomes 0 and is counted.
    pub format: cylfuse_depth_format,
    /// The first pixel of the first row. Any alignment.
    pub data: *mut c_void,
    /// Columns of the buffer; must be those of the intrinsics.
    pub width: u32,
    /// Rows of the buffer; must be those of the intrinsics.
    pub height: u32,
    /// Bytes from a row to the next one, negative too; 0 = `width` * `pixel_stride`.
    pub row_stride: isize,
    /// Bytes from a pixel to the next one; 0 = the size of one.
    pub pixel_stride: isize,
    /// Length of one unit of the stored value, greater than 0: z = value * `scale`.
    pub scale: f64,
}

/// A mask in the caller's memory: one byte a pixel, non-zero = visible lateral surface of the cylinder. Its
/// boundary may be some pixels off: it is a hint and never measured.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_mask_view {
    /// `sizeof(cylfuse_mask_view)`.
    pub struct_size: u32,
    /// Must be 0.
    pub reserved: u32,
    /// The first pixel of the first row.
    pub data: *const u8,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bytes from a row to the next one, negative too; 0 = `width` * `pixel_stride`.
    pub row_stride: isize,
    /// Bytes from a pixel to the next one; 0 = 1.
    pub pixel_stride: isize,
}

/// A grey image in the caller's memory, on the pixels of the camera. Its values have no unit, but are those of the
/// light, as they are or with a gamma, not an equalised or filtered picture.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_image_view {
    /// `sizeof(cylfuse_image_view)`.
    pub struct_size: u32,
    /// Type of a pixel.
    pub format: cylfuse_image_format,
    /// The first pixel of the first row. Any alignment.
    pub data: *const c_void,
    /// Columns; must be those of the intrinsics.
    pub width: u32,
    /// Rows; must be those of the intrinsics.
    pub height: u32,
    /// Bytes from a row to the next one, such as `step` of a `cv::Mat`, negative too; 0 = `width` *
    /// `pixel_stride`.
    pub row_stride: isize,
    /// Bytes from a pixel to the next one; 0 = the size of one. With 3 and U8 the first channel of packed
    /// colours.
    pub pixel_stride: isize,
    /// Light is the value to this power, from 0.1 to 10: 1 for values linear in light, 2.2 for sRGB, in which cameras
    /// and image files usually come. With another one than 1 no value may be negative. 0 = 1.
    pub gamma: f64,
}

/// Edge segments in the caller's memory: pieces of the two lines that bound the cylinder in the (distorted)
/// image. A `std::vector<cv::Vec4f>` passes as it is.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_segments_view {
    /// `sizeof(cylfuse_segments_view)`.
    pub struct_size: u32,
    /// Type of the coordinates.
    pub scalar: cylfuse_scalar,
    /// x1 of the first segment; y1, x2 and y2 follow it, in pixels. The endpoints may come in any order. Any
    /// alignment. May be NULL when `count` is 0.
    pub data: *const c_void,
    /// Number of segments.
    pub count: usize,
    /// Bytes from a segment to the next one, negative too; 0 = 4 scalars.
    pub segment_stride: isize,
    /// `count` weights, from 0 to 1e9; 0 leaves the segment out. NULL = every weight is 1.
    pub weights: *const f64,
}

/// The settings of a fit. `cylfuse_options_init` fills the defaults, which are named below; a field that says
/// "0 = default" may also be left 0.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_options {
    /// `sizeof(cylfuse_options)`.
    pub struct_size: u32,
    /// How the cylinder is estimated. Default FUSED.
    pub method: cylfuse_method,
    /// What FUSED minimises. Default ROBUST.
    pub objective: cylfuse_objective,
    /// Where the iteration starts. Default AUTO.
    pub start: cylfuse_start,
    /// Whether the points must lie on the wall that the camera sees. Default AUTO.
    pub near_wall: cylfuse_near_wall,
    /// The coordinates of the iteration. Default AUTO.
    pub chart: cylfuse_chart,
    /// Most linear solves. Default 400; 0 = default.
    pub max_iterations: u32,
    /// Most threads for the sums over the points; small clouds take one. The result has the same bits for any
    /// number. Default 0 = as many as the machine has.
    pub max_threads: u32,
    /// The weight w of the edges in PAPER, in [0, 1]. Default 0.6. Here 0 is a weight: points only.
    pub edge_weight: f64,
    /// Damping of the first step, greater than 0. Default 1e-3; 0 = default.
    pub initial_lambda: f64,
    /// Factor by which the damping falls after an accepted step and grows after a rejected one, greater than 1.
    /// Default 10; 0 = default.
    pub lambda_factor: f64,
    /// Damping at which no smaller step is tried any more, at least `initial_lambda`. Default 1e12; 0 = default.
    pub max_lambda: f64,
    /// Smallest relative decrease of the cost that counts as progress, in [0, 1). Default 1e-12. Here 0 is a
    /// tolerance: iterate until nothing decreases.
    pub cost_tolerance: f64,
    /// Distance within which RANSAC counts a point as an inlier, in the unit of length, 0 or greater. Default 0
    /// = from the data.
    pub ransac_threshold: f64,
    /// Seed of the random samples of RANSAC: the same seed gives the same result. Default 0.
    pub seed: u64,
    /// Most random samples of RANSAC. Default 1000; 0 = default.
    pub ransac_max_iterations: u32,
    /// Must be 0.
    pub reserved: u32,
    /// What given edge segments are for the objective ROBUST. Default REFINE.
    pub edge_use: cylfuse_edge_use,
    /// How the ends of the visible cylinder are found. Default AUTO.
    pub extent_rule: cylfuse_extent_rule,
    /// The smallest radius, in the unit of length, which the returned cylinder keeps whatever the method and the
    /// start. Default 0 = no limit.
    pub radius_min: f64,
    /// The largest radius, at least `radius_min`; equal to it for a radius that is known. Default 0 = no limit.
    pub radius_max: f64,
    /// The middle of the cone of directions that the returned axis keeps, of any length. Default {0, 0, 0} = all
    /// directions.
    pub axis: [f64; 3],
    /// The largest angle of the axis from `axis`, in radians from 0 to pi/2, whatever the signs; 0 for a direction
    /// that is known. Default 0; must be 0 without `axis`.
    pub axis_max_angle: f64,
}

/// What was pushed, and what was left out by reason.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_counts {
    /// `sizeof(cylfuse_counts)`, set by the caller.
    pub struct_size: u32,
    /// Written as 0.
    pub reserved: u32,
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
    /// Edge segments that were pushed; `segments_used` of a result says how many count.
    pub segments_given: u64,
}

/// The outcome of a fit with the numbers to judge it. NaN stands for what does not apply.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_result {
    /// `sizeof(cylfuse_result)`, set by the caller.
    pub struct_size: u32,
    /// Why the iteration ended.
    pub termination: cylfuse_termination,
    /// How the start was found.
    pub start_kind: cylfuse_start,
    /// Doubts, `CYLFUSE_RESULT_FLAGS_...` by bit; 0 when there are none.
    pub flags: cylfuse_result_flags,
    /// Linear solves.
    pub iterations: u32,
    /// Solves whose step was rejected.
    pub rejected_steps: u32,
    /// Segments that took part.
    pub segments_used: u32,
    /// Segments that were pushed.
    pub segments_given: u32,
    /// Points that took part.
    pub points_used: u64,
    /// Points that were pushed; `cylfuse_fitter_counts` says why the others were left out.
    pub points_given: u64,
    /// The cylinder, its axis point the one nearest to the middle of the points.
    pub model: cylfuse_cylinder,
    /// The model that the iteration started from, moved into the limits.
    pub start_model: cylfuse_cylinder,
    /// Cost of the start, unit of length squared.
    pub initial_cost: f64,
    /// Cost of the cylinder, unit of length squared.
    pub cost: f64,
    /// E_P: mean squared distance of the points from the surface, unit of length squared.
    pub energy_points: f64,
    /// E_L: mean squared distance of the back-projected endpoints from the limb lines, unit of length squared;
    /// NaN without exactly two usable segments.
    pub energy_edges: f64,
    /// The edge weight that was used, 0 when no edges count; NaN where the objective has none.
    pub edge_weight: f64,
    /// Root of E_P, unit of length.
    pub point_rms: f64,
    /// Root mean square distance of the endpoints from the limb lines in ideal pixels; NaN without edges.
    pub edge_rms_pixels: f64,
    /// The part of the points on the wall that the camera sees; NaN when the origin is no camera.
    pub near_wall_fraction: f64,
    /// Condition number of the Jacobian at the cylinder, in units of the size of the data; may be infinite.
    pub condition: f64,
    /// The last damping.
    pub lambda: f64,
    /// Norm of half the gradient of the cost at the end, as far as the limits leave it free, in units of the size of
    /// the data.
    pub gradient_norm: f64,
    /// Norm of the last accepted step, in units of the size of the data.
    pub step_norm: f64,
    /// Wall-clock seconds to find the start.
    pub seconds_start: f64,
    /// Wall-clock seconds to iterate.
    pub seconds_solve: f64,
    /// Wall-clock seconds of the whole fit.
    pub seconds_total: f64,
    /// Standard deviation of the radius, unit of length. This and what follows is that of the noise of the data, with
    /// the weights that were used and the correlation of the depth noise along the order of the points; errors that
    /// all data share (calibration, a scale of the depth) are not in it. NaN for RANSAC and EBERLY, for an edge weight
    /// of 1, and where the data do not determine a cylinder.
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
    /// Limb lines that were located in the grey image and took part, 0 to 2.
    pub limbs_located: u32,
    /// Written as 0.
    pub reserved: u32,
}

/// What the data determine at a cylinder: the singular values of the stacked Jacobian of the five degrees of
/// freedom, in units of the size of the data.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_diagnosis {
    /// `sizeof(cylfuse_diagnosis)`, set by the caller.
    pub struct_size: u32,
    /// How many singular values stand out of the rounding error; 5 when everything is determined.
    pub rank: u32,
    /// Singular values, the largest first.
    pub singular_values: [f64; 5],
    /// Largest over smallest singular value; may be infinite.
    pub condition: f64,
    /// The step along which the residuals change least: how it moves the axis at the middle of the points, in
    /// the unit of length,
    pub weakest_shift: [f64; 3],
    /// how it tilts the axis, in radians towards this vector,
    pub weakest_tilt: [f64; 3],
    /// and how it changes the radius, in the unit of length. Shift and radius over the size of the data and the
    /// tilt have a joint norm of 1.
    pub weakest_radius: f64,
}

/// What became of the pixels of a completion.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_completion {
    /// `sizeof(cylfuse_completion)`, set by the caller.
    pub struct_size: u32,
    /// Written as 0.
    pub reserved: u32,
    /// Points or pixels that were written; after `CYLFUSE_STATUS_BUFFER_TOO_SMALL` the capacity that is needed.
    pub count: u64,
    /// Pixels of the mask whose ray meets the cylinder.
    pub hits: u64,
    /// Pixels of the mask whose ray passes the cylinder by.
    pub misses: u64,
    /// Pixels of the mask for which the camera model has no ray.
    pub outside_camera: u64,
    /// Hits whose depth does not fit the pixel format: written as 0 and not in `count`.
    pub out_of_range: u64,
}

/// The visible piece of the cylinder: `end` = `start` + `length` * direction of the model.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_extent {
    /// `sizeof(cylfuse_extent)`, set by the caller.
    pub struct_size: u32,
    /// What the end against the direction is.
    pub start_state: cylfuse_end_state,
    /// What the end along the direction is.
    pub end_state: cylfuse_end_state,
    /// Written as 0.
    pub reserved: u32,
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

/// The state of a running fit, before each linear solve.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_progress {
    /// Size of this struct in the library: fields beyond it are not there.
    pub struct_size: u32,
    /// What the fit is doing.
    pub phase: cylfuse_phase,
    /// Linear solves so far. Begins again at 0 with every start that is tried and every robust round.
    pub iteration: u32,
    /// Most linear solves.
    pub max_iterations: u32,
    /// The lowest cost so far, unit of length squared; infinite in the phase START.
    pub cost: f64,
    /// The damping of the next step; 0 in the phase START.
    pub lambda: f64,
    /// The best cylinder so far; of radius 0 in the phase START.
    pub model: cylfuse_cylinder,
}
