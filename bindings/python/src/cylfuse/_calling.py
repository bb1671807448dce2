"""What calls back: a fitter and a detector."""

from __future__ import annotations

import atexit
import time
import weakref
from typing import Any

from ._callbacks import Callbacks
from ._handle import Closable
from .errors import from_status


class Calling(Closable):
    """Owns a handle on which callbacks are set, and whose running calls can be cancelled."""

    #: The C function that cancels.
    _cancel_function: Any

    def __init__(self, create: Any, destroy: Any) -> None:
        super().__init__(create, destroy)
        self._callbacks = Callbacks()

    def _call(self, function: Any, *arguments: Any) -> None:
        raise NotImplementedError

    def _set_callback(self, callback: Any, function: Any, *arguments: Any) -> None:
        _WITH_CALLBACKS.add(self)
        self._callbacks.keep(callback)
        self._call(function, *arguments, callback, None)
        self._callbacks.forget_others(callback)

    def cancel(self) -> None:
        """Asks the call that is running to stop with CancelledError; when none is running it does nothing. May be called
        from any thread and from callbacks."""
        handle = self._open()
        status = self._cancel_function(handle.pointer)
        if status:
            raise from_status(status, "the call could not be cancelled")


#: Those that call back.
_WITH_CALLBACKS: weakref.WeakSet[Calling] = weakref.WeakSet()


@atexit.register
def _end_calls() -> None:
    """Once the process ends, Python takes a daemon thread that enters it from a callback out of the midst of the
    library, which aborts the process: running calls end before that, and no other begins."""
    for owner in list(_WITH_CALLBACKS):
        handle = owner._handle
        if handle is None:
            continue
        # A call holds the handle; a callback that waits for ever must not keep the process.
        reference, deadline = weakref.ref(handle), time.monotonic() + 2.0
        owner.close()
        while handle is not None and time.monotonic() < deadline:
            owner._cancel_function(handle.pointer)
            del handle
            time.sleep(0.001)
            handle = reference()
