"""What the library says, as objects whose attributes have the names of cylfuse.h."""

from __future__ import annotations

import html
import math
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from ._arrays import Array, Floats, numbers
from ._record import Record
from .conformity import decide_conformity
from .enums import (
    Conformity, DetectionPhase, EndSource, EndState, Layout, Phase, ResidualKind, ResultFlags, Start, Termination,
)  # fmt: skip
from .errors import CylfuseError, StateError
from .geometry import Cylinder, Intrinsics, Pose

if TYPE_CHECKING:
    from .fitter import Fitter
    from .questions import EndSamples, Limb, LimbSamples, PointWeights


def _square(values: Any) -> Floats:
    entries = numbers(values)
    return entries.reshape(math.isqrt(entries.size), -1)


class Counts(Record):
    """What was pushed into one view, and what was left out by reason."""

    #: The view.
    view: int
    #: Points and pixels that were pushed.
    points_given: int
    #: Points that a fit uses.
    points_used: int
    #: Left out: a coordinate or weight is not finite.
    dropped_not_finite: int
    #: Left out: the weight is 0.
    dropped_zero_weight: int
    #: Left out: the mask is 0 there.
    dropped_outside_mask: int
    #: Left out: no depth was measured there.
    dropped_no_depth: int
    #: Left out: the depth is below ``min_depth`` or above ``max_depth``.
    dropped_out_of_range: int
    #: Left out: the camera model has no ray for the pixel.
    dropped_outside_camera: int
    #: Left out: the colour camera sees something nearer there. Only with a depth camera of its own.
    dropped_hidden: int
    #: Edge segments that were pushed; ``segments_used`` of a result says how many count.
    segments_given: int


class Extent(Record):
    """The visible piece of the cylinder: ``end = start + length * direction``. Deviations and covariances are those
    of the noise; NaN where they do not apply."""

    _convert = {
        "start_state": EndState,
        "end_state": EndState,
        "start_source": EndSource,
        "end_source": EndSource,
        "limbs_known": bool,
        "start": numbers,
        "end": numbers,
        "center": numbers,
        "start_covariance": _square,
        "end_covariance": _square,
        "center_covariance": _square,
    }

    #: What the end against the direction is.
    start_state: EndState
    #: What the end along the direction is.
    end_state: EndState
    #: What the position of each end was taken from.
    start_source: EndSource
    end_source: EndSource
    #: The view that tells most of each end.
    start_view: int
    end_view: int
    #: Whether the limbs were taken as good to a fraction of a pixel, so that the bias of the mask was read off at them.
    limbs_known: bool
    #: The ends and their middle, points on the axis, shape (3,).
    start: Floats
    end: Floats
    center: Floats
    #: The distance of the ends.
    length: float
    #: Standard deviation of the position of each end along the axis, for a model without error.
    start_deviation: float
    end_deviation: float
    #: Standard deviation of the length together with the uncertainty of the fit.
    length_deviation: float
    #: Shape (3, 3), unit of length squared.
    start_covariance: Floats
    end_covariance: Floats
    center_covariance: Floats


class CylinderDiagnosis(Record):
    """What the data determine: singular values of the stacked Jacobian in units of the size of the data."""

    _convert = {"singular_values": numbers, "weakest_shift": numbers, "weakest_tilt": numbers}

    #: 5 when everything is determined.
    rank: int
    #: Largest first, shape (5,).
    singular_values: Floats
    #: Largest over smallest singular value; may be infinite.
    condition: float
    #: The step along which the residuals change least: shift and tilt of the axis, change of the radius.
    weakest_shift: Floats
    weakest_tilt: Floats
    weakest_radius: float


class Completion(Record):
    """A completed cloud or depth image, and what became of the pixels."""

    def __init__(self, struct: Any, array: Array) -> None:
        super().__init__(struct)
        #: Points of the reference frame of shape (N, 3) or (rows, columns, 3), or depth of shape (rows, columns).
        self.array = array

    #: The view whose pixels were completed.
    view: int
    #: Points or pixels that were written.
    count: int
    #: Pixels of the mask whose ray meets the cylinder.
    hits: int
    #: Pixels of the mask whose ray passes the cylinder by.
    misses: int
    #: Pixels of the mask for which the camera model has no ray.
    outside_camera: int
    #: Hits whose depth does not fit the type of the pixels: written as 0 and not in ``count``.
    out_of_range: int


