"""Threads and memory."""

from __future__ import annotations

import ctypes
import functools
import gc
import itertools
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import warnings
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from conftest import FRAMES, load, pipe

import cylfuse
from cylfuse import _native


def test_eight_fitters_at_once_give_the_same_bits(frame: dict[str, Any], result: cylfuse.Result) -> None:
    barrier = threading.Barrier(8)

    def run(_: int) -> bytes:
        barrier.wait()
        return b"".join(cylfuse.fit(**frame).covariance.tobytes() for _ in range(3))

    with ThreadPoolExecutor(8) as pool:
        outcomes = set(pool.map(run, range(8)))
    assert outcomes == {result.covariance.tobytes() * 3}


def test_a_second_call_from_another_thread_raises() -> None:
    fitter, running, go_on = cylfuse.Fitter(), threading.Event(), threading.Event()

    def wait(_: cylfuse.Progress) -> None:
        running.set()
        assert go_on.wait(900)

    fitter.push_points(pipe())
    fitter.on_progress(wait)
    with ThreadPoolExecutor(1) as pool:
        fit = pool.submit(fitter.fit)
        assert running.wait(900)
        for call in (fitter.fit, fitter.clear, lambda: fitter.push_points(pipe()), lambda: fitter.counts):
            with pytest.raises(cylfuse.BusyError):
                call()
        # The one call that other threads may make.
        fitter.cancel()
        go_on.set()
        with pytest.raises(cylfuse.CancelledError):
            fit.result()
    fitter.close()


def test_close_waits_for_the_call_that_runs() -> None:
    fitter, running, go_on = cylfuse.Fitter(), threading.Event(), threading.Event()

    def wait(_: cylfuse.Progress) -> None:
        running.set()
        assert go_on.wait(900)

    fitter.push_points(pipe())
    fitter.on_progress(wait)
    finalizer = fitter._handle.finalizer
    with ThreadPoolExecutor(1) as pool:
        fit = pool.submit(fitter.fit)
        assert running.wait(900)
        fitter.close()
        assert finalizer.alive
        with pytest.raises(cylfuse.StateError, match="closed"):
            fitter.fit()
        go_on.set()
        assert fit.result().model.radius == pytest.approx(0.5)
    assert not finalizer.alive


def test_many_threads_may_ask_at_once(frame: dict[str, Any]) -> None:
    result = cylfuse.fit(**frame)
    expected, barrier = result.residuals(), threading.Barrier(8)

    def ask(_: int) -> bool:
        barrier.wait()
        return all((result.residuals() == expected).all() and len(result.complete()) > 0 for _ in range(20))

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(ask, range(8)))


def test_every_thread_reads_its_own_message() -> None:
    fitter, barrier = cylfuse.Fitter(), threading.Barrier(4)

    def fail(number: int) -> set[str]:
        texts = set()
        barrier.wait()
        for _ in range(200):
            try:
                fitter.evaluate(cylfuse.Cylinder([0, 0, 1], [0, 0, 1], -1.0 - number))
            except cylfuse.CylfuseError as error:
                texts.add(error.message)
        return texts

    with ThreadPoolExecutor(4) as pool:
        for number, texts in enumerate(pool.map(fail, range(4))):
            assert len(texts) == 1 and f"-{1 + number}" in texts.pop()


def test_misuse_raises_and_never_crashes() -> None:
    points = pipe()
    for _ in range(50):
        fitter, barrier = cylfuse.Fitter(), threading.Barrier(8)

        def abuse(number: int) -> None:
            barrier.wait()
            for _ in range(20):
                try:
                    [fitter.fit, lambda: fitter.push_points(points), fitter.clear, fitter.cancel, fitter.residuals,
                     lambda: fitter.counts, fitter.close, lambda: fitter.options][number]()  # fmt: skip
                except cylfuse.CylfuseError:
                    pass

        with ThreadPoolExecutor(8) as pool:
            list(pool.map(abuse, range(8)))


def test_the_gil_is_free_during_calls() -> None:
    # ctypes.PyDLL keeps it, ctypes.CDLL does not.
    assert type(_native.lib) is ctypes.CDLL


