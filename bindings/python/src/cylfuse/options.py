"""The settings of a fit and of a detector."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, TypeVar

import numpy.typing as npt

from . import _structs
from ._arrays import c_vector, vector
from ._check import real, whole
from ._native import make
from .enums import Chart, EdgeUse, ExtentRule, ImageUse, Method, NearWall, Objective, Start

_ENUMS: dict[str, Any] = {
    "method": Method,
    "objective": Objective,
    "start": Start,
    "near_wall": NearWall,
    "chart": Chart,
    "edge_use": EdgeUse,
    "extent_rule": ExtentRule,
    "image_use": ImageUse,
}


@dataclass(frozen=True)
class Options:
    """The settings of a fit. Choices may be given by name, ``Options(objective="paper")``, and are members of their
    enumerations afterwards. Ranges are checked by the library, when the options are set."""

    #: How the cylinder is estimated.
    method: Method | str = Method.FUSED
    #: What FUSED minimises.
    objective: Objective | str = Objective.ROBUST
    #: Where the iteration starts.
    start: Start | str = Start.AUTO
    #: Whether the points must lie on the wall that the camera sees.
    near_wall: NearWall | str = NearWall.AUTO
    #: The coordinates of the iteration.
    chart: Chart | str = Chart.AUTO
    #: What given edges are for the objective ROBUST.
    edge_use: EdgeUse | str = EdgeUse.REFINE
    #: How the ends of the visible cylinder are found.
    extent_rule: ExtentRule | str = ExtentRule.AUTO
    #: Most threads of one fit; 1 starts none. The result has the same bits for any number.
    max_threads: int = 1
    #: Maximum number of iterations.
    max_iterations: int = 400
    #: Smallest relative decrease of the cost that counts as progress; 0 = iterate until nothing decreases.
    cost_tolerance: float = 1e-12
    #: The iteration ends where the cosine of the angle between the residuals and what a step can change of them is not
    #: above this, in [0, 1).
    gradient_tolerance: float = 2.0**-52
    #: The iteration ends with a step that moves the surface at the data by not more than this part of their largest
    #: coordinate and of their size, in [0, 1).
    step_tolerance: float = 2.0**-52
    #: Damping of the first step.
    initial_lambda: float = 1e-3
    #: Factor by which the damping changes.
    lambda_factor: float = 10.0
    #: Damping at which no smaller step is tried any more.
    max_lambda: float = 1e12
    #: The weight of the edges in the objective PAPER, in [0, 1].
    edge_weight: float = 0.6
    #: Seed of the random samples of RANSAC.
    seed: int = 0
    #: Most random samples of RANSAC.
    ransac_max_iterations: int = 1000
    #: Distance of an inlier of RANSAC, in the unit of length; 0 = from the data.
    ransac_threshold: float = 0.0
    #: How many points with independent noise the points of one view are worth; 0 = from the data.
    independent_points: float = 0.0
    #: Standard deviation of a point across the surface, in the unit of length; 0 = from the data.
    depth_noise: float = 0.0
    #: Standard deviation of the values of the image; 0 = from the image.
    image_noise: float = 0.0
    #: Standard deviation of an end of a given edge across its limb, in drawn pixels; 0 = that of edges set by hand.
    edge_noise: float = 0.0
    #: Standard deviation of a side of the mask across its limb, in drawn pixels; 0 = that of masks drawn by hand.
    mask_noise: float = 0.0
    #: Blur of the image, the standard deviation of a Gaussian in pixels; 0 = from the image.
    image_blur: float = 0.0
    #: Size of a pixel of the drawing in which edges and masks were made, in pixels of the image; 0 = by its size.
    drawn_pixel: float = 0.0
    #: The smallest radius that the cylinder keeps.
    radius_min: float = 0.0
    #: The largest radius, equal to the smallest for a known one; 0 = no limit.
    radius_max: float = 0.0
    #: The middle of the cone of directions that the axis keeps; (0, 0, 0) = all directions.
    axis: npt.ArrayLike = (0.0, 0.0, 0.0)
    #: The largest angle from ``axis`` in radians; 0 for a known direction.
    axis_max_angle: float = 0.0
    #: Standard deviation of the errors that all points of a view share, as a part of their distance; 0 = 0.002, less than
    #: 0 = none.
    depth_shared: float = 0.0

    def __post_init__(self) -> None:
        _normalise(self)

    def _struct(self) -> _structs.Options:
        return _filled(make(_structs.Options), self)

    @classmethod
    def _from_struct(cls, struct: _structs.Options) -> Options:
        return cls(**{field.name: getattr(struct, field.name) for field in fields(cls)})


@dataclass(frozen=True)
class DetectorOptions:
    """The settings of a detector. The limits of radius and axis hold for the search and for the fits."""

    #: Whether the image of a frame is looked at.
    image_use: ImageUse | str = ImageUse.AUTO
    #: Most threads, on which cylinders are fitted side by side; 1 starts none. The result has the same bits for any
    #: number.
    max_threads: int = 1
    #: Most cylinders, those with the highest scores; 0 = no limit.
    max_count: int = 0
    #: Fewest pixels of a cylinder; points for a cloud.
    min_pixels: int = 100
    #: The least score, in [0, 1]: the probability that there is a cylinder.
    min_score: float = 0.5
    #: The smallest radius that the cylinders keep.
    radius_min: float = 0.0
    #: The largest radius, equal to the smallest for a known one; 0 = no limit.
    radius_max: float = 0.0
    #: The middle of the cone of directions that the axes keep, in the reference frame; (0, 0, 0) = all directions.
    axis: npt.ArrayLike = (0.0, 0.0, 0.0)
    #: The largest angle from ``axis`` in radians; 0 for a known direction.
    axis_max_angle: float = 0.0

    def __post_init__(self) -> None:
        _normalise(self)

    def _struct(self) -> _structs.DetectorOptions:
        return _filled(make(_structs.DetectorOptions), self)

    @classmethod
    def _from_struct(cls, struct: _structs.DetectorOptions) -> DetectorOptions:
        return cls(**{field.name: getattr(struct, field.name) for field in fields(cls)})


_WHOLE = {
    "max_count": 2**32,
    "max_iterations": 2**32,
    "max_threads": 2**32,
    "min_pixels": 2**64,
    "ransac_max_iterations": 2**64,
    "seed": 2**64,
}

_S = TypeVar("_S", _structs.Options, _structs.DetectorOptions)


def _normalise(options: Options | DetectorOptions) -> None:
    """Gives every option the one type that it has."""
    for field in fields(options):
        object.__setattr__(options, field.name, _normal(field.name, getattr(options, field.name)))


def _filled(struct: _S, options: Options | DetectorOptions) -> _S:
    """The struct with the options."""
    for field in fields(options):
        value = getattr(options, field.name)
        setattr(struct, field.name, c_vector(value) if field.name == "axis" else value)
    return struct


def _normal(name: str, value: Any) -> Any:
    """The value of an option in the one type that it has."""
    if name in _ENUMS:
        return _ENUMS[name](value)
    if name in _WHOLE:
        return whole(name, value, 0, _WHOLE[name])
    return tuple(vector(name, value, 3).tolist()) if name == "axis" else real(name, value)
