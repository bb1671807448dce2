"""The structs of cylfuse.h, field by field; a test compares them with the layout that the library is held to."""

from ctypes import (
    CFUNCTYPE,
    POINTER,
    Structure,
    c_char_p,
    c_double,
    c_int32,
    c_size_t,
    c_ssize_t,
    c_uint32,
    c_uint64,
    c_void_p,
)
from typing import Any


class _View(Structure):
    """A description of memory; it keeps the arrays whose memory that is."""

    array: Any


class Cylinder(Structure):
    _fields_ = [
        ("point", c_double * 3),
        ("direction", c_double * 3),
        ("radius", c_double),
    ]


class Options(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("method", c_int32),
        ("objective", c_int32),
        ("start", c_int32),
        ("near_wall", c_int32),
        ("chart", c_int32),
        ("edge_use", c_int32),
        ("extent_rule", c_int32),
        ("max_threads", c_uint32),
        ("max_iterations", c_uint32),
        ("cost_tolerance", c_double),
        ("gradient_tolerance", c_double),
        ("step_tolerance", c_double),
        ("initial_lambda", c_double),
        ("lambda_factor", c_double),
        ("max_lambda", c_double),
        ("edge_weight", c_double),
        ("seed", c_uint64),
        ("ransac_max_iterations", c_uint64),
        ("ransac_threshold", c_double),
        ("independent_points", c_double),
        ("depth_noise", c_double),
        ("image_noise", c_double),
        ("edge_noise", c_double),
        ("mask_noise", c_double),
        ("image_blur", c_double),
        ("drawn_pixel", c_double),
        ("radius_min", c_double),
        ("radius_max", c_double),
        ("axis", c_double * 3),
        ("axis_max_angle", c_double),
        ("depth_shared", c_double),
    ]


class DetectorOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("image_use", c_int32),
        ("max_threads", c_uint32),
        ("max_count", c_uint32),
        ("min_pixels", c_uint64),
        ("min_score", c_double),
        ("radius_min", c_double),
        ("radius_max", c_double),
        ("axis", c_double * 3),
        ("axis_max_angle", c_double),
    ]


