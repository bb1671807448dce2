"""What can be asked about a model and the data of a fitter."""

from __future__ import annotations

from ctypes import byref, c_size_t
from typing import Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from . import _arrays, _check, _structs
from ._arrays import Array, Floats
from ._handle import Closable
from ._native import lib, make
from .enums import Layout, LimbStatus, ResidualKind
from .errors import CylfuseError
from .geometry import Cylinder, Intrinsics
from .result import Completion, Counts, CylinderDiagnosis, Extent

_BUFFER_TOO_SMALL = -7


class Limb(NamedTuple):
    """A limb of the cylinder in the image of one view."""

    #: The view, from 0.
    view: int
    #: 0 or 1, in the order of :meth:`Cylinder.project`.
    limb: int
    #: Whether it was located, or why not.
    status: LimbStatus
    #: How many pieces of it :meth:`Fitter.limb_samples` lists.
    samples: int
    #: Two points of the line in ideal pixels whose errors across it are independent and equally large, shape (2, 2);
    #: NaN when the limb was not located.
    line: Floats
    #: Standard deviation of either point across the line, in ideal pixels.
    deviation: float


class LimbSamples(NamedTuple):
    """What was seen of the limbs in an image, piece by piece."""

    #: The view, shape (N,).
    view: npt.NDArray[np.uint32]
    #: The limb, 0 or 1, shape (N,).
    limb: npt.NDArray[np.uint32]
    #: Places in pixels, shape (N, 2).
    pixel: Floats
    #: Standard deviations across the limb in ideal pixels, shape (N,).
    deviation: Floats
    #: What each counted, from 1 down to 0 for a refused one, shape (N,).
    weight: Floats


class EndSamples(NamedTuple):
    """Places on the arcs of the ends in the images."""

    #: The view, shape (N,).
    view: npt.NDArray[np.uint32]
    #: 0 for the start of the extent, 1 for its end, shape (N,).
    end: npt.NDArray[np.uint32]
    #: Places in pixels, shape (N, 2).
    pixel: Floats
    #: Unit vectors across the arc, away from the surface, shape (N, 2).
    normal: Floats
    #: Standard deviations along ``normal`` in pixels, shape (N,).
    deviation: Floats


class PointWeights(NamedTuple):
    """How much the points count."""

    #: From 1 on the surface down to 0 for an outlier, without the weight that the point was given, shape (N,).
    weights: Floats
    #: Whether the weight is above 0, shape (N,).
    inliers: npt.NDArray[np.bool_]


def _cylinder(model: Optional[Cylinder]) -> Any:
    return None if model is None else byref(_check.instance("model", model, Cylinder)._struct())


def _optional(view: Any) -> Any:
    return None if view is None else byref(view)


