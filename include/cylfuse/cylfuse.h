/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file cylfuse.h
 * Measures a cylinder from RGB-D views.
 *
 * The smallest use, with error handling left out:
 *
 *     cylfuse_fitter *fitter;
 *     cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &fitter);
 *
 *     cylfuse_intrinsics intrinsics;
 *     cylfuse_intrinsics_init(&intrinsics, sizeof intrinsics);
 *     intrinsics.width = 640;
 *     intrinsics.height = 480;
 *     intrinsics.fx = intrinsics.fy = 570.0;
 *     intrinsics.cx = 319.5;
 *     intrinsics.cy = 239.5;
 *     cylfuse_fitter_set_intrinsics(fitter, &intrinsics);
 *
 *     cylfuse_depth_view depth;
 *     cylfuse_depth_view_init(&depth, sizeof depth);
 *     depth.format = CYLFUSE_DEPTH_FORMAT_U16;
 *     depth.data = depth_pixels;
 *     depth.width = 640;
 *     depth.height = 480;
 *     depth.scale = 0.001;
 *     cylfuse_mask_view mask;
 *     cylfuse_mask_view_init(&mask, sizeof mask);
 *     mask.data = mask_pixels;
 *     mask.width = 640;
 *     mask.height = 480;
 *     cylfuse_fitter_push_depth(fitter, &depth, &mask);
 *
 *     cylfuse_cylinder_estimate estimate;
 *     cylfuse_cylinder_estimate_init(&estimate, sizeof estimate);
 *     if (cylfuse_fitter_fit(fitter, NULL, &estimate) == CYLFUSE_STATUS_OK) {
 *         printf("radius %g +- %g\n", estimate.model.radius, estimate.radius_deviation);
 *     } else {
 *         puts(cylfuse_fitter_last_error(fitter));
 *     }
 *     cylfuse_fitter_destroy(fitter);
 *
 * With the colour image (cylfuse_fitter_push_image()) the limbs and ends are located in it, which makes the outcome far
 * more certain. For the next frame: cylfuse_fitter_clear(), push, fit. For several views of one cylinder:
 * cylfuse_fitter_select_view(). For many cylinders in one view: a cylfuse_frame, which many fitters share. For all
 * cylinders of a frame or a cloud without any mask: cylfuse_detector_detect() and cylfuse_detector_detect_points().
 *
 * Statuses. A call returns 0 (CYLFUSE_STATUS_OK) or a negative number. A call that fails changes nothing and
 * writes no output, unless its text says so, and cylfuse_fitter_last_error() names the value, the limit and the
 * remedy. After a call that succeeded that text is empty. A result that did not converge, or that needs care for
 * another reason, is not an error: the flags of the result are its warnings. The statuses after @return are those that
 * a call adds to NULL_POINTER, STRUCT_SIZE, INVALID_ARGUMENT, BUSY and PANIC, which any call may return.
 *
 * Memory. The library copies what it is given during the call and keeps no pointer but the callbacks and their
 * user_data. All outputs go to memory of the caller: nothing needs to be freed but fitters, frames and detectors, each by
 * its destroy function.
 *
 * Pointers. NULL where a pointer is needed gives NULL_POINTER; a pointer may be NULL only where its text says
 * so. Pointers to data, structs and outputs need no alignment. Data are described by the address of the first
 * element, counts, and strides in bytes, which may be negative; a stride of 0 stands for packed elements.
 * Elements must not overlap. The memory from the first to the last byte of the elements must be readable
 * (writable for outputs).
 *
 * Structs. Those with struct_size grow with later versions, at their end. Each (but cylfuse_progress and
 * cylfuse_detection_progress, which the library makes) has a function named after it that ends in _init, which comes
 * before everything else: it sets struct_size and the defaults. Do not fill such a struct with zeros instead: 0 is no
 * default for some fields. In a struct to be read, struct_size is the size that the program knows: fields that an older
 * program does not have are at their defaults, and fields of a newer one must be 0. In a struct to be written it is the
 * room: the library writes what both sides know, fills the rest of the room with zeros, and sets struct_size to the
 * bytes that it filled; so a field that an older library does not know is 0 and lies beyond struct_size. Elements of
 * arrays have no struct_size: the call is given their size in element_size, and the rest of an element that the library
 * does not know becomes zero. Structs without either never change.
 *
 * Units and frames. Lengths are in one unit, which is the caller's, but for cylfuse_plan(), which takes metres. Angles
 * are in radians. A camera frame is x to the right, y down, z forward, with its origin in the centre of projection.
 * Poses lead from camera frames to the reference frame; with one view at the identity, as at first, the two are the
 * same. Models, results and extents are in the reference frame, data of a view in the frame of its camera. Pixel
 * centres are at integer coordinates, as in OpenCV. Ideal pixels are those of a pinhole with the same fx, fy, cx and
 * cy: without distortion those of the image.
 *
 * Numbers. Points with a coordinate or weight that is not finite, depths of 0, below 0, not finite or, as uint16_t, of
 * 65535, and pixels outside the mask are left out and counted. Anything else that is not finite is an error. All
 * deviations are standard deviations, of the noise of the data; those of a robust fit also have the errors that all
 * points of a view share, as far as depth_shared of the options states them.
 *
 * Threads. Any number of calls that take a const handle may run on it at once; a call that takes a handle that is not
 * const runs alone. What would disturb another call returns BUSY at once instead of waiting. Only
 * the functions that end in _cancel and _last_error always go through. Different handles are independent. No
 * thread is started unless max_threads of the options asks for it. There is no shared state but the text of the last
 * call of each thread, and the library prints nothing.
 *
 * C++. No function throws. Callbacks must not throw either.
 */


#ifndef CYLFUSE_H
#define CYLFUSE_H

#include <stddef.h>
#include <stdint.h>

/** The first part of the version of this header; compare with `cylfuse_version_number()`. */
#define CYLFUSE_VERSION_MAJOR 0
/** The second part. */
#define CYLFUSE_VERSION_MINOR 2
/** The third part. */
#define CYLFUSE_VERSION_PATCH 0
/** All three, with points between them. */
#define CYLFUSE_VERSION_STRING "0.2.0"
/** major * 65536 + minor * 256 + patch. */
#define CYLFUSE_VERSION_NUMBER 512

/** Linkage. Define CYLFUSE_STATIC when linking the static library on Windows. */
#ifndef CYLFUSE_API
#if defined(_WIN32) && !defined(CYLFUSE_STATIC)
#define CYLFUSE_API __declspec(dllimport)
#else
#define CYLFUSE_API
#endif
#endif

/** No function throws; callbacks carry no such mark because C++11 allows none on their types. */
#ifdef __cplusplus
#define CYLFUSE_NOEXCEPT noexcept
#else
#define CYLFUSE_NOEXCEPT
#endif


/**
 * The version of the binary interface that this header describes. It changes only when old programs stop
 * working, and the soname changes with it.
 */
#define CYLFUSE_ABI_VERSION 1

/**
 * Finds all cylinders of a frame or a cloud and fits each by the full method: holds options and the last scene. Opaque;
 * made by `cylfuse_detector_create`.
 *
 * A detector may move between threads. Calls that take a `const cylfuse_detector *` run side by side; a call that may
 * change it runs alone: what would disturb it, from another thread or from a callback, returns `CYLFUSE_STATUS_BUSY`.
 * Different detectors run in parallel.
 */
typedef struct cylfuse_detector cylfuse_detector;

/**
 * Estimates one cylinder: holds options, views with their data, and the last result. Opaque; made by
 * `cylfuse_fitter_create`.
 *
 * A fitter may move between threads. Calls that take a `const cylfuse_fitter *` run side by side; a call that may
 * change it runs alone: what would disturb it, from another thread or from a callback, returns
 * `CYLFUSE_STATUS_BUSY`. Different fitters run in parallel.
 */
typedef struct cylfuse_fitter cylfuse_fitter;

/**
 * What one camera delivered at one time: intrinsics, pose, depth image, image. Any number of fitters use one frame
 * without a copy, such as one for each cylinder of a scene. Opaque; made by `cylfuse_frame_create`.
 *
 * A fitter takes what the frame holds at that time: what is set later, and its destruction, change nothing in fitters.
 * Calls that fill a frame run one at a time; any number of threads may use it at once.
 */
typedef struct cylfuse_frame cylfuse_frame;

/**
 * What a call returns: 0 when it did what it was asked to, else a negative number that says why not.
 *
 * A failed call changes nothing and writes no output unless its text says so; the handle stays usable, but for
 * `CYLFUSE_STATUS_PANIC`. The numbers never change and new ones may be added: treat an unknown negative number
 * as a failure.
 */
typedef int32_t cylfuse_status;
/**
 * The call did what it was asked to.
 */
#define CYLFUSE_STATUS_OK 0
/**
 * An argument or field has a value outside its documented range.
 */
#define CYLFUSE_STATUS_INVALID_ARGUMENT (-1)
/**
 * A pointer that is needed is NULL.
 */
#define CYLFUSE_STATUS_NULL_POINTER (-2)
/**
 * A `struct_size` or `element_size` is smaller than the first version of the struct or larger than 4096, or a
 * struct to be read is larger than this library knows it and uses fields that this library does not know.
 */
#define CYLFUSE_STATUS_STRUCT_SIZE (-3)
/**
 * The program was compiled for another, incompatible version of the library.
 */
#define CYLFUSE_STATUS_ABI_MISMATCH (-4)
/**
 * The call came before something that it needs.
 */
#define CYLFUSE_STATUS_BAD_STATE (-5)
/**
 * Another call on the same handle is running, in another thread or around a callback, and one of the two may
 * change it.
 */
#define CYLFUSE_STATUS_BUSY (-6)
/**
 * The buffer for the output is too small; the call says how much it needs and writes nothing else.
 */
#define CYLFUSE_STATUS_BUFFER_TOO_SMALL (-7)
/**
 * Memory could not be allocated: pass less data at once, or free memory.
 */
#define CYLFUSE_STATUS_OUT_OF_MEMORY (-8)
/**
 * Not supported with these options or data.
 */
#define CYLFUSE_STATUS_UNSUPPORTED (-9)
/**
 * Images on one pixel grid have different sizes.
 */
#define CYLFUSE_STATUS_SIZE_MISMATCH (-10)
/**
 * No camera works with these intrinsics.
 */
#define CYLFUSE_STATUS_INVALID_INTRINSICS (-11)
/**
 * Too few usable points. A fit needs 5, as many as a cylinder has degrees of freedom; a plan needs 8 points with
 * independent noise.
 */
#define CYLFUSE_STATUS_TOO_FEW_POINTS (-20)
/**
 * The points are as flat as a plane.
 */
#define CYLFUSE_STATUS_PLANAR_POINTS (-21)
/**
 * The points lie on one straight line.
 */
#define CYLFUSE_STATUS_COLLINEAR_POINTS (-22)
/**
 * No pixel of the mask is set.
 */
#define CYLFUSE_STATUS_EMPTY_MASK (-23)
/**
 * No pixel in the region has a usable depth.
 */
#define CYLFUSE_STATUS_NO_DEPTH (-24)
/**
 * No start for the iteration could be found.
 */
#define CYLFUSE_STATUS_NO_START (-25)
/**
 * The camera sees no limbs of the cylinder where they are needed, or nothing that was given meets it.
 */
#define CYLFUSE_STATUS_EDGE_GEOMETRY (-26)
/**
 * The arithmetic left the range of numbers.
 */
#define CYLFUSE_STATUS_NUMERICAL (-27)
/**
 * A progress callback, `cylfuse_fitter_cancel` or `cylfuse_detector_cancel` asked to stop.
 */
#define CYLFUSE_STATUS_CANCELLED (-40)
/**
 * A defect of the library. The handle can only be destroyed after it; others are not affected.
 */
#define CYLFUSE_STATUS_PANIC (-99)

/**
 * How the cylinder is estimated.
 */
typedef int32_t cylfuse_method;
/**
 * Points and edges together, by the chosen `cylfuse_objective`.
 */
#define CYLFUSE_METHOD_FUSED 0
/**
 * Points alone by plain least squares; edges are ignored.
 */
#define CYLFUSE_METHOD_POINTS 1
/**
 * Random sample consensus over the points with local optimisation; no fit to all points follows.
 */
#define CYLFUSE_METHOD_RANSAC 2
/**
 * Eberly's algebraic fit by the moments of the points, without a final iteration.
 */
#define CYLFUSE_METHOD_EBERLY 3

/**
 * What `CYLFUSE_METHOD_FUSED` minimises.
 */
typedef int32_t cylfuse_objective;
/**
 * Robust points and the distances of the segment endpoints in pixels, each weighted by its own scale. Takes
 * any number of segments, none included.
 */
#define CYLFUSE_OBJECTIVE_ROBUST 0
/**
 * F = (1 - w) E_P + w E_L of Zhang, Liu and Wang (Sensors 2026, 26(5), 1687), exactly, with the weight
 * w = `edge_weight`. Takes exactly two segments, or w = 0.
 */
#define CYLFUSE_OBJECTIVE_PAPER 1

/**
 * Where the iteration starts.
 */
typedef int32_t cylfuse_start;
/**
 * The candidate of the kinds below that explains the data best. Never in a result.
 */
#define CYLFUSE_START_AUTO 0
/**
 * From two limb segments, scaled by the points.
 */
#define CYLFUSE_START_LIMBS 1
/**
 * Eberly's algebraic fit by the moments of the points.
 */
#define CYLFUSE_START_MOMENTS 2
/**
 * Random sample consensus over the points.
 */
#define CYLFUSE_START_RANSAC 3
/**
 * The model given by `cylfuse_fitter_set_start_model`.
 */
#define CYLFUSE_START_MODEL 4
/**
 * The cylinder of the last successful fit of the fitter, for frames of a sequence, also after `cylfuse_fitter_clear`.
 * Where its limbs are about where it or the points have them, and look in the image as they did, they are not searched: the
 * search, a great part of the time, is left out, and the result depends on the fits before. Where not, and before the first
 * fit, as AUTO, with that cylinder or the start model one of the candidates. Of points alone that hold several bodies
 * the one near that cylinder is fitted.
 */
#define CYLFUSE_START_LAST 5

/**
 * Whether the points must lie on the wall of the cylinder that a camera at the origin sees. There is often a
 * second minimum with the cylinder between camera and surface; this rule refuses it.
 */
typedef int32_t cylfuse_near_wall;
/**
 * On when intrinsics are set: only then is the origin known to be a camera.
 */
#define CYLFUSE_NEAR_WALL_AUTO 0
/**
 * On: the origin is the observer.
 */
#define CYLFUSE_NEAR_WALL_ON 1
/**
 * Off: the minimum nearest to the start stays.
 */
#define CYLFUSE_NEAR_WALL_OFF 2

/**
 * The coordinates in which the iteration steps. All reach the same optima.
 */
typedef int32_t cylfuse_chart;
/**
 * ORTHONORMAL for the paper's objective where a camera stands outside the cylinder, else LOCAL.
 */
#define CYLFUSE_CHART_AUTO 0
/**
 * Shift and tilt of the axis at the data: regular wherever the axis runs.
 */
#define CYLFUSE_CHART_LOCAL 1
/**
 * The orthonormal representation about the origin of coordinates, as in the paper: singular for an axis
 * through the origin.
 */
#define CYLFUSE_CHART_ORTHONORMAL 2

/**
 * What given edge segments are for the objective ROBUST. No other looks for limbs in the image.
 */
typedef int32_t cylfuse_edge_use;
/**
 * A start: where there is an image, the limbs are located in it and join the fit.
 */
#define CYLFUSE_EDGE_USE_REFINE 0
/**
 * The measurement: no limbs are looked for in the image. The arcs of the ends are.
 */
#define CYLFUSE_EDGE_USE_AS_GIVEN 1

/**
 * How the ends of the visible cylinder are found in a mask. Without one, and from inside a pipe, the points on the surface
 * tell them.
 */
typedef int32_t cylfuse_extent_rule;
/**
 * LOCATED for the method FUSED with the objective ROBUST, EXTREMES otherwise.
 */
#define CYLFUSE_EXTENT_RULE_AUTO 0
/**
 * The rule of the paper: the extreme positions along the axis of the points completed over the mask.
 */
#define CYLFUSE_EXTENT_RULE_EXTREMES 1
/**
 * From all lines along the surface together, in the mask and, when there is one, in the image.
 */
#define CYLFUSE_EXTENT_RULE_LOCATED 2

/**
 * The settings of a fit. `cylfuse_options_init` fills the defaults, which are named below.
 */