class Progress(Record):
    """The state of a running fit, before each iteration."""

    _convert = {"phase": Phase}

    def __init__(self, struct: Any) -> None:
        # A copy: the memory is the library's, and the cylinder is there until the callback returns.
        super().__init__(type(struct).from_buffer_copy(struct))
        self.cylinder = Cylinder._from_struct(struct.cylinder.contents) if struct.cylinder else None

    #: What the fit is doing.
    phase: Phase
    #: Iterations so far; from 0 again with every start that is tried and every robust round.
    iteration: int
    #: Maximum number of iterations.
    max_iterations: int
    #: The lowest cost so far, unit of length squared; infinite in the phase START.
    cost: float
    #: The damping of the next step; 0 in the phase START.
    damping: float
    #: The best cylinder so far; None in the phase START.
    cylinder: Optional[Cylinder]


class DetectionProgress(Record):
    """How far a detector is: before the search, after it, and after each fit.

    A cloud that is searched from many places begins again with each."""

    _convert = {"phase": DetectionPhase}

    def __init__(self, struct: Any) -> None:
        # A copy: the memory is the library's.
        super().__init__(type(struct).from_buffer_copy(struct))

    #: What the detector is doing.
    phase: DetectionPhase
    #: Cylinders that are fitted.
    fits_done: int
    #: Cylinders to fit; 0 before the search.
    fits: int


class View(NamedTuple):
    """The camera of a view and where it is."""

    #: The colour camera; None when only clouds were pushed.
    intrinsics: Optional[Intrinsics]
    #: From the camera to the reference frame.
    pose: Pose


