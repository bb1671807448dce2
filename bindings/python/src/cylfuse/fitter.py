"""The fitter: for loops over frames, and for everything that single calls do not offer."""

from __future__ import annotations

import atexit
import threading
import weakref
from ctypes import byref, c_size_t, c_void_p
from typing import Any, Callable, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from . import _arrays, _check, _structs
from ._arrays import Array, Floats
from ._callbacks import Callbacks
from ._native import ABI_VERSION, lib, make, make_output
from .enums import Layout, LogLevel, ResidualKind
from .errors import BusyError, CylfuseError, StateError, fail, from_status
from .geometry import Cylinder, Intrinsics
from .options import Options
from .result import Completion, Counts, Diagnosis, Extent, Progress, Result

_BUFFER_TOO_SMALL = -7


class LimbSamples(NamedTuple):
    """What was seen of the limbs in the grey image, piece by piece."""

    #: Places in pixels, shape (N, 2).
    pixel: Floats
    #: Standard deviations across the limb in ideal pixels, shape (N,).
    sigma: Floats
    #: What each counted, from 1 down to 0 for a refused one, shape (N,).
    weight: Floats
    #: The limb, 0 or 1, shape (N,).
    limb: npt.NDArray[np.uint32]


def _destroy(handle: c_void_p) -> None:
    lib.cylfuse_fitter_destroy(handle)


def _cylinder(model: Optional[Cylinder]) -> Any:
    return None if model is None else byref(_check.instance("model", model, Cylinder)._struct())


def _mask(view: Any) -> Any:
    return None if view is None else byref(view)


