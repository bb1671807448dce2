"""Many fitters at once."""

from __future__ import annotations

from ctypes import byref, c_int32, c_void_p
from typing import Any, Callable, Iterable, Optional, Union

from . import _structs
from ._callbacks import Callbacks
from ._check import instance, whole
from ._native import lib, make
from .errors import CancelledError, CylfuseError, fail, from_status
from .fitter import Fitter
from .result import Result


def fit_all(
    fitters: Iterable[Fitter], *, threads: int = 0, on_progress: Optional[Callable[[int, int], Any]] = None
) -> list[Union[Result, CylfuseError]]:
    """Fits many fitters, several at once, each as :meth:`Fitter.fit` does, and gives their outcomes in order: a result, or
    the :class:`CylfuseError` that the fit failed with, as BusyError of a fitter that is in another call. For frames there
    is :func:`fit_many`, which makes its own fitters.

    The callbacks of the fitters are not called.

    :param threads: how many fits run at the same time; 0 = as many as the machine has processors. The results have the
        same bits for any number.
    :param on_progress: is called after each fit, on this thread, with the index of its fitter and 0 or the ``status`` of
        the error. When it returns False the rest is stopped: the outcome of each fit that had not ended is a
        CancelledError. What it raises comes out.
    :raises InvalidArgumentError: a fitter is there twice
    """
    every = [instance(f"fitters[{index}]", fitter, Fitter) for index, fitter in enumerate(fitters)]
    count = whole("threads", threads, 0, 2**32)
    # Held during the call.
    handles = [fitter._open() for fitter in every]
    pointers = (c_void_p * len(every))(*(handle.pointer for handle in handles))
    # Until the library writes another one: a call that it refuses makes no fit.
    statuses = (c_int32 * len(every))(*[CancelledError.status] * len(every))
    callbacks = Callbacks()
    function = callbacks.fit_ended(on_progress)
    if function:
        callbacks.keep(function)
    # Before the call: what the callback reads of a fitter that has ended is that of the new fit.
    for fitter in every:
        fitter._revision += 1
    try:
        status = callbacks.around(lib.cylfuse_fit_all, pointers, len(every), count, function, None, statuses)
    finally:
        # A fitter whose fit failed still has the one before.
        for fitter, of_fit in zip(every, statuses):
            fitter._revision -= of_fit != 0
    if status not in (0, CancelledError.status):
        fail(status)
    return [_outcome(fitter, of_fit) for fitter, of_fit in zip(every, statuses)]


def _outcome(fitter: Fitter, status: int) -> Union[Result, CylfuseError]:
    if status:
        text = lib.cylfuse_fitter_last_error(fitter._open().pointer)
        return from_status(status, text.decode("ascii", "replace"))
    structs = make(_structs.Result), make(_structs.CylinderEstimate)
    fitter._call(lib.cylfuse_fitter_get_result, byref(structs[0]))
    fitter._call(lib.cylfuse_fitter_get_cylinder, byref(structs[1]))
    return fitter._found(structs)