class Result(Record):
    """The outcome of a fit with the numbers to judge it. NaN stands for what does not apply. Lengths are in the unit
    of the data, angles in radians.

    ``residuals()``, ``complete()`` and so on ask the fitter that made the result: they raise :class:`StateError` once
    that fitter was given something else. ``extent`` stays.
    """

    _convert = {
        "termination": Termination,
        "start_kind": Start,
        "flags": ResultFlags,
        "model": Cylinder._from_struct,
        "start_model": Cylinder._from_struct,
        "covariance": _square,
    }

    #: Warnings.
    flags: ResultFlags
    #: Why the iteration ended.
    termination: Termination
    #: Iterations: linear systems that were solved.
    iterations: int
    #: Solves whose step was rejected.
    rejected_steps: int
    #: Limb lines that were located in the images and took part, at most 2 a view.
    limbs_located: int
    #: Segments that took part, of those that were pushed.
    segments_given: int
    segments_used: int
    #: Points that took part, of those that were pushed.
    points_given: int
    points_used: int
    #: How many points with independent noise the points are worth: the noise of neighbours in a depth image is alike.
    independent_points: float
    #: Standard deviation of the points from the surface by their median, unit of length.
    point_deviation: float
    #: Root of ``energy_points``, unit of length.
    point_rms: float
    #: Root mean square distance of the ends of the edges from the limb lines in ideal pixels.
    edge_rms_pixels: float
    #: The part of the points on the wall that the camera sees.
    near_wall_fraction: float
    #: Cost of the start and of the cylinder, unit of length squared.
    initial_cost: float
    cost: float
    #: Mean squared distance of the points from the surface, unit of length squared.
    energy_points: float
    #: Mean squared distance of the back-projected ends of the edges from the limb lines, unit of length squared; NaN
    #: without exactly two usable segments.
    energy_edges: float
    #: The edge weight that was used; NaN where the objective has none.
    edge_weight: float
    #: Condition number of the Jacobian at the cylinder, in units of the size of the data; may be infinite.
    condition: float
    #: Norm of half the gradient of the cost at the end and of the last step, in units of the size of the data.
    gradient_norm: float
    step_norm: float
    #: The last damping.
    damping: float
    #: Wall-clock seconds to find the start, to iterate, and of the whole fit.
    seconds_start: float
    seconds_solve: float
    seconds_total: float
    #: How the start was found.
    start_kind: Start
    #: The cylinder; ``cylinder`` is the same.
    model: Cylinder
    #: The model that the iteration started from, moved into the limits.
    start_model: Cylinder
    #: Standard deviations of the radius (unit of length), of the direction (radians) and of the position of the axis
    #: across itself (unit of length): those of the noise of the data. With the method FUSED and the objective ROBUST they
    #: also have the errors that all points of a view share and ``depth_shared`` of the options states, by default 0.2 % of
    #: the depth. Errors of the calibration, the registration and a scale of the depth are not in them.
    radius_deviation: float
    direction_deviation: float
    position_deviation: float
    #: The radius by the curvature of the points alone, and by the limbs, each with its standard deviation.
    radius_from_points: float
    radius_from_points_deviation: float
    radius_from_limbs: float
    radius_from_limbs_deviation: float
    #: Their difference in standard deviations; beyond 4 the flag POINTS_AND_LIMBS_DISAGREE is set.
    radius_z_score: float
    #: Covariance of (point, direction, radius), shape (7, 7), rank 5.
    covariance: Floats

    def __init__(self, structs: tuple[Any, Any], fitter: Optional[Fitter], revision: int) -> None:
        super().__init__(*structs)
        self._fitter, self._revision = fitter, revision
        #: The cameras of the views that were fitted.
        self.views: tuple[View, ...] = ()
        self._extent: Optional[Extent | CylfuseError] = None
        self._diagnostics: Optional[CylinderDiagnosis] = None

    def radius_conforms(self, lower: float = -inf, upper: float = inf, coverage: float = 2.0) -> Conformity:
        """Whether the radius conforms to a tolerance, by its deviation and the warnings: see :func:`decide_conformity`."""
        return decide_conformity(
            self.cylinder.radius, self.radius_deviation, lower=lower, upper=upper, coverage=coverage, flags=self.flags
        )

    def diameter_conforms(self, lower: float = -inf, upper: float = inf, coverage: float = 2.0) -> Conformity:
        """The same for the diameter, with limits of the diameter."""
        value, deviation = 2.0 * self.cylinder.radius, 2.0 * self.radius_deviation
        return decide_conformity(value, deviation, lower=lower, upper=upper, coverage=coverage, flags=self.flags)

    def __getstate__(self) -> dict[str, Any]:
        """Copies and what is pickled are the numbers, the extent, and the diagnostics where they were asked for."""
        return {**self.__dict__, "_fitter": None}

    def _find_extent(self) -> None:
        """Finds the extent, or why there is none, while the fitter has the data."""
        try:
            self._extent = self._source().extent()
        except CylfuseError as error:
            # The traceback would keep the fitter.
            self._extent = error.with_traceback(None)

    def _let_go(self) -> Result:
        """Lets go of the fitter, and with it of the data."""
        self._fitter = None
        return self

    def _source(self) -> Fitter:
        if self._fitter is None:
            raise StateError(
                "this result has no fitter, being that of a given model, of a detector or of fit_many, or a copy; ask a "
                "fitter itself, which is detector.fitter(index) for a detection"
            )
        if self._fitter._revision != self._revision:
            raise StateError("the fitter of this result was given something else since; ask before that")
        return self._fitter

    @property
    def cylinder(self) -> Cylinder:
        """The cylinder, its point the one of the axis nearest to the middle of the points."""
        return self.model

    @property
    def extent(self) -> Extent:
        """The visible piece, found together with the fit."""
        if self._extent is None:
            self._extent = self._source().extent()
        if isinstance(self._extent, CylfuseError):
            raise self._extent
        return self._extent

    @property
    def diagnostics(self) -> CylinderDiagnosis:
        """What the data determine at the cylinder."""
        if self._diagnostics is None:
            self._diagnostics = self._source().diagnose()
        return self._diagnostics

    def residuals(self, kind: ResidualKind | str = ResidualKind.POINTS) -> Floats:
        """Signed distances of the used points, or of the ends of the used edges in pixels."""
        return self._source().residuals(kind)

    def point_weights(self) -> PointWeights:
        """How much each used point of the selected view counts."""
        return self._source().point_weights()

    def point_parts(self) -> npt.NDArray[np.uint8]:
        """What each used point of the selected view belongs to, by numbers of :class:`Part`."""
        return self._source().point_parts()

    def limbs(self) -> list[Limb]:
        """The two limbs in each view: where they were located, or why they were not."""
        return self._source().limbs()

    def limb_samples(self) -> LimbSamples:
        """What was seen of the limbs in the image of the selected view."""
        return self._source().limb_samples()

    def end_samples(self) -> EndSamples:
        """The samples on the arcs of both ends in the images."""
        return self._source().end_samples()

    def complete(
        self,
        layout: Layout | str = Layout.PACKED,
        dtype: npt.DTypeLike = np.float64,
        mask: Optional[Array] = None,
    ) -> Array:
        """The completed points: shape (N, 3), or (rows, columns, 3) when organised."""
        return self._source().complete(layout, dtype, mask=mask).array

    def complete_depth(
        self, dtype: npt.DTypeLike = np.float32, scale: float = 1.0, mask: Optional[Array] = None
    ) -> Array:
        """The completed depth image: shape (rows, columns)."""
        return self._source().complete_depth(dtype, scale, mask=mask).array

    def plot(self, image: Optional[Array] = None, ax: Any = None, view: int = 0) -> Any:
        """Draws limbs, ends and axis over the image of a view with matplotlib; returns the axes."""
        from .plot import plot

        return plot(self, image, ax, view)

    def to_trimesh(self) -> Any:
        """The visible piece as a closed mesh of trimesh."""
        from .convert import to_trimesh

        return to_trimesh(self)

    def to_open3d(self) -> Any:
        """The visible piece as a triangle mesh of Open3D."""
        from .convert import to_open3d

        return to_open3d(self)

    def row(self) -> dict[str, Any]:
        """Cylinder, uncertainty, extent (where there is one) and warnings as plain numbers, for a table."""
        row: dict[str, Any] = {}
        for name, values in (("point", self.model.point), ("direction", self.model.direction)):
            row.update({f"{name}_{axis}": float(x) for axis, x in zip("xyz", values)})
        for name in ("radius_deviation", "direction_deviation", "position_deviation", "point_rms"):
            row[name] = getattr(self, name)
        row.update(radius=self.model.radius, points_used=self.points_used, segments_used=self.segments_used)
        row["flags"] = " ".join(self.flags.names)
        try:
            extent = self.extent
        except CylfuseError:
            row["length"] = row["length_deviation"] = math.nan
        else:
            row.update(length=extent.length, length_deviation=extent.length_deviation)
        return row

    @staticmethod
    def _text(vector: Any) -> str:
        return ", ".join(f"{x:.6g}" for x in vector)

    def _summary(self) -> list[tuple[str, str]]:
        model, rows = self.model, []
        rows.append(("radius", f"{model.radius:.6g} ± {self.radius_deviation:.2g}"))
        rows.append(("point", f"{self._text(model.point)} ± {self.position_deviation:.2g}"))
        rows.append(("direction", f"{self._text(model.direction)} ± {self.direction_deviation:.2g} rad"))
        edges = f", {self.segments_used} of {self.segments_given} edges" if self.segments_given else ""
        rows.append(("data", f"{self.points_used} of {self.points_given} points{edges}"))
        rows.append(("root mean square", f"{self.point_rms:.3g}"))
        rows.append(("end", f"{self.termination} after {self.iterations} solves"))
        rows.append(("warnings", ", ".join(self.flags.names) or "none"))
        return rows

    def __repr__(self) -> str:
        return "Result(\n" + "".join(f"  {name}: {text}\n" for name, text in self._summary()) + ")"

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr><th>{name}</th><td>{html.escape(text)}</td></tr>" for name, text in self._summary())
        return f"<table>{rows}</table>"


@dataclass(frozen=True)
class Detection:
    """A cylinder of a scene. It stays as it is whatever its detector searches next."""

    #: The probability that there is a cylinder.
    score: float
    #: Pixels of its region; points for a cloud.
    pixels: int
    #: The outcome of its fit. Residuals, completion and so on are asked of :meth:`Detector.fitter`.
    result: Result

    @property
    def cylinder(self) -> Cylinder:
        """The cylinder."""
        return self.result.cylinder

    @property
    def extent(self) -> Optional[Extent]:
        """The visible piece; that of a cylinder of a cloud ends with its points. None where there is none; ``result.extent``
        raises what says why."""
        try:
            return self.result.extent
        except CylfuseError:
            return None