class Intrinsics(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("distortion_model", c_int32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("fx", c_double),
        ("fy", c_double),
        ("cx", c_double),
        ("cy", c_double),
        ("distortion", c_double * 8),
    ]


class PointsView(_View):
    _fields_ = [
        ("struct_size", c_uint32),
        ("scalar", c_int32),
        ("data", c_void_p),
        ("width", c_size_t),
        ("height", c_size_t),
        ("point_stride", c_ssize_t),
        ("row_stride", c_ssize_t),
        ("weights", c_void_p),
        ("weight_stride", c_ssize_t),
        ("weight_row_stride", c_ssize_t),
        ("normals", c_void_p),
        ("normal_stride", c_ssize_t),
        ("normal_row_stride", c_ssize_t),
    ]


class DepthView(_View):
    _fields_ = [
        ("struct_size", c_uint32),
        ("format", c_int32),
        ("data", c_void_p),
        ("width", c_uint32),
        ("height", c_uint32),
        ("row_stride", c_ssize_t),
        ("pixel_stride", c_ssize_t),
        ("scale", c_double),
        ("min_depth", c_double),
        ("max_depth", c_double),
    ]


class MaskView(_View):
    _fields_ = [
        ("struct_size", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("label", c_uint32),
        ("data", c_void_p),
        ("row_stride", c_ssize_t),
        ("pixel_stride", c_ssize_t),
    ]


class ImageView(_View):
    _fields_ = [
        ("struct_size", c_uint32),
        ("format", c_int32),
        ("data", c_void_p),
        ("width", c_uint32),
        ("height", c_uint32),
        ("row_stride", c_ssize_t),
        ("pixel_stride", c_ssize_t),
        ("gamma", c_double),
    ]


class SegmentsView(_View):
    _fields_ = [
        ("struct_size", c_uint32),
        ("scalar", c_int32),
        ("data", c_void_p),
        ("count", c_size_t),
        ("segment_stride", c_ssize_t),
        ("weights", c_void_p),
    ]


class PointsOut(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("scalar", c_int32),
        ("data", c_void_p),
        ("capacity", c_size_t),
        ("point_stride", c_ssize_t),
        ("row_stride", c_ssize_t),
    ]


class DepthOut(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("format", c_int32),
        ("data", c_void_p),
        ("width", c_uint32),
        ("height", c_uint32),
        ("row_stride", c_ssize_t),
        ("pixel_stride", c_ssize_t),
        ("scale", c_double),
    ]


class Counts(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("view", c_uint32),
        ("points_given", c_uint64),
        ("points_used", c_uint64),
        ("dropped_not_finite", c_uint64),
        ("dropped_zero_weight", c_uint64),
        ("dropped_outside_mask", c_uint64),
        ("dropped_no_depth", c_uint64),
        ("dropped_out_of_range", c_uint64),
        ("dropped_outside_camera", c_uint64),
        ("dropped_hidden", c_uint64),
        ("segments_given", c_uint64),
    ]


class Result(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("flags", c_uint32),
        ("termination", c_int32),
        ("iterations", c_uint32),
        ("rejected_steps", c_uint32),
        ("limbs_located", c_uint32),
        ("segments_given", c_uint32),
        ("segments_used", c_uint32),
        ("points_given", c_uint64),
        ("points_used", c_uint64),
        ("independent_points", c_double),
        ("point_deviation", c_double),
        ("point_rms", c_double),
        ("edge_rms_pixels", c_double),
        ("near_wall_fraction", c_double),
        ("initial_cost", c_double),
        ("cost", c_double),
        ("energy_points", c_double),
        ("energy_edges", c_double),
        ("edge_weight", c_double),
        ("condition", c_double),
        ("gradient_norm", c_double),
        ("step_norm", c_double),
        ("lambda", c_double),
        ("seconds_start", c_double),
        ("seconds_solve", c_double),
        ("seconds_total", c_double),
    ]


class CylinderEstimate(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("start_kind", c_int32),
        ("model", Cylinder),
        ("start_model", Cylinder),
        ("radius_deviation", c_double),
        ("direction_deviation", c_double),
        ("position_deviation", c_double),
        ("radius_from_points", c_double),
        ("radius_from_points_deviation", c_double),
        ("radius_from_limbs", c_double),
        ("radius_from_limbs_deviation", c_double),
        ("radius_z_score", c_double),
        ("covariance", c_double * 49),
    ]


class CylinderDiagnosis(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("rank", c_uint32),
        ("singular_values", c_double * 5),
        ("condition", c_double),
        ("weakest_shift", c_double * 3),
        ("weakest_tilt", c_double * 3),
        ("weakest_radius", c_double),
    ]


class Completion(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("view", c_uint32),
        ("count", c_uint64),
        ("hits", c_uint64),
        ("misses", c_uint64),
        ("outside_camera", c_uint64),
        ("out_of_range", c_uint64),
    ]


class Extent(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("start_state", c_int32),
        ("end_state", c_int32),
        ("start_source", c_int32),
        ("end_source", c_int32),
        ("start_view", c_uint32),
        ("end_view", c_uint32),
        ("limbs_known", c_uint32),
        ("start", c_double * 3),
        ("end", c_double * 3),
        ("center", c_double * 3),
        ("length", c_double),
        ("start_deviation", c_double),
        ("end_deviation", c_double),
        ("length_deviation", c_double),
        ("start_covariance", c_double * 9),
        ("end_covariance", c_double * 9),
        ("center_covariance", c_double * 9),
    ]


class Progress(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("phase", c_int32),
        ("iteration", c_uint32),
        ("max_iterations", c_uint32),
        ("cost", c_double),
        ("lambda", c_double),
        ("cylinder", POINTER(Cylinder)),
    ]


class DetectionProgress(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("phase", c_int32),
        ("fits_done", c_uint32),
        ("fits", c_uint32),
    ]


class Detection(Structure):
    _fields_ = [
        ("score", c_double),
        ("pixels", c_uint64),
        ("model", Cylinder),
    ]


class Limb(Structure):
    _fields_ = [
        ("view", c_uint32),
        ("limb", c_uint32),
        ("status", c_int32),
        ("samples", c_uint32),
        ("line", c_double * 4),
        ("deviation", c_double),
    ]


class LimbSample(Structure):
    _fields_ = [
        ("view", c_uint32),
        ("limb", c_uint32),
        ("pixel", c_double * 2),
        ("deviation", c_double),
        ("weight", c_double),
    ]


class EndSample(Structure):
    _fields_ = [
        ("view", c_uint32),
        ("end", c_uint32),
        ("pixel", c_double * 2),
        ("normal", c_double * 2),
        ("deviation", c_double),
    ]


ProgressFunction = CFUNCTYPE(c_int32, POINTER(Progress), c_void_p)
DetectionProgressFunction = CFUNCTYPE(c_int32, POINTER(DetectionProgress), c_void_p)
FitEndedFunction = CFUNCTYPE(c_int32, c_size_t, c_int32, c_void_p)
LogFunction = CFUNCTYPE(None, c_int32, c_char_p, c_void_p)
