"""What a fitter, a frame and a detector have in common: an object of the library that calls are made on."""

from __future__ import annotations

import weakref
from ctypes import byref, c_void_p
from typing import Any, Optional, TypeVar

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
