"""The detector: all cylinders of a scene."""

from __future__ import annotations

import threading
from ctypes import byref, c_int32, c_size_t, sizeof
from typing import Any, Callable, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from . import _arrays, _check, _structs
from ._calling import Calling
from ._native import lib, make, status_text
from .errors import BusyError, CylfuseError, fail_on_detector
from .fitter import Fitter
from .frame import Frame
from .geometry import Pose
from .options import DetectorOptions, Options
from .result import Detection, DetectionProgress, Extent, Result, View

# Above every index that the library can have.
_INDICES = 2**63


class _Scene(NamedTuple):
    """What the library does not say of a scene."""

    #: The shape of the labels.
    shape: tuple[int, ...]
    view: View


class Detector(Calling):
    """Finds all cylinders of a frame or a cloud, without masks, and fits each by the full method.

    A search returns the cylinders; :attr:`labels`, :meth:`indices` and :meth:`fitter` are of the last search that
    succeeded. Calls that change nothing may be made from any number of threads at once; whatever would disturb another
    call raises :class:`BusyError`. Close a detector, or use it in a ``with`` statement; one that is forgotten is closed
    with its object.
    """

    _what = "detector"
    _cancel_function = lib.cylfuse_detector_cancel

    def __init__(
        self, options: Optional[DetectorOptions] = None, fit_options: Optional[Options] = None
    ) -> None:
        super().__init__(lib.cylfuse_detector_create, lib.cylfuse_detector_destroy)
        self._scene: Optional[_Scene] = None
        self._searching = threading.Lock()
        if options is not None:
            self.options = options
        if fit_options is not None:
            self.fit_options = fit_options

    def _call(self, function: Any, *arguments: Any) -> None:
        handle = self._open()
        status = self._callbacks.around(function, handle.pointer, *arguments)
        if status:
            fail_on_detector(status, handle.pointer)

    # Settings

    @property
    def options(self) -> DetectorOptions:
        """The settings of the next search."""
        struct = make(_structs.DetectorOptions)
        self._call(lib.cylfuse_detector_get_options, byref(struct))
        return DetectorOptions._from_struct(struct)

    @options.setter
    def options(self, options: DetectorOptions) -> None:
        struct = _check.instance("options", options, DetectorOptions)._struct()
        self._call(lib.cylfuse_detector_set_options, byref(struct))

    @property
    def fit_options(self) -> Options:
        """The settings of the fits of the next search. Limits, ``max_threads`` and ``start`` must have their defaults:
        they are the detector's."""
        struct = make(_structs.Options)
        self._call(lib.cylfuse_detector_get_fit_options, byref(struct))
        return Options._from_struct(struct)

    @fit_options.setter
    def fit_options(self, options: Options) -> None:
        struct = _check.instance("fit_options", options, Options)._struct()
        self._call(lib.cylfuse_detector_set_fit_options, byref(struct))

    def on_progress(self, callback: Optional[Callable[[DetectionProgress], Any]]) -> None:
        """Sets what is called with the progress of a search: before it, after it, and after each fit, on the thread of
        the search; None for none. When it returns False the search stops with CancelledError; what it raises ends the search and comes out
        of it."""
        self._set_callback(self._callbacks.progress(callback, DetectionProgress), lib.cylfuse_detector_set_progress)

    # Searching

    def detect(self, frame: Frame) -> list[Detection]:
        """Finds all cylinders in the depth image of a frame, and fits each to its region by depth and image, in the
        reference frame to which the pose of the frame leads. By falling score; there may be none."""
        handle = _check.instance("frame", frame, Frame)._open()
        camera = frame.intrinsics
        shape = (camera.height, camera.width) if camera is not None else (0, 0)
        scene = _Scene(shape, View(camera, frame.pose))
        return self._search(scene, lib.cylfuse_detector_detect, handle.pointer)

    def detect_points(
        self,
        points: npt.ArrayLike,
        weights: Optional[npt.ArrayLike] = None,
        normals: Optional[npt.ArrayLike] = None,
    ) -> list[Detection]:
        """Finds all cylinders in a cloud, N x 3 or rows x columns x 3 of float32 or float64, and fits each to its
        points. Points with a coordinate that is not finite or a weight of 0 are left out. It is looked at from
        where one sensor has seen it, in its origin or where the densities of the points tell; other clouds are looked at
        from all sides, which takes about ten times as long. By falling score; there may be none."""
        view = _arrays.points_view(points, weights, normals)
        scene = _Scene(view.array[0].shape[:-1], View(None, Pose()))
        return self._search(scene, lib.cylfuse_detector_detect_points, byref(view))

    def _search(self, scene: _Scene, function: Any, argument: Any) -> list[Detection]:
        if not self._searching.acquire(blocking=False):
            raise _busy()
        try:
            self._call(function, argument)
            self._scene = scene
            return self._list()
        finally:
            self._searching.release()

    # The last scene

    def _consistent(self, ask: Callable[[], Any]) -> Any:
        """What several calls say, which must be of one scene."""
        scene = self._scene
        answer = ask()
        if self._searching.locked() or self._scene is not scene:
            raise _busy()
        return answer

    @property
    def detections(self) -> list[Detection]:
        """The cylinders of the last search that succeeded, by falling score."""
        found: list[Detection] = self._consistent(self._list)
        return found

    @property
    def is_complete(self) -> bool:
        """Whether the scene was looked at as a whole. The work of a search with its fits is bounded: of a scene with more
        in it than that, cylinders may be missing. One for whose fit there was no work left is what the search
        found, with the warning ``NOT_CONVERGED``."""
        complete = c_int32()
        self._call(lib.cylfuse_detector_is_complete, byref(complete))
        return bool(complete.value)

    @property
    def depth_moved(self) -> tuple[int, int]:
        """The columns (to the right) and rows (down) by which the depth of the frame was moved to where the image shows
        the same bodies; zeros where it was not. Each result then has the warning ``DEPTH_SHIFTED``; labels and indices
        are those of the depth as it was given."""
        columns, rows = c_int32(), c_int32()
        self._call(lib.cylfuse_detector_depth_moved, byref(columns), byref(rows))
        return columns.value, rows.value

    def _list(self) -> list[Detection]:
        count = c_size_t()
        self._call(lib.cylfuse_detector_count, byref(count))
        structs = (_structs.Detection * count.value)()
        size = sizeof(_structs.Detection)
        self._call(lib.cylfuse_detector_detections, structs, size, count.value, byref(count))
        return [Detection(struct.score, struct.pixels, self._result(k)) for k, struct in enumerate(structs)]

    def _result(self, index: int) -> Result:
        structs = make(_structs.Result), make(_structs.CylinderEstimate)
        self._call(lib.cylfuse_detector_get_result, index, byref(structs[0]))
        self._call(lib.cylfuse_detector_get_cylinder, index, byref(structs[1]))
        result = Result(structs, None, 0)
        if self._scene is not None:
            result.views = (self._scene.view,)
        extent = make(_structs.Extent)
        try:
            self._call(lib.cylfuse_detector_get_extent, index, byref(extent))
            result._extent = Extent(extent)
        except BusyError:
            raise
        except CylfuseError as error:
            # The traceback would keep the detector.
            result._extent = error.with_traceback(None)
        return result

    @property
    def labels(self) -> npt.NDArray[np.uint16]:
        """For each pixel of the colour image, or each point of the cloud, the number of its cylinder from 1 on: 1 for
        the first detection; 0 = none. Shape (rows, columns), or (N,) for a cloud that is not organised."""

        labels: npt.NDArray[np.uint16] = self._consistent(
            lambda: self._numbers(np.uint16, lib.cylfuse_detector_labels).reshape(self._shape())
        )
        return labels

    def _shape(self) -> tuple[int, ...]:
        return self._scene.shape if self._scene is not None else (-1,)

    def indices(self, index: int) -> npt.NDArray[np.uint32]:
        """The pixels or points of one detection (from 0), counted from 0 row by row, rising: places in
        ``labels.ravel()``, and in the rows of a cloud."""
        index = _check.whole("index", index, 0, _INDICES)
        indices: npt.NDArray[np.uint32] = self._consistent(
            lambda: self._numbers(np.uint32, lib.cylfuse_detector_indices, index)
        )
        return indices

    def _numbers(self, dtype: Any, function: Any, *arguments: Any) -> Any:
        """Numbers that the library lists, whose count is asked first."""
        count = c_size_t()
        handle = self._open()
        status = function(handle.pointer, *arguments, None, 0, byref(count))
        if status not in (0, _BUFFER_TOO_SMALL):
            fail_on_detector(status, handle.pointer)
        numbers = np.empty(count.value, dtype)
        if numbers.size:
            self._call(function, *arguments, _arrays.address(numbers), numbers.size, byref(count))
        return numbers

    def fitter(self, index: int) -> Fitter:
        """A new fitter of one detection (from 0) as its fit left it, with options, frame or points, region as mask,
        start model and result: for residuals, completion, limbs and so on, or for another fit. It shares the images of
        the frame and does not depend on the detector."""
        index = _check.whole("index", index, 0, _INDICES)

        def create(_: int, out: Any) -> int:
            self._call(lib.cylfuse_detector_make_fitter, index, out)
            return 0

        def ask() -> Fitter:
            scene = self._scene or _Scene((), View(None, Pose()))
            return Fitter._made(create, scene.view)

        fitter: Fitter = self._consistent(ask)
        return fitter


_BUFFER_TOO_SMALL = -7


def _busy() -> BusyError:
    return BusyError(status_text(BusyError.status))
