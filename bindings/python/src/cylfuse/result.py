"""What the library says, as objects whose attributes have the names of cylfuse.h."""

from __future__ import annotations

import html
import math
from typing import TYPE_CHECKING, Any, Callable, ClassVar, Iterator, Optional

import numpy as np
import numpy.typing as npt

from ._arrays import Array, Floats, numbers
from .enums import EndState, Layout, Phase, ResidualKind, ResultFlags, Start, Termination
from .errors import CylfuseError, StateError
from .geometry import Cylinder

if TYPE_CHECKING:
    from .fitter import Fitter


def _square(values: Any) -> Floats:
    entries = numbers(values)
    return entries.reshape(math.isqrt(entries.size), -1)


class _Record:
    """The fields of a struct, converted when they are asked for first."""

    #: How fields that are not plain numbers become objects of Python.
    _convert: ClassVar[dict[str, Callable[[Any], Any]]] = {}
    #: Python's name for a field whose own is a word of the language.
    _renamed: ClassVar[dict[str, str]] = {"damping": "lambda"}

    def __init__(self, struct: Any) -> None:
        self._struct = struct

    # Not for checkers of types: they know the fields, and see a misspelt one.
    if not TYPE_CHECKING:

        def __getattr__(self, name):
            field = self._renamed.get(name, name)
            if name.startswith("_") or field in ("struct_size", "reserved") or not hasattr(self._struct, field):
                raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")
            value = getattr(self._struct, field)
            if field in self._convert:
                value = self._convert[field](value)
            self.__dict__[name] = value
            return value

    def _names(self) -> Iterator[str]:
        back = {field: name for name, field in self._renamed.items()}
        for field in (str(entry[0]) for entry in self._struct._fields_):
            if field not in ("struct_size", "reserved"):
                yield back.get(field, field)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._names()})

    def to_dict(self) -> dict[str, Any]:
        """All fields by their names."""
        return {name: getattr(self, name) for name in self._names()}

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self.to_dict().items())})"


class Counts(_Record):
    """What was pushed, and what was left out by reason."""

    points_given: int
    points_used: int
    dropped_not_finite: int
    dropped_zero_weight: int
    dropped_outside_mask: int
    dropped_no_depth: int
    dropped_out_of_range: int
    dropped_outside_camera: int
    segments_given: int


class Extent(_Record):
    """The visible piece of the cylinder: ``end = start + length * direction``. Deviations and covariances are those
    of the noise; NaN where they do not apply."""

    _convert = {
        "start_state": EndState,
        "end_state": EndState,
        "start": numbers,
        "end": numbers,
        "center": numbers,
        "start_covariance": _square,
        "end_covariance": _square,
        "center_covariance": _square,
    }

    #: What the ends are.
    start_state: EndState
    end_state: EndState
    #: The ends and their middle, points on the axis, shape (3,).
    start: Floats
    end: Floats
    center: Floats
    #: The distance of the ends.
    length: float
    start_deviation: float
    end_deviation: float
    length_deviation: float
    #: Shape (3, 3), unit of length squared.
    start_covariance: Floats
    end_covariance: Floats
    center_covariance: Floats


class Diagnosis(_Record):
    """What the data determine: singular values of the stacked Jacobian in units of the size of the data."""

    _convert = {"singular_values": numbers, "weakest_shift": numbers, "weakest_tilt": numbers}

    #: 5 when everything is determined.
    rank: int
    #: Largest first, shape (5,).
    singular_values: Floats
    condition: float
    #: The step along which the residuals change least: shift and tilt of the axis, change of the radius.
    weakest_shift: Floats
    weakest_tilt: Floats
    weakest_radius: float


class Completion(_Record):
    """A completed cloud or depth image, and what became of the pixels."""

    def __init__(self, struct: Any, array: Array) -> None:
        super().__init__(struct)
        #: Points of shape (N, 3) or (rows, columns, 3), or depth of shape (rows, columns).
        self.array = array

    count: int
    hits: int
    misses: int
    outside_camera: int
    out_of_range: int


class Progress(_Record):
    """The state of a running fit, before each linear solve."""

    _convert = {"phase": Phase, "model": Cylinder._from_struct}

    phase: Phase
    iteration: int
    max_iterations: int
    cost: float
    damping: float
    model: Cylinder


