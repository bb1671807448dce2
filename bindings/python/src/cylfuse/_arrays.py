"""From numpy arrays to views of their memory, without copies; shapes and types are checked here, before the call.

A view of C holds an address only, so each carries the array that it is of: what keeps the view keeps the memory.
"""

from __future__ import annotations

from ctypes import c_double
from typing import Any, Optional, TypeVar

import numpy as np
import numpy.typing as npt

from ._check import real, whole
from ._native import make
from ._structs import DepthView, ImageView, MaskView, PointsView, SegmentsView

#: An array of float64.
Floats = npt.NDArray[np.float64]
#: An image, or whatever else has a type that the caller chooses.
Array = npt.NDArray[Any]

SCALARS = {np.dtype(np.float32): 1, np.dtype(np.float64): 2}
DEPTHS = {np.dtype(np.uint16): 1, np.dtype(np.float32): 2}
_IMAGES = {np.dtype(np.uint8): 1, np.dtype(np.uint16): 2, np.dtype(np.float32): 3}
# By the channels of an image, and whether blue comes first.
_COLORS = {(3, False): 4, (3, True): 5, (4, False): 6, (4, True): 7}
_MASKS = {np.dtype(np.bool_): 1, np.dtype(np.uint8): 1}
# The most pixels of a camera.
_MOST_PIXELS = 2**28


def address(array: Array) -> int:
    """Where the first element is."""
    return int(array.__array_interface__["data"][0])


def _stride(array: Array, axis: int) -> int:
    """Bytes from one to the next along an axis; numpy's number means nothing where there is only one."""
    return array.strides[axis] if array.shape[axis] > 1 else 0


def _apart(array: Array, axes: int, size: int) -> Array:
    """The array, or a copy when elements of so many bytes share memory along its first axes, as those of
    ``numpy.broadcast_to`` do with a stride of 0, which for the library stands for packed elements."""
    if not array.flags.c_contiguous:
        for count, stride in zip(array.shape[:axes], array.strides):
            if count > 1 and abs(stride) < size:
                return np.ascontiguousarray(array)
    return array


def _not_masked(name: str, given: Any, fill: str) -> None:
    # numpy.ma is loaded when it is named first.
    if type(given) not in (np.ndarray, list) and isinstance(given, np.ma.MaskedArray):
        raise TypeError(f"{name} is a masked array, whose mask would not count; {name}.filled({fill}) makes a plain one")


def pixels(name: str, given: Any, formats: dict[Any, int], remedy: str) -> Array:
    """An array of rows x columns in one of the formats."""
    if not isinstance(given, np.ndarray):
        raise TypeError(
            f"{name} is of the type {type(given).__name__}; it must be a numpy array: numpy.asarray makes one"
        )
    if given.dtype not in formats:
        names = " or ".join(str(dtype) for dtype in formats)
        raise TypeError(f"{name} has the type {given.dtype}; it must be {names}; {remedy} converts it")
    if given.ndim != 2:
        raise ValueError(f"{name} has the shape {given.shape}; it must be rows x columns")
    if given.size > _MOST_PIXELS:
        raise ValueError(f"{name} has {given.size} pixels; it must have at most 2^28")
    _not_masked(name, given, "0")
    return _apart(given, 2, given.itemsize)


_V = TypeVar("_V", DepthView, MaskView, ImageView)


def _fill(view: _V, array: Array) -> _V:
    view.array = array
    view.data = address(array)
    view.height, view.width = array.shape[:2]
    view.row_stride, view.pixel_stride = _stride(array, 0), _stride(array, 1)
    return view


def depth_pixels(depth: Any) -> Array:
    """A depth image of rows x columns; float64 is converted."""
    if isinstance(depth, np.ndarray) and depth.dtype == np.float64:
        _not_masked("depth", depth, "0")
        depth = depth.astype(np.float32)
    return pixels("depth", depth, DEPTHS, "depth.astype(numpy.float32)")


def depth_view(depth: Any, scale: Optional[float], minimum: float, maximum: Optional[float]) -> DepthView:
    """A depth image and which depths count."""
    depth = depth_pixels(depth)
    if scale is None:
        if depth.dtype.kind != "f":
            raise TypeError(
                f"depth has the type {depth.dtype} and no scale; give the length of one unit of it: 0.001 for millimetres "
                "where lengths are to be metres, 1 where they are to be in the unit of the depth"
            )
        scale = 1.0
    view = _fill(make(DepthView), depth)
    view.format = DEPTHS[depth.dtype]
    view.scale, view.min_depth = real("the scale of the depth", scale), real("min_depth", minimum)
    view.max_depth = 0.0 if maximum is None else real("max_depth", maximum)
    return view


def mask_view(mask: Any, label: int = 0) -> Optional[MaskView]:
    """A mask of rows x columns, of whose labels one may be meant; None stays None."""
    if mask is None:
        return None
    view = _fill(make(MaskView), pixels("mask", mask, _MASKS, "mask != 0"))
    view.label = whole("label", label, 0, 2**8)
    return view


