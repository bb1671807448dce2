"""Whether a measured length conforms to its tolerance."""

from __future__ import annotations

from ctypes import byref, c_int32
from math import inf

from ._check import real
from ._native import lib
from .enums import Conformity, ResultFlags
from .errors import fail


def decide_conformity(
    value: float,
    deviation: float,
    *,
    lower: float = -inf,
    upper: float = inf,
    coverage: float = 2.0,
    flags: ResultFlags = ResultFlags.NONE,
) -> Conformity:
    """Decides by the rule of ISO 14253-1 whether a length, such as a radius, conforms to a tolerance: only where ``value``
    with ``coverage`` standard deviations on either side lies within the limits, and not only where it lies outside.

    A deviation that is NaN or 0 (of a radius that the limits of the fit fix) decides nothing, nor do ``flags`` with a warning
    of which a deviation says nothing, such as POOR_FIT or RADIUS_AT_LIMIT. A wrong scale of the depth and wrong intrinsics
    are in no deviation. :meth:`Result.radius_conforms` and :meth:`Result.diameter_conforms` ask for the numbers of a fit."""
    names = {"value": value, "deviation": deviation, "lower": lower, "upper": upper, "coverage": coverage}
    value, deviation, lower, upper, coverage = (real(name, given) for name, given in names.items())
    if coverage == 0.0:
        raise ValueError("coverage is 0; it must be finite and greater than 0")
    conformity = c_int32()
    status = lib.cylfuse_decide_conformity(
        value, deviation, ResultFlags(flags), lower, upper, coverage, byref(conformity)
    )
    if status:
        fail(status)
    return Conformity(conformity.value)
