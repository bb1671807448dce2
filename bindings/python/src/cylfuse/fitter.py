"""The fitter: for loops over frames, and for everything that single calls do not offer."""

from __future__ import annotations

from ctypes import byref, c_size_t
from typing import Any, Callable, Optional

import numpy.typing as npt

from . import _arrays, _check, _structs
from ._arrays import Array
from ._calling import Calling
from ._native import lib, make
from .enums import Input, LogLevel
from .errors import fail
from .frame import Frame, depth_camera
from .geometry import Cylinder, Intrinsics, Pose
from .options import Options
from .questions import Questions, _cylinder, _optional
from .result import Progress, Result, View


class Fitter(Questions, Calling):
    """Estimates one cylinder. For the next frame: :meth:`clear`, push, :meth:`fit`.

    There is one view at first, at the identity; :meth:`select_view` adds others and says which one is meant by what is
    set, pushed and asked. Calls that change nothing may be made from any number of threads at once; whatever would
    disturb another call raises :class:`BusyError`. Close a fitter, or use it in a ``with`` statement; one that is
    forgotten is closed with its object.
    """

    _what = "fitter"
    _cancel_function = lib.cylfuse_fitter_cancel

    def __init__(self, intrinsics: Optional[Intrinsics] = None, options: Optional[Options] = None) -> None:
        super().__init__(lib.cylfuse_fitter_create, lib.cylfuse_fitter_destroy)
        self._begin(View(None, Pose()))
        if options is not None:
            self.options = options
        if intrinsics is not None:
            self.intrinsics = intrinsics

    @classmethod
    def _made(cls, create: Any, view: View) -> Fitter:
        """The fitter that a detector makes, with its view."""
        fitter = cls.__new__(cls)
        super(Fitter, fitter).__init__(create, lib.cylfuse_fitter_destroy)
        fitter._begin(view)
        return fitter

    def clone(self) -> Fitter:
        """Another fitter with all that this one holds, settings, data and result, but no callbacks. Images are shared, points
        are copied: clone one that is set up for each thread before data are pushed."""

        def create(_: int, out: Any) -> int:
            self._call(lib.cylfuse_fitter_clone, out)
            return 0

        fitter = Fitter._made(create, View(None, Pose()))
        fitter._views, fitter._selected = list(self._views), self._selected
        return fitter

    def _begin(self, view: View) -> None:
        #: Counts what changes the answers about the last result.
        self._revision = 0
        self._views = [view]
        self._selected = 0

    def _call(self, function: Any, *arguments: Any, changes: bool = False) -> None:
        handle = self._open()
        # Before the call: when a callback or Ctrl-C ends it with an exception, it may have changed something.
        self._revision += changes
        status = self._callbacks.around(function, handle.pointer, *arguments)
        if status:
            self._revision -= changes
            fail(status, handle.pointer)

    # Settings

    @property
    def options(self) -> Options:
        """The settings of the next fit."""
        struct = make(_structs.Options)
        self._call(lib.cylfuse_fitter_get_options, byref(struct))
        return Options._from_struct(struct)

    @options.setter
    def options(self, options: Options) -> None:
        struct = _check.instance("options", options, Options)._struct()
        self._call(lib.cylfuse_fitter_set_options, byref(struct), changes=True)

    def set_start_model(self, model: Optional[Cylinder]) -> None:
        """Sets a start in the reference frame: a candidate for the start AUTO, the start of MODEL. None takes it away."""
        self._call(lib.cylfuse_fitter_set_start_model, _cylinder(model), changes=True)

    def on_progress(self, callback: Optional[Callable[[Progress], Any]]) -> None:
        """Sets what is called before every iteration, on the thread of the fit; None for none. When it returns False the
        fit stops with CancelledError; what it raises ends the fit and comes out of it."""
        self._set_callback(self._callbacks.progress(callback), lib.cylfuse_fitter_set_progress)

    def on_log(
        self, callback: Optional[Callable[[LogLevel, str], Any]], level: LogLevel | str = LogLevel.INFO
    ) -> None:
        """Sets what takes log lines up to a level, on the thread of the call; None for none. What it raises comes out
        of the call."""
        self._set_callback(self._callbacks.log(callback), lib.cylfuse_fitter_set_log, LogLevel(level))

    # Views

    def select_view(self, index: int) -> None:
        """Selects the view that is meant by what is set, pushed and asked; the number of views adds one."""
        index = _check.whole("index", index, 0, 2**32)
        self._call(lib.cylfuse_fitter_select_view, index, changes=index != self._selected)
        if index == len(self._views):
            self._views.append(View(None, Pose()))
        self._selected = index

    @property
    def selected_view(self) -> int:
        """The selected view, from 0."""
        return self._selected

    @property
    def view_count(self) -> int:
        """How many views there are, at least 1."""
        count = c_size_t()
        self._call(lib.cylfuse_fitter_view_count, byref(count))
        return count.value

    def _know(self, **changed: Any) -> None:
        self._views[self._selected] = self._views[self._selected]._replace(**changed)

    @property
    def intrinsics(self) -> Optional[Intrinsics]:
        """The colour camera of the selected view, which depth images, images and edges need. Points that were pushed
        before stay as they are."""
        return self._views[self._selected].intrinsics

    @intrinsics.setter
    def intrinsics(self, intrinsics: Intrinsics) -> None:
        struct = _check.instance("intrinsics", intrinsics, Intrinsics)._struct()
        self._call(lib.cylfuse_fitter_set_intrinsics, byref(struct), changes=True)
        self._know(intrinsics=intrinsics)

    @property
    def pose(self) -> Pose:
        """Where the selected view is in the reference frame; :meth:`set_pose` sets it."""
        return self._views[self._selected].pose

    def set_pose(self, pose: Pose | npt.ArrayLike) -> None:
        """Sets where the selected view is: the motion from its camera to the reference frame, as a :class:`Pose` or a
        4 x 4 matrix. The identity at first."""
        pose = Pose.of(pose)
        self._call(lib.cylfuse_fitter_set_pose, *pose._numbers(), changes=True)
        self._know(pose=pose)

    def set_depth_camera(self, intrinsics: Optional[Intrinsics], pose: Pose | npt.ArrayLike = Pose()) -> None:
        """Gives the depth of the selected view a camera of its own: depth images that are pushed later are in its
        pixels, masks and edges in those of the colour camera. ``pose`` is the motion from the depth camera to the
        colour camera. None takes it away."""
        self._call(lib.cylfuse_fitter_set_depth_camera, *depth_camera(intrinsics, pose), changes=True)

    # Data

    def push_points(
        self,
        points: npt.ArrayLike,
        weights: Optional[npt.ArrayLike] = None,
        normals: Optional[npt.ArrayLike] = None,
        mask: Optional[Array] = None,
        *,
        label: int = 0,
    ) -> None:
        """Adds points, N x 3 or rows x columns x 3, of float32 or float64, with any strides between points; in the
        camera frame when edges or extent matter. ``mask`` selects from an organised cloud."""
        view, mask_view = _arrays.points_view(points, weights, normals), _arrays.mask_view(mask, label)
        self._call(lib.cylfuse_fitter_push_points, byref(view), _optional(mask_view), changes=True)

    def push_depth(
        self,
        depth: Array,
        mask: Optional[Array] = None,
        scale: Optional[float] = None,
        min_depth: float = 0.0,
        max_depth: Optional[float] = None,
        *,
        label: int = 0,
    ) -> None:
        """Adds the points of a depth image of uint16 or float32, rows x columns with any strides: z = value *
        ``scale``, the length of one unit of it, 1 for float depth where it is left out, and needed for uint16. It is read
        in place; float64 is converted. ``mask`` (bool or uint8) marks the cylinder, or the whole object, where it is not 0,
        or where it is ``label``: see :func:`fit`. Both are kept for completion and extent. Depths below ``min_depth`` or
        above ``max_depth`` become no points; the extent is found with all."""
        view, mask_view = _arrays.depth_view(depth, scale, min_depth, max_depth), _arrays.mask_view(mask, label)
        self._call(lib.cylfuse_fitter_push_depth, byref(view), _optional(mask_view), changes=True)

    def push_image(self, image: Array, gamma: float = 1.0, *, bgr: bool = False) -> None:
        """Takes the image of the selected view: grey (uint8, uint16 or float32), or in colour: uint8, rows x columns x
        3, red first or with ``bgr`` blue first as OpenCV reads files; a fourth channel is ignored. The limbs are
        located in it. Light is the value to the power of ``gamma``: 2.2 for sRGB."""
        self._call(lib.cylfuse_fitter_push_image, byref(_arrays.image_view(image, gamma, bgr)), changes=True)

    def push_edges(self, edges: npt.ArrayLike, weights: Optional[npt.ArrayLike] = None) -> None:
        """Adds edge segments x1, y1, x2, y2 in pixels, N x 4 or N x 2 x 2, on either limb."""
        self._call(lib.cylfuse_fitter_push_edges, byref(_arrays.segments_view(edges, weights)), changes=True)

    def use_frame(self, frame: Frame, mask: Optional[Array] = None, *, label: int = 0) -> None:
        """Lets the selected view take camera, pose and images from a frame, without a copy, in place of its own, and
        adds the points of the depth image inside the mask."""
        handle, view = _check.instance("frame", frame, Frame)._open(), _arrays.mask_view(mask, label)
        self._call(lib.cylfuse_fitter_use_frame, handle.pointer, _optional(view), changes=True)
        self._know(intrinsics=frame.intrinsics, pose=frame.pose)

    def reserve(self, points: int, segments: int = 0) -> None:
        """Makes room for the coordinates of that many more points and for that many more segments in the selected view."""
        counts = (_check.whole(name, n, 0, 2**63) for name, n in (("points", points), ("segments", segments)))
        self._call(lib.cylfuse_fitter_reserve, *counts)

    def clear(self) -> None:
        """Forgets the data, all views but the first, its pose and the result; keeps options, the cameras of the first
        view, start model, what the start LAST goes on from, callbacks and memory."""
        self._call(lib.cylfuse_fitter_clear, changes=True)
        self._views = [View(self._views[0].intrinsics, Pose())]
        self._selected = 0

    def clear_input(self, *inputs: Input | str) -> None:
        """Forgets some of the data of the selected view, such as ``clear_input("points", "depth")``."""
        kinds = {Input(kind) for kind in inputs}
        self._call(lib.cylfuse_fitter_clear_input, sum(kinds), changes=True)

    # Fitting

    def fit(self) -> Result:
        """Estimates the cylinder from everything that was pushed into all views, and its extent."""
        structs = make(_structs.Result), make(_structs.CylinderEstimate)
        self._call(lib.cylfuse_fitter_fit, byref(structs[0]), byref(structs[1]), changes=True)
        return self._found(structs)

    def _found(self, structs: tuple[Any, Any]) -> Result:
        """The result of a fit that was just made."""
        result = self._result(structs)
        # Now, for the next frame takes the data away.
        result._find_extent()
        return result

    def _result(self, structs: tuple[Any, Any]) -> Result:
        result = Result(structs, self, self._revision)
        result.views = tuple(self._views)
        return result

    def evaluate(self, model: Cylinder) -> Result:
        """What a fit would report for a given model, without iterating."""
        structs = make(_structs.Result), make(_structs.CylinderEstimate)
        given = _check.instance("model", model, Cylinder)._struct()
        self._call(lib.cylfuse_fitter_evaluate, byref(given), byref(structs[0]), byref(structs[1]))
        return Result(structs, None, 0)

    @property
    def result(self) -> Result:
        """The result of the last fit that succeeded."""
        structs = make(_structs.Result), make(_structs.CylinderEstimate)
        self._call(lib.cylfuse_fitter_get_result, byref(structs[0]))
        self._call(lib.cylfuse_fitter_get_cylinder, byref(structs[1]))
        return self._result(structs)