class Result(_Record):
    """The outcome of a fit with the numbers to judge it. NaN stands for what does not apply. Lengths are in the unit
    of the data, angles in radians.

    ``extent``, ``residuals()`` and so on ask the fitter that made the result: they raise :class:`StateError` once
    that fitter was given something else.
    """

    _convert = {
        "termination": Termination,
        "start_kind": Start,
        "flags": ResultFlags,
        "model": Cylinder._from_struct,
        "start_model": Cylinder._from_struct,
        "covariance": _square,
    }

    #: Why the iteration ended.
    termination: Termination
    start_kind: Start
    #: Doubts; 0 when there are none.
    flags: ResultFlags
    iterations: int
    rejected_steps: int
    segments_used: int
    segments_given: int
    points_used: int
    points_given: int
    #: The cylinder; ``cylinder`` is the same.
    model: Cylinder
    start_model: Cylinder
    initial_cost: float
    cost: float
    energy_points: float
    energy_edges: float
    edge_weight: float
    point_rms: float
    edge_rms_pixels: float
    near_wall_fraction: float
    condition: float
    damping: float
    gradient_norm: float
    step_norm: float
    seconds_start: float
    seconds_solve: float
    seconds_total: float
    radius_deviation: float
    direction_deviation: float
    position_deviation: float
    radius_from_points: float
    radius_from_points_deviation: float
    radius_from_limbs: float
    radius_from_limbs_deviation: float
    radius_z_score: float
    #: Covariance of (point, direction, radius), shape (7, 7), rank 5.
    covariance: Floats
    limbs_located: int

    def __init__(self, struct: Any, fitter: Optional[Fitter], revision: int) -> None:
        super().__init__(struct)
        self._fitter, self._revision = fitter, revision
        self._extent: Optional[Extent] = None
        self._diagnostics: Optional[Diagnosis] = None

    def __getstate__(self) -> dict[str, Any]:
        """Copies and what is pickled are the numbers, and the extent and the diagnostics where they were asked for."""
        return {**self.__dict__, "_fitter": None}

    def _source(self) -> Fitter:
        if self._fitter is None:
            raise StateError("this result has no fitter, being that of a given model or a copy; ask a fitter itself")
        if self._fitter._revision != self._revision:
            raise StateError("the fitter of this result was given something else since; ask before that")
        return self._fitter

    @property
    def cylinder(self) -> Cylinder:
        """The cylinder, its point the one of the axis nearest to the middle of the points."""
        return self.model

    @property
    def extent(self) -> Extent:
        """The visible piece; needs intrinsics and a mask."""
        if self._extent is None:
            self._extent = self._source().extent()
        return self._extent

    @property
    def diagnostics(self) -> Diagnosis:
        """What the data determine at the cylinder."""
        if self._diagnostics is None:
            self._diagnostics = self._source().diagnose()
        return self._diagnostics

    def residuals(self, kind: ResidualKind | str = ResidualKind.POINTS) -> Floats:
        """Signed distances of the used points, or of the ends of the used edges in pixels."""
        return self._source().residuals(kind)

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

    def plot(self, image: Optional[Array] = None, ax: Any = None) -> Any:
        """Draws limbs, ends and axis over an image with matplotlib; returns the axes."""
        from .plot import plot

        return plot(self, image, ax)

    def to_trimesh(self) -> Any:
        """The visible piece as a closed mesh of trimesh."""
        from .convert import to_trimesh

        return to_trimesh(self)

    def to_open3d(self) -> Any:
        """The visible piece as a triangle mesh of Open3D."""
        from .convert import to_open3d

        return to_open3d(self)

    def row(self) -> dict[str, Any]:
        """Cylinder, uncertainty, extent (where there is one) and doubts as plain numbers, for a table."""
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
        rows.append(("doubts", ", ".join(self.flags.names) or "none"))
        return rows

    def __repr__(self) -> str:
        return "Result(\n" + "".join(f"  {name}: {text}\n" for name, text in self._summary()) + ")"

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr><th>{name}</th><td>{html.escape(text)}</td></tr>" for name, text in self._summary())
        return f"<table>{rows}</table>"
