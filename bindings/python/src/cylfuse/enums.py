"""The choices of cylfuse.h. Wherever one is asked for, its name in any case will do too: ``"paper"``."""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import TYPE_CHECKING, Any, Optional, TypeVar

from ._native import lib

__all__ = [
    "Chart",
    "Conformity",
    "DetectionPhase",
    "Distortion",
    "EdgeUse",
    "EndSource",
    "EndState",
    "ExtentRule",
    "ImageUse",
    "Input",
    "Layout",
    "LimbStatus",
    "LogLevel",
    "Method",
    "NearWall",
    "Objective",
    "Part",
    "Phase",
    "ResidualKind",
    "ResultFlags",
    "Start",
    "Termination",
]

_C = TypeVar("_C", bound="_Choice")


def _text(text: bytes) -> str:
    return text.decode("ascii", "replace")


def _formatted(constant: int, spec: str) -> str:
    """A constant in a format: its name, or for a type of integers, as in ``:x``, its number. From Python 3.11 on, a width
    alone would give the number."""
    return int.__format__(constant, spec) if spec.endswith(tuple("bdnoxX")) else format(str(constant), spec)


class _Choice(IntEnum):
    if TYPE_CHECKING:
        # A name will do, as _missing_ says.
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
        return _formatted(self, spec)


class Method(_Choice):
    """How the cylinder is estimated."""

    #: Points and edges together, by the chosen :class:`Objective`.
    FUSED = 0
    #: Points alone by plain least squares; edges are ignored.
    POINTS = 1
    #: Random sample consensus over the points, without a final iteration.
    RANSAC = 2
    #: Eberly's algebraic fit by the moments of the points, without a final iteration.
    EBERLY = 3


class Objective(_Choice):
    """What the method FUSED minimises."""

    #: Robust points and distances of the endpoints of edges in pixels, each weighted by its own scale.
    ROBUST = 0
    #: F = (1 - w) E_P + w E_L of Zhang, Liu and Wang, exactly, with w = ``edge_weight``; exactly two edges, or w = 0.
    PAPER = 1


class Start(_Choice):
    """Where the iteration starts."""

    #: The candidate of the kinds below that explains the data best. Never in a result.
    AUTO = 0
    #: From two limb segments, scaled by the points.
    LIMBS = 1
    #: Eberly's algebraic fit by the moments of the points.
    MOMENTS = 2
    #: Random sample consensus over the points.
    RANSAC = 3
    #: The model of :meth:`Fitter.set_start_model`.
    MODEL = 4
    #: The cylinder of the last successful fit of the fitter, for frames of a sequence, also after :meth:`Fitter.clear`.
    #: Where its limbs are about where it or the points have them, and look in the image as they did, they are not
    #: searched, and the result depends on the fits before. Where not, and before the first fit, as ``AUTO``, with that
    #: cylinder or the start model one of the candidates. Of points alone that hold several bodies the one near that
    #: cylinder is fitted.
    LAST = 5

    @property
    def description(self) -> str:
        """Its name, a colon, and what it means in a few words."""
        return _text(lib.cylfuse_start_string(self))


class NearWall(_Choice):
    """Whether the points must lie on the wall that a camera at the origin sees."""

    #: On when intrinsics are set: only then is the origin known to be a camera.
    AUTO = 0
    #: The origin is the observer.
    ON = 1
    #: The minimum nearest to the start stays.
    OFF = 2


class Chart(_Choice):
    """The coordinates in which the iteration steps."""

    #: ORTHONORMAL for the paper's objective where a camera stands outside the cylinder, else LOCAL.
    AUTO = 0
    #: Shift and tilt of the axis at the data: regular wherever the axis runs.
    LOCAL = 1
    #: The orthonormal representation about the origin: singular for an axis through the origin.
    ORTHONORMAL = 2