@pytest.mark.parametrize("kind", ["progress", "log"])
def test_ctrl_c_comes_out_of_a_call_with_callbacks(kind: str) -> None:
    begun, points = threading.Event(), pipe() + 1e-3 * np.sin(np.arange(600)).reshape(-1, 3)

    def interrupt() -> None:
        begun.wait(900)
        os.kill(os.getpid(), signal.SIGINT)

    def begin() -> None:
        # Once: the signal must not find the lock of the event held, which would stay so.
        if not begun.is_set():
            begun.set()

    hook = sys.unraisablehook
    with cylfuse.Fitter() as fitter:
        fitter.push_points(points)
        if kind == "progress":
            fitter.on_progress(lambda state: begin())
        else:
            fitter.on_log(lambda level, text: begin(), "debug")
        thread = threading.Thread(target=interrupt)
        thread.start()
        # Python notices the signal when the next callback begins; a fit has many. The last fit is for a signal that came
        # when none ran.
        with pytest.raises(KeyboardInterrupt):
            while thread.is_alive():
                fitter.fit()
            fitter.fit()
        thread.join()
        assert sys.unraisablehook is hook
        assert fitter.fit().model.radius == pytest.approx(0.5, rel=0.1)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timers that signal")
def test_signals_at_any_moment_leave_the_fitter_usable() -> None:
    class Tick(Exception):
        pass

    armed, points = False, pipe()

    def tick(*_: Any) -> None:
        nonlocal armed
        if armed:
            armed = False
            raise Tick

    before = signal.signal(signal.SIGALRM, tick)
    signal.setitimer(signal.ITIMER_REAL, 0.001, 0.0003)
    try:
        with cylfuse.Fitter() as fitter:
            for _ in range(3000):
                try:
                    armed = True
                    fitter.clear()
                    fitter.push_points(points)
                    fitter.fit()
                    armed = False
                except Tick:
                    pass
            fitter.clear()
            fitter.push_points(points)
            assert fitter.fit().model.radius == pytest.approx(0.5)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_a_daemon_thread_in_a_fit_does_not_abort_the_end() -> None:
    code = """
import threading, numpy, cylfuse
k = numpy.arange(30000)
angle = 1.6 * k / 30000
points = numpy.c_[0.5 * numpy.cos(angle), 0.1 * (k % 7), 2 - 0.5 * numpy.sin(angle)]
fitter, begun = cylfuse.Fitter(), threading.Event()
fitter.push_points(points + 1e-3 * numpy.sin(numpy.arange(90000) * 1.7).reshape(-1, 3))
fitter.on_progress(lambda state: begun.set())
def loop():
    while True:
        fitter.fit()
threading.Thread(target=loop, daemon=True).start()
begun.wait()
print("end", flush=True)
"""
    for _ in range(5):
        run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        assert run.returncode == 0 and run.stdout == "end\n", run.stderr


def radius(count: int) -> float:
    return float(cylfuse.fit_points(pipe(count)).model.radius)


@pytest.mark.parametrize("method", [m for m in ("fork", "spawn") if m in multiprocessing.get_all_start_methods()])
def test_processes(method: str) -> None:
    expected = [radius(count) for count in (50, 100)]
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map(radius, [50, 100]) == expected
        results = pool.map(cylfuse.fit_points, [pipe(50), pipe(100)])
    assert [result.model.radius for result in results] == expected


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_fitter_after_a_fork() -> None:
    fitter = cylfuse.Fitter()
    fitter.push_points(pipe(100_000))
    expected = fitter.fit().model.radius
    child = os.fork()
    if child == 0:
        try:
            same = fitter.fit().model.radius == expected and len(fitter.residuals()) == 100_000
            fitter.close()
            os._exit(0 if same else 1)
        finally:
            os._exit(2)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    assert fitter.fit().model.radius == expected


def resident() -> int:
    """Bytes of memory in use, and what Python can give back is given back."""
    gc.collect()
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096


@pytest.mark.parametrize("close", [True, False])
def test_ten_thousand_fitters_leave_no_memory(close: bool) -> None:
    points = pipe(50)

    def cycle(count: int) -> None:
        for _ in range(count):
            fitter = cylfuse.Fitter()
            fitter.push_points(points)
            fitter.fit().residuals()
            if close:
                fitter.close()

    cycle(1000)
    growths = []
    # A leak of 100 bytes a cycle would be a million, every time; the system joins pages when it likes.
    for _ in range(3):
        before = resident()
        cycle(10_000)
        growths.append(resident() - before)
        if growths[-1] < 1_000_000:
            return
    pytest.fail(f"memory grew by {growths}")


