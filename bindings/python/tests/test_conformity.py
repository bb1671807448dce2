"""Decisions about a tolerance, and fitters that are cloned."""

from __future__ import annotations

from math import inf, nan

import numpy as np
import pytest
from conftest import pipe

import cylfuse
from cylfuse import Conformity, ResultFlags, decide_conformity


def test_the_interval_decides() -> None:
    assert decide_conformity(20.0, 0.12, lower=19.5, upper=20.25) is Conformity.CONFORMING
    assert decide_conformity(20.0, 0.13, lower=19.5, upper=20.25) is Conformity.UNDECIDED
    assert decide_conformity(20.0, 0.13, lower=19.5, upper=20.25, coverage=1) is Conformity.CONFORMING
    assert decide_conformity(20.0, 0.13, upper=19.5) is Conformity.NOT_CONFORMING
    for deviation in (nan, 0.0):
        assert decide_conformity(20.0, deviation, lower=19.5) is Conformity.UNDECIDED
    for flags, expected in ((ResultFlags.WEAK_RADIUS, "conforming"), (ResultFlags.POOR_FIT, "undecided")):
        assert decide_conformity(20.0, 0.1, lower=19.5, flags=flags) is Conformity(expected)
    with pytest.raises(cylfuse.InvalidArgumentError, match="21 to 19"):
        decide_conformity(20.0, 0.1, lower=21, upper=19)
    with pytest.raises(cylfuse.InvalidArgumentError, match="measured value is inf"):
        decide_conformity(inf, 0.1, lower=1)
    with pytest.raises(ValueError, match="coverage is 0"):
        decide_conformity(20.0, 0.1, lower=1, coverage=0)
    with pytest.raises(TypeError, match="lower is 'low'"):
        decide_conformity(20.0, 0.1, lower="low")  # type: ignore[arg-type]


def test_a_result_is_judged_by_its_deviation_and_its_warnings() -> None:
    points = pipe()
    points[:, 2] += 0.002 * np.sin(7.0 * np.arange(len(points)))
    result = cylfuse.fit_points(points)
    radius, deviation = result.cylinder.radius, result.radius_deviation
    assert 0 < deviation < 0.05 * radius
    assert result.radius_conforms(radius - 2.1 * deviation, radius + 2.1 * deviation) is Conformity.CONFORMING
    assert result.radius_conforms(radius - 1.9 * deviation) is Conformity.UNDECIDED
    assert result.radius_conforms(radius - 1.9 * deviation, coverage=1) is Conformity.CONFORMING
    assert result.diameter_conforms(2 * radius - 4.2 * deviation) is Conformity.CONFORMING
    assert result.diameter_conforms(upper=2 * radius - 4.2 * deviation) is Conformity.NOT_CONFORMING
    ransac = cylfuse.fit_points(points, options=cylfuse.Options(method="ransac"))
    assert ransac.radius_conforms(upper=9.0) is Conformity.UNDECIDED


def test_a_clone_goes_its_own_way() -> None:
    camera = cylfuse.Intrinsics(640, 480, 570, 570, 319.5, 239.5)
    with cylfuse.Fitter(camera, cylfuse.Options(max_iterations=77)) as fitter:
        fitter.push_points(pipe())
        radius = fitter.fit().cylinder.radius
        fitter.on_progress(lambda _: False)
        with fitter.clone() as clone:
            assert clone.options.max_iterations == 77 and clone.intrinsics == camera
            assert clone.result.cylinder.radius == radius and clone.fit().cylinder.radius == radius
            with pytest.raises(cylfuse.CancelledError):
                fitter.fit()
            clone.select_view(1)
            clone.clear()
            assert (clone.counts.points_given, fitter.counts.points_given) == (0, len(pipe()))
            assert fitter.selected_view == 0 and fitter.view_count == 1
