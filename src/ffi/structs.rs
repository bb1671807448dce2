//! The structs that the caller fills. Fixed-width integers, doubles, sizes and pointers only, without padding.
//!
//! A struct whose first field is `struct_size` only ever grows at its end, and there zero means the behaviour from
//! before.

use super::constants::{
    cylfuse_chart, cylfuse_depth_format, cylfuse_distortion, cylfuse_edge_use, cylfuse_extent_rule,
    cylfuse_image_format, cylfuse_image_use, cylfuse_method, cylfuse_near_wall, cylfuse_objective,
    cylfuse_scalar, cylfuse_start,
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
    /// Rows of an organised cloud, else 1; 0 only when `width` is 0.
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
    /// Bytes from a row to the next one in the layout ORGANISED, negative too; 0 = width * `point_stride`. Must be
    /// 0 in the layout PACKED.
    pub row_stride: isize,
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
    /// Columns; those of the intrinsics (of the depth camera where there is one).
    pub width: u32,
    /// Rows; likewise.
    pub height: u32,
    /// Bytes from a row to the next one, such as `step` of a `cv::Mat`, negative too; 0 = `width` *
    /// `pixel_stride`.
    pub row_stride: isize,
    /// Bytes from a pixel to the next one; 0 = the size of one.
    pub pixel_stride: isize,
    /// Length of one unit of the stored value, greater than 0: 0.001 for millimetres when the unit of length is
    /// the metre. `cylfuse_depth_view_init` sets 1: the unit of length is then that of the stored values, and nothing can
    /// tell that another one was meant.
    pub scale: f64,
    /// The nearest depth that becomes a point, in the unit of length, 0 or greater. Both limits are those of the points,
    /// and of the search of a detector: the extent is found with all depths.
    pub min_depth: f64,
    /// The farthest depth that becomes a point, in the unit of length; 0 = no limit.
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

/// A mask in the caller's memory, one byte a pixel, on the pixels of the colour image: which pixels show the cylinder. It
/// may hold the lateral surface alone, or the whole object with caps, lids and handles: with the objective ROBUST a fit
/// leaves out what the depth image shows to be no part of the lateral surface. Its boundary may be some pixels off: it is a
/// hint and never measured.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_mask_view {
    /// `sizeof(cylfuse_mask_view)`.
    pub struct_size: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// In an image of labels, that of the cylinder, 1 to 255: the pixels of this value are the mask. 0 = all pixels that
    /// are not 0.
    pub label: u32,
    /// The first pixel of the first row.
    pub data: *const u8,
    /// Bytes from a row to the next one, negative too; 0 = `width` * `pixel_stride`.
    pub row_stride: isize,
    /// Bytes from a pixel to the next one; 0 = 1.
    pub pixel_stride: isize,
}

/// An image in the caller's memory, grey or in colour, on the pixels of the camera. Its values have no unit, but are
/// those of the light, as they are or with a gamma, not an equalised or filtered picture.
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
    /// Bytes from a pixel to the next one; 0 = the size of one.
    pub pixel_stride: isize,
    /// Light is the value to this power, from 0.1 to 10. Default 1: values linear in light; 2.2 is about sRGB. With
    /// another one than 1 no value may be negative.
    pub gamma: f64,
}

/// Edge segments in the caller's memory: pieces of the two lines that bound the cylinder in the (distorted)
/// image. A `std::vector<cv::Vec4f>` can be passed unchanged.
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