def test_many_frames_in_order_with_their_failures() -> None:
    names = [path.name for path in sorted(FRAMES.iterdir())] * 3
    frames: list[Any] = [functools.partial(load, FRAMES / name) for name in names]
    frames.insert(4, {**load(FRAMES / names[0]), "mask": np.zeros((480, 640), bool)})
    expected = {name: cylfuse.fit(**load(FRAMES / name)).model.radius for name in set(names)}
    for threads in (1, 3):
        outcomes = list(cylfuse.fit_many(frames, threads=threads))
        assert isinstance(outcomes.pop(4), cylfuse.EmptyMaskError)
        assert [outcome.model.radius for outcome in outcomes] == [expected[name] for name in names]


def test_many_frames_are_taken_as_they_are_needed(frame: dict[str, Any]) -> None:
    taken = []

    def endless() -> Any:
        while True:
            taken.append(None)
            yield frame

    outcomes = cylfuse.fit_many(endless(), threads=2)
    for _ in range(3):
        assert isinstance(next(outcomes), cylfuse.Result)
    outcomes.close()
    assert len(taken) <= 3 + 4


def test_a_loader_that_fails_is_not_hidden() -> None:
    with pytest.raises(ZeroDivisionError):
        list(cylfuse.fit_many([lambda: 1 / 0]))


def test_what_the_frames_raise_comes_after_the_outcomes_before_it(frame: dict[str, Any]) -> None:
    def frames() -> Any:
        yield from [frame] * 3
        raise RuntimeError("the camera is gone")

    outcomes = cylfuse.fit_many(frames(), threads=2)
    assert [type(outcome) for outcome in itertools.islice(outcomes, 3)] == [cylfuse.Result] * 3
    with pytest.raises(RuntimeError, match="the camera is gone"):
        next(outcomes)


def test_results_of_many_frames_keep_no_data(frame: dict[str, Any], result: cylfuse.Result) -> None:
    outcomes = cylfuse.fit_many([frame] * 2, threads=1)
    one = next(outcomes)
    assert isinstance(one, cylfuse.Result) and one.extent.length == result.extent.length
    gc.collect()
    assert not any(isinstance(thing, cylfuse.Fitter) for thing in gc.get_referents(one.__dict__))
    assert one.row() == result.row()
    with pytest.raises(cylfuse.StateError, match="or of fit_many"):
        one.residuals()
    outcomes.close()


def test_a_failed_frame_keeps_no_data(frame: dict[str, Any]) -> None:
    (failed,) = cylfuse.fit_many([{**frame, "depth": np.zeros((480, 640), np.uint16)}])
    assert isinstance(failed, cylfuse.NoDepthError) and failed.__traceback__ is None


def test_the_bar_counts_the_frames(capsys: pytest.CaptureFixture[str], frame: dict[str, Any]) -> None:
    pytest.importorskip("tqdm")
    assert len(list(cylfuse.fit_many([frame] * 3, progress=True))) == 3
    assert "3/3" in capsys.readouterr().err


def batch() -> list[cylfuse.Fitter]:
    fitters = [cylfuse.Fitter() for _ in range(8)]
    for number, fitter in enumerate(fitters):
        points = pipe()[number:]
        fitter.push_points([[0.0, 0.1 * k, 1.0] for k in range(20)] if number == 2 else points)
    return fitters


@pytest.mark.parametrize("threads", [0, 1, 3])
def test_fitters_at_once_give_the_bits_of_each(threads: int) -> None:
    heard: dict[int, int] = {}
    fitters = batch()
    outcomes = cylfuse.fit_all(fitters, threads=threads, on_progress=heard.__setitem__)
    assert heard == {number: cylfuse.CollinearPointsError.status if number == 2 else 0 for number in range(8)}
    for number, (alone, fitter, outcome) in enumerate(zip(batch(), fitters, outcomes)):
        if number == 2:
            assert isinstance(outcome, cylfuse.CollinearPointsError) and "line" in str(outcome)
            continue
        expected = alone.fit()
        assert isinstance(outcome, cylfuse.Result)
        for one in (outcome, fitter.result):
            assert one.covariance.tobytes() == expected.covariance.tobytes()
        assert outcome.residuals().shape == (expected.points_used,)


