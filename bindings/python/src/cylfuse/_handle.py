"""What a fitter, a frame and a detector have in common: an object of the library that calls are made on."""

from __future__ import annotations

import difflib
import weakref
from ctypes import byref, c_void_p
from typing import TYPE_CHECKING, Any, Optional, TypeVar

from ._native import ABI_VERSION
from .errors import StateError, fail

_Self = TypeVar("_Self", bound="Closable")


class Handle:
    """An object of the library. A call keeps it alive, so that it is destroyed when the last call has ended."""

    def __init__(self, create: Any, destroy: Any) -> None:
        pointer = c_void_p()
        status = create(ABI_VERSION, byref(pointer))
        if status:
            fail(status)
        self.pointer = pointer
        self.finalizer = weakref.finalize(self, destroy, pointer)
        # The process ends with its memory; a thread may still be in a call.
        self.finalizer.atexit = False


class Closable:
    """Owns a handle until it is closed or forgotten."""

    _what = ""

    def __init__(self, create: Any, destroy: Any) -> None:
        self._handle: Optional[Handle] = Handle(create, destroy)

    # Type checkers would take it as leave to assign anything.
    if not TYPE_CHECKING:

        def __setattr__(self, name: str, value: Any) -> None:
            """Refuses what would be kept and have no effect: a misspelt name, a callback in place of the method that sets
            it. A class derived elsewhere may have attributes of its own."""
            kind = type(self)
            known = getattr(kind, name, None)
            if callable(known) and not name.startswith("_"):
                raise AttributeError(f"{name} is a method of a {kind.__name__}; call it: {self._what}.{name}(...)")
            if known is None and not name.startswith("_") and kind.__module__.split(".")[0] == "cylfuse":
                public = [other for other in dir(kind) if not other.startswith("_")]
                near = difflib.get_close_matches(name, public, 1)
                hint = f"; did you mean {near[0]!r}?" if near else ""
                raise AttributeError(f"a {kind.__name__} has no attribute {name!r}{hint}")
            super().__setattr__(name, value)

    def __enter__(self: _Self) -> _Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> Any:
        raise TypeError(f"a {type(self).__name__} cannot be copied or pickled: make one where it is used")

    def close(self) -> None:
        """Frees everything, once the calls that are running have ended. A second time it does nothing; any other call
        afterwards raises StateError."""
        self._handle = None

    @property
    def closed(self) -> bool:
        """Whether it was closed."""
        return self._handle is None

    def _open(self) -> Handle:
        """The handle, to be held during a call."""
        handle = self._handle
        if handle is None:
            raise StateError(f"the {self._what} is closed; make a new one")
        return handle