def image_view(image: Any, gamma: float, bgr: bool = False) -> ImageView:
    """An image of rows x columns, or of uint8 and rows x columns x 3, or x 4 with a fourth channel that is ignored."""
    if isinstance(image, np.ndarray) and image.ndim == 3:
        if (image.shape[2], bool(bgr)) not in _COLORS or image.dtype != np.uint8:
            remedy = ""
            if image.shape[0] in (3, 4) and image.shape[2] > 4:
                remedy = "; numpy.moveaxis(image, 0, 2) puts the channels last"
            elif image.dtype.kind == "f":
                remedy = "; (255 * image).astype(numpy.uint8) converts values from 0 to 1"
            raise ValueError(
                f"image has the shape {image.shape} and the type {image.dtype}; it must be rows x columns, or "
                f"rows x columns x 3 or 4 of uint8{remedy}"
            )
        _not_masked("image", image, "0")
        if image.strides[2] != 1:
            image = np.ascontiguousarray(image)
        image = _apart(image, 2, image.shape[2])
        view = _fill(make(ImageView), image)
        view.format = _COLORS[image.shape[2], bool(bgr)]
    else:
        image = pixels("image", image, _IMAGES, "image.astype(numpy.float32)")
        view = _fill(make(ImageView), image)
        view.format = _IMAGES[image.dtype]
    view.gamma = real("gamma", gamma)
    return view


def _floats(name: str, given: Any) -> Array:
    """An array of floats; integers and lists are converted."""
    _not_masked(name, given, "numpy.nan")
    array = np.asarray(given)
    if array.dtype in SCALARS:
        return array
    if array.size == 0 or array.dtype.kind in "iuf":
        return array.astype(np.float64)
    found = type(given).__name__ if array.ndim == 0 else array.dtype
    raise TypeError(f"{name} have the type {found}; it must be float32 or float64")


def _vectors(name: str, given: Any, dtype: Any = None) -> Array:
    """Vectors of x, y and z, which must follow each other: of a transposed array that takes a copy."""
    array = _floats(name, given)
    if array.ndim not in (2, 3) or array.shape[-1] != 3:
        raise ValueError(f"{name} have the shape {array.shape}; it must be N x 3, or rows x columns x 3")
    if array.dtype != (dtype or array.dtype) or array.strides[-1] != array.itemsize:
        array = array.astype(dtype or array.dtype, order="C")
    return _apart(array, array.ndim - 1, 3 * array.itemsize)


def _grid_strides(array: Array, axes: int) -> tuple[int, int]:
    """The strides of an element and of a row."""
    return _stride(array, axes - 1), _stride(array, 0) if axes == 2 else 0


def points_view(points: Any, weights: Any = None, normals: Any = None) -> PointsView:
    """A cloud."""
    points = _vectors("points", points)
    axes = points.ndim - 1
    view = make(PointsView)
    view.scalar = SCALARS[points.dtype]
    view.data = address(points)
    view.width = points.shape[axes - 1]
    view.height = points.shape[0] if axes == 2 else 1
    view.point_stride, view.row_stride = _grid_strides(points, axes)
    if weights is not None:
        weights = _apart(_floats("weights", weights).astype(points.dtype, copy=False), axes, points.itemsize)
        if weights.shape != points.shape[:-1]:
            raise ValueError(f"weights have the shape {weights.shape}; it must be {points.shape[:-1]}")
        view.weights = address(weights)
        view.weight_stride, view.weight_row_stride = _grid_strides(weights, axes)
    if normals is not None:
        normals = _vectors("normals", normals, points.dtype)
        if normals.shape != points.shape:
            raise ValueError(f"normals have the shape {normals.shape}; it must be {points.shape}")
        view.normals = address(normals)
        view.normal_stride, view.normal_row_stride = _grid_strides(normals, axes)
    view.array = points, weights, normals
    return view


def segments_view(segments: Any, weights: Any = None) -> SegmentsView:
    """Edge segments."""
    segments = _floats("edges", segments)
    if segments.ndim == 3 and segments.shape[1:] == (2, 2):
        segments = segments.reshape(-1, 4)
    if segments.size == 0:
        segments = segments.reshape(0, 4)
    if segments.ndim != 2 or segments.shape[1] != 4:
        raise ValueError(f"edges have the shape {segments.shape}; it must be N x 4 (x1, y1, x2, y2) or N x 2 x 2")
    if segments.strides[1] != segments.itemsize:
        segments = np.ascontiguousarray(segments)
    segments = _apart(segments, 1, 4 * segments.itemsize)
    view = make(SegmentsView)
    view.scalar = SCALARS[segments.dtype]
    view.data = address(segments)
    view.count = len(segments)
    view.segment_stride = _stride(segments, 0)
    if weights is not None:
        weights = np.ascontiguousarray(_floats("weights", weights), dtype=np.float64)
        if weights.shape != (len(segments),):
            raise ValueError(f"weights have the shape {weights.shape}; it must be ({len(segments)},)")
        view.weights = address(weights)
    view.array = segments, weights
    return view


def vector(name: str, given: Any, length: Optional[int] = None) -> Floats:
    """So many numbers as an array of its own; without a length any list of them."""
    try:
        if given is None:  # which numpy takes for NaN
            raise TypeError
        array = np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"{name} is {given!r}; it must be {length or 'a list of'} numbers") from None
    if length is None:
        return array.ravel()
    if array.shape != (length,):
        raise ValueError(f"{name} has the shape {array.shape}; it must be ({length},)")
    return array


def numbers(values: Any) -> Floats:
    """The numbers of a C array as an array of its own."""
    return np.frombuffer(values, dtype=np.float64).copy()


def c_vector(values: Any) -> Any:
    """Numbers as a C array."""
    return (c_double * len(values))(*values)