typedef struct cylfuse_options {
    /**
     * `sizeof(cylfuse_options)`.
     */
    uint32_t struct_size;
    /**
     * How the cylinder is estimated. Default FUSED.
     */
    cylfuse_method method;
    /**
     * What FUSED minimises. Default ROBUST.
     */
    cylfuse_objective objective;
    /**
     * Where the iteration starts. Default AUTO.
     */
    cylfuse_start start;
    /**
     * Whether the points must lie on the wall that the camera sees. Default AUTO.
     */
    cylfuse_near_wall near_wall;
    /**
     * The coordinates of the iteration. Default AUTO.
     */
    cylfuse_chart chart;
    /**
     * What given edge segments are for the objective ROBUST. Default REFINE.
     */
    cylfuse_edge_use edge_use;
    /**
     * How the ends of the visible cylinder are found. Default AUTO.
     */
    cylfuse_extent_rule extent_rule;
    /**
     * Most threads for the sums over the points; small clouds take one. The result has the same bits for any
     * number. Default 1: no thread is started; 0 = 1.
     */
    uint32_t max_threads;
    /**
     * Maximum number of iterations, at least 1. Default 400.
     */
    uint32_t max_iterations;
    /**
     * Smallest relative decrease of the cost that counts as progress, in [0, 1). Default 1e-12.
     */
    double cost_tolerance;
    /**
     * The iteration ends where the cosine of the angle between the residuals and what a step can change of them is not
     * above this, in [0, 1). Default 2^-52.
     */
    double gradient_tolerance;
    /**
     * The iteration ends with a step that moves the surface at the data by not more than this part of their largest
     * coordinate and of their size, in [0, 1). Default 2^-52.
     */
    double step_tolerance;
    /**
     * Damping of the first step, greater than 0. Default 1e-3.
     */
    double initial_lambda;
    /**
     * Factor by which the damping falls after an accepted step and grows after a rejected one, greater than 1.
     * Default 10.
     */
    double lambda_factor;
    /**
     * Damping at which no smaller step is tried any more, at least `initial_lambda`. Default 1e12.
     */
    double max_lambda;
    /**
     * The weight w of the edges in PAPER, in [0, 1]. Default 0.6; 0 is points only.
     */
    double edge_weight;
    /**
     * Seed of the random samples of RANSAC: the same seed gives the same result. Default 0.
     */
    uint64_t seed;
    /**
     * Most random samples of RANSAC, 1 to 1,000,000. Default 1000.
     */
    uint64_t ransac_max_iterations;
    /**
     * Distance within which RANSAC counts a point as an inlier, in the unit of length, 0 or greater. Default 0
     * = from the data.
     */
    double ransac_threshold;
    /**
     * How many points with independent noise the points of one view are worth, by which points and limbs are weighed
     * against each other; 0 or greater. Default 0 = from the data.
     */
    double independent_points;
    /**
     * Standard deviation of a point across the surface, in the unit of length, 0 or greater. Default 0 = from the data.
     */
    double depth_noise;
    /**
     * Standard deviation of the values of the image, in their unit where that is linear in light, 0 or greater. Default
     * 0 = from the image.
     */
    double image_noise;
    /**
     * Standard deviation of an endpoint of a given edge segment across its limb, in drawn pixels, 0 or greater. Default
     * 0 = 0.5, that of edges set by hand. Beyond 8 pixels, more than a sixteenth of the longer side of the image counts as that.
     */
    double edge_noise;
    /**
     * Standard deviation of a side of the mask as a whole across its limb, in drawn pixels, 0 or greater. Default 0 =
     * 1.6, that of masks drawn by hand; at most as `edge_noise`.
     */
    double mask_noise;
    /**
     * Blur of the image, the standard deviation of a Gaussian in pixels, 0 or greater. Default 0 = from the image.
     */
    double image_blur;
    /**
     * Size of a pixel of the drawing in which edges and masks were made, in pixels of the image, 0 or greater: people
     * and networks draw on a grid of some hundred columns, whatever the size of the image. Default 0 = 1 up to
     * 640 x 480 pixels, beyond that the square root of how many times as many pixels the image has.
     */
    double drawn_pixel;
    /**
     * The smallest radius, in the unit of length, which the returned cylinder keeps whatever the method and the
     * start. Default 0 = no limit.
     */
    double radius_min;
    /**
     * The largest radius, at least `radius_min`; equal to it for a radius that is known. Default 0 = no limit.
     */
    double radius_max;
    /**
     * The middle of the cone of directions that the returned axis keeps, of any length. Default {0, 0, 0} = all
     * directions.
     */
    double axis[3];
    /**
     * The largest angle of the axis from `axis`, in radians from 0 to pi/2, whatever the signs; 0 for a direction
     * that is known. Default 0; must be 0 without `axis`.
     */
    double axis_max_angle;
    /**
     * Standard deviation of the errors that all points of a view share, as a part of their distance: by so much all of
     * them may be too near or too far, and so much may the radius of the cylinder they lie on be wrong, as matching
     * windows and filters bend a profile. Default 0 = 0.002, a fifth of what data sheets grant; less than 0 = they share
     * none.
     */
    double depth_shared;
} cylfuse_options;

/**
 * Whether a detector looks at the image of a frame.
 */
typedef int32_t cylfuse_image_use;
/**
 * Where there is one.
 */
#define CYLFUSE_IMAGE_USE_AUTO 0
/**
 * Never: by depth alone.
 */
#define CYLFUSE_IMAGE_USE_IGNORE 1

/**
 * The settings of a detector. `cylfuse_detector_options_init` fills the defaults, which are named below.
 */
typedef struct cylfuse_detector_options {
    /**
     * `sizeof(cylfuse_detector_options)`.
     */
    uint32_t struct_size;
    /**
     * Whether the image of a frame is looked at. Default AUTO.
     */
    cylfuse_image_use image_use;
    /**
     * Most threads, on which cylinders are fitted side by side. The result has the same bits for any number. Default 1:
     * no thread is started; 0 = 1.
     */
    uint32_t max_threads;
    /**
     * Most cylinders, those with the highest scores. Default 0 = no limit.
     */
    uint32_t max_count;
    /**
     * Fewest pixels of a cylinder; points for a cloud. Default 100.
     */
    uint64_t min_pixels;
    /**
     * The least score, in [0, 1]: the probability that there is a cylinder. Default 0.5.
     */
    double min_score;
    /**
     * The smallest radius, in the unit of length, which the search and the fits keep. Default 0 = no limit.
     */
    double radius_min;
    /**
     * The largest radius, at least `radius_min`; equal to it for a radius that is known. Default 0 = no limit.
     */
    double radius_max;
    /**
     * The middle of the cone of directions that the axes keep, in the reference frame and of any length. Default
     * {0, 0, 0} = all directions.
     */
    double axis[3];
    /**
     * The largest angle of an axis from `axis`, in radians from 0 to pi/2, whatever the signs; 0 for a direction that is
     * known. Default 0; must be 0 without `axis`.
     */
    double axis_max_angle;
} cylfuse_detector_options;

/**
 * The distortion of the lens. What the numbers in `cylfuse_intrinsics::distortion` mean.
 */
typedef int32_t cylfuse_distortion;
/**
 * A pinhole; all coefficients are 0.
 */
#define CYLFUSE_DISTORTION_NONE 0
/**
 * Brown and Conrady: k1 k2 p1 p2 k3 k4 k5 k6 in the order of OpenCV; the missing ones of a shorter list are
 * 0.
 */
#define CYLFUSE_DISTORTION_BROWN_CONRADY 1
/**
 * Kannala and Brandt, the fisheye model of OpenCV: k1 k2 k3 k4; the other coefficients are 0. Rays less than
 * 89 degrees from the axis.
 */
#define CYLFUSE_DISTORTION_KANNALA_BRANDT 2

/**
 * A camera as a calibration gives it. Pixel centres are at integer coordinates, as in OpenCV.
 */
typedef struct cylfuse_intrinsics {
    /**
     * `sizeof(cylfuse_intrinsics)`.
     */
    uint32_t struct_size;
    /**
     * What the numbers in `distortion` mean.
     */
    cylfuse_distortion distortion_model;
    /**
     * Width of the image in pixels, at least 1.
     */
    uint32_t width;
    /**
     * Height of the image in pixels, at least 1; both together at most 2^28 pixels.
     */
    uint32_t height;
    /**
     * Focal length in pixel widths, greater than 0.
     */
    double fx;
    /**
     * Focal length in pixel heights, greater than 0.
     */
    double fy;
    /**
     * Principal point in pixels from the centre of the first pixel, to the right.
     */
    double cx;
    /**
     * Principal point in pixels from the centre of the first pixel, down.
     */
    double cy;
    /**
     * Coefficients in the order of `distortion_model`; those that the model does not have are 0.
     */
    double distortion[8];
} cylfuse_intrinsics;

/**
 * The type of a coordinate.
 */
typedef int32_t cylfuse_scalar;
/**
 * `float`.
 */
#define CYLFUSE_SCALAR_F32 1
/**
 * `double`.
 */
#define CYLFUSE_SCALAR_F64 2

/**
 * A cloud in the caller's memory, organised (`height` > 1) or not. PCL: `data = &cloud[0].x`,
 * `point_stride = sizeof(PointT)`, width and height of the cloud.
 */
typedef struct cylfuse_points_view {
    /**
     * `sizeof(cylfuse_points_view)`.
     */
    uint32_t struct_size;
    /**
     * Type of the coordinates and weights.
     */
    cylfuse_scalar scalar;
    /**
     * x of the first point; y and z follow it. Any alignment. May be NULL when there are no points.
     */
    const void *data;
    /**
     * Columns of an organised cloud, or the number of points.
     */
    size_t width;
    /**
     * Rows of an organised cloud, else 1; 0 only when `width` is 0.
     */
    size_t height;
    /**
     * Bytes from a point to the next one in its row, negative too; 0 = 3 scalars.
     */
    ptrdiff_t point_stride;
    /**
     * Bytes from a row to the next one, negative too; 0 = `width` * `point_stride`.
     */
    ptrdiff_t row_stride;
    /**
     * Weight of the first point, 0 or greater; 0 drops the point. NULL = every weight is 1.
     */
    const void *weights;
    /**
     * Bytes from a weight to the next one in its row; 0 = 1 scalar.
     */
    ptrdiff_t weight_stride;
    /**
     * Bytes from a row of weights to the next one; 0 = `width` * `weight_stride`.
     */
    ptrdiff_t weight_row_stride;
    /**
     * x of the normal at the first point; y and z follow it, in the type of the coordinates. Normals have any
     * length and sign; one of length 0 or that is not finite counts as unknown. Only RANSAC uses them, and
     * only when all points come with normals. NULL = unknown.
     */
    const void *normals;
    /**
     * Bytes from a normal to the next one in its row; 0 = 3 scalars.
     */
    ptrdiff_t normal_stride;
    /**
     * Bytes from a row of normals to the next one; 0 = `width` * `normal_stride`.
     */
    ptrdiff_t normal_row_stride;
} cylfuse_points_view;

/**
 * How a depth is stored in a pixel.
 */
typedef int32_t cylfuse_depth_format;
/**
 * `uint16_t`; 0 and 65535 (too far) = no measurement.
 */
#define CYLFUSE_DEPTH_FORMAT_U16 1
/**
 * `float`; 0, negative or not finite = no measurement.
 */
#define CYLFUSE_DEPTH_FORMAT_F32 2

/**
 * A depth image in the caller's memory. The value is z, not the distance along the ray.
 */
typedef struct cylfuse_depth_view {
    /**
     * `sizeof(cylfuse_depth_view)`.
     */
    uint32_t struct_size;
    /**
     * Type of a pixel.
     */
    cylfuse_depth_format format;
    /**
     * The first pixel of the first row. Any alignment.
     */
    const void *data;
    /**
     * Columns; those of the intrinsics (of the depth camera where there is one).
     */
    uint32_t width;
    /**
     * Rows; likewise.
     */
    uint32_t height;
    /**
     * Bytes from a row to the next one, such as `step` of a `cv::Mat`, negative too; 0 = `width` *
     * `pixel_stride`.
     */
    ptrdiff_t row_stride;
    /**
     * Bytes from a pixel to the next one; 0 = the size of one.
     */
    ptrdiff_t pixel_stride;
    /**
     * Length of one unit of the stored value, greater than 0: 0.001 for millimetres when the unit of length is
     * the metre. `cylfuse_depth_view_init` sets 1: the unit of length is then that of the stored values, and nothing can
     * tell that another one was meant.
     */
    double scale;
    /**
     * The nearest depth that becomes a point, in the unit of length, 0 or greater. Both limits are those of the points,
     * and of the search of a detector: the extent is found with all depths.
     */
    double min_depth;
    /**
     * The farthest depth that becomes a point, in the unit of length; 0 = no limit.
     */
    double max_depth;
} cylfuse_depth_view;

/**
 * A mask in the caller's memory, one byte a pixel, on the pixels of the colour image: which pixels show the cylinder. It
 * may hold the lateral surface alone, or the whole object with caps, lids and handles: with the objective ROBUST a fit
 * leaves out what the depth image shows to be no part of the lateral surface. Its boundary may be some pixels off: it is a
 * hint and never measured.
 */
typedef struct cylfuse_mask_view {
    /**
     * `sizeof(cylfuse_mask_view)`.
     */
    uint32_t struct_size;
    /**
     * Columns.
     */
    uint32_t width;
    /**
     * Rows.
     */
    uint32_t height;
    /**
     * In an image of labels, that of the cylinder, 1 to 255: the pixels of this value are the mask. 0 = all pixels that
     * are not 0.
     */
    uint32_t label;
    /**
     * The first pixel of the first row.
     */
    const uint8_t *data;
    /**
     * Bytes from a row to the next one, negative too; 0 = `width` * `pixel_stride`.
     */
    ptrdiff_t row_stride;
    /**
     * Bytes from a pixel to the next one; 0 = 1.
     */
    ptrdiff_t pixel_stride;
} cylfuse_mask_view;

/**
 * How a pixel of an image is stored: one grey value, or three colours and perhaps a fourth byte (alpha), which is
 * ignored.
 */
typedef int32_t cylfuse_image_format;
/**
 * `uint8_t`.
 */
#define CYLFUSE_IMAGE_FORMAT_U8 1
/**
 * `uint16_t`.
 */
#define CYLFUSE_IMAGE_FORMAT_U16 2
/**
 * `float`, finite.
 */
#define CYLFUSE_IMAGE_FORMAT_F32 3
/**
 * Red, green, blue, each `uint8_t`.
 */
#define CYLFUSE_IMAGE_FORMAT_RGB8 4
/**
 * Blue, green, red, each `uint8_t`, as OpenCV reads image files.
 */
#define CYLFUSE_IMAGE_FORMAT_BGR8 5
/**
 * Red, green, blue, alpha, each `uint8_t`.
 */
#define CYLFUSE_IMAGE_FORMAT_RGBA8 6
/**
 * Blue, green, red, alpha, each `uint8_t`.
 */
#define CYLFUSE_IMAGE_FORMAT_BGRA8 7

/**
 * An image in the caller's memory, grey or in colour, on the pixels of the camera. Its values have no unit, but are
 * those of the light, as they are or with a gamma, not an equalised or filtered picture.
 */
typedef struct cylfuse_image_view {
    /**
     * `sizeof(cylfuse_image_view)`.
     */
    uint32_t struct_size;
    /**
     * Type of a pixel.
     */
    cylfuse_image_format format;
    /**
     * The first pixel of the first row. Any alignment.
     */
    const void *data;
    /**
     * Columns; must be those of the intrinsics.
     */
    uint32_t width;
    /**
     * Rows; must be those of the intrinsics.
     */
    uint32_t height;
    /**
     * Bytes from a row to the next one, such as `step` of a `cv::Mat`, negative too; 0 = `width` *
     * `pixel_stride`.
     */
    ptrdiff_t row_stride;
    /**
     * Bytes from a pixel to the next one; 0 = the size of one.
     */
    ptrdiff_t pixel_stride;
    /**
     * Light is the value to this power, from 0.1 to 10. Default 1: values linear in light; 2.2 is about sRGB. With
     * another one than 1 no value may be negative.
     */
    double gamma;
} cylfuse_image_view;

/**
 * Edge segments in the caller's memory: pieces of the two lines that bound the cylinder in the (distorted)
 * image. A `std::vector<cv::Vec4f>` can be passed unchanged.
 */
