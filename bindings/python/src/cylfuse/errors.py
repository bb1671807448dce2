"""One exception for each kind of failure, all derived from :class:`CylfuseError`."""

from __future__ import annotations

from typing import NoReturn

from ._native import lib, status_text

__all__ = [
    "BusyError",
    "CancelledError",
    "CollinearPointsError",
    "CylfuseError",
    "DataError",
    "DefectError",
    "EdgeGeometryError",
    "EmptyMaskError",
    "InvalidArgumentError",
    "InvalidIntrinsicsError",
    "NoDepthError",
    "NoStartError",
    "NumericalError",
    "OutOfMemoryError",
    "PlanarPointsError",
    "SizeMismatchError",
    "StateError",
    "TooFewPointsError",
    "UnsupportedError",
]


class CylfuseError(Exception):
    """A call that failed. ``status`` is the number of cylfuse.h, ``name`` its name; the text names the value, the
    limit and the remedy."""

    status = -99

    @property
    def name(self) -> str:
        """The name of the status, such as "PLANAR_POINTS"."""
        return status_text(self.status).split(":")[0]

    @property
    def message(self) -> str:
        """The text."""
        return str(self.args[0]) if self.args else ""


class InvalidArgumentError(CylfuseError, ValueError):
    """An argument has a value outside its documented range."""

    status = -1


class StateError(CylfuseError):
    """The call came before something that it needs."""

    status = -5


class BusyError(CylfuseError):
    """Another call on the same fitter, frame or detector is running, and one of the two may change it; take one of them
    for each thread."""

    status = -6


class OutOfMemoryError(CylfuseError, MemoryError):
    """Memory could not be allocated: pass less data at once, or free memory."""

    status = -8


class UnsupportedError(CylfuseError):
    """Not supported with these options or data."""

    status = -9


class SizeMismatchError(CylfuseError, ValueError):
    """Images on one pixel grid have different sizes."""

    status = -10


class InvalidIntrinsicsError(CylfuseError, ValueError):
    """No camera works with these intrinsics."""

    status = -11


class DataError(CylfuseError):
    """The data do not determine a cylinder; the subclasses say why."""


class TooFewPointsError(DataError):
    """Too few usable points. A fit needs 5, as many as a cylinder has degrees of freedom; a plan needs 8 points with
    independent noise."""

    status = -20


class PlanarPointsError(DataError):
    """The points are as flat as a plane."""

    status = -21


class CollinearPointsError(DataError):
    """The points lie on one straight line."""

    status = -22


class EmptyMaskError(DataError):
    """No pixel of the mask is set."""

    status = -23


class NoDepthError(DataError):
    """No pixel in the region has a usable depth."""

    status = -24


class NoStartError(DataError):
    """No start for the iteration could be found."""

    status = -25


class EdgeGeometryError(DataError):
    """The camera sees no limbs of the cylinder, or nothing that was given meets it."""

    status = -26


class NumericalError(DataError, ArithmeticError):
    """The arithmetic left the range of numbers."""

    status = -27


class CancelledError(CylfuseError):
    """The progress callback, :meth:`Fitter.cancel` or :meth:`Detector.cancel` asked to stop."""

    status = -40


class DefectError(CylfuseError):
    """A defect of the library or of this package; please report it."""


_KINDS = {
    kind.status: kind
    for kind in [
        InvalidArgumentError, StateError, BusyError, OutOfMemoryError, UnsupportedError, SizeMismatchError,
        InvalidIntrinsicsError, TooFewPointsError, PlanarPointsError, CollinearPointsError, EmptyMaskError,
        NoDepthError, NoStartError, EdgeGeometryError, NumericalError, CancelledError,
    ]
}  # fmt: skip


def from_status(status: int, message: str) -> CylfuseError:
    """The exception for a status."""
    error = _KINDS.get(status, DefectError)(message)
    error.status = status
    return error


def fail(status: int, fitter: object = None) -> NoReturn:
    """Raises what the last call on a fitter failed with, or without one the last call of this thread."""
    raise from_status(status, lib.cylfuse_fitter_last_error(fitter).decode("ascii", "replace"))


def fail_on_detector(status: int, detector: object) -> NoReturn:
    """Raises what the last call on a detector failed with."""
    raise from_status(status, lib.cylfuse_detector_last_error(detector).decode("ascii", "replace"))


def fail_on_frame(status: int, frame: object) -> NoReturn:
    """Raises what the last call on a frame failed with."""
    raise from_status(status, lib.cylfuse_frame_last_error(frame).decode("ascii", "replace"))
