"""What a fitter calls while it works: with its progress, and with lines of a log."""

from __future__ import annotations

import gc
from typing import Any

import numpy as np
import pytest
from conftest import pipe

import cylfuse


def test_progress(frame: dict[str, Any]) -> None:
    states: list[cylfuse.Progress] = []
    with cylfuse.Fitter() as fitter:
        fitter.push_points(pipe() + 1e-3 * np.sin(np.arange(600)).reshape(-1, 3))
        fitter.on_progress(states.append)
        fitter.fit()
        assert states[0].phase == cylfuse.Phase.START and states[-1].phase == cylfuse.Phase.SOLVE
        assert states[-1].cylinder.radius == pytest.approx(0.5, rel=0.1) and states[-1].damping > 0
        assert states[0].cylinder is None
        fitter.on_progress(lambda state: False)
        with pytest.raises(cylfuse.CancelledError):
            fitter.fit()
        fitter.on_progress(lambda state: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            fitter.fit()
        fitter.on_progress(lambda state: fitter.counts)
        with pytest.raises(cylfuse.BusyError):
            fitter.fit()
        fitter.on_progress(lambda state: fitter.cancel())
        with pytest.raises(cylfuse.CancelledError):
            fitter.fit()
        fitter.on_progress(lambda state: np.float64(state.iteration) < 0)
        with pytest.raises(cylfuse.CancelledError):
            fitter.fit()
        fitter.on_progress(None)
        assert fitter.fit().model.radius == pytest.approx(0.5, rel=0.1)


def test_a_callback_may_be_an_empty_list_that_can_be_called() -> None:
    class Recorder(list):  # type: ignore[type-arg]
        __call__ = list.append

    states = Recorder()
    with cylfuse.Fitter() as fitter:
        fitter.push_points(pipe())
        fitter.on_progress(states)
        fitter.fit()
    assert states


def test_a_callback_that_was_set_in_an_interrupted_call_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    states: list[cylfuse.Progress] = []
    with cylfuse.Fitter() as fitter:
        fitter.push_points(pipe())
        original = fitter._call

        def interrupted(*arguments: Any) -> None:
            original(*arguments)
            raise KeyboardInterrupt

        monkeypatch.setattr(fitter, "_call", interrupted)
        with pytest.raises(KeyboardInterrupt):
            fitter.on_progress(lambda state: states.append(state))
        monkeypatch.undo()
        gc.collect()
        fitter.fit()
        assert states
        fitter.on_progress(None)
        count = len(states)
        fitter.fit()
        assert len(states) == count


def test_what_a_log_callback_ends_has_changed_the_data() -> None:
    with cylfuse.Fitter() as fitter:
        fitter.push_points(pipe())
        result = fitter.fit()
        fitter.on_log(lambda level, text: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            fitter.push_points(pipe())
        fitter.on_log(None)
        assert fitter.counts.points_given == 400
        with pytest.raises(cylfuse.StateError, match="something else"):
            result.residuals()
        # A call that failed has changed nothing.
        result = fitter.fit()
        with pytest.raises(cylfuse.InvalidArgumentError):
            fitter.push_edges([[1, 2, 3, np.nan]])
        assert len(result.residuals()) == 400


def test_log() -> None:
    lines: list[tuple[cylfuse.LogLevel, str]] = []
    with cylfuse.Fitter() as fitter:
        fitter.on_log(lambda level, text: lines.append((level, text)), "debug")
        fitter.push_points(pipe())
        fitter.fit()
        assert any("cloud pushed: 200" in text for level, text in lines if level == cylfuse.LogLevel.INFO)
        lines.clear()
        fitter.residuals()
        fitter.limb_samples()
        assert lines == []
        fitter.on_log(lambda level, text: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            fitter.push_points(pipe())
        fitter.on_log(None)
        fitter.push_points(pipe())