class EdgeUse(_Choice):
    """What given edges are for the objective ROBUST: a start for limbs in the image, or the measurement."""

    #: A start: where there is an image, the limbs are located in it and join the fit.
    REFINE = 0
    #: The measurement: no limbs are looked for in the image. The arcs of the ends are.
    AS_GIVEN = 1


class ExtentRule(_Choice):
    """How the ends of the visible cylinder are found in a mask. Without one, and from inside a pipe, the points on the
    surface tell them."""

    #: LOCATED for the method FUSED with the objective ROBUST, EXTREMES otherwise.
    AUTO = 0
    #: The rule of the paper: the extreme positions along the axis of the points completed over the mask.
    EXTREMES = 1
    #: From all lines along the surface together, in the mask and, when there is one, in the image.
    LOCATED = 2


class Distortion(_Choice):
    """What the coefficients of a lens mean, in the order of OpenCV."""

    #: A pinhole.
    NONE = 0
    #: k1 k2 p1 p2 k3 k4 k5 k6.
    BROWN_CONRADY = 1
    #: The fisheye model of OpenCV: k1 k2 k3 k4.
    KANNALA_BRANDT = 2


class Layout(_Choice):
    """Completed points: only those that exist, or one a pixel with NaN where there is none."""

    #: Only the points that exist, row by row of the image.
    PACKED = 0
    #: One point for each pixel of the image, NaN where there is none.
    ORGANISED = 1


class ResidualKind(_Choice):
    """Which residuals to list."""

    #: Signed distance of every used point from the surface, negative inside.
    POINTS = 1
    #: Signed distance of both ends of every used edge from its limb line, in ideal pixels.
    EDGES = 2


class Termination(_Choice):
    """Why an iteration ended."""

    #: There was no iteration.
    NONE = 0
    #: The cost no longer fell by more than the tolerance.
    COST = 1
    #: No step down to the largest damping lowered the cost: a minimum to rounding.
    STALLED = 2
    #: The limit of iterations was reached; the flag NOT_CONVERGED is set too.
    MAX_ITERATIONS = 3
    #: The radius left all proportion to the data: they are flat.
    RADIUS_RAN_AWAY = 4
    #: The gradient fell below its tolerance.
    GRADIENT = 5
    #: The step fell below its tolerance.
    STEP = 6

    @property
    def description(self) -> str:
        """Its name, a colon, and what it means in a few words."""
        return _text(lib.cylfuse_termination_string(self))


class EndState(_Choice):
    """What an end of the visible cylinder is."""

    #: Nothing tells what lies beyond the end: no depth was measured there, or no depth image pushed.
    UNKNOWN = 0
    #: The surface ends there: what lies beyond is farther than the surface would be.
    SEEN = 1
    #: The border of the image cuts the cylinder off.
    CUT = 2
    #: Something nearer than the surface covers what lies beyond.
    HIDDEN = 3

    @property
    def description(self) -> str:
        """Its name, a colon, and what it means in a few words."""
        return _text(lib.cylfuse_end_state_string(self))


class EndSource(_Choice):
    """What the position of an end was taken from."""

    #: The extreme point completed over the mask.
    EXTREME = 0
    #: Where the lines along the surface leave the mask, or where within the mask the depth shows that the body ends: at a
    #: cap, an opening, a shoulder or a narrower part. Also where the image shows an arc that is less certain than that.
    MASK = 1
    #: Mostly the arc of the end circle in the image: it is joined with mask and depth by the variances, and is the more
    #: certain.
    IMAGE = 2
    #: The last of the surface inside the border of the image.
    BORDER = 3
    #: The points on the surface, where there is no mask, and from inside a pipe.
    POINTS = 4

    @property
    def description(self) -> str:
        """Its name, a colon, and what it means in a few words."""
        return _text(lib.cylfuse_end_source_string(self))