typedef struct cylfuse_segments_view {
    /**
     * `sizeof(cylfuse_segments_view)`.
     */
    uint32_t struct_size;
    /**
     * Type of the coordinates.
     */
    cylfuse_scalar scalar;
    /**
     * x1 of the first segment; y1, x2 and y2 follow it, in pixels. The endpoints may come in any order. Any
     * alignment. May be NULL when `count` is 0.
     */
    const void *data;
    /**
     * Number of segments.
     */
    size_t count;
    /**
     * Bytes from a segment to the next one, negative too; 0 = 4 scalars.
     */
    ptrdiff_t segment_stride;
    /**
     * `count` weights, from 0 to 1e9; 0 leaves the segment out. NULL = every weight is 1.
     */
    const double *weights;
} cylfuse_segments_view;

/**
 * A buffer for points in the caller's memory.
 */
typedef struct cylfuse_points_out {
    /**
     * `sizeof(cylfuse_points_out)`.
     */
    uint32_t struct_size;
    /**
     * Type of the coordinates.
     */
    cylfuse_scalar scalar;
    /**
     * Where x of the first point goes; y and z follow it, whatever else is in the buffer stays. Any alignment.
     * May be NULL when `capacity` is 0.
     */
    void *data;
    /**
     * Points that the buffer holds.
     */
    size_t capacity;
    /**
     * Bytes from a point to the next one (in its row), negative too; 0 = 3 scalars.
     */
    ptrdiff_t point_stride;
    /**
     * Bytes from a row to the next one in the layout ORGANISED, negative too; 0 = width * `point_stride`. Must be
     * 0 in the layout PACKED.
     */
    ptrdiff_t row_stride;
} cylfuse_points_out;

/**
 * A depth image to be written in the caller's memory. A pixel without depth becomes 0.
 */
typedef struct cylfuse_depth_out {
    /**
     * `sizeof(cylfuse_depth_out)`.
     */
    uint32_t struct_size;
    /**
     * Type of a pixel. A depth beyond the range of `uint16_t` becomes 0 and is counted.
     */
    cylfuse_depth_format format;
    /**
     * The first pixel of the first row. Any alignment.
     */
    void *data;
    /**
     * Columns of the buffer; must be those of the intrinsics.
     */
    uint32_t width;
    /**
     * Rows of the buffer; must be those of the intrinsics.
     */
    uint32_t height;
    /**
     * Bytes from a row to the next one, negative too; 0 = `width` * `pixel_stride`.
     */
    ptrdiff_t row_stride;
    /**
     * Bytes from a pixel to the next one; 0 = the size of one.
     */
    ptrdiff_t pixel_stride;
    /**
     * Length of one unit of the stored value, greater than 0: z = value * `scale`.
     */
    double scale;
} cylfuse_depth_out;

/**
 * What was pushed into one view, and what was left out by reason.
 */
typedef struct cylfuse_counts {
    /**
     * The room in bytes; as output the bytes that were filled.
     */
    uint32_t struct_size;
    /**
     * The view that the counts are of.
     */
    uint32_t view;
    /**
     * Points and pixels that were pushed.
     */
    uint64_t points_given;
    /**
     * Points that a fit uses.
     */
    uint64_t points_used;
    /**
     * Left out: a coordinate or weight is not finite.
     */
    uint64_t dropped_not_finite;
    /**
     * Left out: the weight is 0.
     */
    uint64_t dropped_zero_weight;
    /**
     * Left out: the mask is 0 there.
     */
    uint64_t dropped_outside_mask;
    /**
     * Left out: no depth was measured there.
     */
    uint64_t dropped_no_depth;
    /**
     * Left out: the depth is below `min_depth` or above `max_depth`.
     */
    uint64_t dropped_out_of_range;
    /**
     * Left out: the camera model has no ray for the pixel.
     */
    uint64_t dropped_outside_camera;
    /**
     * Left out: the mask is set there, but the colour camera sees something nearer. Only with a depth camera of its own.
     */
    uint64_t dropped_hidden;
    /**
     * Edge segments that were pushed; `segments_used` of a result says how many count.
     */
    uint64_t segments_given;
} cylfuse_counts;

/**
 * Warnings about a result, one bit each. None of them is an error: the numbers of the result say how much it matters.
 */
typedef uint32_t cylfuse_result_flags;
/**
 * Segments were given but none of them counts; the other flags and the counts say why.
 */
#define CYLFUSE_RESULT_FLAGS_EDGES_IGNORED 1
/**
 * Some segments have no length or lie outside the field of the camera model.
 */
#define CYLFUSE_RESULT_FLAGS_SEGMENTS_UNUSABLE 2
/**
 * Two segments cross each other: they cannot be the two limbs.
 */
#define CYLFUSE_RESULT_FLAGS_EDGES_CROSS 4
/**
 * Two segments lie on one line to within 2 pixels: they are the same limb.
 */
#define CYLFUSE_RESULT_FLAGS_EDGES_COINCIDE 8
/**
 * The rays of the endpoints do not meet the plane of the limbs in front of the camera.
 */
#define CYLFUSE_RESULT_FLAGS_EDGES_BEHIND 16
/**
 * The edges alone (an edge weight of 1) do not tell the scale: that of the start was kept.
 */
#define CYLFUSE_RESULT_FLAGS_SCALE_HELD 32
/**
 * The data hardly determine the radius: see `radius_deviation`.
 */
#define CYLFUSE_RESULT_FLAGS_WEAK_RADIUS 64
/**
 * The coordinates are coarser than 0.01 % of the radius: a float cloud far from the origin.
 */
#define CYLFUSE_RESULT_FLAGS_RESOLUTION_LOST 128
/**
 * The limit of iterations came before convergence. Of a cylinder of a scene also: its depth came without an image,
 * no work was left for its fit (see `cylfuse_detector_is_complete`), or no fit was as good, and it is what the search found.
 */
#define CYLFUSE_RESULT_FLAGS_NOT_CONVERGED 256
/**
 * Most points lie on the wall that the camera cannot see.
 */
#define CYLFUSE_RESULT_FLAGS_HIDDEN_WALL 512
/**
 * The camera is inside the cylinder: there are no limbs.
 */
#define CYLFUSE_RESULT_FLAGS_CAMERA_INSIDE 1024
/**
 * Points with coordinates that are not finite were left out.
 */
#define CYLFUSE_RESULT_FLAGS_POINTS_NOT_FINITE 2048
/**
 * The radius by the points alone and the radius by the limbs differ by more than 4 standard deviations:
 * `radius_from_points` and `radius_from_limbs` say how. An offset of the depth, depth that is smeared or bent,
 * wrong intrinsics or edges that are not the limbs do that. Or the points alone, far from edges that were taken
 * as given, would be another cylinder: one 1.5 times nearer to them, or surely 1.5 times as large or as small. Or a
 * line that was located as a limb lies beside that of the result, by more than 4 of its standard deviations and a
 * pixel. Or located limbs would raise the scale of the points 1.5 times, given edges 3 times, and were not followed.
 */
#define CYLFUSE_RESULT_FLAGS_POINTS_AND_LIMBS_DISAGREE 4096
/**
 * The radius is at its limit, and the data fit better beyond it. Of a radius that is known: the data contradict it by
 * more than 4 standard deviations.
 */
#define CYLFUSE_RESULT_FLAGS_RADIUS_AT_LIMIT 8192
/**
 * The axis is on the border of its cone, and the data fit better beyond it. Of a known direction: the data contradict
 * it by more than 4 standard deviations.
 */
#define CYLFUSE_RESULT_FLAGS_AXIS_AT_LIMIT 16384
/**
 * The data do not tell how uncertain the result is, and deviations and covariance are NaN: fewer than eight points
 * are independent, some degree of freedom is not determined, the coordinates are coarser than the noise of the points
 * (RESOLUTION_LOST), or most points lie on the cylinder to the last digit and more than a tenth do not, as of a few
 * pixels of depth in coarse steps. Only with the methods FUSED and POINTS: the others never state an uncertainty.
 */
#define CYLFUSE_RESULT_FLAGS_UNCERTAINTY_UNKNOWN 32768
/**
 * Depth and image are shifted against each other across the axis, by a wrong registration or wrong principal points:
 * the points lie beside the middle of the limbs by more than 3 standard deviations. Or one of the limbs is the edge of
 * something else, such as a neighbour that touches, and the radius is wrong. From a detector also: the whole depth image
 * was shifted, and has been moved to where the image shows the same bodies.
 */
#define CYLFUSE_RESULT_FLAGS_DEPTH_SHIFTED 65536
/**
 * A mask holds the pixels that have depth and no others, although depth is missing around it, as it is beside the limbs
 * of a curved surface: its sides are no hint where the limbs are. With an image they were drawn again about the
 * cylinder of a first fit; a mask of the whole surface is more certain.
 */
#define CYLFUSE_RESULT_FLAGS_MASK_ENDS_WITH_DEPTH 131072
/**
 * The points do not lie on the cylinder, so its numbers mean nothing: `point_deviation` is more than 1 % of their
 * distance from the camera, and more than three times `depth_noise` of the options where that is set; without a
 * camera, more than a quarter of the radius. A mask that holds much else than the cylinder does that, or wrong poses.
 * Or what they leave has a shape along the axis that no cylinder has, as a bent pipe or a sphere does. Or they lie on two
 * planes, as the sides of a box do. Or points without a mask lie on several surfaces: the cylinder has less than half
 * of those that are on no plane or less than a quarter of all, or a plane holds a quarter of its own. Or they are off the
 * cylinder together by a twentieth of the radius: fewer than a fiftieth of them are independent.
 */
#define CYLFUSE_RESULT_FLAGS_POOR_FIT 262144
/**
 * The lines that the image shows of both limbs turn against each other, so that the radius changes along the axis: by more
 * than 3 standard deviations with 0.3 % of the length added for the lens. The body is no cylinder, or one of the lines
 * is no limb. Or, where fewer than two limbs of a view were located or given, the sides of the mask converge: by more
 * than 3 standard deviations, and by a slope of the radius of more than 0.05. Or points without a camera tell it, as the limbs do:
 * seen from one side, their axis may tilt by as much as the radius changes, which is in its stated deviation.
 */
#define CYLFUSE_RESULT_FLAGS_BODY_TAPERS 524288
/**
 * The mask ends beside a limb of the cylinder along most of the axis: by more than masks are off (5 pixels of an
 * image of 640 x 480, or three times `mask_noise` where that is more), by more than 3 standard deviations of the radius,
 * and not because something in front or the border of the image ends it. Depth and image are misaligned, the depth is
 * smeared beyond the body, or the mask holds something else. Only where fewer than two limbs of a view were located or
 * given. Or no limb was seen, and the radius by the sides of the mask and that by the points differ by more than 2.5
 * standard deviations, or the points would scatter 3 times as much if the sides were followed. Or the mask holds another
 * body: more than a tenth of its pixels, without those beside its outline, have points outside of the cylinder and of its
 * lids and rings. Where an image but no mask was pushed, that is said of the points. The sides are not checked of a mask
 * that ends where the depth does (MASK_ENDS_WITH_DEPTH) or was made of the points. Nothing is checked of the region of a
 * detector, nor where the camera is inside the cylinder.
 */
#define CYLFUSE_RESULT_FLAGS_MASK_DISAGREES 1048576

/**
 * Why an iteration ended.
 */
typedef int32_t cylfuse_termination;
/**
 * There was no iteration: the method has none, or a given model was evaluated.
 */
#define CYLFUSE_TERMINATION_NONE 0
/**
 * The cost no longer fell by more than the tolerance, or reached the rounding error of the data.
 */
#define CYLFUSE_TERMINATION_COST 1
/**
 * No step down to the largest damping lowered the cost: a minimum to rounding.
 */
#define CYLFUSE_TERMINATION_STALLED 2
/**
 * The limit of iterations was reached; `CYLFUSE_RESULT_FLAGS_NOT_CONVERGED` is set too.
 */
#define CYLFUSE_TERMINATION_MAX_ITERATIONS 3
/**
 * The radius left all proportion to the data: they are flat.
 */
#define CYLFUSE_TERMINATION_RADIUS_RAN_AWAY 4
/**
 * The gradient fell below its tolerance.
 */
#define CYLFUSE_TERMINATION_GRADIENT 5
/**
 * The step fell below its tolerance.
 */
#define CYLFUSE_TERMINATION_STEP 6

/**
 * The outcome of a fit with the numbers to judge it, whatever shape was fitted. NaN stands for what does not apply.
 * The shape itself is in a struct of its own: `cylfuse_cylinder_estimate`.
 */
typedef struct cylfuse_result {
    /**
     * The room in bytes; as output the bytes that were filled.
     */
    uint32_t struct_size;
    /**
     * Warnings, `CYLFUSE_RESULT_FLAGS_...` by bit; 0 when there are none.
     */
    cylfuse_result_flags flags;
    /**
     * Why the iteration ended.
     */
    cylfuse_termination termination;
    /**
     * Iterations: linear systems that were solved.
     */
    uint32_t iterations;
    /**
     * Solves whose step was rejected.
     */
    uint32_t rejected_steps;
    /**
     * Limb lines that were located in the images and took part, at most 2 a view.
     */
    uint32_t limbs_located;
    /**
     * Edge segments that were pushed.
     */
    uint32_t segments_given;
    /**
     * Edge segments that took part.
     */
    uint32_t segments_used;
    /**
     * Points that were pushed; `cylfuse_fitter_counts` says why some were left out.
     */
    uint64_t points_given;
    /**
     * Points that took part.
     */
    uint64_t points_used;
    /**
     * How many points with independent noise the points of all views are worth: the noise of neighbours in a depth
     * image is alike.
     */
    double independent_points;
    /**
     * Standard deviation of the points from the surface by their median, unit of length: points beyond some of it lose
     * their weight in the objective ROBUST.
     */
    double point_deviation;
    /**
     * Root mean square distance of the points from the surface, unit of length.
     */
    double point_rms;
    /**
     * Root mean square distance of the given endpoints from the limb lines in ideal pixels; NaN without edges.
     */
    double edge_rms_pixels;
    /**
     * The part of the points on the wall that the camera sees; NaN when the origin is no camera.
     */
    double near_wall_fraction;
    /**
     * Cost of the start, unit of length squared.
     */
    double initial_cost;
    /**
     * Cost of the outcome, unit of length squared.
     */
    double cost;
    /**
     * E_P: mean squared distance of the points from the surface, unit of length squared.
     */
    double energy_points;
    /**
     * E_L: mean squared distance of the back-projected endpoints from the limb lines, unit of length squared;
     * NaN without exactly two usable segments.
     */
    double energy_edges;
    /**
     * The edge weight that was used, 0 when no edges count; NaN where the objective has none.
     */
    double edge_weight;
    /**
     * Condition number of the Jacobian at the outcome, in units of the size of the data; may be infinite.
     */
    double condition;
    /**
     * Norm of half the gradient of the cost at the end, as far as the limits leave it free, in units of the size of
     * the data.
     */
    double gradient_norm;
    /**
     * Norm of the last accepted step, in units of the size of the data.
     */
    double step_norm;
    /**
     * The last damping.
     */
    double lambda;
    /**
     * Wall-clock seconds to find the start.
     */
    double seconds_start;
    /**
     * Wall-clock seconds to iterate.
     */
    double seconds_solve;
    /**
     * Wall-clock seconds of the whole fit.
     */
    double seconds_total;
} cylfuse_result;

/**
 * An infinite cylinder, in the order of the coefficients of PCL's cylinder model. This struct never changes.
 */
typedef struct cylfuse_cylinder {
    /**
     * A point on the axis, in the unit of length of the data.
     */
    double point[3];
    /**
     * The direction of the axis. As input of any length but 0, as output of length 1. Its sign has no meaning;
     * the library gives the one with a positive largest component.
     */
    double direction[3];
    /**
     * The radius in the unit of length of the data, greater than 0.
     */
    double radius;
} cylfuse_cylinder;

/**
 * The cylinder that a fit found, how certain it is, and where the iteration started.
 *
 * Deviations and covariance are those of the noise of the data, with the weights that were used and the correlation
 * of neighbouring depths. With the method FUSED and the objective ROBUST they also have the errors that all points of a
 * view share and `depth_shared` of the options states: by default 0.2 % of the depth, as a bend of the profile, an offset
 * and a tilt. Errors of the calibration, the registration and a scale of the depth are not in them. All
 * deviations of the interface are standard deviations: for an expanded uncertainty with the coverage factor k = 2,
 * as calibration certificates state it, multiply by 2. NaN for RANSAC and EBERLY, for an edge weight of 1, and where
 * the data do not determine the number.
 */
