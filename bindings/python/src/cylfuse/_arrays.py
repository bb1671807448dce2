"""From numpy arrays to views of their memory, without copies; shapes and types are checked here, before the call.

A view holds an address only: the caller keeps the array alive, and each function returns it beside the view when it
may not be the one that was given.
"""

from __future__ import annotations

from ctypes import c_double
from typing import Any, Optional, TypeVar

import numpy as np

from ._native import make
from ._structs import DepthView, ImageView, MaskView, PointsView, SegmentsView

_SCALARS = {np.dtype(np.float32): 1, np.dtype(np.float64): 2}
_DEPTHS = {np.dtype(np.uint16): 1, np.dtype(np.float32): 2}
_IMAGES = {np.dtype(np.uint8): 1, np.dtype(np.uint16): 2, np.dtype(np.float32): 3}


def address(array: Any) -> int:
    """Where the first element is."""
    return int(array.__array_interface__["data"][0])


def _stride(array: Any, axis: int) -> int:
    """Bytes from one to the next along an axis; numpy's number means nothing where there is only one."""
    return array.strides[axis] if array.shape[axis] > 1 else 0


def _two_dimensional(name: str, given: Any, formats: Any, remedy: str) -> Any:
    if not isinstance(given, np.ndarray):
        raise TypeError(f"{name} is a {type(given).__name__}; it must be a numpy array")
    if given.dtype not in formats:
        names = " or ".join(str(dtype) for dtype in formats)
        raise TypeError(f"{name} has the type {given.dtype}; it must be {names}{remedy}")
    if given.ndim != 2:
        colours = f": take one channel, {name}[..., 1]" if given.ndim == 3 else ""
        raise ValueError(f"{name} has the shape {given.shape}; it must be rows x columns{colours}")
    return given


_V = TypeVar("_V", DepthView, MaskView, ImageView)


def _fill(view: _V, array: Any) -> _V:
    view.data = address(array)
    view.height, view.width = array.shape
    view.row_stride, view.pixel_stride = _stride(array, 0), _stride(array, 1)
    return view


def depth_view(depth: Any, scale: float, minimum: float, maximum: Optional[float]) -> DepthView:
    """A depth image of rows x columns."""
    _two_dimensional("depth", depth, _DEPTHS, "; depth.astype(numpy.float32) converts it")
    view = _fill(make(DepthView), depth)
    view.format = _DEPTHS[depth.dtype]
    view.scale, view.min_depth = scale, minimum
    view.max_depth = 0.0 if maximum is None else maximum
    return view


def mask_view(mask: Any) -> Optional[MaskView]:
    """A mask of rows x columns; None stays None."""
    if mask is None:
        return None
    formats = (np.dtype(np.bool_), np.dtype(np.uint8))
    return _fill(make(MaskView), _two_dimensional("mask", mask, formats, "; mask != 0 converts it"))


def image_view(image: Any, gamma: float) -> ImageView:
    """A grey image of rows x columns."""
    _two_dimensional("image", image, _IMAGES, "; image.astype(numpy.float32) converts it")
    view = _fill(make(ImageView), image)
    view.format = _IMAGES[image.dtype]
    view.gamma = gamma
    return view


def _floats(name: str, given: Any) -> Any:
    """An array of floats; integers and lists are converted."""
    array = np.asarray(given)
    if array.dtype in _SCALARS:
        return array
    if array.size == 0 or array.dtype.kind in "iuf":
        return array.astype(np.float64)
    raise TypeError(f"{name} has the type {array.dtype}; it must be float32 or float64")


def _vectors(name: str, given: Any) -> Any:
    array = _floats(name, given)
    if array.ndim not in (2, 3) or array.shape[-1] != 3:
        raise ValueError(f"{name} has the shape {array.shape}; it must be N x 3, or rows x columns x 3")
    # x, y and z must follow each other; of a transposed array that takes a copy.
    return array if array.strides[-1] == array.itemsize else np.ascontiguousarray(array)


def _grid_strides(array: Any, dimensions: int) -> tuple[int, int]:
    """The strides of an element and of a row."""
    return _stride(array, dimensions - 1), _stride(array, 0) if dimensions == 2 else 0


def points_view(points: Any, weights: Any = None, normals: Any = None) -> tuple[PointsView, Any]:
    """A cloud, and what must stay alive."""
    points = _vectors("points", points)
    dimensions = points.ndim - 1
    view = make(PointsView)
    view.scalar = _SCALARS[points.dtype]
    view.data = address(points)
    view.width = points.shape[dimensions - 1]
    view.height = points.shape[0] if dimensions == 2 else 1
    view.point_stride, view.row_stride = _grid_strides(points, dimensions)
    if weights is not None:
        weights = np.asarray(weights)
        if weights.dtype != points.dtype:
            weights = _floats("weights", weights).astype(points.dtype)
        if weights.shape != points.shape[:-1]:
            raise ValueError(f"weights have the shape {weights.shape}; it must be {points.shape[:-1]}")
        view.weights = address(weights)
        view.weight_stride, view.weight_row_stride = _grid_strides(weights, dimensions)
    if normals is not None:
        normals = _vectors("normals", normals).astype(points.dtype, copy=False)
        if normals.shape != points.shape:
            raise ValueError(f"normals have the shape {normals.shape}; it must be {points.shape}")
        view.normals = address(normals)
        view.normal_stride, view.normal_row_stride = _grid_strides(normals, dimensions)
    return view, (points, weights, normals)


def segments_view(segments: Any, weights: Any = None) -> tuple[SegmentsView, Any]:
    """Edge segments, and what must stay alive."""
    segments = _floats("edges", segments)
    if segments.ndim == 3 and segments.shape[1:] == (2, 2):
        segments = segments.reshape(-1, 4)
    if segments.size == 0:
        segments = segments.reshape(0, 4)
    if segments.ndim != 2 or segments.shape[1] != 4:
        raise ValueError(f"edges have the shape {segments.shape}; it must be N x 4 (x1, y1, x2, y2) or N x 2 x 2")
    if segments.strides[1] != segments.itemsize:
        segments = np.ascontiguousarray(segments)
    view = make(SegmentsView)
    view.scalar = _SCALARS[segments.dtype]
    view.data = address(segments)
    view.count = len(segments)
    view.segment_stride = _stride(segments, 0)
    if weights is not None:
        weights = np.ascontiguousarray(weights, dtype=np.float64)
        if weights.shape != (len(segments),):
            raise ValueError(f"weights have the shape {weights.shape}; it must be ({len(segments)},)")
        view.weights = address(weights)
    return view, (segments, weights)


def vector(name: str, given: Any, length: int) -> Any:
    """So many numbers as an array of its own."""
    array = np.array(given, dtype=np.float64)
    if array.shape != (length,):
        raise ValueError(f"{name} has the shape {array.shape}; it must be ({length},)")
    return array


def numbers(values: Any) -> Any:
    """The numbers of a C array as an array of its own."""
    return np.frombuffer(values, dtype=np.float64).copy()


def c_vector(name: str, given: Any, length: int) -> Any:
    """So many numbers as a C array."""
    return (c_double * length)(*vector(name, given, length))