class LimbStatus(_Choice):
    """Whether a limb was located in the image, or why not."""

    #: It was located.
    LOCATED = 0
    #: The image was not searched: there is none, the edges were taken as given, or the objective does not look.
    NOT_SEARCHED = 1
    #: The cylinder has no limbs in front of the camera.
    NO_LIMBS = 2
    #: Fewer than 12 rows or columns of the image show the limb, or something in front covers it.
    TOO_SHORT = 3
    #: No line near the expected place has more of an edge than noise gives.
    NO_EDGE = 4
    #: The line left the expected place while it was refined, or lies beside the mask.
    OUT_OF_REACH = 5
    #: The line would be less certain than one set by hand, or what is there is softer than any limb.
    UNCERTAIN = 6
    #: A small part of the line carries it all.
    PATCHY = 7
    #: The other limb was found at the same place, and more certainly.
    SAME_LINE = 8

    @property
    def description(self) -> str:
        """Its name, a colon, and what it means in a few words."""
        return _text(lib.cylfuse_limb_status_string(self))


class Conformity(_Choice):
    """What a measurement says about a tolerance."""

    #: It does not tell: its uncertainty reaches over a limit or is not known, or a warning puts it in doubt.
    UNDECIDED = 0
    #: The value is within the limits with all of its uncertainty.
    CONFORMING = 1
    #: The value is outside the limits with all of its uncertainty.
    NOT_CONFORMING = 2

    @property
    def description(self) -> str:
        """Its name, a colon, and what it means in a few words."""
        return _text(lib.cylfuse_conformity_string(self))


class Part(_Choice):
    """What a point in the mask belongs to."""

    #: The lateral surface.
    BODY = 1
    #: A cap: it lies in the plane across the axis at an end.
    CAP = 2
    #: The inside of the cylinder, seen through an open end: its inner wall or its bottom.
    INNER_WALL = 3
    #: Something nearer than the surface: a lid or a rim that is wider, a handle, what stands in front.
    OTHER = 4
    #: Something farther away than the cylinder: the background.
    BEHIND = 5

    @property
    def description(self) -> str:
        """Its name, a colon, and what it means in a few words."""
        return _text(lib.cylfuse_part_string(self))


class Input(_Choice):
    """Data of a view, for :meth:`Fitter.clear_input`."""

    #: All points: those of clouds and those that were made of depth images.
    POINTS = 1
    #: The depth image and its mask; the points that were made of it stay.
    DEPTH = 2
    #: Edge segments.
    EDGES = 4
    #: The image.
    IMAGE = 8


class Phase(_Choice):
    """What a fit is doing."""

    #: It is about to look for a start, or looks for one and asks whether to go on.
    START = 1
    #: It iterates, or asks after an iteration whether to go on: the last state is reported again then.
    SOLVE = 2


class ImageUse(_Choice):
    """Whether a detector looks at the image of a frame."""

    #: Where there is one.
    AUTO = 0
    #: Never: by depth alone.
    IGNORE = 1


class DetectionPhase(_Choice):
    """What a detector is doing."""

    #: It is about to look for cylinders.
    SEARCH = 1
    #: It fits those that were found.
    FIT = 2


class LogLevel(_Choice):
    """How much a log line matters."""

    #: No lines.
    OFF = 0
    #: Calls that failed, with their message.
    ERROR = 1
    #: Warnings about a result, such as ignored edges.
    WARNING = 2
    #: What was pushed, which start was taken, how a fit ended.
    INFO = 3
    #: Every iteration.
    DEBUG = 4


