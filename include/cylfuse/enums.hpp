/* SPDX-License-Identifier: MIT OR Apache-2.0 */

/**
 * @file enums.hpp
 * The constants of cylfuse.h as enumerations. What each of them means is said at the constant of its value. Include
 * cylfuse.hpp.
 */

#ifndef CYLFUSE_ENUMS_HPP
#define CYLFUSE_ENUMS_HPP

#include <cylfuse/cylfuse.h>

namespace cylfuse {

/** What a call returns: Ok when it did what it was asked to, else why not. */
enum class Status : cylfuse_status {
    Ok = CYLFUSE_STATUS_OK,
    InvalidArgument = CYLFUSE_STATUS_INVALID_ARGUMENT,
    NullPointer = CYLFUSE_STATUS_NULL_POINTER,
    StructSize = CYLFUSE_STATUS_STRUCT_SIZE,
    AbiMismatch = CYLFUSE_STATUS_ABI_MISMATCH,
    BadState = CYLFUSE_STATUS_BAD_STATE,
    Busy = CYLFUSE_STATUS_BUSY,
    BufferTooSmall = CYLFUSE_STATUS_BUFFER_TOO_SMALL,
    OutOfMemory = CYLFUSE_STATUS_OUT_OF_MEMORY,
    Unsupported = CYLFUSE_STATUS_UNSUPPORTED,
    SizeMismatch = CYLFUSE_STATUS_SIZE_MISMATCH,
    InvalidIntrinsics = CYLFUSE_STATUS_INVALID_INTRINSICS,
    TooFewPoints = CYLFUSE_STATUS_TOO_FEW_POINTS,
    PlanarPoints = CYLFUSE_STATUS_PLANAR_POINTS,
    CollinearPoints = CYLFUSE_STATUS_COLLINEAR_POINTS,
    EmptyMask = CYLFUSE_STATUS_EMPTY_MASK,
    NoDepth = CYLFUSE_STATUS_NO_DEPTH,
    NoStart = CYLFUSE_STATUS_NO_START,
    EdgeGeometry = CYLFUSE_STATUS_EDGE_GEOMETRY,
    Numerical = CYLFUSE_STATUS_NUMERICAL,
    Cancelled = CYLFUSE_STATUS_CANCELLED,
    Panic = CYLFUSE_STATUS_PANIC,
};

/** How the cylinder is estimated. */
enum class Method : cylfuse_method {
    Fused = CYLFUSE_METHOD_FUSED,
    Points = CYLFUSE_METHOD_POINTS,
    Ransac = CYLFUSE_METHOD_RANSAC,
    Eberly = CYLFUSE_METHOD_EBERLY,
};

/** What Method::Fused minimises. */
enum class Objective : cylfuse_objective {
    Robust = CYLFUSE_OBJECTIVE_ROBUST,
    Paper = CYLFUSE_OBJECTIVE_PAPER,
};

/** Where the iteration starts. */
enum class Start : cylfuse_start {
    Auto = CYLFUSE_START_AUTO,
    Limbs = CYLFUSE_START_LIMBS,
    Moments = CYLFUSE_START_MOMENTS,
    Ransac = CYLFUSE_START_RANSAC,
    Model = CYLFUSE_START_MODEL,
    Last = CYLFUSE_START_LAST,
};

/** Whether the points must lie on the wall of the cylinder that the camera sees. */
enum class NearWall : cylfuse_near_wall {
    Auto = CYLFUSE_NEAR_WALL_AUTO,
    On = CYLFUSE_NEAR_WALL_ON,
    Off = CYLFUSE_NEAR_WALL_OFF,
};

/** The coordinates in which the iteration steps. */
enum class Chart : cylfuse_chart {
    Auto = CYLFUSE_CHART_AUTO,
    Local = CYLFUSE_CHART_LOCAL,
    Orthonormal = CYLFUSE_CHART_ORTHONORMAL,
};

/** Whether a detector looks at the image of a frame. */
enum class ImageUse : cylfuse_image_use {
    Auto = CYLFUSE_IMAGE_USE_AUTO,
    Ignore = CYLFUSE_IMAGE_USE_IGNORE,
};

/** What given edge segments are. */
enum class EdgeUse : cylfuse_edge_use {
    Refine = CYLFUSE_EDGE_USE_REFINE,
    AsGiven = CYLFUSE_EDGE_USE_AS_GIVEN,
};

/** How the ends of the visible cylinder are found in a mask. */
enum class ExtentRule : cylfuse_extent_rule {
    Auto = CYLFUSE_EXTENT_RULE_AUTO,
    Extremes = CYLFUSE_EXTENT_RULE_EXTREMES,
    Located = CYLFUSE_EXTENT_RULE_LOCATED,
};

/** The distortion of the lens. */
enum class Distortion : cylfuse_distortion {
    None = CYLFUSE_DISTORTION_NONE,
    BrownConrady = CYLFUSE_DISTORTION_BROWN_CONRADY,
    KannalaBrandt = CYLFUSE_DISTORTION_KANNALA_BRANDT,
};

/** How a depth is stored in a pixel. */
enum class DepthFormat : cylfuse_depth_format {
    U16 = CYLFUSE_DEPTH_FORMAT_U16,
    F32 = CYLFUSE_DEPTH_FORMAT_F32,
};

/** How a pixel of an image is stored. */
enum class ImageFormat : cylfuse_image_format {
    U8 = CYLFUSE_IMAGE_FORMAT_U8,
    U16 = CYLFUSE_IMAGE_FORMAT_U16,
    F32 = CYLFUSE_IMAGE_FORMAT_F32,
    Rgb8 = CYLFUSE_IMAGE_FORMAT_RGB8,
    Bgr8 = CYLFUSE_IMAGE_FORMAT_BGR8,
    Rgba8 = CYLFUSE_IMAGE_FORMAT_RGBA8,
    Bgra8 = CYLFUSE_IMAGE_FORMAT_BGRA8,
};

/** Warnings about a result, one bit each; joined by |. */
enum class ResultFlags : cylfuse_result_flags {
    EdgesIgnored = CYLFUSE_RESULT_FLAGS_EDGES_IGNORED,
    SegmentsUnusable = CYLFUSE_RESULT_FLAGS_SEGMENTS_UNUSABLE,
    EdgesCross = CYLFUSE_RESULT_FLAGS_EDGES_CROSS,
    EdgesCoincide = CYLFUSE_RESULT_FLAGS_EDGES_COINCIDE,
    EdgesBehind = CYLFUSE_RESULT_FLAGS_EDGES_BEHIND,
    ScaleHeld = CYLFUSE_RESULT_FLAGS_SCALE_HELD,
    WeakRadius = CYLFUSE_RESULT_FLAGS_WEAK_RADIUS,
    ResolutionLost = CYLFUSE_RESULT_FLAGS_RESOLUTION_LOST,
    NotConverged = CYLFUSE_RESULT_FLAGS_NOT_CONVERGED,
    HiddenWall = CYLFUSE_RESULT_FLAGS_HIDDEN_WALL,
    CameraInside = CYLFUSE_RESULT_FLAGS_CAMERA_INSIDE,
    PointsNotFinite = CYLFUSE_RESULT_FLAGS_POINTS_NOT_FINITE,
    PointsAndLimbsDisagree = CYLFUSE_RESULT_FLAGS_POINTS_AND_LIMBS_DISAGREE,
    RadiusAtLimit = CYLFUSE_RESULT_FLAGS_RADIUS_AT_LIMIT,
    AxisAtLimit = CYLFUSE_RESULT_FLAGS_AXIS_AT_LIMIT,
    UncertaintyUnknown = CYLFUSE_RESULT_FLAGS_UNCERTAINTY_UNKNOWN,
    DepthShifted = CYLFUSE_RESULT_FLAGS_DEPTH_SHIFTED,
    MaskEndsWithDepth = CYLFUSE_RESULT_FLAGS_MASK_ENDS_WITH_DEPTH,
    PoorFit = CYLFUSE_RESULT_FLAGS_POOR_FIT,
    BodyTapers = CYLFUSE_RESULT_FLAGS_BODY_TAPERS,
    MaskDisagrees = CYLFUSE_RESULT_FLAGS_MASK_DISAGREES,
};

/** Both. */
constexpr ResultFlags operator|(ResultFlags a, ResultFlags b) noexcept
{
    return ResultFlags(cylfuse_result_flags(a) | cylfuse_result_flags(b));
}

/** Why an iteration ended. */
enum class Termination : cylfuse_termination {
    None = CYLFUSE_TERMINATION_NONE,
    Cost = CYLFUSE_TERMINATION_COST,
    Stalled = CYLFUSE_TERMINATION_STALLED,
    MaxIterations = CYLFUSE_TERMINATION_MAX_ITERATIONS,
    RadiusRanAway = CYLFUSE_TERMINATION_RADIUS_RAN_AWAY,
    Gradient = CYLFUSE_TERMINATION_GRADIENT,
    Step = CYLFUSE_TERMINATION_STEP,
};

/** What an end of the visible cylinder is. */
enum class EndState : cylfuse_end_state {
    Unknown = CYLFUSE_END_STATE_UNKNOWN,
    Seen = CYLFUSE_END_STATE_SEEN,
    Cut = CYLFUSE_END_STATE_CUT,
    Hidden = CYLFUSE_END_STATE_HIDDEN,
};

/**
 * What the position of an end was taken from. Mask: where the lines along the surface leave the mask, or where within the mask
 * the depth shows that the body ends. Image: mostly the arc of the end circle in the image.
 */
enum class EndSource : cylfuse_end_source {
    Extreme = CYLFUSE_END_SOURCE_EXTREME,
    Mask = CYLFUSE_END_SOURCE_MASK,
    Image = CYLFUSE_END_SOURCE_IMAGE,
    Border = CYLFUSE_END_SOURCE_BORDER,
    Points = CYLFUSE_END_SOURCE_POINTS,
};

/** Data of a view, one bit each; joined by |. */
enum class Input : cylfuse_input {
    Points = CYLFUSE_INPUT_POINTS,
    Depth = CYLFUSE_INPUT_DEPTH,
    Edges = CYLFUSE_INPUT_EDGES,
    Image = CYLFUSE_INPUT_IMAGE,
};

/** Both. */
constexpr Input operator|(Input a, Input b) noexcept
{
    return Input(cylfuse_input(a) | cylfuse_input(b));
}

/** What a fit is doing. */
enum class Phase : cylfuse_phase {
    Start = CYLFUSE_PHASE_START,
    Solve = CYLFUSE_PHASE_SOLVE,
};

/** What a detector is doing. */
enum class DetectionPhase : cylfuse_detection_phase {
    Search = CYLFUSE_DETECTION_PHASE_SEARCH,
    Fit = CYLFUSE_DETECTION_PHASE_FIT,
};

/** How much a log line matters. */
enum class LogLevel : cylfuse_log_level {
    Off = CYLFUSE_LOG_LEVEL_OFF,
    Error = CYLFUSE_LOG_LEVEL_ERROR,
    Warning = CYLFUSE_LOG_LEVEL_WARNING,
    Info = CYLFUSE_LOG_LEVEL_INFO,
    Debug = CYLFUSE_LOG_LEVEL_DEBUG,
};

/** Which residuals to list. */
enum class ResidualKind : cylfuse_residual_kind {
    Points = CYLFUSE_RESIDUAL_KIND_POINTS,
    Edges = CYLFUSE_RESIDUAL_KIND_EDGES,
};

/** Whether a limb was located in the image, or why not. */
enum class LimbStatus : cylfuse_limb_status {
    Located = CYLFUSE_LIMB_STATUS_LOCATED,
    NotSearched = CYLFUSE_LIMB_STATUS_NOT_SEARCHED,
    NoLimbs = CYLFUSE_LIMB_STATUS_NO_LIMBS,
    TooShort = CYLFUSE_LIMB_STATUS_TOO_SHORT,
    NoEdge = CYLFUSE_LIMB_STATUS_NO_EDGE,
    OutOfReach = CYLFUSE_LIMB_STATUS_OUT_OF_REACH,
    Uncertain = CYLFUSE_LIMB_STATUS_UNCERTAIN,
    Patchy = CYLFUSE_LIMB_STATUS_PATCHY,
    SameLine = CYLFUSE_LIMB_STATUS_SAME_LINE,
};

/** What a point in the mask belongs to. */
enum class Part : cylfuse_part {
    Body = CYLFUSE_PART_BODY,
    Cap = CYLFUSE_PART_CAP,
    InnerWall = CYLFUSE_PART_INNER_WALL,
    Other = CYLFUSE_PART_OTHER,
    Behind = CYLFUSE_PART_BEHIND,
};

/** What a measurement says about a tolerance. */
enum class Conformity : cylfuse_conformity {
    Undecided = CYLFUSE_CONFORMITY_UNDECIDED,
    Conforming = CYLFUSE_CONFORMITY_CONFORMING,
    NotConforming = CYLFUSE_CONFORMITY_NOT_CONFORMING,
};

/** How the points of an output buffer are arranged. */
enum class Layout : cylfuse_layout {
    Packed = CYLFUSE_LAYOUT_PACKED,
    Organised = CYLFUSE_LAYOUT_ORGANISED,
};

} // namespace cylfuse

#endif