class Fitter:
    """Estimates one cylinder. For the next frame: :meth:`clear`, push, :meth:`fit`.

    A fitter runs one call at a time: a second one, from another thread or from a callback, raises
    :class:`BusyError`. Close it, or use it in a ``with`` statement; one that is forgotten is closed with its object.
    """

    def __init__(self, intrinsics: Optional[Intrinsics] = None, options: Optional[Options] = None) -> None:
        handle = c_void_p()
        status = lib.cylfuse_fitter_create(ABI_VERSION, byref(handle))
        if status:
            fail(status)
        self._handle: Optional[c_void_p] = handle
        # Held during a call, so that another thread finds the fitter busy and cannot close it meanwhile.
        self._running = threading.Lock()
        # Held where the handle is used without the lock above: by cancel, against close. A handler of a signal may
        # cancel in the midst of either.
        self._alive = threading.RLock()
        self._finalizer = weakref.finalize(self, _destroy, handle)
        # The process ends with its memory; a thread may still be in a call.
        self._finalizer.atexit = False
        #: Counts what changes the answers about the last result.
        self._revision = 0
        self._intrinsics: Optional[Intrinsics] = None
        self._callbacks = Callbacks()
        if options is not None:
            self.options = options
        if intrinsics is not None:
            self.intrinsics = intrinsics

    def __enter__(self) -> Fitter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> Any:
        raise TypeError("a Fitter cannot be copied or pickled: make one where it is used")

    def _calling(self) -> threading.Lock:
        """What a call holds, in ``with``: Ctrl-C finds no gap between taking it and giving it back."""
        if self._running.locked():
            raise BusyError(
                "another call on this fitter is running; take one fitter for each thread, and of a callback call "
                "nothing but cancel"
            )
        return self._running

    def close(self) -> None:
        """Frees everything. A second time it does nothing; any other call afterwards raises StateError."""
        with self._calling(), self._alive:
            self._handle = None
            self._finalizer()

    @property
    def closed(self) -> bool:
        """Whether the fitter was closed."""
        return self._handle is None

    def _call(self, function: Any, *arguments: Any, changes: bool = False) -> None:
        with self._calling():
            self._checked(function, *arguments, changes=changes)

    def _checked(self, function: Any, *arguments: Any, changes: bool = False) -> None:
        handle = self._handle
        if handle is None:
            raise StateError("the fitter is closed; make a new one")
        # Before the call: when a callback or Ctrl-C ends it with an exception, it may have changed something.
        self._revision += changes
        status = self._callbacks.around(function, handle, *arguments)
        if status:
            self._revision -= changes
            fail(status, handle)

    # Settings

    @property
    def options(self) -> Options:
        """The settings of the next fit."""
        struct = make_output(_structs.Options)
        self._call(lib.cylfuse_fitter_get_options, byref(struct))
        return Options._from_struct(struct)

    @options.setter
    def options(self, options: Options) -> None:
        struct = _check.instance("options", options, Options)._struct()
        self._call(lib.cylfuse_fitter_set_options, byref(struct), changes=True)

    @property
    def intrinsics(self) -> Optional[Intrinsics]:
        """The camera, which depth images and edges need. Points that were pushed before stay as they are."""
        return self._intrinsics

    @intrinsics.setter
    def intrinsics(self, intrinsics: Intrinsics) -> None:
        struct = _check.instance("intrinsics", intrinsics, Intrinsics)._struct()
        self._call(lib.cylfuse_fitter_set_intrinsics, byref(struct), changes=True)
        self._intrinsics = intrinsics

    def set_start_model(self, model: Optional[Cylinder]) -> None:
        """Sets a start: a candidate for the start AUTO, the start of MODEL. None takes it away."""
        self._call(lib.cylfuse_fitter_set_start_model, _cylinder(model), changes=True)

    def on_progress(self, callback: Optional[Callable[[Progress], Any]]) -> None:
        """Sets what hears of every linear solve, on the thread of the fit; None for none. When it returns False the
        fit stops with CancelledError; what it raises ends the fit and comes out of it."""
        self._set_callback(self._callbacks.progress(callback), lib.cylfuse_fitter_set_progress)

    def on_log(
        self, callback: Optional[Callable[[LogLevel, str], Any]], level: LogLevel | str = LogLevel.INFO
    ) -> None:
        """Sets what takes log lines up to a level; None for none. What it raises comes out of the call."""
        self._set_callback(self._callbacks.log(callback), lib.cylfuse_fitter_set_log, LogLevel(level))

    def _set_callback(self, callback: Any, function: Any, *arguments: Any) -> None:
        _WITH_CALLBACKS.add(self)
        self._callbacks.keep(callback)
        self._call(function, *arguments, callback, None)
        self._callbacks.forget_others(callback)

    # Data

    def push_points(
        self,
        points: npt.ArrayLike,
        weights: Optional[npt.ArrayLike] = None,
        normals: Optional[npt.ArrayLike] = None,
        mask: Optional[Array] = None,
    ) -> None:
        """Adds points, N x 3 or rows x columns x 3, of float32 or float64, with any strides between points; in the
        camera frame when edges or extent matter. ``mask`` selects from an organised cloud."""
        view, mask_view = _arrays.points_view(points, weights, normals), _arrays.mask_view(mask)
        self._call(lib.cylfuse_fitter_push_points, byref(view), _mask(mask_view), changes=True)

    def push_depth(
        self,
        depth: Array,
        mask: Optional[Array] = None,
        scale: float = 1.0,
        min_depth: float = 0.0,
        max_depth: Optional[float] = None,
    ) -> None:
        """Adds a depth image of uint16 or float32, rows x columns with any strides: z = value * ``scale``. It is
        read in place. ``mask`` (bool or uint8) marks the cylinder. Both are kept for completion and extent."""
        view, mask_view = _arrays.depth_view(depth, scale, min_depth, max_depth), _arrays.mask_view(mask)
        self._call(lib.cylfuse_fitter_push_depth, byref(view), _mask(mask_view), changes=True)

    def push_image(self, image: Array, gamma: float = 1.0) -> None:
        """Takes the grey image of the camera (uint8, uint16 or float32): the limbs are located in it. Light is the
        value to the power of ``gamma``: 2.2 for sRGB, in which cameras and image files usually come."""
        self._call(lib.cylfuse_fitter_push_image, byref(_arrays.image_view(image, gamma)), changes=True)

    def push_edges(self, edges: npt.ArrayLike, weights: Optional[npt.ArrayLike] = None) -> None:
        """Adds edge segments x1, y1, x2, y2 in pixels, N x 4 or N x 2 x 2, on either limb."""
        self._call(lib.cylfuse_fitter_push_edges, byref(_arrays.segments_view(edges, weights)), changes=True)

    def reserve(self, points: int, segments: int = 0) -> None:
        """Makes room, so that pushing that many more needs no memory."""
        counts = (_check.whole(name, n, 0, 2**63) for name, n in (("points", points), ("segments", segments)))
        self._call(lib.cylfuse_fitter_reserve, *counts)

    def clear(self) -> None:
        """Forgets data, result and a request to cancel; keeps options, camera, start model, callbacks, memory."""
        self._call(lib.cylfuse_fitter_clear, changes=True)

    @property
    def counts(self) -> Counts:
        """What was pushed, and what was left out by reason."""
        struct = make_output(_structs.Counts)
        self._call(lib.cylfuse_fitter_counts, byref(struct))
        return Counts(struct)

    # Fitting

    def fit(self) -> Result:
        """Estimates the cylinder from everything that was pushed."""
        return self._result(lib.cylfuse_fitter_fit, changes=True)

    def _result(self, function: Any, changes: bool = False) -> Result:
        struct = make_output(_structs.Result)
        with self._calling():
            self._checked(function, byref(struct), changes=changes)
            return Result(struct, self, self._revision)

    def cancel(self) -> None:
        """Asks the running fit, or the next one, to stop with CancelledError. The one call for other threads."""
        with self._alive:
            if self._handle is None:
                raise StateError("the fitter is closed; make a new one")
            status = lib.cylfuse_fitter_cancel(self._handle)
        if status:
            raise from_status(status, "the fit could not be cancelled")

    def evaluate(self, model: Cylinder) -> Result:
        """What a fit would report for a given model, without iterating."""
        struct = make_output(_structs.Result)
        given = _check.instance("model", model, Cylinder)._struct()
        self._call(lib.cylfuse_fitter_evaluate, byref(given), byref(struct))
        return Result(struct, None, 0)

    @property
    def result(self) -> Result:
        """The result of the last fit that succeeded."""
        return self._result(lib.cylfuse_fitter_get_result)

    # What can be asked about a model; None is that of the last fit, with its uncertainty.

    def residuals(self, kind: ResidualKind | str = ResidualKind.POINTS, model: Optional[Cylinder] = None) -> Floats:
        """Signed distances of the used points from the surface in the order of pushing, or of both ends of every
        used edge from its limb in ideal pixels."""
        given, which, counts = _cylinder(model), ResidualKind(kind), self.counts
        capacity = counts.points_used if which == ResidualKind.POINTS else 2 * counts.segments_given

        def arguments(out: Any, count: Any) -> tuple[Any, ...]:
            return given, which, _arrays.address(out), out.size, count

        residuals: Floats = self._list(lib.cylfuse_fitter_residuals, arguments, np.float64, capacity)
        return residuals

    def limb_samples(self) -> LimbSamples:
        """What the last fit saw of the limbs in the grey image; empty when it was not searched."""
        pointer = lib.cylfuse_fitter_limb_samples.argtypes[1]

        def arguments(out: Any, count: Any) -> tuple[Any, ...]:
            return out.ctypes.data_as(pointer), out.size, count

        # Enough for limbs of 500 pixels; longer ones take a second call.
        samples = self._list(lib.cylfuse_fitter_limb_samples, arguments, np.dtype(_structs.LimbSample), 1024)
        return LimbSamples(*(samples[name] for name in LimbSamples._fields))

    def _list(self, function: Any, arguments: Any, dtype: Any, capacity: int) -> Any:
        """An output whose length the library tells."""
        count = c_size_t()
        with self._calling():
            while True:
                out = np.empty(capacity, dtype)
                try:
                    self._checked(function, *arguments(out, byref(count)))
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

    def diagnose(self, model: Optional[Cylinder] = None) -> Diagnosis:
        """What the data determine, more precise than ``condition`` of a result and far slower."""
        struct = make_output(_structs.Diagnosis)
        self._call(lib.cylfuse_fitter_diagnose, _cylinder(model), byref(struct))
        return Diagnosis(struct)

    def extent(self, model: Optional[Cylinder] = None, mask: Optional[Array] = None) -> Extent:
        """The visible piece of the cylinder; without ``mask`` that of the last depth image."""
        struct = make_output(_structs.Extent)
        view = _arrays.mask_view(mask)
        self._call(lib.cylfuse_fitter_extent, _cylinder(model), _mask(view), byref(struct))
        return Extent(struct)

    def complete(
        self,
        layout: Layout | str = Layout.PACKED,
        dtype: npt.DTypeLike = np.float64,
        model: Optional[Cylinder] = None,
        mask: Optional[Array] = None,
    ) -> Completion:
        """Casts the ray of every pixel of a mask onto the cylinder: points in the camera frame."""
        dtype, layout = np.dtype(dtype), Layout(layout)
        if dtype not in _arrays.SCALARS:
            raise TypeError(f"dtype is {dtype}; it must be float32 or float64")
        region, capacity = _arrays.mask_view(mask), c_size_t()
        struct, out = make_output(_structs.Completion), make(_structs.PointsOut)
        out.layout, out.scalar = layout, _arrays.SCALARS[dtype]
        with self._calling():
            self._checked(lib.cylfuse_fitter_complete_bound, _mask(region), layout, byref(capacity))
            points: Array = np.empty((capacity.value, 3), dtype)
            out.data, out.capacity = _arrays.address(points), capacity.value
            self._checked(
                lib.cylfuse_fitter_complete, _cylinder(model), _mask(region), byref(out), byref(struct)
            )
            camera = self._intrinsics
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
        """The depth image of uint16 or float32 with value * ``scale`` = z of the completed points, 0 elsewhere."""
        dtype = np.dtype(dtype)
        if dtype not in _arrays.DEPTHS:
            raise TypeError(f"dtype is {dtype}; it must be uint16 or float32")
        region = _arrays.mask_view(mask)
        struct, out = make_output(_structs.Completion), make(_structs.DepthOut)
        camera = self._intrinsics
        depth = np.empty((camera.height, camera.width) if camera else (0, 0), dtype)
        out.format, out.scale, out.data = _arrays.DEPTHS[dtype], _check.real("scale", scale), _arrays.address(depth)
        out.height, out.width = depth.shape
        self._call(
            lib.cylfuse_fitter_complete_depth, _cylinder(model), _mask(region), byref(out), byref(struct)
        )
        return Completion(struct, depth)


#: The fitters that call back.
_WITH_CALLBACKS: weakref.WeakSet[Fitter] = weakref.WeakSet()


@atexit.register
def _end_calls() -> None:
    """Once the process ends, Python takes a daemon thread that enters it from a callback out of the midst of the
    library, which aborts the process: running fits end before that, and no other begins."""
    for fitter in list(_WITH_CALLBACKS):
        if not fitter.closed:
            fitter.cancel()
            # A callback that waits for ever must not keep the process.
            fitter._running.acquire(timeout=2.0)
