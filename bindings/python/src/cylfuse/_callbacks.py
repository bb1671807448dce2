"""Functions of Python that the library calls during a call."""

from __future__ import annotations

import inspect
import sys
import threading
from typing import Any, Callable, Optional, Type, Union

import numpy as np

from . import _structs
from .enums import LogLevel
from .result import DetectionProgress, Progress


class _Raised(threading.local):
    """What callbacks of the calls of this thread raised: several threads may be in calls at once."""

    error: Optional[BaseException] = None


class Callbacks:
    """The callbacks of one fitter or detector. What they raise comes out of the call in which they ran.

    It does not know its owner, which would make a cycle that only the garbage collector ends.
    """

    def __init__(self) -> None:
        # What the library may call must live as long as it may.
        self._functions: list[Any] = []
        self._raised = _Raised()

    def progress(
        self,
        callback: Optional[Callable[[Any], Any]],
        kind: Union[Type[Progress], Type[DetectionProgress]] = Progress,
    ) -> Any:
        """The C function for a callback of progress, NULL for None."""
        function_type = _structs.ProgressFunction if kind is Progress else _structs.DetectionProgressFunction
        if callback is None:
            return function_type()
        function = _callable(callback)

        def forward(progress: Any, _: object) -> int:
            try:
                if self._raised.error is not None:
                    return 1
                return _says_stop(function(kind(progress.contents)))
            except BaseException as error:
                self._raised.error = error
                return 1

        return function_type(forward)

    def fit_ended(self, callback: Optional[Callable[[int, int], Any]]) -> Any:
        """The C function for a callback of fits that ended, NULL for None."""
        if callback is None:
            return _structs.FitEndedFunction()
        function = _callable(callback)

        def forward(index: int, status: int, _: object) -> int:
            try:
                if self._raised.error is not None:
                    return 1
                return _says_stop(function(index, status))
            except BaseException as error:
                self._raised.error = error
                return 1

        return _structs.FitEndedFunction(forward)

    def log(self, callback: Optional[Callable[[LogLevel, str], Any]]) -> Any:
        """The C function for a callback of log lines, NULL for None."""
        if callback is None:
            return _structs.LogFunction()
        function = _callable(callback)

        def forward(level: int, message: bytes, _: object) -> None:
            try:
                _answered(function(LogLevel(level), message.decode("utf-8", "replace")))
            except BaseException as error:
                self._raised.error = error

        return _structs.LogFunction(forward)

    def keep(self, function: Any) -> None:
        """Keeps a C function beside the one that it is to replace: nobody knows which an interrupted call left."""
        self._functions.append(function)

    def forget_others(self, function: Any) -> None:
        """Forgets those that the library has a C function in place of, and this one too when it is NULL."""
        self._functions = [other for other in self._functions if type(other) is not type(function)]
        if function:
            self._functions.append(function)

    def around(self, function: Any, *arguments: Any) -> int:
        """Calls the library; raises what a callback raised meanwhile."""
        if not self._functions:
            return function(*arguments)  # type: ignore[no-any-return]
        self._raised.error = None
        if threading.current_thread() is threading.main_thread():
            status = self._with_signals(function, *arguments)
        else:
            status = function(*arguments)
        raised, self._raised.error = self._raised.error, None
        if raised is not None:
            raise raised
        return status

    def _with_signals(self, function: Any, *arguments: Any) -> int:
        """In the main thread Python runs handlers of signals as soon as a callback begins, before its ``try``. What
        they raise, as KeyboardInterrupt, ctypes would print and drop: this takes it from the hook that prints."""
        hook = sys.unraisablehook

        def take(unraisable: Any) -> None:
            traceback = unraisable.exc_traceback
            if traceback is not None and traceback.tb_frame.f_globals is globals():
                self._raised.error = unraisable.exc_value
            else:
                hook(unraisable)

        sys.unraisablehook = take
        try:
            return function(*arguments)  # type: ignore[no-any-return]
        finally:
            sys.unraisablehook = hook


def _callable(callback: Any) -> Any:
    if not callable(callback):
        raise TypeError(f"callback is {callback!r}; it must be a function, or None")
    if inspect.iscoroutinefunction(callback):
        raise TypeError(f"callback is {callback!r}, which is async; it must be a plain function, or None")
    return callback


def _answered(answer: Any) -> Any:
    """What a callback returned: nothing that would have to be awaited, as the call goes on at once."""
    if inspect.isawaitable(answer):
        if inspect.iscoroutine(answer):
            # Else Python warns that it was never awaited.
            answer.close()
        raise TypeError(f"callback returned {answer!r}; it must be a plain function, not async")
    return answer


def _says_stop(answer: Any) -> int:
    return int(isinstance(_answered(answer), (bool, np.bool_)) and not answer)
