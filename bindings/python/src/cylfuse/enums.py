"""The choices of cylfuse.h. Wherever one is asked for, its name in any case will do too: ``"paper"``."""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import TYPE_CHECKING, Any, Optional, TypeVar

_C = TypeVar("_C", bound="_Choice")

__all__ = [
    "Chart",
    "Distortion",
    "EdgeUse",
    "EndState",
    "ExtentRule",
    "Layout",
    "LogLevel",
    "Method",
    "NearWall",
    "Objective",
    "Phase",
    "ResidualKind",
    "ResultFlags",
    "Start",
    "Termination",
]


class _Choice(IntEnum):
    if TYPE_CHECKING:

        def __new__(cls: type[_C], value: int | str) -> _C: ...

    @classmethod
    def _missing_(cls, value: Any) -> Optional[_Choice]:
        if isinstance(value, str):
            for choice in cls:
                if choice.name == value.upper().replace("-", "_"):
                    return choice
        names = ", ".join(choice.name.lower() for choice in cls)
        raise ValueError(f"{cls.__name__} is {value!r}; it must be one of {names}")

    def __str__(self) -> str:
        return self.name.lower()

    def __format__(self, spec: str) -> str:
        return format(str(self), spec)


class Method(_Choice):
    """How the cylinder is estimated."""

    FUSED = 0
    POINTS = 1
    RANSAC = 2
    EBERLY = 3


class Objective(_Choice):
    """What the method FUSED minimises."""

    ROBUST = 0
    PAPER = 1


class Start(_Choice):
    """Where the iteration starts."""

    AUTO = 0
    LIMBS = 1
    MOMENTS = 2
    RANSAC = 3
    MODEL = 4


class NearWall(_Choice):
    """Whether the points must lie on the wall that a camera at the origin sees."""

    AUTO = 0
    ON = 1
    OFF = 2


class Chart(_Choice):
    """The coordinates in which the iteration steps."""

    AUTO = 0
    LOCAL = 1
    ORTHONORMAL = 2


class EdgeUse(_Choice):
    """What given edges are for the objective ROBUST: a start for limbs in the image, or the measurement."""

    REFINE = 0
    AS_GIVEN = 1


class ExtentRule(_Choice):
    """How the ends of the visible cylinder are found."""

    AUTO = 0
    EXTREMES = 1
    LOCATED = 2


class Distortion(_Choice):
    """What the coefficients of a lens mean, in the order of OpenCV."""

    NONE = 0
    BROWN_CONRADY = 1
    KANNALA_BRANDT = 2


class Layout(_Choice):
    """Completed points: only those that exist, or one a pixel with NaN where there is none."""

    PACKED = 0
    ORGANISED = 1


class ResidualKind(_Choice):
    """Which residuals to list."""

    POINTS = 1
    EDGES = 2


class Termination(_Choice):
    """Why an iteration ended."""

    NONE = 0
    COST = 1
    STALLED = 2
    MAX_ITERATIONS = 3
    RADIUS_RAN_AWAY = 4


class EndState(_Choice):
    """What an end of the visible cylinder is."""

    UNKNOWN = 0
    SEEN = 1
    CUT = 2
    HIDDEN = 3


class Phase(_Choice):
    """What a fit is doing."""

    START = 1
    SOLVE = 2


class LogLevel(_Choice):
    """How much a log line matters."""

    OFF = 0
    ERROR = 1
    WARNING = 2
    INFO = 3
    DEBUG = 4


class ResultFlags(IntFlag):
    """Doubts about a result; cylfuse.h explains each."""

    NONE = 0
    EDGES_IGNORED = 1
    SEGMENTS_UNUSABLE = 2
    EDGES_CROSS = 4
    EDGES_COINCIDE = 8
    EDGES_BEHIND = 16
    SCALE_HELD = 32
    WEAK_RADIUS = 64
    RESOLUTION_LOST = 128
    NOT_CONVERGED = 256
    HIDDEN_WALL = 512
    CAMERA_INSIDE = 1024
    POINTS_NOT_FINITE = 2048
    POINTS_AND_LIMBS_DISAGREE = 4096
    RADIUS_AT_LIMIT = 8192
    AXIS_AT_LIMIT = 16384

    @property
    def names(self) -> list[str]:
        """The names of the flags that are set."""
        return [str(flag.name) for flag in ResultFlags if flag and flag in self]