typedef struct cylfuse_cylinder_estimate {
    /**
     * The room in bytes; as output the bytes that were filled.
     */
    uint32_t struct_size;
    /**
     * How the start was found.
     */
    cylfuse_start start_kind;
    /**
     * The cylinder, its axis point the one nearest to the middle of the points.
     */
    struct cylfuse_cylinder model;
    /**
     * The cylinder that the iteration started from, moved into the limits.
     */
    struct cylfuse_cylinder start_model;
    /**
     * Standard deviation of the radius, unit of length.
     */
    double radius_deviation;
    /**
     * Standard deviation of the direction in radians: the tilt in the plane in which it is least certain.
     */
    double direction_deviation;
    /**
     * Standard deviation of the position of the axis across itself, at `model.point` and in the direction in which it
     * is least certain, unit of length.
     */
    double position_deviation;
    /**
     * The radius by the curvature of the points alone, unit of length; NaN without segments or limbs, and where the
     * points alone determine no cylinder.
     */
    double radius_from_points;
    /**
     * Its standard deviation.
     */
    double radius_from_points_deviation;
    /**
     * The radius by the limbs, with distance and tilt of the axis from the points, unit of length; NaN likewise.
     */
    double radius_from_limbs;
    /**
     * Its standard deviation.
     */
    double radius_from_limbs_deviation;
    /**
     * `radius_from_points` minus `radius_from_limbs` in standard deviations of the difference; beyond 4 the flag
     * POINTS_AND_LIMBS_DISAGREE is set.
     */
    double radius_z_score;
    /**
     * Covariance of (`model.point`, `model.direction`, `model.radius`), 7 x 7, symmetric, of rank 5; `[7 * i + j]` is
     * that of the numbers i and j.
     */
    double covariance[49];
} cylfuse_cylinder_estimate;

/**
 * What the data determine at a cylinder: the singular values of the stacked Jacobian of the five degrees of
 * freedom, in units of the size of the data.
 */
typedef struct cylfuse_cylinder_diagnosis {
    /**
     * The room in bytes; as output the bytes that were filled.
     */
    uint32_t struct_size;
    /**
     * How many singular values stand out of the rounding error; 5 when everything is determined.
     */
    uint32_t rank;
    /**
     * Singular values, the largest first.
     */
    double singular_values[5];
    /**
     * Largest over smallest singular value; may be infinite.
     */
    double condition;
    /**
     * How the step along which the residuals change least moves the axis at the middle of the points, in the unit of
     * length.
     */
    double weakest_shift[3];
    /**
     * How that step tilts the axis, in radians towards this vector.
     */
    double weakest_tilt[3];
    /**
     * How that step changes the radius, in the unit of length. Shift and radius over the size of the data and the tilt
     * have a joint norm of 1.
     */
    double weakest_radius;
} cylfuse_cylinder_diagnosis;

/**
 * What became of the pixels of a completion.
 */
typedef struct cylfuse_completion {
    /**
     * The room in bytes; as output the bytes that were filled.
     */
    uint32_t struct_size;
    /**
     * The view whose pixels were completed.
     */
    uint32_t view;
    /**
     * Points or pixels that were written; after `CYLFUSE_STATUS_BUFFER_TOO_SMALL` the capacity that is needed.
     */
    uint64_t count;
    /**
     * Pixels of the mask whose ray meets the cylinder.
     */
    uint64_t hits;
    /**
     * Pixels of the mask whose ray passes the cylinder by.
     */
    uint64_t misses;
    /**
     * Pixels of the mask for which the camera model has no ray.
     */
    uint64_t outside_camera;
    /**
     * Hits whose depth does not fit the pixel format: written as 0 and not in `count`. Hits whose point does not fit the
     * scalar: as if there were none.
     */
    uint64_t out_of_range;
} cylfuse_completion;

/**
 * What an end of the visible cylinder is.
 */
typedef int32_t cylfuse_end_state;
/**
 * No depth was measured beyond the end, or nothing tells what lies beyond, or no depth image was pushed.
 */
#define CYLFUSE_END_STATE_UNKNOWN 0
/**
 * The surface ends there: what lies beyond is farther than the surface would be.
 */
#define CYLFUSE_END_STATE_SEEN 1
/**
 * The border of the image cuts the cylinder off.
 */
#define CYLFUSE_END_STATE_CUT 2
/**
 * Something nearer than the surface covers what lies beyond.
 */
#define CYLFUSE_END_STATE_HIDDEN 3

/**
 * What the position of an end was taken from.
 */
typedef int32_t cylfuse_end_source;
/**
 * The extreme point completed over the mask: by the extent rule EXTREMES, or where no line along the surface ends in
 * the mask.
 */
#define CYLFUSE_END_SOURCE_EXTREME 0
/**
 * Where the lines along the surface leave the mask, or where within the mask the depth shows that the body ends: at a cap,
 * an opening, a shoulder or a narrower part. Also where the image shows an arc that is less certain than that.
 */
#define CYLFUSE_END_SOURCE_MASK 1
/**
 * Mostly the arc of the end circle in the image: it is joined with mask and depth by the variances, and is the more
 * certain.
 */
#define CYLFUSE_END_SOURCE_IMAGE 2
/**
 * The last of the surface inside the border of the image.
 */
#define CYLFUSE_END_SOURCE_BORDER 3
/**
 * The points on the surface, where there is no mask, and from inside a pipe.
 */
#define CYLFUSE_END_SOURCE_POINTS 4

/**
 * The visible piece of the cylinder: `end` = `start` + `length` * direction of the model.
 */
typedef struct cylfuse_extent {
    /**
     * The room in bytes; as output the bytes that were filled.
     */
    uint32_t struct_size;
    /**
     * What the end against the direction is.
     */
    cylfuse_end_state start_state;
    /**
     * What the end along the direction is.
     */
    cylfuse_end_state end_state;
    /**
     * What the position of the start was taken from.
     */
    cylfuse_end_source start_source;
    /**
     * What the position of the end was taken from.
     */
    cylfuse_end_source end_source;
    /**
     * The view that determines the start best.
     */
    uint32_t start_view;
    /**
     * The view that determines the end best.
     */
    uint32_t end_view;
    /**
     * 1 when the limbs of the model were taken as good to a fraction of a pixel in these views, so that the bias of
     * the mask was read off at them; else 0.
     */
    uint32_t limbs_known;
    /**
     * The end against the direction, a point on the axis.
     */
    double start[3];
    /**
     * The end along the direction, a point on the axis.
     */
    double end[3];
    /**
     * The middle of the ends.
     */
    double center[3];
    /**
     * The distance of the ends.
     */
    double length;
    /**
     * Standard deviation of the position of the start along the axis, for a model without error; NaN for an extreme
     * position. Of a start that is not SEEN it is that of the visible piece: the cylinder may well go on.
     */
    double start_deviation;
    /**
     * The same for the end.
     */
    double end_deviation;
    /**
     * Standard deviation of the length together with the uncertainty of the fit, of the visible piece. This and what
     * follows is NaN for a model that was given, for extreme positions and when the fit has no uncertainty.
     */
    double length_deviation;
    /**
     * Covariance of `start`, 3 x 3, symmetric, unit of length squared.
     */
    double start_covariance[9];
    /**
     * Covariance of `end`.
     */
    double end_covariance[9];
    /**
     * Covariance of `center`.
     */
    double center_covariance[9];
} cylfuse_extent;

/**
 * Data of a view, one bit each.
 */
typedef uint32_t cylfuse_input;
/**
 * All points: those of clouds and those that were made of depth images.
 */
#define CYLFUSE_INPUT_POINTS 1
/**
 * The depth image and its mask, which completion and extent look at; the points that were made of it stay.
 */
#define CYLFUSE_INPUT_DEPTH 2
/**
 * Edge segments, of `cylfuse_fitter_push_edges`.
 */
#define CYLFUSE_INPUT_EDGES 4
/**
 * The image, of `cylfuse_fitter_push_image` and of a frame.
 */
#define CYLFUSE_INPUT_IMAGE 8

/**
 * What a fit is doing.
 */
typedef int32_t cylfuse_phase;
/**
 * It is about to look for a start, or looks for one and asks whether to go on.
 */
#define CYLFUSE_PHASE_START 1
/**
 * It iterates, or asks after an iteration whether to go on: the last state is reported again then.
 */
#define CYLFUSE_PHASE_SOLVE 2

/**
 * The state of a running fit, before each iteration.
 */
typedef struct cylfuse_progress {
    /**
     * Size of this struct in the library: fields beyond it are not there.
     */
    uint32_t struct_size;
    /**
     * What the fit is doing.
     */
    cylfuse_phase phase;
    /**
     * Iterations so far. Begins again at 0 with every start that is tried and every robust round.
     */
    uint32_t iteration;
    /**
     * Maximum number of iterations.
     */
    uint32_t max_iterations;
    /**
     * The lowest cost so far, unit of length squared; infinite in the phase START.
     */
    double cost;
    /**
     * The damping of the next step; 0 in the phase START.
     */
    double lambda;
    /**
     * The best cylinder so far, valid until the callback returns; NULL in the phase START.
     */
    const struct cylfuse_cylinder *cylinder;
} cylfuse_progress;

/**
 * Called before every iteration of a fit, on the thread that called `cylfuse_fitter_fit`, and with the last one again
 * between the other steps of the fit.
 *
 * It must not throw, unwind or longjmp. Of the functions on the same fitter it may only call
 * `cylfuse_fitter_cancel` and `cylfuse_fitter_last_error`: all others return BUSY. Other fitters are free.
 *
 * @param progress valid until the callback returns
 * @param user_data what was given with the callback
 * @return 0 to go on; anything else stops the fit, which returns CANCELLED
 */
typedef int32_t (*cylfuse_progress_fn)(const struct cylfuse_progress *progress, void *user_data);

/**
 * How much a log line matters.
 */
typedef int32_t cylfuse_log_level;
/**
 * No lines.
 */
#define CYLFUSE_LOG_LEVEL_OFF 0
/**
 * Calls that failed, with the text of `cylfuse_fitter_last_error`.
 */
#define CYLFUSE_LOG_LEVEL_ERROR 1
/**
 * Warnings about a result, such as ignored edges.
 */
#define CYLFUSE_LOG_LEVEL_WARNING 2
/**
 * What was pushed, which start was taken, how a fit ended.
 */
#define CYLFUSE_LOG_LEVEL_INFO 3
/**
 * Every iteration.
 */
#define CYLFUSE_LOG_LEVEL_DEBUG 4

/**
 * Takes a log line, on the thread that called the function: on several at once when several threads make calls with
 * a `const cylfuse_fitter *`. It must not throw, unwind or longjmp, nor call functions on the same fitter but
 * `cylfuse_fitter_cancel` and `cylfuse_fitter_last_error`.
 *
 * @param level how much it matters
 * @param message one line without a line break, valid until the callback returns
 * @param user_data what was given with the callback
 */
typedef void (*cylfuse_log_fn)(cylfuse_log_level level, const char *message, void *user_data);

/**
 * What a detector is doing.
 */
typedef int32_t cylfuse_detection_phase;
/**
 * It is about to look for cylinders.
 */
#define CYLFUSE_DETECTION_PHASE_SEARCH 1
/**
 * It fits those that were found.
 */
#define CYLFUSE_DETECTION_PHASE_FIT 2

/**
 * How far a detector is.
 */
typedef struct cylfuse_detection_progress {
    /**
     * The size of this struct in the library that calls: later fields exist when it is large enough.
     */
    uint32_t struct_size;
    /**
     * What it is doing.
     */
    cylfuse_detection_phase phase;
    /**
     * Cylinders that are fitted.
     */
    uint32_t fits_done;
    /**
     * Cylinders to fit; 0 before the search.
     */
    uint32_t fits;
} cylfuse_detection_progress;

/**
 * Is called with the progress of a detector: before the search, after it, and after each fit, on the thread that
 * called `cylfuse_detector_detect` or `cylfuse_detector_detect_points`. A cloud that was not seen from its origin is
 * searched from many places, and phase and counts begin again with each.
 *
 * It must not throw, unwind or longjmp. Of the functions on the same detector it may only call
 * `cylfuse_detector_cancel` and `cylfuse_detector_last_error`: all others return BUSY. Other detectors and all fitters
 * are free.
 *
 * @param progress valid until the callback returns
 * @param user_data what was given with the callback
 * @return 0 to go on; anything else stops the search, which returns CANCELLED
 */
typedef int32_t (*cylfuse_detection_progress_fn)(const struct cylfuse_detection_progress *progress,
                                                 void *user_data);

/**
 * A cylinder of a scene. Elements of an array: their size is an argument of the call, and only ever grows.
 */
typedef struct cylfuse_detection {
    /**
     * The probability that there is a cylinder.
     */
    double score;
    /**
     * Pixels of its region; points for a cloud. Of a cloud that was seen from its origin the fit takes those within 0.7
     * radii of the axis, where these are most: next to limbs sensors draw points out.
     */
    uint64_t pixels;
    /**
     * The cylinder that was fitted, as in its `cylfuse_cylinder_estimate`.
     */
    struct cylfuse_cylinder model;
} cylfuse_detection;

/**
 * Is called after each fit of `cylfuse_fit_all`, in the order in which they end, on the thread that called it.
 *
 * It must not throw, unwind or longjmp. It may call functions on fitters whose fit has ended, such as
 * `cylfuse_fitter_get_result` on this one; the others may be BUSY.
 *
 * @param index the index of the fitter
 * @param status what `cylfuse_fitter_fit` would have returned for it
 * @param user_data what was given with the callback
 * @return 0 to go on; anything else stops the fits that run, and no other begins
 */
typedef int32_t (*cylfuse_fit_all_fn)(size_t index, cylfuse_status status, void *user_data);

/**
 * Which residuals to list.
 */
typedef int32_t cylfuse_residual_kind;
/**
 * Signed distance of every used point from the surface, in the unit of length, negative inside; in the order
 * in which the points were pushed, without the dropped ones.
 */
#define CYLFUSE_RESIDUAL_KIND_POINTS 1
/**
 * Signed distance of both endpoints of every used segment from its limb line, in ideal pixels.
 */
#define CYLFUSE_RESIDUAL_KIND_EDGES 2

/**
 * What a point in the mask belongs to.
 */
typedef uint8_t cylfuse_part;
/**
 * The lateral surface.
 */
#define CYLFUSE_PART_BODY 1
/**
 * A cap: it lies in the plane across the axis at an end.
 */
#define CYLFUSE_PART_CAP 2
/**
 * The inside of the cylinder, seen through an open end: its inner wall or its bottom.
 */
#define CYLFUSE_PART_INNER_WALL 3
/**
 * Something nearer than the surface: a lid or a rim that is wider, a handle, what stands in front.
 */
#define CYLFUSE_PART_OTHER 4
/**
 * Something farther away than the cylinder: the background.
 */
#define CYLFUSE_PART_BEHIND 5

/**
 * Whether a limb was located in the image, or why not.
 */
typedef int32_t cylfuse_limb_status;
/**
 * It was located.
 */
#define CYLFUSE_LIMB_STATUS_LOCATED 0
/**
 * The image was not searched: there is none, the edges were taken as given, or the objective does not look.
 */
#define CYLFUSE_LIMB_STATUS_NOT_SEARCHED 1
/**
 * The cylinder has no limbs in front of the camera: the camera is inside it, or it lies behind.
 */
#define CYLFUSE_LIMB_STATUS_NO_LIMBS 2
/**
 * Fewer than 12 rows or columns of the image show the limb, or something in front covers it.
 */
#define CYLFUSE_LIMB_STATUS_TOO_SHORT 3
/**
 * No line near the expected position has more of an edge than noise gives.
 */
#define CYLFUSE_LIMB_STATUS_NO_EDGE 4
/**
 * The line left the expected position while it was refined, or lies beside the mask.
 */
#define CYLFUSE_LIMB_STATUS_OUT_OF_REACH 5
/**
 * The line would be less certain than one set by hand, or what is there is softer than any limb.
 */
#define CYLFUSE_LIMB_STATUS_UNCERTAIN 6
/**
 * A small part of the line carries it all.
 */
#define CYLFUSE_LIMB_STATUS_PATCHY 7
/**
 * The other limb was found at the same position, and more certainly.
 */
#define CYLFUSE_LIMB_STATUS_SAME_LINE 8

/**
 * A limb of the cylinder in the image of one view: where it was located, or why it was not.
 *
 * An element of the array that `cylfuse_fitter_limbs` writes.
 */