class Questions(Closable):
    """The calls that change nothing. Any number of threads may make them at once. ``model`` stands in for that of the
    last fit, and is then without its uncertainty."""

    def _call(self, function: Any, *arguments: Any, changes: bool = False) -> None:
        raise NotImplementedError

    @property
    def intrinsics(self) -> Optional[Intrinsics]:
        raise NotImplementedError

    @property
    def counts(self) -> Counts:
        """What was pushed into the selected view, and what was left out by reason."""
        struct = make(_structs.Counts)
        self._call(lib.cylfuse_fitter_counts, byref(struct))
        return Counts(struct)

    def residuals(self, kind: ResidualKind | str = ResidualKind.POINTS, model: Optional[Cylinder] = None) -> Floats:
        """Signed distances of the used points from the surface in the order of pushing, or of both ends of every
        used edge from its limb in ideal pixels."""
        given, which, counts = _cylinder(model), ResidualKind(kind), self.counts
        capacity = counts.points_used if which == ResidualKind.POINTS else 2 * counts.segments_given

        def arguments(out: Any, count: Any) -> tuple[Any, ...]:
            return given, which, _arrays.address(out), out.size, count

        residuals: Floats = self._list(lib.cylfuse_fitter_residuals, arguments, np.float64, capacity)
        return residuals

    def point_weights(self) -> PointWeights:
        """How much each used point of the selected view counts at the cylinder of the last fit, in the order of
        :meth:`residuals`, whatever was minimised."""
        inliers = np.empty(0, np.uint8)

        def arguments(out: Any, count: Any) -> tuple[Any, ...]:
            nonlocal inliers
            inliers = np.empty(out.size, np.uint8)
            return _arrays.address(out), _arrays.address(inliers), out.size, count

        weights: Floats = self._list(
            lib.cylfuse_fitter_point_weights, arguments, np.float64, self.counts.points_used
        )
        return PointWeights(weights, inliers[: len(weights)].astype(bool))

    def point_parts(self, model: Optional[Cylinder] = None) -> npt.NDArray[np.uint8]:
        """What each used point of the selected view belongs to, in the order of :meth:`residuals`: numbers of
        :class:`Part`, so that ``parts == Part.BODY`` selects the lateral surface."""
        given = _cylinder(model)

        def arguments(out: Any, count: Any) -> tuple[Any, ...]:
            return given, _arrays.address(out), out.size, count

        parts: npt.NDArray[np.uint8] = self._list(
            lib.cylfuse_fitter_point_parts, arguments, np.uint8, self.counts.points_used
        )
        return parts

    def limbs(self) -> list[Limb]:
        """The two limbs of the last fit in each view, view after view. None was searched once data or options have
        changed since."""
        rows = self._structs(lib.cylfuse_fitter_limbs, _structs.Limb, 2)
        return [
            Limb(int(row["view"]), int(row["limb"]), LimbStatus(int(row["status"])), int(row["samples"]),
                 row["line"].reshape(2, 2).copy(), float(row["deviation"]))
            for row in rows
        ]  # fmt: skip

    def limb_samples(self) -> LimbSamples:
        """What the last fit saw of the limbs in the image of the selected view; empty when it was not searched, and
        once data or options have changed since."""
        # Enough for limbs of 500 pixels; longer ones take a second call.
        samples = self._structs(lib.cylfuse_fitter_limb_samples, _structs.LimbSample, 1024)
        return LimbSamples(*(samples[name] for name in LimbSamples._fields))

    def end_samples(self, model: Optional[Cylinder] = None, mask: Optional[Array] = None) -> EndSamples:
        """The samples on the arcs of both ends that :meth:`extent` finds in the images, view after view."""
        view = _arrays.mask_view(mask)
        samples = self._structs(
            lib.cylfuse_fitter_end_samples, _structs.EndSample, 256, _cylinder(model), _optional(view)
        )
        return EndSamples(*(samples[name] for name in EndSamples._fields))

    def _structs(self, function: Any, kind: Any, capacity: int, *first: Any) -> Any:
        """An output of structs as an array with their fields."""
        dtype = np.dtype(kind)

        def arguments(out: Any, count: Any) -> tuple[Any, ...]:
            return (*first, _arrays.address(out), dtype.itemsize, out.size, count)

        return self._list(function, arguments, dtype, capacity)

    def _list(self, function: Any, arguments: Any, dtype: Any, capacity: int) -> Any:
        """An output whose length the library tells."""
        count = c_size_t()
        while True:
            out = np.empty(capacity, dtype)
            try:
                self._call(function, *arguments(out, byref(count)))
                return out[: count.value]
            except CylfuseError as error:
                if error.status != _BUFFER_TOO_SMALL:
                    raise
                capacity = count.value

    def select_edges(
        self, segments: npt.ArrayLike, reach: float = 0.0, model: Optional[Cylinder] = None
    ) -> npt.NDArray[np.uint8]:
        """Selects, of edges that a line detector found, those on the limbs of a rough cylinder: for each 1 or 2 for
        the limb that it lies on, 0 for none, shape (N,). ``segments[selected > 0]`` is for :meth:`push_edges`.

        :param reach: how far a limb may be from that of the model in pixels; 0 = 15 % of the distance of the limbs
        :param model: the rough cylinder; None = that of the last fit
        """
        view = _arrays.segments_view(segments)
        out = np.empty(view.count, np.uint8)
        self._call(
            lib.cylfuse_fitter_select_edges, _cylinder(model), byref(view), _check.real("reach", reach),
            _arrays.address(out), out.size,
        )  # fmt: skip
        return out

    def diagnose(self, model: Optional[Cylinder] = None) -> CylinderDiagnosis:
        """What the data determine, more precise than ``condition`` of a result and far slower."""
        struct = make(_structs.CylinderDiagnosis)
        self._call(lib.cylfuse_fitter_diagnose, _cylinder(model), byref(struct))
        return CylinderDiagnosis(struct)

    def extent(self, model: Optional[Cylinder] = None, mask: Optional[Array] = None) -> Extent:
        """The visible piece of the cylinder, in views with a camera and a mask by the mask, in others by the points on the
        surface; ``mask`` stands in for that of the last depth image of the selected view."""
        struct = make(_structs.Extent)
        view = _arrays.mask_view(mask)
        self._call(lib.cylfuse_fitter_extent, _cylinder(model), _optional(view), byref(struct))
        return Extent(struct)

    def complete(
        self,
        layout: Layout | str = Layout.PACKED,
        dtype: npt.DTypeLike = np.float64,
        model: Optional[Cylinder] = None,
        mask: Optional[Array] = None,
    ) -> Completion:
        """Casts the ray of every pixel of a mask of the selected view onto the cylinder: points in the reference
        frame."""
        dtype, layout = np.dtype(dtype), Layout(layout)
        if dtype not in _arrays.SCALARS:
            raise TypeError(f"dtype is {dtype}; it must be float32 or float64")
        region, capacity, camera = _arrays.mask_view(mask), c_size_t(), self.intrinsics
        struct, out = make(_structs.Completion), make(_structs.PointsOut)
        out.scalar = _arrays.SCALARS[dtype]
        self._call(lib.cylfuse_fitter_complete_bound, _optional(region), layout, byref(capacity))
        points: Array = np.empty((capacity.value, 3), dtype)
        out.data, out.capacity = _arrays.address(points), capacity.value
        self._call(
            lib.cylfuse_fitter_complete, _cylinder(model), _optional(region), layout, byref(out), byref(struct)
        )
        if layout == Layout.PACKED:
            points = points[: struct.count]
        elif camera is not None:
            points = points.reshape(camera.height, camera.width, 3)
        return Completion(struct, points)

    def complete_depth(
        self,
        dtype: npt.DTypeLike = np.float32,
        scale: float = 1.0,
        model: Optional[Cylinder] = None,
        mask: Optional[Array] = None,
    ) -> Completion:
        """The depth image of the selected view, of uint16 or float32, with value * ``scale`` = z of the completed points, 0 elsewhere."""
        dtype = np.dtype(dtype)
        if dtype not in _arrays.DEPTHS:
            raise TypeError(f"dtype is {dtype}; it must be uint16 or float32")
        region = _arrays.mask_view(mask)
        struct, out = make(_structs.Completion), make(_structs.DepthOut)
        camera = self.intrinsics
        depth = np.empty((camera.height, camera.width) if camera else (0, 0), dtype)
        out.format, out.scale, out.data = _arrays.DEPTHS[dtype], _check.real("scale", scale), _arrays.address(depth)
        out.height, out.width = depth.shape
        self._call(
            lib.cylfuse_fitter_complete_depth, _cylinder(model), _optional(region), byref(out), byref(struct)
        )
        return Completion(struct, depth)