def test_fitters_at_once_are_stopped_and_refused() -> None:
    fitters = batch()
    outcomes = cylfuse.fit_all(fitters, threads=1, on_progress=lambda index, status: index < 3)
    kinds = [cylfuse.Result] * 2 + [cylfuse.CollinearPointsError, cylfuse.Result] + [cylfuse.CancelledError] * 4
    assert [type(outcome) for outcome in outcomes] == kinds and "cancel" in str(outcomes[4])
    assert fitters[3].result.model.radius == pytest.approx(0.5)
    with pytest.raises(cylfuse.StateError):
        fitters[4].result
    with pytest.raises(ZeroDivisionError):
        cylfuse.fit_all(fitters, threads=2, on_progress=lambda index, status: 1 / 0)
    with pytest.raises(cylfuse.InvalidArgumentError, match=r"fitters\[1\] is the same"):
        cylfuse.fit_all(fitters[:1] * 2)
    with pytest.raises(TypeError, match=r"fitters\[1\] is of the type NoneType"):
        cylfuse.fit_all([fitters[0], None])  # type: ignore[list-item]
    fitters[5].close()
    with pytest.raises(cylfuse.StateError, match="closed"):
        cylfuse.fit_all(fitters)
    assert cylfuse.fit_all([]) == []


def test_results_of_fits_that_were_not_made_anew_still_answer() -> None:
    fitters = batch()[:2]
    first, second = (fitter.fit() for fitter in fitters)
    with pytest.raises(cylfuse.InvalidArgumentError):
        cylfuse.fit_all(fitters[:1] * 2)
    with pytest.raises(ZeroDivisionError):
        cylfuse.fit_all(fitters[1:], on_progress=lambda index, status: 1 / 0)
    assert len(first.residuals()) == first.points_used
    with pytest.raises(cylfuse.StateError, match="something else since"):
        second.residuals()

    results = [fitter.result for fitter in fitters]
    (outcome,) = cylfuse.fit_all(fitters[:1], on_progress=lambda index, status: results.append(fitters[index].result))
    assert isinstance(outcome, cylfuse.Result) and len(outcome.residuals()) == len(results.pop().residuals())
    with pytest.raises(cylfuse.StateError, match="something else since"):
        results[0].residuals()
    assert len(results[1].residuals()) == second.points_used

    # The second is not reached.
    results = [fitter.result for fitter in fitters]
    outcomes = cylfuse.fit_all(fitters, threads=1, on_progress=lambda index, status: False)
    for result, of_call in zip(results, outcomes):
        if isinstance(of_call, cylfuse.CancelledError):
            assert len(result.residuals()) == result.points_used
        else:
            with pytest.raises(cylfuse.StateError):
                result.residuals()


def test_a_busy_fitter_has_its_text_and_the_others_are_fitted() -> None:
    one, other = batch()[:2]
    outcomes: list[object] = []
    one.on_progress(lambda progress: outcomes.extend(cylfuse.fit_all([one, other], threads=2)))
    one.fit()
    assert isinstance(outcomes[0], cylfuse.BusyError) and "the handle is busy in another call" in str(outcomes[0])
    assert isinstance(outcomes[1], cylfuse.Result)


def test_callbacks_are_plain_functions() -> None:
    async def ask(*_: object) -> bool:
        return False

    fitter = batch()[0]
    for refused in (fitter.on_progress, fitter.on_log, cylfuse.Detector().on_progress):
        with pytest.raises(TypeError, match="async"):
            refused(ask)
    with pytest.raises(TypeError, match="async"):
        cylfuse.fit_all([fitter], on_progress=ask)
    # What only shows in the call.
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(TypeError, match="must be a plain function, not async"):
            cylfuse.fit_all([fitter], on_progress=lambda index, status: ask(index))
        fitter.on_progress(lambda progress: ask(progress))
        with pytest.raises(TypeError, match="must be a plain function, not async"):
            fitter.fit()
        fitter.on_progress(None)
        fitter.on_log(lambda level, line: ask(), cylfuse.LogLevel.DEBUG)
        with pytest.raises(TypeError, match="must be a plain function, not async"):
            fitter.fit()
    fitter.on_log(None)
    assert fitter.fit().model.radius == pytest.approx(0.5)