typedef struct cylfuse_limb {
    /**
     * The view, from 0.
     */
    uint32_t view;
    /**
     * The limb, 0 or 1, in the order of `cylfuse_cylinder_project`.
     */
    uint32_t limb;
    /**
     * Whether the limb was located, or why not.
     */
    cylfuse_limb_status status;
    /**
     * How many pieces of it `cylfuse_fitter_limb_samples` lists.
     */
    uint32_t samples;
    /**
     * x1 y1 x2 y2: the two points of the located line whose errors across it are independent and equally large,
     * in ideal pixels. They need not lie on the part that was seen. NaN when the limb was not located.
     */
    double line[4];
    /**
     * Standard deviation of either point across the line, in ideal pixels; NaN when the limb was not located.
     */
    double deviation;
} cylfuse_limb;

/**
 * What a short piece of a limb in the image says.
 *
 * An element of the array that `cylfuse_fitter_limb_samples` writes.
 */
typedef struct cylfuse_limb_sample {
    /**
     * The view, from 0.
     */
    uint32_t view;
    /**
     * The limb that it belongs to, 0 or 1, in the order of `cylfuse_cylinder_project`.
     */
    uint32_t limb;
    /**
     * Where the limb is seen, x and y in pixels of the (distorted) image.
     */
    double pixel[2];
    /**
     * Standard deviation across the limb in ideal pixels, by the noise of the image only.
     */
    double deviation;
    /**
     * Its part in the line, from 1 down to 0 for a refused sample.
     */
    double weight;
} cylfuse_limb_sample;

/**
 * A sample on the arc of an end of the cylinder in the image.
 *
 * An element of the array that `cylfuse_fitter_end_samples` writes.
 */
typedef struct cylfuse_end_sample {
    /**
     * The view, from 0.
     */
    uint32_t view;
    /**
     * 0 for the start of the extent, 1 for its end.
     */
    uint32_t end;
    /**
     * Where the arc is seen, x and y in pixels of the (distorted) image.
     */
    double pixel[2];
    /**
     * The unit vector across the arc in the image, away from the surface.
     */
    double normal[2];
    /**
     * Standard deviation along `normal`, in pixels.
     */
    double deviation;
} cylfuse_end_sample;

/**
 * How the points of an output buffer are arranged.
 */
typedef int32_t cylfuse_layout;
/**
 * Only the points that exist, one after the other, row by row of the image.
 */
#define CYLFUSE_LAYOUT_PACKED 0
/**
 * One point for each pixel of the image, NaN where there is none.
 */
#define CYLFUSE_LAYOUT_ORGANISED 1

/**
 * What a measurement says about a tolerance.
 */
typedef int32_t cylfuse_conformity;
/**
 * The measurement does not tell: its uncertainty reaches over a limit or is not known, or a warning puts it in
 * doubt.
 */
#define CYLFUSE_CONFORMITY_UNDECIDED 0
/**
 * The value is within the limits with all of its uncertainty.
 */
#define CYLFUSE_CONFORMITY_CONFORMING 1
/**
 * The value is outside the limits with all of its uncertainty.
 */
#define CYLFUSE_CONFORMITY_NOT_CONFORMING 2

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The `CYLFUSE_ABI_VERSION` of the loaded library.
 */
CYLFUSE_API uint32_t cylfuse_abi_version(void) CYLFUSE_NOEXCEPT;

/**
 * The version of the loaded library as a number, major * 65536 + minor * 256 + patch: compare it with
 * `CYLFUSE_VERSION_NUMBER`, the version that the program was compiled for.
 */
CYLFUSE_API uint32_t cylfuse_version_number(void) CYLFUSE_NOEXCEPT;

/**
 * The version of the loaded library as text, such as "0.2.0". Static.
 */
CYLFUSE_API const char *cylfuse_version_string(void) CYLFUSE_NOEXCEPT;

/**
 * How the library was built: version, target, profile, compiler, features. Static, for reports of defects.
 */
CYLFUSE_API const char *cylfuse_build_info(void) CYLFUSE_NOEXCEPT;

/**
 * The name of a status without its prefix, a colon, and what it means in a few words. Static; a text for
 * unknown numbers too.
 */
CYLFUSE_API const char *cylfuse_status_string(cylfuse_status status) CYLFUSE_NOEXCEPT;

/**
 * Fills options with the defaults.
 *
 * @param options what to fill
 * @param struct_size `sizeof(cylfuse_options)`
 * @return STRUCT_SIZE for a size that cannot be, and then nothing is written
 */
