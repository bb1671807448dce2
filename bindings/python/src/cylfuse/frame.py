"""Frames: what a camera delivered once, for any number of fitters."""

from __future__ import annotations

from ctypes import byref
from typing import Any, Optional

import numpy.typing as npt

from . import _arrays, _check
from ._arrays import Array
from ._handle import Closable
from ._native import lib
from .errors import fail_on_frame
from .geometry import Intrinsics, Pose


class Frame(Closable):
    """What one camera delivered at one time: intrinsics, pose, depth image, image. Any number of fitters, such as one
    for each cylinder of a scene, use it without a copy: :meth:`Fitter.use_frame`. What is set later, and closing it,
    changes nothing in them."""

    _what = "frame"

    def __init__(
        self, intrinsics: Optional[Intrinsics] = None, pose: Optional[Pose | npt.ArrayLike] = None
    ) -> None:
        super().__init__(lib.cylfuse_frame_create, lib.cylfuse_frame_destroy)
        self._intrinsics: Optional[Intrinsics] = None
        self._pose = Pose()
        if intrinsics is not None:
            self.intrinsics = intrinsics
        if pose is not None:
            self.set_pose(pose)

    def _call(self, function: Any, *arguments: Any) -> None:
        handle = self._open()
        status = function(handle.pointer, *arguments)
        if status:
            fail_on_frame(status, handle.pointer)

    @property
    def intrinsics(self) -> Optional[Intrinsics]:
        """The colour camera, which comes before depth and image."""
        return self._intrinsics

    @intrinsics.setter
    def intrinsics(self, intrinsics: Intrinsics) -> None:
        struct = _check.instance("intrinsics", intrinsics, Intrinsics)._struct()
        self._call(lib.cylfuse_frame_set_intrinsics, byref(struct))
        self._intrinsics = intrinsics

    @property
    def pose(self) -> Pose:
        """Where the camera is in the reference frame; :meth:`set_pose` sets it."""
        return self._pose

    def set_pose(self, pose: Pose | npt.ArrayLike) -> None:
        """Sets where the camera is: the motion from its frame to the reference frame, as a :class:`Pose` or a 4 x 4
        matrix. The identity at first."""
        pose = Pose.of(pose)
        self._call(lib.cylfuse_frame_set_pose, *pose._numbers())
        self._pose = pose

    def set_depth_camera(
        self, intrinsics: Optional[Intrinsics], pose: Pose | npt.ArrayLike = Pose()
    ) -> None:
        """Gives the depth a camera of its own, before :meth:`set_depth`; ``pose`` is the motion from the depth camera
        to the colour camera. None takes it away."""
        self._call(lib.cylfuse_frame_set_depth_camera, *depth_camera(intrinsics, pose))

    def set_depth(
        self,
        depth: Array,
        scale: Optional[float] = None,
        min_depth: float = 0.0,
        max_depth: Optional[float] = None,
    ) -> None:
        """Sets the depth image, as :meth:`Fitter.push_depth` takes it. A detector, too, searches only from ``min_depth`` to
        ``max_depth``."""
        self._call(lib.cylfuse_frame_set_depth, byref(_arrays.depth_view(depth, scale, min_depth, max_depth)))

    def set_image(self, image: Array, gamma: float = 1.0, *, bgr: bool = False) -> None:
        """Sets the image, as :meth:`Fitter.push_image` takes it."""
        self._call(lib.cylfuse_frame_set_image, byref(_arrays.image_view(image, gamma, bgr)))


def depth_camera(intrinsics: Optional[Intrinsics], pose: Pose | npt.ArrayLike) -> tuple[Any, ...]:
    """The arguments of a depth camera."""
    if intrinsics is None:
        return None, None, None
    struct = _check.instance("intrinsics", intrinsics, Intrinsics)._struct()
    return (byref(struct), *Pose.of(pose)._numbers())
