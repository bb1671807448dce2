"""What a camera will measure."""

import math

import pytest

import cylfuse

CAMERA = cylfuse.Intrinsics(640, 480, 570.0, 570.0, 319.5, 239.5)


def test_farther_is_worse_and_a_cut_pipe_has_no_length():
    near = cylfuse.plan(CAMERA, distance=0.7, radius=0.03, length=0.1, tilt=0.35, turn=0.42)
    far = cylfuse.plan(CAMERA, distance=1.4, radius=0.03, length=0.1, tilt=0.35, turn=0.42)
    for a, b, c in zip(near.scatter, near.total, far.total):
        assert 0.0 < a < b < c
    cut = cylfuse.plan(CAMERA, distance=0.7, radius=0.03, length=2.0)
    assert math.isnan(cut.total.length) and cut.total.radius > 0.0


def test_the_noise_counts_and_mistakes_are_named():
    can = {"distance": 0.7, "radius": 0.03, "length": 0.1}
    usual = cylfuse.plan(CAMERA, **can)
    noisy = cylfuse.plan(CAMERA, **can, noise=[0.01, 0.0, 0.0, 9.0, 0.014, 0.7])
    assert noisy.scatter.position > 2.0 * usual.scatter.position
    with pytest.raises(cylfuse.CylfuseError, match="correlation of depth is 0"):
        cylfuse.plan(CAMERA, **can, noise=[0.01, 0.0, 0.0, 0.0, 0.014, 0.7])
    with pytest.raises(ValueError, match="noise"):
        cylfuse.plan(CAMERA, **can, noise=[0.01])
