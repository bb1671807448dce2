"""Cylinders and cameras."""

from __future__ import annotations

import warnings
from ctypes import byref, c_double
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _structs
from ._arrays import Floats, address, c_vector, numbers, points_view, vector
from ._check import instance, real, whole
from ._native import lib, make
from .enums import Distortion
from .errors import fail


class Comparison(NamedTuple):
    """How two cylinders differ."""

    #: Angle between the axes in radians, whatever the signs of the directions.
    angle: float
    #: Shortest distance between the axes, in the unit of length.
    axis_distance: float
    #: (radius of the other - radius) / radius.
    radius_relative: float


@dataclass(frozen=True, eq=False, init=False)
class Cylinder:
    """An infinite cylinder in the unit of length and the frame of the data."""

    #: A point on the axis, shape (3,).
    point: Floats
    #: The direction of the axis, shape (3,): of length 1 in results, of any length but 0 where it is given.
    direction: Floats
    #: The radius.
    radius: float

    def __init__(self, point: npt.ArrayLike, direction: npt.ArrayLike, radius: float) -> None:
        self.__dict__.update(
            point=vector("point", point, 3), direction=vector("direction", direction, 3), radius=real("radius", radius)
        )

    @classmethod
    def _from_struct(cls, struct: _structs.Cylinder) -> Cylinder:
        cylinder = cls.__new__(cls)
        values = numbers(struct)
        cylinder.__dict__.update(point=values[:3], direction=values[3:6], radius=float(values[6]))
        return cylinder

    def _struct(self) -> _structs.Cylinder:
        return _structs.Cylinder(c_vector(self.point), c_vector(self.direction), self.radius)

    def distances(self, points: npt.ArrayLike) -> Floats:
        """Signed distances of points (N x 3, or rows x columns x 3) from the surface, negative inside; NaN for a
        point that is not finite."""
        view = points_view(points)
        out = np.empty(view.array[0].shape[:-1])
        status = lib.cylfuse_cylinder_distances(byref(self._struct()), byref(view), address(out), out.size)
        if status:
            fail(status)
        return out

    def project(self, intrinsics: Intrinsics) -> Floats:
        """The two limb lines a u + b v + c = 0 in ideal pixels, those of a pinhole with the same focal lengths and
        principal point, as rows (a, b, c) with a^2 + b^2 = 1: shape (2, 3)."""
        out = np.empty((2, 3))
        camera = instance("intrinsics", intrinsics, Intrinsics)._struct()
        status = lib.cylfuse_cylinder_project(byref(self._struct()), byref(camera), address(out))
        if status:
            fail(status)
        return out

    def compare(self, other: Cylinder) -> Comparison:
        """How another cylinder differs from this one, such as the truth."""
        angle, distance, radius = c_double(), c_double(), c_double()
        model = instance("other", other, Cylinder)._struct()
        status = lib.cylfuse_cylinder_compare(
            byref(self._struct()), byref(model), byref(angle), byref(distance), byref(radius)
        )
        if status:
            fail(status)
        return Comparison(angle.value, distance.value, radius.value)

    def __repr__(self) -> str:
        point = ", ".join(f"{x:.6g}" for x in self.point)
        direction = ", ".join(f"{x:.6g}" for x in self.direction)
        return f"Cylinder(point=[{point}], direction=[{direction}], radius={self.radius:.6g})"


