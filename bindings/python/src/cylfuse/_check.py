"""Arguments that are no arrays: checked before the call, so that an error names them."""

from __future__ import annotations

import operator
from typing import Any, Type, TypeVar

_T = TypeVar("_T")


def instance(name: str, given: Any, kind: Type[_T]) -> _T:
    """An object of a class of this package."""
    if not isinstance(given, kind):
        what = f"the class {given.__name__}" if isinstance(given, type) else f"of the type {type(given).__name__}"
        raise TypeError(f"{name} is {what}; it must be of the type cylfuse.{kind.__name__}")
    return given


def real(name: str, given: Any) -> float:
    """A number; what else is wrong with it the library says."""
    try:
        if not isinstance(given, (str, bytes)):
            return float(given)
    except TypeError:
        pass
    raise TypeError(f"{name} is {given!r}; it must be a number")


def whole(name: str, given: Any, least: int, limit: int) -> int:
    """A whole number, at least the one and below the other limit."""
    try:
        number = operator.index(given)
    except TypeError:
        raise TypeError(f"{name} is {given!r}; it must be a whole number") from None
    if not least <= number < limit:
        raise ValueError(f"{name} is {number}; it must lie in [{least}, 2^{limit.bit_length() - 1})")
    return number
