"""The shared library: where it is found and the types of its functions."""

from __future__ import annotations

import ctypes
import os
import pathlib
import sys
from ctypes import POINTER, byref, c_char_p, c_double, c_int32, c_size_t, c_uint8, c_uint32, c_void_p, sizeof
from typing import Any, Type, TypeVar

from . import _structs as structs

#: The binary interface that this package was written for.
ABI_VERSION = 1

_NAMES = {"win32": "cylfuse.dll", "darwin": "libcylfuse.dylib"}


def library_path() -> str:
    """The path of the shared library: the environment variable CYLFUSE_LIBRARY, else the one in the package."""
    given = os.environ.get("CYLFUSE_LIBRARY")
    if given:
        return given
    path = pathlib.Path(__file__).with_name(_NAMES.get(sys.platform, "libcylfuse.so"))
    if not path.is_file():
        raise ImportError(
            f"{path} is not there: install a wheel of cylfuse for this platform, or set CYLFUSE_LIBRARY to the "
            "path of the shared library"
        )
    return str(path)


def _load() -> Any:
    path = library_path()
    try:
        library = ctypes.CDLL(path)  # releases the GIL during every call
        found = library.cylfuse_abi_version()
    except (OSError, AttributeError) as error:
        raise ImportError(
            f"{path} could not be loaded as the library of cylfuse: {error}; leave CYLFUSE_LIBRARY unset, or set it to "
            "the path of the shared library"
        ) from error
    if found != ABI_VERSION:
        raise ImportError(
            f"{path} has version {found} of the binary interface but this package needs {ABI_VERSION}; install package "
            "and library of one release"
        )
    fitter, frame, detector, status, size = c_void_p, c_void_p, c_void_p, c_int32, c_size_t
    cylinder = POINTER(structs.Cylinder)
    mask = POINTER(structs.MaskView)
    points = POINTER(structs.PointsView)
    depth = POINTER(structs.DepthView)
    image = POINTER(structs.ImageView)
    segments = POINTER(structs.SegmentsView)
    intrinsics = POINTER(structs.Intrinsics)
    options = POINTER(structs.Options)
    detector_options = POINTER(structs.DetectorOptions)
    result = POINTER(structs.Result)
    estimate = POINTER(structs.CylinderEstimate)
    completion = POINTER(structs.Completion)
    extent = POINTER(structs.Extent)
    number = POINTER(c_double)
    count = POINTER(c_size_t)
    # An array of structs: where it goes, the size of an element, how many there is room for, how many there are.
    array = [c_void_p, size, size, count]
    signatures: dict[str, tuple[Any, list[Any]]] = {
        "cylfuse_abi_version": (c_uint32, []),
        "cylfuse_version_number": (c_uint32, []),
        "cylfuse_version_string": (c_char_p, []),
        "cylfuse_build_info": (c_char_p, []),
        "cylfuse_status_string": (c_char_p, [status]),
        "cylfuse_flag_string": (c_char_p, [c_uint32]),
        "cylfuse_termination_string": (c_char_p, [c_int32]),
        "cylfuse_start_string": (c_char_p, [c_int32]),
        "cylfuse_end_state_string": (c_char_p, [c_int32]),
        "cylfuse_end_source_string": (c_char_p, [c_int32]),
        "cylfuse_limb_status_string": (c_char_p, [c_int32]),
        "cylfuse_part_string": (c_char_p, [c_uint8]),
        "cylfuse_conformity_string": (c_char_p, [c_int32]),
        "cylfuse_options_init": (status, [options, size]),
        "cylfuse_detector_options_init": (status, [detector_options, size]),
        "cylfuse_intrinsics_init": (status, [intrinsics, size]),
        "cylfuse_points_view_init": (status, [points, size]),
        "cylfuse_depth_view_init": (status, [depth, size]),
        "cylfuse_mask_view_init": (status, [mask, size]),
        "cylfuse_image_view_init": (status, [image, size]),
        "cylfuse_segments_view_init": (status, [segments, size]),
        "cylfuse_points_out_init": (status, [POINTER(structs.PointsOut), size]),
        "cylfuse_depth_out_init": (status, [POINTER(structs.DepthOut), size]),
        "cylfuse_counts_init": (status, [POINTER(structs.Counts), size]),
        "cylfuse_result_init": (status, [result, size]),
        "cylfuse_cylinder_estimate_init": (status, [estimate, size]),
        "cylfuse_cylinder_diagnosis_init": (status, [POINTER(structs.CylinderDiagnosis), size]),
        "cylfuse_completion_init": (status, [completion, size]),
        "cylfuse_extent_init": (status, [extent, size]),
        "cylfuse_fitter_create": (status, [c_uint32, POINTER(fitter)]),
        "cylfuse_fitter_clone": (status, [fitter, POINTER(fitter)]),
        "cylfuse_fitter_destroy": (status, [fitter]),
        "cylfuse_fitter_reserve": (status, [fitter, size, size]),
        "cylfuse_fitter_clear": (status, [fitter]),
        "cylfuse_fitter_clear_input": (status, [fitter, c_uint32]),
        "cylfuse_fitter_last_error": (c_char_p, [fitter]),
        "cylfuse_fitter_cancel": (status, [fitter]),
        "cylfuse_fitter_set_options": (status, [fitter, options]),
        "cylfuse_fitter_get_options": (status, [fitter, options]),
        "cylfuse_fitter_select_view": (status, [fitter, size]),
        "cylfuse_fitter_view_count": (status, [fitter, count]),
        "cylfuse_fitter_set_pose": (status, [fitter, number, number]),
        "cylfuse_fitter_set_depth_camera": (status, [fitter, intrinsics, number, number]),
        "cylfuse_fitter_set_intrinsics": (status, [fitter, intrinsics]),
        # For users of `lib`: a fitter knows the object that it was given.
        "cylfuse_fitter_get_intrinsics": (status, [fitter, intrinsics]),
        "cylfuse_fitter_set_start_model": (status, [fitter, cylinder]),
        "cylfuse_fitter_set_progress": (status, [fitter, structs.ProgressFunction, c_void_p]),
        "cylfuse_fitter_set_log": (status, [fitter, c_int32, structs.LogFunction, c_void_p]),
        "cylfuse_fitter_push_points": (status, [fitter, points, mask]),
        "cylfuse_fitter_push_depth": (status, [fitter, depth, mask]),
        "cylfuse_fitter_push_image": (status, [fitter, image]),
        "cylfuse_fitter_push_edges": (status, [fitter, segments]),
        "cylfuse_fitter_counts": (status, [fitter, POINTER(structs.Counts)]),
        "cylfuse_frame_create": (status, [c_uint32, POINTER(frame)]),
        "cylfuse_frame_destroy": (status, [frame]),
        "cylfuse_frame_last_error": (c_char_p, [frame]),
        "cylfuse_frame_set_intrinsics": (status, [frame, intrinsics]),
        "cylfuse_frame_set_pose": (status, [frame, number, number]),
        "cylfuse_frame_set_depth_camera": (status, [frame, intrinsics, number, number]),
        "cylfuse_frame_set_depth": (status, [frame, depth]),
        "cylfuse_frame_set_image": (status, [frame, image]),
        "cylfuse_fitter_use_frame": (status, [fitter, frame, mask]),
        "cylfuse_fitter_fit": (status, [fitter, result, estimate]),
        "cylfuse_fit_all": (status, [c_void_p, size, c_uint32, structs.FitEndedFunction, c_void_p, c_void_p]),
        "cylfuse_fitter_evaluate": (status, [fitter, cylinder, result, estimate]),
        "cylfuse_fitter_get_result": (status, [fitter, result]),
        "cylfuse_fitter_get_cylinder": (status, [fitter, estimate]),
        "cylfuse_fitter_diagnose": (status, [fitter, cylinder, POINTER(structs.CylinderDiagnosis)]),
        "cylfuse_fitter_residuals": (status, [fitter, cylinder, c_int32, c_void_p, size, count]),
        "cylfuse_fitter_point_weights": (status, [fitter, c_void_p, c_void_p, size, count]),
        "cylfuse_fitter_point_parts": (status, [fitter, cylinder, c_void_p, size, count]),
        "cylfuse_fitter_limbs": (status, [fitter, *array]),
        "cylfuse_fitter_limb_samples": (status, [fitter, *array]),
        "cylfuse_fitter_end_samples": (status, [fitter, cylinder, mask, *array]),
        "cylfuse_fitter_complete_bound": (status, [fitter, mask, c_int32, count]),
        "cylfuse_fitter_complete": (
            status,
            [fitter, cylinder, mask, c_int32, POINTER(structs.PointsOut), completion],
        ),
        "cylfuse_fitter_complete_depth": (status, [fitter, cylinder, mask, POINTER(structs.DepthOut), completion]),
        "cylfuse_fitter_extent": (status, [fitter, cylinder, mask, extent]),
        "cylfuse_fitter_select_edges": (status, [fitter, cylinder, segments, c_double, c_void_p, size]),
        "cylfuse_detector_create": (status, [c_uint32, POINTER(detector)]),
        "cylfuse_detector_destroy": (status, [detector]),
        "cylfuse_detector_last_error": (c_char_p, [detector]),
        "cylfuse_detector_cancel": (status, [detector]),
        "cylfuse_detector_set_options": (status, [detector, detector_options]),
        "cylfuse_detector_get_options": (status, [detector, detector_options]),
        "cylfuse_detector_set_fit_options": (status, [detector, options]),
        "cylfuse_detector_get_fit_options": (status, [detector, options]),
        "cylfuse_detector_set_progress": (status, [detector, structs.DetectionProgressFunction, c_void_p]),
        "cylfuse_detector_detect": (status, [detector, frame]),
        "cylfuse_detector_detect_points": (status, [detector, points]),
        "cylfuse_detector_count": (status, [detector, count]),
        "cylfuse_detector_is_complete": (status, [detector, POINTER(c_int32)]),
        "cylfuse_detector_depth_moved": (status, [detector, POINTER(c_int32), POINTER(c_int32)]),
        "cylfuse_detector_detections": (status, [detector, *array]),
        "cylfuse_detector_get_result": (status, [detector, size, result]),
        "cylfuse_detector_get_cylinder": (status, [detector, size, estimate]),
        "cylfuse_detector_get_extent": (status, [detector, size, extent]),
        "cylfuse_detector_labels": (status, [detector, c_void_p, size, count]),
        "cylfuse_detector_indices": (status, [detector, size, c_void_p, size, count]),
        "cylfuse_detector_make_fitter": (status, [detector, size, POINTER(fitter)]),
        "cylfuse_cylinder_distances": (status, [cylinder, points, c_void_p, size]),
        "cylfuse_cylinder_project": (status, [cylinder, intrinsics, c_void_p]),
        "cylfuse_cylinder_compare": (status, [cylinder, cylinder, number, number, number]),
        "cylfuse_plan": (status, [intrinsics, c_void_p, c_void_p, c_void_p, c_void_p]),
        "cylfuse_decide_conformity": (
            status,
            [c_double, c_double, c_uint32, c_double, c_double, c_double, POINTER(c_int32)],
        ),
        "cylfuse_intrinsics_project": (status, [intrinsics, points, c_void_p, size]),
        "cylfuse_intrinsics_unproject": (status, [intrinsics, c_void_p, size, c_void_p]),
    }
    for name, (restype, argtypes) in signatures.items():
        try:
            function = getattr(library, name)
        except AttributeError:
            raise ImportError(
                f"{path} has no function {name}: it is older than this package; install package and library of one "
                "release"
            ) from None
        function.restype = restype
        function.argtypes = argtypes
    return library


