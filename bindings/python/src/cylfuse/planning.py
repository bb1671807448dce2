"""What a camera will measure."""

from __future__ import annotations

from ctypes import byref
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ._arrays import address, vector
from ._check import instance, real
from ._native import lib
from .errors import fail
from .geometry import Intrinsics


class Deviations(NamedTuple):
    """Standard deviations of what is measured of a cylinder."""

    #: Of the radius in metres.
    radius: float
    #: Of the direction of the axis in radians, in the plane in which it is least certain.
    direction: float
    #: Of the position of the axis across itself in metres, in the direction in which it is least certain.
    position: float
    #: Of the length in metres; NaN where an end lies outside the image.
    length: float


class Expectation(NamedTuple):
    """What is to be expected of measurements."""

    #: How much captures of one scene scatter.
    scatter: Deviations
    #: How far a measurement is off: what a fit states.
    total: Deviations


def plan(
    intrinsics: Intrinsics,
    *,
    distance: float,
    radius: float,
    length: float,
    tilt: float = 0.0,
    turn: float = 0.0,
    noise: npt.ArrayLike | None = None,
) -> Expectation:
    """The standard deviations to be expected of a cylinder with the middle of its axis on the optical axis, by the
    covariance at the exact view. Lengths are in metres.

    `tilt` is the angle between the axis and the plane of the image, `turn` its angle in the image from the vertical.
    `noise` has six numbers: a, b, c of the noise of depth a + b z + c z^2 at the depth z; the side of the squares of
    pixels that share it, at least 1; the noise of a pixel of the image as a part of the step of brightness at limbs and
    ends; the blur of the image in pixels. Without it, it is that of structured light and an ordinary image. A noise for each
    limb and end, and simulated captures, are in `cylfuse plan` on the command line and in Rust alone."""
    camera = instance("intrinsics", intrinsics, Intrinsics)._struct()
    numbers = {"distance": distance, "radius": radius, "length": length, "tilt": tilt, "turn": turn}
    cylinder = np.array([real(name, value) for name, value in numbers.items()])
    laws = None if noise is None else np.ascontiguousarray(vector("noise", noise, 6))
    scatter, total = np.empty(4), np.empty(4)
    status = lib.cylfuse_plan(
        byref(camera), address(cylinder), None if laws is None else address(laws), address(scatter), address(total)
    )
    if status:
        fail(status)
    return Expectation(Deviations(*scatter.tolist()), Deviations(*total.tolist()))