/// The settings of a fit. `cylfuse_options_init` fills the defaults, which are named below.
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
    /// What given edge segments are for the objective ROBUST. Default REFINE.
    pub edge_use: cylfuse_edge_use,
    /// How the ends of the visible cylinder are found. Default AUTO.
    pub extent_rule: cylfuse_extent_rule,
    /// Most threads for the sums over the points; small clouds take one. The result has the same bits for any
    /// number. Default 1: no thread is started; 0 = 1.
    pub max_threads: u32,
    /// Maximum number of iterations, at least 1. Default 400.
    pub max_iterations: u32,
    /// Smallest relative decrease of the cost that counts as progress, in [0, 1). Default 1e-12.
    pub cost_tolerance: f64,
    /// The iteration ends where the cosine of the angle between the residuals and what a step can change of them is not
    /// above this, in [0, 1). Default 2^-52.
    pub gradient_tolerance: f64,
    /// The iteration ends with a step that moves the surface at the data by not more than this part of their largest
    /// coordinate and of their size, in [0, 1). Default 2^-52.
    pub step_tolerance: f64,
    /// Damping of the first step, greater than 0. Default 1e-3.
    pub initial_lambda: f64,
    /// Factor by which the damping falls after an accepted step and grows after a rejected one, greater than 1.
    /// Default 10.
    pub lambda_factor: f64,
    /// Damping at which no smaller step is tried any more, at least `initial_lambda`. Default 1e12.
    pub max_lambda: f64,
    /// The weight w of the edges in PAPER, in [0, 1]. Default 0.6; 0 is points only.
    pub edge_weight: f64,
    /// Seed of the random samples of RANSAC: the same seed gives the same result. Default 0.
    pub seed: u64,
    /// Most random samples of RANSAC, 1 to 1,000,000. Default 1000.
    pub ransac_max_iterations: u64,
    /// Distance within which RANSAC counts a point as an inlier, in the unit of length, 0 or greater. Default 0
    /// = from the data.
    pub ransac_threshold: f64,
    /// How many points with independent noise the points of one view are worth, by which points and limbs are weighed
    /// against each other; 0 or greater. Default 0 = from the data.
    pub independent_points: f64,
    /// Standard deviation of a point across the surface, in the unit of length, 0 or greater. Default 0 = from the data.
    pub depth_noise: f64,
    /// Standard deviation of the values of the image, in their unit where that is linear in light, 0 or greater. Default
    /// 0 = from the image.
    pub image_noise: f64,
    /// Standard deviation of an endpoint of a given edge segment across its limb, in drawn pixels, 0 or greater. Default
    /// 0 = 0.5, that of edges set by hand. Beyond 8 pixels, more than a sixteenth of the longer side of the image counts as that.
    pub edge_noise: f64,
    /// Standard deviation of a side of the mask as a whole across its limb, in drawn pixels, 0 or greater. Default 0 =
    /// 1.6, that of masks drawn by hand; at most as `edge_noise`.
    pub mask_noise: f64,
    /// Blur of the image, the standard deviation of a Gaussian in pixels, 0 or greater. Default 0 = from the image.
    pub image_blur: f64,
    /// Size of a pixel of the drawing in which edges and masks were made, in pixels of the image, 0 or greater: people
    /// and networks draw on a grid of some hundred columns, whatever the size of the image. Default 0 = 1 up to
    /// 640 x 480 pixels, beyond that the square root of how many times as many pixels the image has.
    pub drawn_pixel: f64,
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
    /// Standard deviation of the errors that all points of a view share, as a part of their distance: by so much all of
    /// them may be too near or too far, and so much may the radius of the cylinder they lie on be wrong, as matching
    /// windows and filters bend a profile. Default 0 = 0.002, a fifth of what data sheets grant; less than 0 = they share
    /// none.
    pub depth_shared: f64,
}

/// The settings of a detector. `cylfuse_detector_options_init` fills the defaults, which are named below.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cylfuse_detector_options {
    /// `sizeof(cylfuse_detector_options)`.
    pub struct_size: u32,
    /// Whether the image of a frame is looked at. Default AUTO.
    pub image_use: cylfuse_image_use,
    /// Most threads, on which cylinders are fitted side by side. The result has the same bits for any number. Default 1:
    /// no thread is started; 0 = 1.
    pub max_threads: u32,
    /// Most cylinders, those with the highest scores. Default 0 = no limit.
    pub max_count: u32,
    /// Fewest pixels of a cylinder; points for a cloud. Default 100.
    pub min_pixels: u64,
    /// The least score, in [0, 1]: the probability that there is a cylinder. Default 0.5.
    pub min_score: f64,
    /// The smallest radius, in the unit of length, which the search and the fits keep. Default 0 = no limit.
    pub radius_min: f64,
    /// The largest radius, at least `radius_min`; equal to it for a radius that is known. Default 0 = no limit.
    pub radius_max: f64,
    /// The middle of the cone of directions that the axes keep, in the reference frame and of any length. Default
    /// {0, 0, 0} = all directions.
    pub axis: [f64; 3],
    /// The largest angle of an axis from `axis`, in radians from 0 to pi/2, whatever the signs; 0 for a direction that is
    /// known. Default 0; must be 0 without `axis`.
    pub axis_max_angle: f64,
}