class ResultFlags(IntFlag):
    """Warnings about a result. None of them is an error."""

    #: No warnings.
    NONE = 0
    #: Segments were given but none of them counts; the other flags and the counts say why.
    EDGES_IGNORED = 1
    #: Some segments have no length or lie outside the field of the camera model.
    SEGMENTS_UNUSABLE = 2
    #: Two segments cross each other: they cannot be the two limbs.
    EDGES_CROSS = 4
    #: Two segments lie on one line to within 2 pixels: they are the same limb.
    EDGES_COINCIDE = 8
    #: The rays of the endpoints do not meet the plane of the limbs in front of the camera.
    EDGES_BEHIND = 16
    #: The edges alone (an edge weight of 1) do not tell the scale: that of the start was kept.
    SCALE_HELD = 32
    #: The data hardly determine the radius: see its stated deviation.
    WEAK_RADIUS = 64
    #: The coordinates are coarser than 0.01 % of the radius: a float cloud far from the origin.
    RESOLUTION_LOST = 128
    #: The limit of iterations came before convergence. Of a cylinder of a scene also: its depth came without an image,
    #: no work was left for its fit, or no fit was as good, and it is what the search found.
    NOT_CONVERGED = 256
    #: Most points lie on the wall that the camera cannot see.
    HIDDEN_WALL = 512
    #: The camera is inside the cylinder: there are no limbs.
    CAMERA_INSIDE = 1024
    #: Points with coordinates that are not finite were left out.
    POINTS_NOT_FINITE = 2048
    #: The radius by the points alone and that by the limbs differ by more than 4 standard deviations, or the points
    #: contradict limbs or edges, which were not followed.
    POINTS_AND_LIMBS_DISAGREE = 4096
    #: The radius is at its limit, and the data fit better beyond it. Of a known radius: the data contradict it by more than
    #: 4 standard deviations.
    RADIUS_AT_LIMIT = 8192
    #: The axis is on the border of its cone, and the data fit better beyond it. Of a known direction: the data contradict
    #: it by more than 4 standard deviations.
    AXIS_AT_LIMIT = 16384
    #: The data do not tell how uncertain the result is, and deviations and covariance are NaN: fewer than eight points are
    #: independent, some degree of freedom is not determined, the coordinates are coarser than the noise, or most points lie
    #: on the cylinder to the last digit and more than a tenth do not.
    UNCERTAINTY_UNKNOWN = 32768
    #: Depth and image are shifted against each other across the axis. Or one of the limbs is the edge of something
    #: else, and the radius is wrong. From a detector also: the whole depth image was shifted, and has been moved.
    DEPTH_SHIFTED = 65536
    #: A mask holds the pixels that have depth and no others: its sides are no hint where the limbs are.
    MASK_ENDS_WITH_DEPTH = 131072
    #: The points do not lie on the cylinder: they scatter about its surface by more than 1 % of their distance from the
    #: camera or, without a camera, by more than a quarter of the radius, or have a shape along the axis that no
    #: cylinder has, or lie on two planes, as the sides of a box do.
    POOR_FIT = 262144
    #: The lines of both limbs turn against each other, so that the radius changes along the axis: the body is no
    #: cylinder, or one of the lines is no limb. Or, without them, the sides of the mask do, or points without a camera tell it.
    BODY_TAPERS = 524288
    #: The mask ends beside a limb of the cylinder along most of the axis, by more than masks are off and the deviation
    #: of the radius says; or no limb was seen, and the radii by the mask and by the points differ by more than 2.5 standard
    #: deviations, or the points would scatter 3 times as much if the mask were followed; or the mask holds another body.
    MASK_DISAGREES = 1048576

    @property
    def names(self) -> list[str]:
        """The names of the flags that are set."""
        return [str(flag.name) for flag in ResultFlags if flag and flag in self]

    @property
    def descriptions(self) -> list[str]:
        """For each flag that is set its name, a colon, and what it means in a few words; empty for no warnings."""
        return [_text(lib.cylfuse_flag_string(1 << bit)) for bit in range(32) if self & 1 << bit]

    def __str__(self) -> str:
        names = [name.lower() for name in self.names]
        # The bits that a later library has added.
        later = int(self) & ~sum(ResultFlags.__members__.values())
        return ", ".join([*names, str(later)] if later else names) or "none"

    def __format__(self, spec: str) -> str:
        return _formatted(self, spec)