CYLFUSE_API
cylfuse_status cylfuse_options_init(struct cylfuse_options *options,
                                    size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills options of a detector with the defaults.
 *
 * @param options what to fill
 * @param struct_size `sizeof(cylfuse_detector_options)`
 * @return STRUCT_SIZE for a size that cannot be, and then nothing is written
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_options_init(struct cylfuse_detector_options *options,
                                             size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills intrinsics with zeros: a pinhole, whose size, focal lengths and principal point the caller sets.
 *
 * @param intrinsics what to fill
 * @param struct_size `sizeof(cylfuse_intrinsics)`
 */
CYLFUSE_API
cylfuse_status cylfuse_intrinsics_init(struct cylfuse_intrinsics *intrinsics,
                                       size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills a view of points with zeros and a height of 1: packed points without weights, whose scalar, data and
 * width the caller sets.
 *
 * @param points what to fill
 * @param struct_size `sizeof(cylfuse_points_view)`
 */
CYLFUSE_API
cylfuse_status cylfuse_points_view_init(struct cylfuse_points_view *points,
                                        size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills a view of a depth image with zeros and a scale of 1: packed, without limits of the depth; the caller
 * sets format, data and size.
 *
 * @param depth what to fill
 * @param struct_size `sizeof(cylfuse_depth_view)`
 */
CYLFUSE_API
cylfuse_status cylfuse_depth_view_init(struct cylfuse_depth_view *depth,
                                       size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills a view of a mask with zeros: packed; the caller sets data and size.
 *
 * @param mask what to fill
 * @param struct_size `sizeof(cylfuse_mask_view)`
 */
CYLFUSE_API
cylfuse_status cylfuse_mask_view_init(struct cylfuse_mask_view *mask,
                                      size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills a view of an image with zeros and a gamma of 1: packed, linear in light; the caller sets format, data
 * and size.
 *
 * @param image what to fill
 * @param struct_size `sizeof(cylfuse_image_view)`
 */
CYLFUSE_API
cylfuse_status cylfuse_image_view_init(struct cylfuse_image_view *image,
                                       size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills a view of segments with zeros: packed, without weights; the caller sets scalar, data and count.
 *
 * @param segments what to fill
 * @param struct_size `sizeof(cylfuse_segments_view)`
 */
CYLFUSE_API
cylfuse_status cylfuse_segments_view_init(struct cylfuse_segments_view *segments,
                                          size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills a buffer for points with zeros: packed points; the caller sets scalar, data and capacity.
 *
 * @param out what to fill
 * @param struct_size `sizeof(cylfuse_points_out)`
 */
CYLFUSE_API
cylfuse_status cylfuse_points_out_init(struct cylfuse_points_out *out,
                                       size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills a buffer for a depth image with zeros and a scale of 1: packed; the caller sets format, data and size.
 *
 * @param out what to fill
 * @param struct_size `sizeof(cylfuse_depth_out)`
 */
CYLFUSE_API
cylfuse_status cylfuse_depth_out_init(struct cylfuse_depth_out *out,
                                      size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills counts with zeros and the size: room for an output.
 *
 * @param counts what to fill
 * @param struct_size `sizeof(cylfuse_counts)`
 */
CYLFUSE_API
cylfuse_status cylfuse_counts_init(struct cylfuse_counts *counts,
                                   size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills a result with zeros and the size: room for an output.
 *
 * @param result what to fill
 * @param struct_size `sizeof(cylfuse_result)`
 */
CYLFUSE_API
cylfuse_status cylfuse_result_init(struct cylfuse_result *result,
                                   size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills an estimate with zeros and the size: room for an output.
 *
 * @param estimate what to fill
 * @param struct_size `sizeof(cylfuse_cylinder_estimate)`
 */
CYLFUSE_API
cylfuse_status cylfuse_cylinder_estimate_init(struct cylfuse_cylinder_estimate *estimate,
                                              size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills a diagnosis with zeros and the size: room for an output.
 *
 * @param diagnosis what to fill
 * @param struct_size `sizeof(cylfuse_cylinder_diagnosis)`
 */
CYLFUSE_API
cylfuse_status cylfuse_cylinder_diagnosis_init(struct cylfuse_cylinder_diagnosis *diagnosis,
                                               size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills the counts of a completion with zeros and the size: room for an output.
 *
 * @param completion what to fill
 * @param struct_size `sizeof(cylfuse_completion)`
 */
CYLFUSE_API
cylfuse_status cylfuse_completion_init(struct cylfuse_completion *completion,
                                       size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Fills an extent with zeros and the size: room for an output.
 *
 * @param extent what to fill
 * @param struct_size `sizeof(cylfuse_extent)`
 */
CYLFUSE_API
cylfuse_status cylfuse_extent_init(struct cylfuse_extent *extent,
                                   size_t struct_size)
CYLFUSE_NOEXCEPT;

/**
 * Makes a fitter with default options, one view at the identity, and no data.
 *
 * Use one fitter for many fits. The memory that a call needs is not freed after it but kept in the fitter, so that a later
 * call with as many data allocates none. It is about as much memory as the data themselves take.
 *
 * @param abi_version `CYLFUSE_ABI_VERSION`
 * @param out_fitter where the fitter goes, for `cylfuse_fitter_destroy` in the end; set to NULL when the call
 *   fails
 * @return ABI_MISMATCH when the program was compiled for another version of the interface, OUT_OF_MEMORY
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_create(uint32_t abi_version,
                                     struct cylfuse_fitter **out_fitter)
CYLFUSE_NOEXCEPT;

/**
 * Makes another fitter with all that one holds: options, cameras, poses and data of all views, start model, the last
 * result and what the start LAST goes on from. Callbacks stay behind. Images are shared and not copied, but points are:
 * set up one fitter, and clone it for each thread before data are pushed.
 *
 * @param fitter the fitter, which stays as it is
 * @param out_fitter where the new one goes, for `cylfuse_fitter_destroy` in the end; set to NULL when the call fails
 * @return OUT_OF_MEMORY
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_clone(const struct cylfuse_fitter *fitter,
                                    struct cylfuse_fitter **out_fitter)
CYLFUSE_NOEXCEPT;

/**
 * Destroys a fitter and frees what it holds. No other call on it may be running or follow.
 *
 * @param fitter the fitter; NULL does nothing
 * @return BUSY when a call on the fitter is running, which a call from one of its callbacks always finds;
 *   nothing is destroyed then
 */
CYLFUSE_API cylfuse_status cylfuse_fitter_destroy(struct cylfuse_fitter *fitter) CYLFUSE_NOEXCEPT;

/**
 * Makes room for the coordinates of that many more points and for that many more segments in the selected view.
 *
 * @param fitter the fitter
 * @param points how many points
 * @param segments how many edge segments
 * @return OUT_OF_MEMORY
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_reserve(struct cylfuse_fitter *fitter,
                                      size_t points,
                                      size_t segments)
CYLFUSE_NOEXCEPT;

/**
 * Forgets the data, all views but the first, its pose and the result; keeps options, the cameras of the first view,
 * start model, what the start LAST goes on from, callbacks and memory: the way from one frame to the next.
 *
 * @param fitter the fitter
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_clear(struct cylfuse_fitter *fitter)
CYLFUSE_NOEXCEPT;

/**
 * Forgets some of the data of the selected view, and keeps the rest and the last result.
 *
 * @param fitter the fitter
 * @param inputs which data, `CYLFUSE_INPUT_...` by bit
 * @return INVALID_ARGUMENT for an unknown bit
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_clear_input(struct cylfuse_fitter *fitter,
                                          cylfuse_input inputs)
CYLFUSE_NOEXCEPT;

/**
 * Why the last call on a fitter failed: what was wrong, the value, the limit and the remedy, one line of ASCII. Empty
 * when the call succeeded.
 *
 * Ask right after the call, on the same thread: the text is then about that call, even where other threads use the
 * fitter too. Where the last call of this thread was not on this fitter, the text is about the call on the fitter that
 * finished last, on any thread. So it is found, too, by a program whose tasks move between threads.
 *
 * @param fitter the fitter, which may be busy; NULL asks for the last call of this thread, whatever it was on, which
 *   is where calls without a fitter leave their text
 * @return a text that is valid until the next call of this thread that returns a status or asks for such a text; never
 *   NULL
 */
CYLFUSE_API
const char *cylfuse_fitter_last_error(const struct cylfuse_fitter *fitter)
CYLFUSE_NOEXCEPT;

/**
 * Asks the calls that are running on a fitter to stop: a fit returns CANCELLED before its next iteration or random
 * sample. When no call is running it does nothing. May be called from any thread and from callbacks.
 *
 * @param fitter the fitter
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_cancel(struct cylfuse_fitter *fitter)
CYLFUSE_NOEXCEPT;

/**
 * Replaces the options.
 *
 * @param fitter the fitter
 * @param options copied
 * @return INVALID_ARGUMENT for a value out of range, STRUCT_SIZE; the old options stay then
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_set_options(struct cylfuse_fitter *fitter,
                                          const struct cylfuse_options *options)
CYLFUSE_NOEXCEPT;

/**
 * Reads the options.
 *
 * @param fitter the fitter
 * @param out_options where they go; `cylfuse_options_init` comes before
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_get_options(const struct cylfuse_fitter *fitter,
                                          struct cylfuse_options *out_options)
CYLFUSE_NOEXCEPT;

/**
 * Selects a view, so that the calls that set or push something, and those whose text says so, concern that view. There
 * is one view at first, number 0, and it is selected: with one view this function is not needed.
 *
 * All views see the same cylinder. A fit uses the data of all of them; models, results and extents are in the
 * reference frame, in which the poses of the views are given. With one view at the identity that is the camera frame.
 *
 * @param fitter the fitter
 * @param index the view, from 0; the number of views adds one, at the identity and without a camera
 * @return INVALID_ARGUMENT for a larger index, OUT_OF_MEMORY
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_select_view(struct cylfuse_fitter *fitter,
                                          size_t index)
CYLFUSE_NOEXCEPT;

/**
 * Says how many views there are, at least 1.
 *
 * @param fitter the fitter
 * @param out_count where the number goes
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_view_count(const struct cylfuse_fitter *fitter,
                                         size_t *out_count)
CYLFUSE_NOEXCEPT;

/**
 * Sets the pose of the selected view: x_reference = rotation * x_camera + translation. The identity at first.
 *
 * @param fitter the fitter
 * @param rotation 9 doubles, a rotation matrix row by row, to 1e-4; small rounding errors are corrected
 * @param translation 3 doubles, the position of the camera in the reference frame, in the unit of length
 * @return INVALID_ARGUMENT when a number is not finite or the matrix is no rotation; the old pose stays then
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_set_pose(struct cylfuse_fitter *fitter,
                                       const double *rotation,
                                       const double *translation)
CYLFUSE_NOEXCEPT;

/**
 * Gives the depth of the selected view a camera of its own, for depth that is not registered to the colour image:
 * depth images that are pushed later are then in its pixels; mask, image and edges stay in those of the colour
 * camera, which `cylfuse_fitter_set_intrinsics` sets. A mask selects the depth pixels that the colour camera sees in
 * it.
 *
 * @param fitter the fitter
 * @param intrinsics those of the depth camera, copied; NULL takes the depth camera away, and what follows is not read
 * @param rotation 9 doubles, row by row: x_colour = rotation * x_depth + translation
 * @param translation 3 doubles, in the unit of length
 * @return INVALID_INTRINSICS, INVALID_ARGUMENT, STRUCT_SIZE; SIZE_MISMATCH with a depth image that was pushed
 *   (`cylfuse_fitter_clear_input`), OUT_OF_MEMORY; the old depth camera stays then
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_set_depth_camera(struct cylfuse_fitter *fitter,
                                               const struct cylfuse_intrinsics *intrinsics,
                                               const double *rotation,
                                               const double *translation)
CYLFUSE_NOEXCEPT;

/**
 * Sets the colour camera of the selected view, which depth images, images and edges need. Points that were pushed
 * before stay as they are.
 *
 * @param fitter the fitter
 * @param intrinsics copied
 * @return INVALID_INTRINSICS, INVALID_ARGUMENT for an unknown model, STRUCT_SIZE; SIZE_MISMATCH with an image that was
 *   pushed (`cylfuse_fitter_clear_input`), OUT_OF_MEMORY; the old camera stays then
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_set_intrinsics(struct cylfuse_fitter *fitter,
                                             const struct cylfuse_intrinsics *intrinsics)
CYLFUSE_NOEXCEPT;

/**
 * Reads the intrinsics of the colour camera of the selected view: those that were set, or those of its frame.
 *
 * @param fitter the fitter
 * @param out_intrinsics where they go; `cylfuse_intrinsics_init` comes before
 * @return BAD_STATE when the view has no colour camera
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_get_intrinsics(const struct cylfuse_fitter *fitter,
                                             struct cylfuse_intrinsics *out_intrinsics)
CYLFUSE_NOEXCEPT;

/**
 * Sets a start model: a candidate for the start AUTO, the start of MODEL. Of points alone that hold several bodies AUTO and
 * LAST fit the one near it.
 *
 * @param fitter the fitter
 * @param model in the reference frame, copied; NULL takes the start model away
 * @return INVALID_ARGUMENT when a number is not finite, the direction 0 or the radius not positive; the old
 *   start model stays then
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_set_start_model(struct cylfuse_fitter *fitter,
                                              const struct cylfuse_cylinder *model)
CYLFUSE_NOEXCEPT;

/**
 * Sets or takes away the progress callback.
 *
 * @param fitter the fitter
 * @param callback NULL for none
 * @param user_data handed to the callback, kept until the callback is replaced; may be NULL
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_set_progress(struct cylfuse_fitter *fitter,
                                           cylfuse_progress_fn callback,
                                           void *user_data)
CYLFUSE_NOEXCEPT;

/**
 * Sets or takes away the log callback. There is none at first, and the library never prints.
 *
 * @param fitter the fitter
 * @param max_level lines up to this level are handed over
 * @param callback NULL for none
 * @param user_data handed to the callback, kept until the callback is replaced; may be NULL
 * @return INVALID_ARGUMENT for an unknown level
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_set_log(struct cylfuse_fitter *fitter,
                                      cylfuse_log_level max_level,
                                      cylfuse_log_fn callback,
                                      void *user_data)
CYLFUSE_NOEXCEPT;

/**
 * Adds points to the selected view, in its camera frame (x right, y down, z forward) when edges, the near-wall rule,
 * completion or extent matter, else in any frame. Points with a coordinate that is not finite, a weight of 0 or outside the
 * mask are left out and counted.
 *
 * @param fitter the fitter
 * @param points read during the call only
 * @param mask selects pixels of an organised cloud, of the same size as it; NULL = all. Read during the call
 *   only.
 * @return SIZE_MISMATCH, EMPTY_MASK, INVALID_ARGUMENT for a negative weight or a bad stride, OUT_OF_MEMORY;
 *   nothing is added then
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_push_points(struct cylfuse_fitter *fitter,
                                          const struct cylfuse_points_view *points,
                                          const struct cylfuse_mask_view *mask)
CYLFUSE_NOEXCEPT;

/**
 * Adds the points of a depth image of the selected view; `cylfuse_fitter_set_intrinsics` comes before. Pixels without
 * a depth, out of range, outside the mask or hidden from the colour camera are left out and counted. The image and the
 * mask are kept, in place of earlier ones, for completion and extent.
 *
 * @param fitter the fitter
 * @param depth read during the call only
 * @param mask in the pixels of the colour image; NULL = all pixels. Read during the call only.
 * @return BAD_STATE without intrinsics, SIZE_MISMATCH, EMPTY_MASK, NO_DEPTH when no pixel is usable,
 *   INVALID_ARGUMENT for a bad scale, range or stride, OUT_OF_MEMORY; nothing is added then
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_push_depth(struct cylfuse_fitter *fitter,
                                         const struct cylfuse_depth_view *depth,
                                         const struct cylfuse_mask_view *mask)
CYLFUSE_NOEXCEPT;

/**
 * Takes the image of the selected view, grey or in colour, in place of an earlier one;
 * `cylfuse_fitter_set_intrinsics` comes before.
 * With the objective ROBUST the limbs and the arcs of the ends are located in it and join the fit; with the extent
 * rule LOCATED the ends are. The objective PAPER and the methods other than FUSED never look at it. Without a mask and
 * without edges the limbs are looked for beside the outline of the points, where these are as dense as the image.
 *
 * @param fitter the fitter
 * @param image read during the call only
 * @return BAD_STATE without intrinsics, SIZE_MISMATCH, INVALID_ARGUMENT for a bad stride or gamma, or a value that is
 *   not finite or that the gamma forbids, OUT_OF_MEMORY; the earlier image stays then
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_push_image(struct cylfuse_fitter *fitter,
                                         const struct cylfuse_image_view *image)
CYLFUSE_NOEXCEPT;

/**
 * Adds edge segments to the selected view: pieces of the two limb lines in the (distorted) image, any number of
 * either. A fit with segments needs intrinsics.
 *
 * @param fitter the fitter
 * @param segments read during the call only
 * @return INVALID_ARGUMENT when a coordinate is not finite or a weight is negative, OUT_OF_MEMORY; nothing is
 *   added then
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_push_edges(struct cylfuse_fitter *fitter,
                                         const struct cylfuse_segments_view *segments)
CYLFUSE_NOEXCEPT;

/**
 * Says what was pushed into the selected view since the fitter was created or cleared, and what was left out by
 * reason.
 *
 * @param fitter the fitter
 * @param out_counts where the counts go; `cylfuse_counts_init` comes before
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_counts(const struct cylfuse_fitter *fitter,
                                     struct cylfuse_counts *out_counts)
CYLFUSE_NOEXCEPT;

/**
 * Makes a frame at the identity, without a camera and data.
 *
 * @param abi_version `CYLFUSE_ABI_VERSION`
 * @param out_frame where the frame goes, for `cylfuse_frame_destroy` in the end; set to NULL when the call fails
 * @return ABI_MISMATCH when the program was compiled for another version of the interface, OUT_OF_MEMORY
 */
CYLFUSE_API
cylfuse_status cylfuse_frame_create(uint32_t abi_version,
                                    struct cylfuse_frame **out_frame)
CYLFUSE_NOEXCEPT;

/**
 * Destroys a frame. Fitters that use it go on with what they need of it. No other call on it may be running or
 * follow.
 *
 * @param frame the frame; NULL does nothing
 * @return BUSY when a call on the frame is running; nothing is destroyed then
 */
CYLFUSE_API
cylfuse_status cylfuse_frame_destroy(struct cylfuse_frame *frame)
CYLFUSE_NOEXCEPT;

/**
 * Why the last call on a frame failed; see `cylfuse_fitter_last_error`, whose rules hold here too. The text of
 * `cylfuse_fitter_use_frame` is with the fitter.
 *
 * @param frame the frame; NULL asks for the last call of this thread, whatever it was on
 * @return a text that is valid until the next call of this thread that returns a status or asks for such a text; never
 *   NULL
 */
CYLFUSE_API
const char *cylfuse_frame_last_error(const struct cylfuse_frame *frame)
CYLFUSE_NOEXCEPT;

/**
 * Sets the colour camera of a frame; it comes before depth and image, which must have its size.
 *
 * @param frame the frame
 * @param intrinsics copied
 * @return INVALID_INTRINSICS, INVALID_ARGUMENT for an unknown model, STRUCT_SIZE; SIZE_MISMATCH with an image that the
 *   frame has, OUT_OF_MEMORY; the old camera stays then
 */
CYLFUSE_API
cylfuse_status cylfuse_frame_set_intrinsics(struct cylfuse_frame *frame,
                                            const struct cylfuse_intrinsics *intrinsics)
CYLFUSE_NOEXCEPT;

/**
 * Sets the pose of a frame: x_reference = rotation * x_camera + translation. The identity at first.
 *
 * @param frame the frame
 * @param rotation 9 doubles, a rotation matrix row by row, to 1e-4; small rounding errors are corrected
 * @param translation 3 doubles, in the unit of length
 * @return INVALID_ARGUMENT when a number is not finite or the matrix is no rotation; the old pose stays then
 */
CYLFUSE_API
cylfuse_status cylfuse_frame_set_pose(struct cylfuse_frame *frame,
                                      const double *rotation,
                                      const double *translation)
CYLFUSE_NOEXCEPT;

/**
 * Gives the depth of a frame a camera of its own, whose size the depth image must have. See
 * `cylfuse_fitter_set_depth_camera`.
 *
 * @param frame the frame
 * @param intrinsics those of the depth camera, copied; NULL takes the depth camera away, and what follows is not read
 * @param rotation 9 doubles, row by row: x_colour = rotation * x_depth + translation
 * @param translation 3 doubles, in the unit of length
 * @return INVALID_INTRINSICS, INVALID_ARGUMENT, STRUCT_SIZE; SIZE_MISMATCH with the depth image that the frame has,
 *   OUT_OF_MEMORY; the old depth camera stays then
 */
CYLFUSE_API
cylfuse_status cylfuse_frame_set_depth_camera(struct cylfuse_frame *frame,
                                              const struct cylfuse_intrinsics *intrinsics,
                                              const double *rotation,
                                              const double *translation)
CYLFUSE_NOEXCEPT;

/**
 * Sets the depth image of a frame, in place of an earlier one.
 *
 * @param frame the frame, with intrinsics
 * @param depth copied
 * @return BAD_STATE without intrinsics, SIZE_MISMATCH, INVALID_ARGUMENT for a bad scale, range or stride,
 *   OUT_OF_MEMORY; the earlier image stays then
 */
CYLFUSE_API
cylfuse_status cylfuse_frame_set_depth(struct cylfuse_frame *frame,
                                       const struct cylfuse_depth_view *depth)
CYLFUSE_NOEXCEPT;

/**
 * Sets the image of a frame, grey or in colour, in place of an earlier one.
 *
 * @param frame the frame, with intrinsics
 * @param image copied
 * @return BAD_STATE without intrinsics, SIZE_MISMATCH, INVALID_ARGUMENT for a bad stride or gamma, or a value that is
 *   not finite or that the gamma forbids, OUT_OF_MEMORY; the earlier image stays then
 */
CYLFUSE_API
cylfuse_status cylfuse_frame_set_image(struct cylfuse_frame *frame,
                                       const struct cylfuse_image_view *image)
CYLFUSE_NOEXCEPT;

/**
 * Lets the selected view of a fitter take camera, depth camera, pose and images from a frame, in place of its own, and
 * adds the points of the depth image, if there is one. Points and edge segments that were pushed stay
 * (`cylfuse_fitter_clear_input`). The images are shared and not copied.
 *
 * @param fitter the fitter
 * @param frame the frame, with intrinsics; it may be changed or destroyed afterwards, of which the fitter sees nothing
 * @param mask in the pixels of the colour image, copied; NULL = all pixels
 * @return BAD_STATE without intrinsics, SIZE_MISMATCH, EMPTY_MASK, NO_DEPTH when no pixel of the depth image in the
 *   mask is usable, BUSY when the frame is being filled, OUT_OF_MEMORY; the view stays as it was then
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_use_frame(struct cylfuse_fitter *fitter,
                                        const struct cylfuse_frame *frame,
                                        const struct cylfuse_mask_view *mask)
CYLFUSE_NOEXCEPT;

/**
 * Makes a detector with default options. It keeps the memory of its calls for the next ones, 3 to 25 MB after frames of
 * 640 × 480 pixels: use it again.
 *
 * @param abi_version `CYLFUSE_ABI_VERSION`
 * @param out_detector where the detector goes, for `cylfuse_detector_destroy` in the end; set to NULL when the call
 *   fails
 * @return ABI_MISMATCH when the program was compiled for another version of the interface, OUT_OF_MEMORY
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_create(uint32_t abi_version,
                                       struct cylfuse_detector **out_detector)
CYLFUSE_NOEXCEPT;

/**
 * Destroys a detector and frees what it holds. Fitters that it made stay. No other call on it may be running or follow.
 *
 * @param detector the detector; NULL does nothing
 * @return BUSY when a call on the detector is running, which a call from its callback always finds; nothing is
 *   destroyed then
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_destroy(struct cylfuse_detector *detector)
CYLFUSE_NOEXCEPT;

/**
 * Why the last call on a detector failed; see `cylfuse_fitter_last_error`, whose rules hold here too.
 *
 * @param detector the detector, which may be busy; NULL asks for the last call of this thread, whatever it was on
 * @return a text that is valid until the next call of this thread that returns a status or asks for such a text; never
 *   NULL
 */
CYLFUSE_API
const char *cylfuse_detector_last_error(const struct cylfuse_detector *detector)
CYLFUSE_NOEXCEPT;

/**
 * Asks the calls that are running on a detector to stop: they return CANCELLED, during the search or before the next
 * iteration of a fit. When no call is running it does nothing. May be called from any thread and from callbacks.
 *
 * @param detector the detector
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_cancel(struct cylfuse_detector *detector)
CYLFUSE_NOEXCEPT;

/**
 * Replaces the options of a detector: of the search, and of the scene as a whole.
 *
 * @param detector the detector
 * @param options copied
 * @return INVALID_ARGUMENT for a value out of range, STRUCT_SIZE; the old options stay then
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_set_options(struct cylfuse_detector *detector,
                                            const struct cylfuse_detector_options *options)
CYLFUSE_NOEXCEPT;

/**
 * Reads the options of a detector.
 *
 * @param detector the detector
 * @param out_options where they go; `cylfuse_detector_options_init` comes before
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_get_options(const struct cylfuse_detector *detector,
                                            struct cylfuse_detector_options *out_options)
CYLFUSE_NOEXCEPT;

/**
 * Replaces the options of the fits of a detector. Limits, threads and the start are those of the detector: here
 * `radius_min`, `radius_max`, `axis`, `axis_max_angle`, `max_threads` and `start` must have their defaults.
 *
 * @param detector the detector
 * @param options copied
 * @return INVALID_ARGUMENT for a value out of range and for one that the detector sets, STRUCT_SIZE; the old options
 *   stay then
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_set_fit_options(struct cylfuse_detector *detector,
                                                const struct cylfuse_options *options)
CYLFUSE_NOEXCEPT;

/**
 * Reads the options of the fits of a detector.
 *
 * @param detector the detector
 * @param out_options where they go; `cylfuse_options_init` comes before
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_get_fit_options(const struct cylfuse_detector *detector,
                                                struct cylfuse_options *out_options)
CYLFUSE_NOEXCEPT;

/**
 * Sets or takes away the progress callback of a detector.
 *
 * @param detector the detector
 * @param callback NULL for none
 * @param user_data handed to the callback, kept until the callback is replaced; may be NULL
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_set_progress(struct cylfuse_detector *detector,
                                             cylfuse_detection_progress_fn callback,
                                             void *user_data)
CYLFUSE_NOEXCEPT;

/**
 * Finds all cylinders in the depth image of a frame, and fits each to its region by depth and image. Results are in the
 * reference frame, to which the pose of the frame leads. The scene takes the place of the last one.
 *
 * @param detector the detector
 * @param frame the frame, with intrinsics and a depth image; shared and not copied. It may be changed or destroyed
 *   afterwards, of which the scene sees nothing.
 * @return BAD_STATE without intrinsics or depth, UNSUPPORTED for options of the fits that need edges, BUSY when the frame
 *   is being filled, OUT_OF_MEMORY, CANCELLED; the last scene stays then. A scene without any cylinder is none of them.
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_detect(struct cylfuse_detector *detector,
                                       const struct cylfuse_frame *frame)
CYLFUSE_NOEXCEPT;

/**
 * Finds all cylinders in a cloud, organised or not, and fits each to its points. It is looked at from where
 * one sensor has seen it, in its origin or where the densities of the points tell; other clouds are looked at from all
 * sides, which takes about ten times as long. Points with a coordinate that is not finite or a weight of 0 are left
 * out. The scene takes the place of the last one.
 *
 * @param detector the detector
 * @param points read during the call only
 * @return INVALID_ARGUMENT for a negative weight or a bad stride, UNSUPPORTED for options of the fits that need edges,
 *   OUT_OF_MEMORY, CANCELLED; the last scene stays then. A scene without any cylinder is none of them.
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_detect_points(struct cylfuse_detector *detector,
                                              const struct cylfuse_points_view *points)
CYLFUSE_NOEXCEPT;

/**
 * Says how many cylinders the last scene has.
 *
 * @param detector the detector
 * @param out_count where the number goes
 * @return BAD_STATE when no scene was searched
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_count(const struct cylfuse_detector *detector,
                                      size_t *out_count)
CYLFUSE_NOEXCEPT;

/**
 * Says whether the last scene was looked at as a whole. The work of a search with its fits is bounded, so that no input
 * takes much longer than any other of its size. A scene that has more in it than that is searched by falling score until
 * the work is done: cylinders may be missing. One for whose fit there was no work left is what the search found, with
 * `CYLFUSE_RESULT_FLAGS_NOT_CONVERGED`.
 *
 * @param detector the detector
 * @param out_complete 1, or 0 when cylinders may be missing
 * @return BAD_STATE when no scene was searched
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_is_complete(const struct cylfuse_detector *detector,
                                            int32_t *out_complete)
CYLFUSE_NOEXCEPT;

/**
 * Says by how many pixels the depth of the last frame was moved to where the image shows the same bodies. Where registration
 * is off by pixels, edges beside limbs would be taken for these. Each result then has
 * `CYLFUSE_RESULT_FLAGS_DEPTH_SHIFTED`; labels and indices are those of the depth as it was given.
 *
 * @param detector the detector
 * @param out_columns how far to the right; negative to the left, 0 where it was not moved
 * @param out_rows how far down; negative is up, 0 where it was not moved
 * @return BAD_STATE when no scene was searched
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_depth_moved(const struct cylfuse_detector *detector,
                                            int32_t *out_columns,
                                            int32_t *out_rows)
CYLFUSE_NOEXCEPT;

/**
 * Lists the cylinders of the last scene by falling score. Their order numbers them from 0 in the calls that ask for one.
 *
 * @param detector the detector
 * @param out room for `capacity` elements of `element_size` bytes, of any alignment; may be NULL when `capacity`
 *   is 0
 * @param element_size `sizeof(cylfuse_detection)`
 * @param capacity how many elements `out` holds
 * @param out_count how many there are; set after BUFFER_TOO_SMALL too
 * @return BAD_STATE when no scene was searched, STRUCT_SIZE, BUFFER_TOO_SMALL
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_detections(const struct cylfuse_detector *detector,
                                           struct cylfuse_detection *out,
                                           size_t element_size,
                                           size_t capacity,
                                           size_t *out_count)
CYLFUSE_NOEXCEPT;

/**
 * Reads the outcome of the fit of one cylinder.
 *
 * @param detector the detector
 * @param index the cylinder, from 0
 * @param out_result where the result goes; `cylfuse_result_init` comes before
 * @return BAD_STATE when no scene was searched, INVALID_ARGUMENT when there is no such cylinder
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_get_result(const struct cylfuse_detector *detector,
                                           size_t index,
                                           struct cylfuse_result *out_result)
CYLFUSE_NOEXCEPT;

/**
 * Reads one cylinder with its deviations.
 *
 * @param detector the detector
 * @param index the cylinder, from 0
 * @param out_estimate where the cylinder goes; `cylfuse_cylinder_estimate_init` comes before
 * @return BAD_STATE when no scene was searched, INVALID_ARGUMENT when there is no such cylinder
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_get_cylinder(const struct cylfuse_detector *detector,
                                             size_t index,
                                             struct cylfuse_cylinder_estimate *out_estimate)
CYLFUSE_NOEXCEPT;

/**
 * Reads the visible piece of one cylinder. Those of a cloud end with their points.
 *
 * @param detector the detector
 * @param index the cylinder, from 0
 * @param out_extent where the extent goes; `cylfuse_extent_init` comes before
 * @return BAD_STATE when no scene was searched, INVALID_ARGUMENT when there is no such cylinder, EDGE_GEOMETRY when no ray
 *   of its region meets it and no points lie along it
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_get_extent(const struct cylfuse_detector *detector,
                                           size_t index,
                                           struct cylfuse_extent *out_extent)
CYLFUSE_NOEXCEPT;

/**
 * Writes for each pixel of the colour image, or each point of the cloud, row by row, the number of its cylinder from 1 on:
 * 1 for the cylinder of index 0. 0 = none.
 *
 * @param detector the detector
 * @param out room for `capacity` numbers, of any alignment; may be NULL when `capacity` is 0
 * @param capacity width * height of the frame or of the cloud
 * @param out_count how many there are; set after BUFFER_TOO_SMALL too
 * @return BAD_STATE when no scene was searched, BUFFER_TOO_SMALL
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_labels(const struct cylfuse_detector *detector,
                                       uint16_t *out,
                                       size_t capacity,
                                       size_t *out_count)
CYLFUSE_NOEXCEPT;

/**
 * Lists the pixels or points of one cylinder, counted from 0 row by row, in rising order.
 *
 * @param detector the detector
 * @param index the cylinder, from 0
 * @param out room for `capacity` indices, of any alignment; may be NULL when `capacity` is 0
 * @param capacity `pixels` of its `cylfuse_detection` is enough
 * @param out_count how many there are; set after BUFFER_TOO_SMALL too
 * @return BAD_STATE when no scene was searched, INVALID_ARGUMENT when there is no such cylinder, BUFFER_TOO_SMALL
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_indices(const struct cylfuse_detector *detector,
                                        size_t index,
                                        uint32_t *out,
                                        size_t capacity,
                                        size_t *out_count)
CYLFUSE_NOEXCEPT;

/**
 * Makes a fitter of one cylinder as its fit left it, with options, frame or points, region as mask, start model and
 * result: for residuals, completion, limbs and all else that can be asked of a fit, or for another fit. It shares the
 * images of the frame and does not depend on the detector. That of a cloud has no mask: completion asks for intrinsics and
 * one.
 *
 * @param detector the detector
 * @param index the cylinder, from 0
 * @param out_fitter where the fitter goes, for `cylfuse_fitter_destroy` in the end; set to NULL when the call fails
 * @return BAD_STATE when no scene was searched, INVALID_ARGUMENT when there is no such cylinder, OUT_OF_MEMORY
 */
CYLFUSE_API
cylfuse_status cylfuse_detector_make_fitter(const struct cylfuse_detector *detector,
                                            size_t index,
                                            struct cylfuse_fitter **out_fitter)
CYLFUSE_NOEXCEPT;

/**
 * Estimates the cylinder from everything that was pushed into all views.
 *
 * @param fitter the fitter
 * @param out_result where the result goes; `cylfuse_result_init` comes before. May be NULL.
 * @param out_estimate where the cylinder goes; `cylfuse_cylinder_estimate_init` comes before. May be NULL.
 * @return TOO_FEW_POINTS for fewer than 5 usable points, PLANAR_POINTS, COLLINEAR_POINTS, NO_START, NUMERICAL when the data
 *   do not determine a cylinder; UNSUPPORTED, BAD_STATE, EDGE_GEOMETRY when they do not go with the options; OUT_OF_MEMORY; CANCELLED.
 *   The last result stays then. Lack of convergence and other warnings are not errors but fields of the result.
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_fit(struct cylfuse_fitter *fitter,
                                  struct cylfuse_result *out_result,
                                  struct cylfuse_cylinder_estimate *out_estimate)
CYLFUSE_NOEXCEPT;

/**
 * Says what a fit would report for a given cylinder, without iterating. The last result stays.
 *
 * @param fitter the fitter
 * @param model the cylinder, in the reference frame
 * @param out_result where the result goes; `cylfuse_result_init` comes before. May be NULL.
 * @param out_estimate where the deviations go; `cylfuse_cylinder_estimate_init` comes before. May be NULL.
 * @return INVALID_ARGUMENT for a bad model, else as `cylfuse_fitter_fit`; EDGE_GEOMETRY where the cost is
 *   infinite
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_evaluate(const struct cylfuse_fitter *fitter,
                                       const struct cylfuse_cylinder *model,
                                       struct cylfuse_result *out_result,
                                       struct cylfuse_cylinder_estimate *out_estimate)
CYLFUSE_NOEXCEPT;

/**
 * Reads the result of the last fit that succeeded.
 *
 * @param fitter the fitter
 * @param out_result where the result goes; `cylfuse_result_init` comes before
 * @return BAD_STATE when there is none
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_get_result(const struct cylfuse_fitter *fitter,
                                         struct cylfuse_result *out_result)
CYLFUSE_NOEXCEPT;

/**
 * Reads the cylinder of the last fit that succeeded.
 *
 * @param fitter the fitter
 * @param out_estimate where the cylinder goes; `cylfuse_cylinder_estimate_init` comes before
 * @return BAD_STATE when there is none
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_get_cylinder(const struct cylfuse_fitter *fitter,
                                           struct cylfuse_cylinder_estimate *out_estimate)
CYLFUSE_NOEXCEPT;

/**
 * Says what the data determine at a model, by an orthogonal factorisation of the whole Jacobian: more precise
 * than `condition` of a result, and far slower.
 *
 * @param fitter the fitter
 * @param model the model; NULL = that of the last fit
 * @param out_diagnosis where the diagnosis goes; `cylfuse_cylinder_diagnosis_init` comes before
 * @return BAD_STATE without a model and a result, EDGE_GEOMETRY where the cost is infinite; else as
 *   `cylfuse_fitter_fit`
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_diagnose(const struct cylfuse_fitter *fitter,
                                       const struct cylfuse_cylinder *model,
                                       struct cylfuse_cylinder_diagnosis *out_diagnosis)
CYLFUSE_NOEXCEPT;

/**
 * Fits many fitters, several at once, each as `cylfuse_fitter_fit` does. The results stay in the fitters, for
 * `cylfuse_fitter_get_result` and all else that can be asked of a fit; a fit that fails has its status in the list, and
 * its text in `cylfuse_fitter_last_error` of its fitter until the next call on that, and the others go on. For the next
 * frames: `cylfuse_fitter_clear`, push, and this again on the same fitters, which keep the room of their data; the memory
 * of the calls is shared by all on a thread.
 *
 * The callbacks of the fitters are not called.
 *
 * @param fitters the fitters, each once. One that is busy has the status BUSY. One that is NULL has NULL_POINTER and no
 *   text, as there is no fitter to ask.
 * @param count how many there are
 * @param threads how many fits run at the same time, 0 for as many as the machine has processors; 1 starts no thread.
 *   More than 256 are 256, and there are fewer where the system does not start that many. The results have the same bits
 *   for any number. Each fit takes `max_threads` of its options beside that, of which the default, 1, is right here.
 * @param callback is called after each fit, and may stop the rest; NULL for none
 * @param user_data handed to the callback; may be NULL
 * @param out_statuses where the statuses of the `count` fits go, in the order of the fitters
 * @return OK when all fits ended, whatever their statuses; CANCELLED when the callback stopped them, where those that had
 *   not ended have the status CANCELLED, too; INVALID_ARGUMENT for a fitter that is there twice, OUT_OF_MEMORY, and then
 *   nothing was done
 */
CYLFUSE_API
cylfuse_status cylfuse_fit_all(struct cylfuse_fitter *const *fitters,
                               size_t count,
                               uint32_t threads,
                               cylfuse_fit_all_fn callback,
                               void *user_data,
                               cylfuse_status *out_statuses)
CYLFUSE_NOEXCEPT;

/**
 * Lists residuals of the selected view.
 *
 * @param fitter the fitter
 * @param model the model, in the reference frame; NULL = that of the last fit
 * @param kind which residuals
 * @param out room for `capacity` doubles, of any alignment; may be NULL when `capacity` is 0
 * @param capacity `points_used` of `cylfuse_fitter_counts` is enough for POINTS, 2 a segment for EDGES
 * @param out_count how many there are; set after BUFFER_TOO_SMALL too
 * @return BAD_STATE without a model and a result, EDGE_GEOMETRY for EDGES when the camera is inside the
 *   cylinder, NUMERICAL where no number holds a residual, BUFFER_TOO_SMALL, OUT_OF_MEMORY
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_residuals(const struct cylfuse_fitter *fitter,
                                        const struct cylfuse_cylinder *model,
                                        cylfuse_residual_kind kind,
                                        double *out,
                                        size_t capacity,
                                        size_t *out_count)
CYLFUSE_NOEXCEPT;

/**
 * Lists how much each point of the selected view counts at the cylinder of the last fit, in the order of the residuals
 * POINTS: by the weights of the objective ROBUST, whatever was minimised.
 *
 * @param fitter the fitter
 * @param out_weights room for `capacity` doubles, of any alignment: from 1 for a point on the surface down to 0 for an
 *   outlier, without the weight that the point was given. NULL = not wanted.
 * @param out_inliers room for `capacity` bytes: 1 for a point whose weight is above 0, else 0. NULL = not wanted.
 * @param capacity `points_used` of `cylfuse_fitter_counts` is enough
 * @param out_count how many there are; set after BUFFER_TOO_SMALL too
 * @return BAD_STATE without a result, BUFFER_TOO_SMALL; else as `cylfuse_fitter_fit`, when data were cleared since
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_point_weights(const struct cylfuse_fitter *fitter,
                                            double *out_weights,
                                            uint8_t *out_inliers,
                                            size_t capacity,
                                            size_t *out_count)
CYLFUSE_NOEXCEPT;

/**
 * Tells what each point of the selected view belongs to, in the order of the residuals POINTS: the lateral surface of the
 * cylinder, or what else a mask of a whole object holds. A depth image tells where within the mask the lateral surface
 * ends; without one it goes on, and no point is of a cap.
 *
 * @param fitter the fitter
 * @param model the model, in the reference frame; NULL = that of the last fit
 * @param out room for `capacity` parts, of one byte each; may be NULL when `capacity` is 0
 * @param capacity `points_used` of `cylfuse_fitter_counts` is enough
 * @param out_count how many there are; set after BUFFER_TOO_SMALL too
 * @return BAD_STATE without a model and a result, BUFFER_TOO_SMALL, OUT_OF_MEMORY
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_point_parts(const struct cylfuse_fitter *fitter,
                                          const struct cylfuse_cylinder *model,
                                          cylfuse_part *out,
                                          size_t capacity,
                                          size_t *out_count)
CYLFUSE_NOEXCEPT;

/**
 * Lists the two limbs of the last fit in each view, view after view: where they were located in the image, or why
 * they were not. All are NOT_SEARCHED once data or options have changed since.
 *
 * @param fitter the fitter
 * @param out room for `capacity` elements of `element_size` bytes, of any alignment; may be NULL when `capacity`
 *   is 0
 * @param element_size `sizeof(cylfuse_limb)`
 * @param capacity how many elements `out` holds
 * @param out_count how many there are; set after BUFFER_TOO_SMALL too
 * @return BAD_STATE without a result, STRUCT_SIZE, BUFFER_TOO_SMALL
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_limbs(const struct cylfuse_fitter *fitter,
                                    struct cylfuse_limb *out,
                                    size_t element_size,
                                    size_t capacity,
                                    size_t *out_count)
CYLFUSE_NOEXCEPT;

/**
 * Lists what the last fit saw of the limbs in the image of the selected view, piece by piece, used and refused; all
 * samples of a limb that was not located in the end are refused. Empty when the image was not searched, and once data or
 * options have changed since.
 *
 * @param fitter the fitter
 * @param out room for `capacity` elements of `element_size` bytes, of any alignment; may be NULL when `capacity`
 *   is 0
 * @param element_size `sizeof(cylfuse_limb_sample)`
 * @param capacity how many elements `out` holds
 * @param out_count how many there are; set after BUFFER_TOO_SMALL too
 * @return BAD_STATE without a result, STRUCT_SIZE, BUFFER_TOO_SMALL
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_limb_samples(const struct cylfuse_fitter *fitter,
                                           struct cylfuse_limb_sample *out,
                                           size_t element_size,
                                           size_t capacity,
                                           size_t *out_count)
CYLFUSE_NOEXCEPT;

/**
 * Lists the samples on the arcs of both ends that `cylfuse_fitter_extent` finds in the images, view after view: first
 * those of the start, then those of the end. There are none for an end that the image of a view does not show.
 *
 * @param fitter the fitter, with intrinsics
 * @param model the model, in the reference frame; NULL = that of the last fit
 * @param mask the region, of the size of the intrinsics; NULL = the mask of the view
 * @param out room for `capacity` elements of `element_size` bytes, of any alignment; may be NULL when `capacity`
 *   is 0
 * @param element_size `sizeof(cylfuse_end_sample)`
 * @param capacity how many elements `out` holds
 * @param out_count how many there are; set after BUFFER_TOO_SMALL too
 * @return as `cylfuse_fitter_extent`; BUFFER_TOO_SMALL
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_end_samples(const struct cylfuse_fitter *fitter,
                                          const struct cylfuse_cylinder *model,
                                          const struct cylfuse_mask_view *mask,
                                          struct cylfuse_end_sample *out,
                                          size_t element_size,
                                          size_t capacity,
                                          size_t *out_count)
CYLFUSE_NOEXCEPT;

/**
 * Says how many points a completion of the selected view may give at most.
 *
 * @param fitter the fitter
 * @param mask the region; NULL = the mask of the view
 * @param layout for which layout
 * @param out_capacity where the number goes: the set pixels of the mask when packed, all pixels of the image
 *   when organised
 * @return BAD_STATE without intrinsics or mask, SIZE_MISMATCH, EMPTY_MASK
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_complete_bound(const struct cylfuse_fitter *fitter,
                                             const struct cylfuse_mask_view *mask,
                                             cylfuse_layout layout,
                                             size_t *out_capacity)
CYLFUSE_NOEXCEPT;

/**
 * Completes the cloud of the selected view: casts the ray of every pixel of a mask and takes its first meeting with
 * the cylinder, the near wall from outside, the far one from inside a pipe. The points are in the reference frame,
 * so that those of all views go together.
 *
 * @param fitter the fitter, with intrinsics
 * @param model the model, in the reference frame; NULL = that of the last fit
 * @param mask the region, of the size of the intrinsics; NULL = the mask of the view
 * @param layout how the points are arranged
 * @param out the buffer: `cylfuse_fitter_complete_bound` says what is enough. Must not overlap with what the
 *   other parameters point to.
 * @param out_completion what became of the pixels; `cylfuse_completion_init` comes before. After BUFFER_TOO_SMALL its
 *   `count` is the capacity that is needed.
 * @return BAD_STATE without model, intrinsics or mask, SIZE_MISMATCH, EMPTY_MASK, INVALID_ARGUMENT,
 *   BUFFER_TOO_SMALL; no point is written then
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_complete(const struct cylfuse_fitter *fitter,
                                       const struct cylfuse_cylinder *model,
                                       const struct cylfuse_mask_view *mask,
                                       cylfuse_layout layout,
                                       const struct cylfuse_points_out *out,
                                       struct cylfuse_completion *out_completion)
CYLFUSE_NOEXCEPT;

/**
 * Completes the depth image of the selected view, on the pixels of its colour image: writes the z in its camera frame of
 * every point of `cylfuse_fitter_complete`, and 0 where there is none.
 *
 * @param fitter the fitter, with intrinsics
 * @param model the model, in the reference frame; NULL = that of the last fit
 * @param mask the region, of the size of the intrinsics; NULL = the mask of the view
 * @param out the image, of the size of the intrinsics: every pixel of it is written. Must not overlap with what
 *   the other parameters point to.
 * @param out_completion what became of the pixels; `cylfuse_completion_init` comes before. Its `count` is the number of
 *   pixels with a depth.
 * @return BAD_STATE without model, intrinsics or mask, SIZE_MISMATCH, EMPTY_MASK, INVALID_ARGUMENT; nothing is
 *   written then
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_complete_depth(const struct cylfuse_fitter *fitter,
                                             const struct cylfuse_cylinder *model,
                                             const struct cylfuse_mask_view *mask,
                                             const struct cylfuse_depth_out *out,
                                             struct cylfuse_completion *out_completion)
CYLFUSE_NOEXCEPT;

/**
 * Finds the visible piece of the cylinder and what its ends are: in a view with a camera and a mask by the `extent_rule`
 * of the options, in others, and from inside a pipe, by the points on the surface. A fit without a mask may have made an
 * outline of the points, which then serves as the mask. An end that is seen in several views is their mean by their
 * variances; one that is seen in none is the outermost of what they show, by views with a mask if there are any. The extent
 * of another model than the last fit's states no `length_deviation` and no covariances, which are NaN.
 *
 * @param fitter the fitter
 * @param model the model, in the reference frame; NULL = that of the last fit
 * @param mask the region in the selected view, of the size of its intrinsics; NULL = the mask of the view
 * @param out_extent where the extent goes; `cylfuse_extent_init` comes before
 * @return BAD_STATE without a model, without points or a mask, and for a mask that is given without intrinsics;
 *   SIZE_MISMATCH, EMPTY_MASK, EDGE_GEOMETRY when no ray of the mask meets the cylinder and no points lie along it
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_extent(const struct cylfuse_fitter *fitter,
                                     const struct cylfuse_cylinder *model,
                                     const struct cylfuse_mask_view *mask,
                                     struct cylfuse_extent *out_extent)
CYLFUSE_NOEXCEPT;

/**
 * Selects, of straight edges that a line detector found in the image, those on the two limbs of a rough cylinder
 * beside the points that were pushed, such as a fit to these points alone. For each limb the edge with the longest
 * pieces wins, the nearer the limb the better, if they cover 30 % of it. Nothing is pushed.
 *
 * @param fitter the fitter, with intrinsics and points
 * @param model the rough cylinder; NULL = that of the last fit
 * @param segments the edges in pixels of the (distorted) image; weights are ignored
 * @param reach how far a limb may be from that of the model, in pixels, 0 or greater; 0 = 15 % of the distance of
 *   the limbs, at least 4
 * @param out_limbs room for `capacity` bytes, one for each segment: 1 or 2 for the limb that it lies on, in the
 *   order of `cylfuse_cylinder_project`, 0 for none. May be NULL when `capacity` is 0.
 * @param capacity at least the count of the segments
 * @return BAD_STATE without model, intrinsics or points, INVALID_ARGUMENT for a bad segment or reach, EDGE_GEOMETRY
 *   when the camera is inside the cylinder or a limb cannot be seen, BUFFER_TOO_SMALL; nothing is written then
 */
CYLFUSE_API
cylfuse_status cylfuse_fitter_select_edges(const struct cylfuse_fitter *fitter,
                                           const struct cylfuse_cylinder *model,
                                           const struct cylfuse_segments_view *segments,
                                           double reach,
                                           uint8_t *out_limbs,
                                           size_t capacity)
CYLFUSE_NOEXCEPT;

/**
 * Signed distances of points from the surface, negative inside.
 *
 * @param model the cylinder
 * @param points the points; weights are ignored
 * @param out room for `capacity` doubles, row by row of the points; NaN for a point with a coordinate that is not
 *   finite, or so far away that no number holds its distance. Of any alignment; must not overlap with the points. May be
 *   NULL when `capacity` is 0.
 * @param capacity at least width * height of the points
 * @return INVALID_ARGUMENT, STRUCT_SIZE, BUFFER_TOO_SMALL; nothing is written then
 */
CYLFUSE_API
cylfuse_status cylfuse_cylinder_distances(const struct cylfuse_cylinder *model,
                                          const struct cylfuse_points_view *points,
                                          double *out,
                                          size_t capacity)
CYLFUSE_NOEXCEPT;

/**
 * The two limb lines of a cylinder in the image: a u + b v + c = 0 with a^2 + b^2 = 1, in ideal pixels, which
 * are those of a pinhole with the same fx, fy, cx and cy: without distortion the pixels of the image. The cylinder has no
 * ends here: whether its visible part lies before the camera is not asked.
 *
 * @param model the cylinder in the camera frame
 * @param intrinsics the camera
 * @param out_lines room for 6 doubles: a, b, c of the first line, then of the second. Of any alignment.
 * @return EDGE_GEOMETRY when the camera is inside the cylinder or a line lies at infinity, INVALID_ARGUMENT,
 *   INVALID_INTRINSICS, STRUCT_SIZE; nothing is written then
 */
CYLFUSE_API
cylfuse_status cylfuse_cylinder_project(const struct cylfuse_cylinder *model,
                                        const struct cylfuse_intrinsics *intrinsics,
                                        double *out_lines)
CYLFUSE_NOEXCEPT;

/**
 * How two cylinders differ.
 *
 * @param a the first cylinder, such as the truth
 * @param b the second cylinder
 * @param out_angle angle between the axes in radians, in [0, pi / 2], whatever the signs of the directions
 * @param out_axis_distance shortest distance between the two axes, in the unit of length
 * @param out_radius_relative (radius of b - radius of a) / radius of a
 * @return INVALID_ARGUMENT for a bad cylinder, NUMERICAL where no number holds a difference; nothing is written then
 */
CYLFUSE_API
cylfuse_status cylfuse_cylinder_compare(const struct cylfuse_cylinder *a,
                                        const struct cylfuse_cylinder *b,
                                        double *out_angle,
                                        double *out_axis_distance,
                                        double *out_radius_relative)
CYLFUSE_NOEXCEPT;

/**
 * What to expect of measurements of a cylinder with a camera: standard deviations by the covariance at the exact view. The
 * middle of the axis lies on the optical axis. Unlike elsewhere in the interface lengths are in metres, as the noise of the
 * structured light is known in them; angles are in radians.
 *
 * @param intrinsics the camera of the image, on whose pixels the depth is
 * @param cylinder 5 doubles: the distance from the camera to the middle of the axis; radius; length; the tilt of the axis
 *   out of the plane of the image, from -1.4 to 1.4; its angle in the image from the vertical
 * @param noise 6 doubles, or NULL for those of the structured light of the twin and an ordinary image: a, b, c of the noise of
 *   depth a + b z + c z^2 at the depth z; the side of the squares of pixels that share it, at least 1; the noise of a pixel
 *   of the image as a part of the step of brightness at limbs and ends; the blur of the image in pixels
 * @param out_scatter room for 4 doubles: the standard deviations of captures of one scene about each other, of radius,
 *   direction (radians), position of the axis and length; NaN for the length where an end lies outside the image
 * @param out_total room for 4 doubles: the same of a measurement about the truth, which is what a fit states
 * @return INVALID_ARGUMENT, INVALID_INTRINSICS, TOO_FEW_POINTS when the pixels that see the cylinder are worth fewer than 8
 *   points with independent noise, NUMERICAL where the view does not determine it, STRUCT_SIZE; nothing is written then
 */
CYLFUSE_API
cylfuse_status cylfuse_plan(const struct cylfuse_intrinsics *intrinsics,
                            const double *cylinder,
                            const double *noise,
                            double *out_scatter,
                            double *out_total)
CYLFUSE_NOEXCEPT;

/**
 * The pixels of the (distorted) image at which a camera sees points.
 *
 * @param intrinsics the camera
 * @param points in the camera frame; weights and normals are ignored
 * @param out_pixels room for `capacity` pixels of 2 doubles, x and y, row by row of the points. Pixels may lie beyond
 *   the border of the image; NaN for a point that is not finite, not in front of the camera or outside the field of
 *   its model. Of any alignment; must not overlap with the points. May be NULL when `capacity` is 0.
 * @param capacity at least width * height of the points
 * @return INVALID_INTRINSICS, INVALID_ARGUMENT, STRUCT_SIZE, BUFFER_TOO_SMALL; nothing is written then
 */
CYLFUSE_API
cylfuse_status cylfuse_intrinsics_project(const struct cylfuse_intrinsics *intrinsics,
                                          const struct cylfuse_points_view *points,
                                          double *out_pixels,
                                          size_t capacity)
CYLFUSE_NOEXCEPT;

/**
 * The rays along which a camera sees pixels of the (distorted) image: the points at z = 1 of its frame.
 *
 * The ray of an ideal pixel, as those of limb lines are, is that of the same intrinsics without distortion.
 *
 * @param intrinsics the camera
 * @param pixels `count` pixels of 2 doubles, x and y, in the image or beyond its border; of any alignment. May be NULL
 *   when `count` is 0.
 * @param count how many pixels
 * @param out_rays room for `count` rays of 3 doubles, x, y and z = 1; NaN for a pixel that is not finite or for which
 *   the model has no ray. Of any alignment; must not overlap with the pixels. May be NULL when `count` is 0.
 * @return INVALID_INTRINSICS, INVALID_ARGUMENT, STRUCT_SIZE; nothing is written then
 */
CYLFUSE_API
cylfuse_status cylfuse_intrinsics_unproject(const struct cylfuse_intrinsics *intrinsics,
                                            const double *pixels,
                                            size_t count,
                                            double *out_rays)
CYLFUSE_NOEXCEPT;

/**
 * Decides whether a measured length, such as a radius or a diameter, conforms to a tolerance, by the rule of ISO
 * 14253-1: the value with `coverage` deviations on either side lies within the limits, or outside, or the measurement
 * does not tell.
 *
 * For the radius of a fit give `model.radius` and `radius_deviation` of its `cylfuse_cylinder_estimate`, for its
 * diameter twice of both, and `flags` of its `cylfuse_result`. Nothing is decided with a warning of which the deviation
 * says nothing: POOR_FIT, POINTS_AND_LIMBS_DISAGREE, BODY_TAPERS, MASK_DISAGREES, DEPTH_SHIFTED, HIDDEN_WALL,
 * MASK_ENDS_WITH_DEPTH, NOT_CONVERGED, RADIUS_AT_LIMIT, AXIS_AT_LIMIT, SCALE_HELD, RESOLUTION_LOST, UNCERTAINTY_UNKNOWN.
 * A deviation covers the noise of the data and what the options say that all points share, not a wrong scale of the depth
 * nor wrong intrinsics: a decision is as good as that. The length of an extent with an end that is not SEEN is that of the
 * visible part: of the whole only NOT_CONFORMING above the upper limit is true.
 *
 * @param value in any unit of length, finite
 * @param deviation its standard deviation, in that unit. NaN, as of a method that states none, and 0, as of a radius
 *   that the limits of the fit fix, decide nothing.
 * @param flags the warnings of the result; 0 for none
 * @param lower the lower limit, which conforms itself, in that unit; -INFINITY for none
 * @param upper the upper limit likewise, greater than `lower`; INFINITY for none. One of the two must be finite.
 * @param coverage the coverage factor k, finite and 0 or greater; 0 = 2
 * @param out_conformity where the decision goes
 * @return INVALID_ARGUMENT, also for an unknown bit of `flags`; nothing is written then
 */
CYLFUSE_API
cylfuse_status cylfuse_decide_conformity(double value,
                                         double deviation,
                                         cylfuse_result_flags flags,
                                         double lower,
                                         double upper,
                                         double coverage,
                                         cylfuse_conformity *out_conformity)
CYLFUSE_NOEXCEPT;

/**
 * A warning as text: its name without its prefix, a colon, and what it means in a few words. Static; a text for
 * unknown bits and for none or several of them, too. Of several, ask for each bit that is set.
 */
CYLFUSE_API
const char *cylfuse_flag_string(cylfuse_result_flags flag)
CYLFUSE_NOEXCEPT;

/**
 * Why an iteration ended, as text: the name of the constant without its prefix, a colon, and what it means in a few
 * words. Static; a text for unknown numbers too.
 */
CYLFUSE_API
const char *cylfuse_termination_string(cylfuse_termination termination)
CYLFUSE_NOEXCEPT;

/**
 * Where an iteration started, as text: the name of the constant without its prefix, a colon, and what it means in a few
 * words. Static; a text for unknown numbers too.
 */
CYLFUSE_API
const char *cylfuse_start_string(cylfuse_start start)
CYLFUSE_NOEXCEPT;

/**
 * What an end of the visible cylinder is, as text: the name of the constant without its prefix, a colon, and what it
 * means in a few words. Static; a text for unknown numbers too.
 */
CYLFUSE_API
const char *cylfuse_end_state_string(cylfuse_end_state state)
CYLFUSE_NOEXCEPT;

/**
 * What the position of an end was taken from, as text: the name of the constant without its prefix, a colon, and what
 * it means in a few words. Static; a text for unknown numbers too.
 */
CYLFUSE_API
const char *cylfuse_end_source_string(cylfuse_end_source source)
CYLFUSE_NOEXCEPT;

/**
 * Whether a limb was located in the image, or why not, as text: the name of the constant without its prefix, a colon,
 * and what it means in a few words. Static; a text for unknown numbers too.
 */
CYLFUSE_API
const char *cylfuse_limb_status_string(cylfuse_limb_status status)
CYLFUSE_NOEXCEPT;

/**
 * What a point in the mask belongs to, as text: the name of the constant without its prefix, a colon, and what it
 * means in a few words. Static; a text for unknown numbers too.
 */
CYLFUSE_API
const char *cylfuse_part_string(cylfuse_part part)
CYLFUSE_NOEXCEPT;

/**
 * What a measurement says about a tolerance, as text: the name of the constant without its prefix, a colon, and what it
 * means in a few words. Static; a text for unknown numbers too.
 */
CYLFUSE_API
const char *cylfuse_conformity_string(cylfuse_conformity conformity)
CYLFUSE_NOEXCEPT;

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CYLFUSE_H */