@dataclass(frozen=True, init=False)
class Intrinsics:
    """A camera as a calibration gives it. Pixel centres are at integer coordinates, as in OpenCV. Ranges are checked
    by the library, when the camera is used."""

    #: The size of the image in pixels.
    width: int
    height: int
    #: The focal lengths in pixels.
    fx: float
    fy: float
    #: The principal point in pixels.
    cx: float
    cy: float
    #: What the coefficients mean; its name will do. Left out: Brown-Conrady where any of them is not 0.
    distortion_model: Distortion
    #: Up to 8 coefficients in the order of OpenCV; missing ones are 0.
    distortion: tuple[float, ...]

    def __init__(
        self,
        width: int,
        height: int,
        fx: float,
        fy: float,
        cx: float,
        cy: float,
        distortion_model: Distortion | str | None = None,
        distortion: npt.ArrayLike = (),
    ) -> None:
        coefficients = tuple(vector("distortion", distortion).tolist())
        if len(coefficients) > 8:
            raise ValueError(f"distortion has {len(coefficients)} coefficients; it must have at most 8")
        if distortion_model is None:
            distortion_model = Distortion.BROWN_CONRADY if any(coefficients) else Distortion.NONE
        self.__dict__.update(
            width=whole("width", width, 0, 2**32), height=whole("height", height, 0, 2**32),
            fx=real("fx", fx), fy=real("fy", fy), cx=real("cx", cx), cy=real("cy", cy),
            distortion_model=Distortion(distortion_model), distortion=coefficients,
        )  # fmt: skip

        def centred(x: float, y: float) -> bool:
            # To a tenth: lenses are centred to a few hundredths of the image.
            sides = ((x, self.width), (y, self.height))
            return all(abs(middle + 0.5 - side / 2) <= side / 10 for middle, side in sides)

        if centred(self.cy, self.cx) and not centred(self.cx, self.cy):
            warnings.warn(
                f"the principal point is ({self.cx:g}, {self.cy:g}) in an image of {width} x {height} pixels; are cx and cy "
                "swapped?",
                stacklevel=2,
            )
        if self.fx > 0 and self.fy > 0:
            # 140 degrees; focal lengths in millimetres make it wider by far.
            fisheye = self.distortion_model == Distortion.KANNALA_BRANDT
            if not fisheye and max(width / self.fx, height / self.fy) > 5.5:
                warnings.warn(
                    f"the focal lengths {self.fx:g} and {self.fy:g} are short for {width} x {height} pixels; give them in "
                    "pixels, not in millimetres",
                    stacklevel=2,
                )
            elif max(self.fx, self.fy) > 1.2 * min(self.fx, self.fy):
                warnings.warn(
                    f"fx is {self.fx:g} and fy is {self.fy:g}, which are nearly the same in most cameras; check them, and "
                    "their order",
                    stacklevel=2,
                )

    @classmethod
    def from_matrix(
        cls, matrix: npt.ArrayLike, width: int, height: int, distortion: npt.ArrayLike = ()
    ) -> Intrinsics:
        """From the 3 x 3 camera matrix of OpenCV and, when there are any, its Brown-Conrady coefficients."""
        if matrix is None:
            raise TypeError("intrinsics is None; it must be an Intrinsics or a 3 x 3 camera matrix")
        if np.shape(matrix) != (3, 3):
            raise ValueError(f"the camera matrix has the shape {np.shape(matrix)}; it must be (3, 3), or give an Intrinsics")
        k = vector("the camera matrix", matrix).reshape(3, 3)
        for row, column, value in ((0, 1, 0.0), (1, 0, 0.0), (2, 0, 0.0), (2, 1, 0.0), (2, 2, 1.0)):
            if k[row, column] != value:
                raise ValueError(
                    f"the camera matrix has {k[row, column]:g} in row {row}, column {column}; it must be {value:g}, "
                    "for the matrix is fx 0 cx, 0 fy cy, 0 0 1"
                )
        return cls(width, height, k[0, 0], k[1, 1], k[0, 2], k[1, 2], distortion=distortion)

    def _struct(self) -> _structs.Intrinsics:
        struct = make(_structs.Intrinsics)
        struct.distortion_model = self.distortion_model
        struct.width, struct.height = self.width, self.height
        struct.fx, struct.fy, struct.cx, struct.cy = self.fx, self.fy, self.cx, self.cy
        struct.distortion[: len(self.distortion)] = self.distortion
        return struct

    def project(self, points: npt.ArrayLike) -> Floats:
        """The pixels of the (distorted) image at which the camera sees points (N x 3, or rows x columns x 3) of its
        frame: shape (N, 2). They may lie beyond the border; NaN for a point that the camera cannot see."""
        view = points_view(points)
        out = np.empty((*view.array[0].shape[:-1], 2))
        status = lib.cylfuse_intrinsics_project(byref(self._struct()), byref(view), address(out), out.size // 2)
        if status:
            fail(status)
        return out

    def unproject(self, pixels: npt.ArrayLike) -> Floats:
        """The rays along which the camera sees pixels (N x 2) of the (distorted) image, as points at z = 1: shape
        (N, 3); NaN where the model has no ray."""
        array = np.ascontiguousarray(vector("pixels", pixels).reshape(-1, 2))
        if np.shape(pixels) != array.shape and array.size:
            raise ValueError(f"pixels have the shape {np.shape(pixels)}; it must be N x 2")
        out = np.empty((len(array), 3))
        status = lib.cylfuse_intrinsics_unproject(
            byref(self._struct()), address(array), len(array), address(out)
        )
        if status:
            fail(status)
        return out


@dataclass(frozen=True, eq=False, init=False)
class Pose:
    """A rigid motion, x' = rotation x + translation: of a view from its camera to the reference frame, of a depth
    camera from it to the colour camera. Without arguments the identity."""

    #: Shape (3, 3); small rounding errors are corrected by the library.
    rotation: Floats
    #: Shape (3,), in the unit of length.
    translation: Floats

    def __init__(
        self, rotation: npt.ArrayLike = ((1, 0, 0), (0, 1, 0), (0, 0, 1)), translation: npt.ArrayLike = (0, 0, 0)
    ) -> None:
        if np.shape(rotation) != (3, 3):
            raise ValueError(f"rotation has the shape {np.shape(rotation)}; it must be (3, 3)")
        self.__dict__.update(
            rotation=vector("rotation", rotation).reshape(3, 3), translation=vector("translation", translation, 3)
        )

    @classmethod
    def of(cls, given: Pose | npt.ArrayLike) -> Pose:
        """The pose, or that of a 4 x 4 matrix."""
        if isinstance(given, Pose):
            return given
        if np.shape(given) != (4, 4):
            raise ValueError(f"the pose has the shape {np.shape(given)}; it must be a cylfuse.Pose, or a 4 x 4 matrix")
        matrix = vector("the pose", given).reshape(4, 4)
        if matrix[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
            raise ValueError(f"the pose has {matrix[3].tolist()} in its last row; it must be 0, 0, 0, 1")
        return cls(matrix[:3, :3], matrix[:3, 3])

    def inverse(self) -> Pose:
        """The motion back."""
        return Pose(self.rotation.T, -self.rotation.T @ self.translation)

    def points(self, points: npt.ArrayLike) -> Floats:
        """Moved points, of the same shape, (..., 3)."""
        moved: Floats = np.asarray(points, dtype=np.float64) @ self.rotation.T + self.translation
        return moved

    def cylinder(self, cylinder: Cylinder) -> Cylinder:
        """A moved cylinder."""
        return Cylinder(self.points(cylinder.point), self.rotation @ cylinder.direction, cylinder.radius)

    def _numbers(self) -> tuple[Any, Any]:
        return c_vector(self.rotation.ravel()), c_vector(self.translation)


def across(direction: Any) -> Any:
    """Two vectors of length 1 that are perpendicular to a direction of length 1 and to each other, as rows; with it
    as the third they are right-handed."""
    first = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(direction, first)])
