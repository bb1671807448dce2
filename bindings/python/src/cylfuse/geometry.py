"""Cylinders and cameras."""

from __future__ import annotations

import math
from ctypes import byref, c_double
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from . import _structs
from ._arrays import address, c_vector, numbers, points_view, vector
from ._native import lib, make
from .enums import Distortion
from .errors import fail_without_fitter


class Comparison(NamedTuple):
    """How two cylinders differ."""

    #: Angle between the axes in radians, whatever the signs of the directions.
    angle: float
    #: Shortest distance between the axes, in the unit of length.
    axis_distance: float
    #: (radius of the other - radius) / radius.
    radius_relative: float


@dataclass(frozen=True, eq=False)
class Cylinder:
    """An infinite cylinder in the unit of length and the frame of the data."""

    #: A point on the axis, shape (3,).
    point: Any
    #: The direction of the axis, shape (3,), of length 1 in results.
    direction: Any
    #: The radius.
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "point", vector("point", self.point, 3))
        object.__setattr__(self, "direction", vector("direction", self.direction, 3))
        object.__setattr__(self, "radius", float(self.radius))

    @classmethod
    def _from_struct(cls, struct: _structs.Cylinder) -> Cylinder:
        cylinder = cls.__new__(cls)
        values = numbers(struct)
        cylinder.__dict__.update(point=values[:3], direction=values[3:6], radius=float(values[6]))
        return cylinder

    def _struct(self) -> _structs.Cylinder:
        return _structs.Cylinder(
            c_vector("point", self.point, 3), c_vector("direction", self.direction, 3), self.radius
        )

    def distances(self, points: Any) -> Any:
        """Signed distances of points (N x 3, or rows x columns x 3) from the surface, negative inside; NaN for a
        point that is not finite."""
        view, kept = points_view(points)
        out = np.empty(kept[0].shape[:-1])
        status = lib.cylfuse_cylinder_distances(byref(self._struct()), byref(view), address(out), out.size)
        if status:
            fail_without_fitter(status)
        return out

    def project(self, intrinsics: Intrinsics) -> Any:
        """The two limb lines a u + b v + c = 0 in ideal pixels, those of a pinhole with the same focal lengths and
        principal point, as rows (a, b, c) with a^2 + b^2 = 1: shape (2, 3)."""
        out = np.empty((2, 3))
        camera = intrinsics._struct()
        pointer = out.ctypes.data_as(lib.cylfuse_cylinder_project.argtypes[2])
        status = lib.cylfuse_cylinder_project(byref(self._struct()), byref(camera), pointer)
        if status:
            fail_without_fitter(status)
        return out

    def compare(self, other: Cylinder) -> Comparison:
        """How another cylinder differs from this one, such as the truth."""
        angle, distance, radius = c_double(), c_double(), c_double()
        status = lib.cylfuse_cylinder_compare(
            byref(self._struct()), byref(other._struct()), byref(angle), byref(distance), byref(radius)
        )
        if status:
            fail_without_fitter(status)
        return Comparison(angle.value, distance.value, radius.value)

    def __repr__(self) -> str:
        point = ", ".join(f"{x:.6g}" for x in self.point)
        direction = ", ".join(f"{x:.6g}" for x in self.direction)
        return f"Cylinder(point=[{point}], direction=[{direction}], radius={self.radius:.6g})"


@dataclass(frozen=True)
class Intrinsics:
    """A camera as a calibration gives it. Pixel centres are at integer coordinates, as in OpenCV."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion_model: Distortion = Distortion.NONE
    #: Up to 8 coefficients in the order of OpenCV; missing ones are 0.
    distortion: Any = field(default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "distortion_model", Distortion(self.distortion_model))
        distortion = tuple(float(x) for x in self.distortion)
        if len(distortion) > 8:
            raise ValueError(f"distortion has {len(distortion)} coefficients; it must have at most 8")
        object.__setattr__(self, "distortion", distortion)
        for name in ("width", "height"):
            size = getattr(self, name)
            if not 0 <= size < 2**32:
                raise ValueError(f"{name} is {size}; it must lie in [1, 2^28]")

    @classmethod
    def from_matrix(cls, matrix: Any, width: int, height: int, distortion: Any = ()) -> Intrinsics:
        """From the 3 x 3 camera matrix of OpenCV and, when there are any, its Brown-Conrady coefficients."""
        k = np.asarray(matrix, dtype=np.float64)
        if k.shape != (3, 3):
            raise ValueError(f"the camera matrix has the shape {k.shape}; it must be (3, 3)")
        if k[0, 1] != 0.0:
            raise ValueError(f"the camera matrix has the skew {k[0, 1]}; it must be 0")
        coefficients = tuple(float(x) for x in np.ravel(distortion))
        model = Distortion.BROWN_CONRADY if any(coefficients) else Distortion.NONE
        return cls(width, height, k[0, 0], k[1, 1], k[0, 2], k[1, 2], model, coefficients)

    def _struct(self) -> _structs.Intrinsics:
        struct = make(_structs.Intrinsics)
        struct.distortion_model = self.distortion_model
        struct.width, struct.height = self.width, self.height
        struct.fx, struct.fy, struct.cx, struct.cy = self.fx, self.fy, self.cx, self.cy
        struct.distortion[: len(self.distortion)] = self.distortion
        return struct

    def pixels(self, points: Any) -> Any:
        """Pixels of points (N x 3) in the camera frame, through the lens; for drawing. Shape (N, 2)."""
        x, y, z = np.asarray(points, dtype=np.float64).T
        x, y = x / z, y / z
        k = self.distortion + (0.0,) * (8 - len(self.distortion))
        r2 = x * x + y * y
        if self.distortion_model == Distortion.BROWN_CONRADY:
            k1, k2, p1, p2, k3, k4, k5, k6 = k
            radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
            x, y = (
                x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
            )
        elif self.distortion_model == Distortion.KANNALA_BRANDT:
            angle = np.arctan(np.sqrt(r2))
            a2 = angle * angle
            bent = angle * (1 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3]))))
            scale = np.where(r2 > 0, bent / np.sqrt(np.where(r2 > 0, r2, 1)), 1.0)
            x, y = x * scale, y * scale
        return np.stack([self.fx * x + self.cx, self.fy * y + self.cy], axis=-1)


def limb_points(cylinder: Cylinder, start: Any, end: Any) -> list[Any]:
    """The ends of both limbs, two arrays of shape (2, 3): where the rays of a camera at the origin touch the
    surface. Empty from inside the cylinder."""
    direction = cylinder.direction
    foot = start - direction * (start @ direction)
    distance = math.sqrt(foot @ foot)
    if distance <= cylinder.radius:
        return []
    toward = foot / distance
    side = np.cross(direction, toward)
    sine = cylinder.radius / distance
    across = [-sine * toward + s * math.sqrt(1 - sine * sine) * side for s in (1.0, -1.0)]
    return [np.stack([start, end]) + cylinder.radius * radius for radius in across]