#: The loaded library.
lib: Any = _load()

_S = TypeVar("_S", bound=ctypes.Structure)


def _defaults(kind: Type[_S], init: Any) -> _S:
    struct = kind()
    init(byref(struct), sizeof(struct))  # fails for a wrong size only, which the version rules out
    return struct


#: The structs as the library begins them: those that are filled here with its defaults, outputs with their size.
_FIRST: dict[Any, Any] = {
    kind: _defaults(kind, init)
    for kind, init in [
        (structs.Options, lib.cylfuse_options_init),
        (structs.DetectorOptions, lib.cylfuse_detector_options_init),
        (structs.Intrinsics, lib.cylfuse_intrinsics_init),
        (structs.PointsView, lib.cylfuse_points_view_init),
        (structs.DepthView, lib.cylfuse_depth_view_init),
        (structs.MaskView, lib.cylfuse_mask_view_init),
        (structs.ImageView, lib.cylfuse_image_view_init),
        (structs.SegmentsView, lib.cylfuse_segments_view_init),
        (structs.PointsOut, lib.cylfuse_points_out_init),
        (structs.DepthOut, lib.cylfuse_depth_out_init),
        (structs.Counts, lib.cylfuse_counts_init),
        (structs.Result, lib.cylfuse_result_init),
        (structs.CylinderEstimate, lib.cylfuse_cylinder_estimate_init),
        (structs.CylinderDiagnosis, lib.cylfuse_cylinder_diagnosis_init),
        (structs.Completion, lib.cylfuse_completion_init),
        (structs.Extent, lib.cylfuse_extent_init),
    ]
}


def make(kind: Type[_S]) -> _S:
    """A struct as the library begins it."""
    return kind.from_buffer_copy(_FIRST[kind])


def version() -> str:
    """The version of the loaded library, such as "0.2.0"."""
    return str(lib.cylfuse_version_string().decode())


def version_number() -> int:
    """The version of the loaded library as major * 65536 + minor * 256 + patch."""
    return int(lib.cylfuse_version_number())


def build_info() -> str:
    """How the library was built, for reports of defects."""
    return str(lib.cylfuse_build_info().decode())


def status_text(status: int) -> str:
    """The name of a status, a colon, and what it means."""
    return str(lib.cylfuse_status_string(status).decode())
