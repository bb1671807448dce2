"""The detector."""

from __future__ import annotations

import gc
import pickle
import subprocess
import sys
import threading
import weakref
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import cylfuse

WIDTH, HEIGHT = 160, 120
CAMERA = cylfuse.Intrinsics(WIDTH, HEIGHT, 170, 170, 79.5, 59.5)
TRUTHS = [
    cylfuse.Cylinder([-0.12, 0.0, 0.7], [0.1, 0.99, 0.1], 0.05),
    cylfuse.Cylinder([0.13, 0.05, 0.8], [0.9, 0.3, 0.2], 0.035),
]
LENGTHS = [0.24, 0.2]


def seen(x: Any, y: Any) -> tuple[Any, Any]:
    """The depth along rays x, y, 1, and who is seen there: 0 the wall, then the cylinders."""
    rays = np.stack([x, y, np.ones_like(x)], axis=-1)
    depth, owner = 1.2 / (1.0 + 0.1 * x - 0.2 * y), np.zeros(x.shape, int)
    for number, (truth, length) in enumerate(zip(TRUTHS, LENGTHS), 1):
        axis = truth.direction / np.linalg.norm(truth.direction)
        across = rays - (rays @ axis)[..., None] * axis
        offset = truth.point - truth.point @ axis * axis
        a, b = (across**2).sum(-1), across @ offset
        root = b * b - a * (offset @ offset - truth.radius**2)
        z = (b - np.sqrt(np.maximum(root, 0.0))) / a
        front = (root >= 0) & (np.abs(z * (rays @ axis) - truth.point @ axis) <= length / 2) & (z < depth)
        depth, owner = np.where(front, z, depth), np.where(front, number, owner)
    return depth, owner


def scene() -> tuple[Any, Any, Any, Any]:
    """Two cylinders before a wall: depth, image, points and who is seen where."""
    row, column = np.mgrid[:HEIGHT, :WIDTH].astype(float)
    x, y = (column - CAMERA.cx) / CAMERA.fx, (row - CAMERA.cy) / CAMERA.fy
    depth, owner = seen(x, y)
    image = np.full(depth.shape, 40.0)
    for k in range(16):
        aside = (k % 4 - 1.5) / 4.0 / CAMERA.fx, (k // 4 - 1.5) / 4.0 / CAMERA.fy
        image += 10.0 * (seen(x + aside[0], y + aside[1])[1] > 0)
    depth = depth + np.random.default_rng(1).uniform(-0.001, 0.001, depth.shape)
    points = np.stack([x * depth, y * depth, depth], axis=-1)
    return depth.astype(np.float32), image.astype(np.uint8), points, owner


DEPTH, IMAGE, POINTS, OWNER = scene()


def make_frame(with_image: bool = True) -> cylfuse.Frame:
    frame = cylfuse.Frame(CAMERA)
    frame.set_depth(DEPTH)
    if with_image:
        frame.set_image(IMAGE)
    return frame


def check(detector: cylfuse.Detector, found: list[cylfuse.Detection], tolerance: float) -> None:
    """Checks what a detector says of both cylinders, and one thing against another."""
    labels = detector.labels.ravel()
    assert len(found) == 2 and 1.0 >= found[0].score >= found[1].score >= 0.5
    truths = set()
    for k, one in enumerate(found):
        truth = next(
            number
            for number, cylinder in enumerate(TRUTHS)
            if (difference := cylinder.compare(one.cylinder)).angle < tolerance
            and difference.axis_distance < tolerance * cylinder.radius
            and abs(difference.radius_relative) < tolerance
        )
        truths.add(truth)
        indices = detector.indices(k)
        assert indices.dtype == np.uint32 and len(indices) == one.pixels > 300
        assert (np.flatnonzero(labels == k + 1) == indices).all()
        assert (OWNER.ravel()[indices] == truth + 1).mean() > 0.95
        assert one.result.start_kind == cylfuse.Start.MODEL and one.result.radius_deviation > 0
        assert 0 < one.result.points_used <= one.pixels
        if one.extent is not None:
            assert one.extent.length == pytest.approx(LENGTHS[truth], rel=0.05)
    assert truths == {0, 1} and (labels > 0).sum() == sum(one.pixels for one in found)


def models(found: list[cylfuse.Detection]) -> list[Any]:
    return [(one.score, one.pixels, one.result.covariance.tobytes(), *one.cylinder.point) for one in found]


def test_cylinders_of_a_frame() -> None:
    with cylfuse.Detector() as detector, make_frame() as frame, make_frame(False) as without:
        found = detector.detect(frame)
        check(detector, found, 0.01)
        assert detector.labels.shape == (HEIGHT, WIDTH) and detector.labels.dtype == np.uint16
        assert found[0].result.limbs_located == 2 and found[0].result.views[0].intrinsics == CAMERA
        assert models(detector.detections) == models(found)
        assert found[1].result.row()["length"] == found[1].extent.length

        # The image is not looked at: as if there were none.
        detector.options = cylfuse.DetectorOptions(image_use="ignore")
        ignored = detector.detect(frame)
        check(detector, ignored, 0.1)
        detector.options = cylfuse.DetectorOptions()
        missing = detector.detect(without)
        assert models(ignored) == models(missing)

        # In the reference frame.
        pose = cylfuse.Pose([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]], [-0.5, 0.1, 0.2])
        without.set_pose(pose)
        turned = detector.detect(without)
        for one, other in zip(missing, turned):
            there = cylfuse.Cylinder(
                pose.rotation @ one.cylinder.point + pose.translation, pose.rotation @ one.cylinder.direction,
                one.cylinder.radius,
            )  # fmt: skip
            assert np.abs(there.compare(other.cylinder)).max() < 1e-9
        frame.close()
        assert len(detector.detections) == 2
    # What was found stays.
    assert found[0].extent.length > 0


def test_cylinders_of_a_cloud() -> None:
    with cylfuse.Detector() as detector:
        check(detector, detector.detect_points(POINTS), 0.1)
        assert detector.labels.shape == (HEIGHT, WIDTH)
        one = detector.detections[0]
        assert one.extent is not None and one.extent.end_source == cylfuse.EndSource.POINTS
        with pytest.raises(cylfuse.StateError, match=r"which is detector\.fitter\(index\)"):
            one.result.residuals()

        # Not organised, float, with strides, and weights.
        mixed = np.zeros((WIDTH * HEIGHT, 6), np.float32)
        mixed[:, :3], mixed[:, 3] = POINTS.reshape(-1, 3), 1.0
        check(detector, detector.detect_points(mixed[:, :3], mixed[:, 3]), 0.1)
        assert detector.labels.shape == (WIDTH * HEIGHT,)
        # Weights of 0 leave points out: all but those of the wall and the first cylinder.
        mixed[:, 3] = np.where(OWNER.ravel() == 2, 0.0, 2.0)
        assert len(detector.detect_points(mixed[:, :3], mixed[:, 3])) == 1
        mixed[7, 3] = -1.0
        with pytest.raises(cylfuse.InvalidArgumentError, match="the weight of point 7 is -1"):
            detector.detect_points(mixed[:, :3], mixed[:, 3])
        assert len(detector.detections) == 1


def test_a_fitter_goes_on() -> None:
    with cylfuse.Detector() as detector, make_frame() as frame:
        found = detector.detect(frame)
        fitter = detector.fitter(1)
    one = found[1]
    with fitter:
        result = fitter.result
        assert result.covariance.tobytes() == one.result.covariance.tobytes()
        assert result.extent.to_dict().keys() == one.extent.to_dict().keys()
        assert (result.extent.start == one.extent.start).all()
        assert fitter.intrinsics == CAMERA and fitter.options.start == cylfuse.Start.MODEL
        assert [limb.status for limb in result.limbs()] == [cylfuse.LimbStatus.LOCATED] * 2
        assert len(result.residuals()) == result.points_used == fitter.counts.points_used
        assert 0 < len(result.complete()) <= one.pixels
        # The same fit once more.
        again = fitter.fit()
        assert (again.cylinder.point == one.cylinder.point).all() and again.extent.length == one.extent.length
    with cylfuse.Detector() as detector:
        found = detector.detect_points(POINTS)
        with detector.fitter(0) as fitter:
            # Fitted to its whole region: its points share no errors.
            assert fitter.counts.points_used == found[0].pixels
            assert fitter.intrinsics is None
            assert fitter.result.cylinder.radius == found[0].cylinder.radius
        for call in (detector.fitter, detector.indices):
            with pytest.raises(cylfuse.InvalidArgumentError, match="index is 2; it must be less than the number"):
                call(2)
            with pytest.raises(ValueError, match="index is -1"):
                call(-1)


def test_limits_hold() -> None:
    options = cylfuse.DetectorOptions(radius_min=0.04, radius_max=0.06, axis=[0, -3, 0], axis_max_angle=0.2)
    with cylfuse.Detector(options, cylfuse.Options(depth_noise=0.001)) as detector, make_frame() as frame:
        assert detector.options == options and detector.fit_options == cylfuse.Options(depth_noise=0.001)
        for found in (detector.detect(frame), detector.detect_points(POINTS)):
            assert len(found) == 1 and found[0].cylinder.radius == pytest.approx(0.05, abs=0.005)
        detector.options = cylfuse.DetectorOptions(max_count=1)
        assert len(detector.detect(frame)) == 1
        detector.options = cylfuse.DetectorOptions(min_pixels=2**64 - 1)
        assert detector.detect(frame) == [] and not detector.labels.any()
        for refused, text in [(dict(min_score=1.5), "options.min_score is 1.5"), (dict(radius_min=-1), "radius")]:
            with pytest.raises(cylfuse.InvalidArgumentError, match=text):
                detector.options = cylfuse.DetectorOptions(**refused)
        for limited in (dict(start="moments"), dict(max_threads=2), dict(radius_max=0.1)):
            with pytest.raises(cylfuse.InvalidArgumentError, match="of the fits"):
                detector.fit_options = cylfuse.Options(**limited)
        assert detector.options.min_pixels == 2**64 - 1
        assert detector.fit_options == cylfuse.Options(depth_noise=0.001)
        detector.fit_options = cylfuse.Options(objective="paper")
        detector.options = cylfuse.DetectorOptions()
        with pytest.raises(cylfuse.UnsupportedError):
            detector.detect(frame)


def test_any_number_of_threads_gives_the_same_bits() -> None:
    with make_frame() as frame:
        outcomes = []
        for threads in (1, 3):
            with cylfuse.Detector(cylfuse.DetectorOptions(max_threads=threads)) as detector:
                outcomes.append(models(detector.detect(frame)))
    assert outcomes[0] == outcomes[1]


def test_what_needs_a_search() -> None:
    with cylfuse.Detector() as detector, cylfuse.Frame() as frame:
        questions = (
            lambda: detector.detections, lambda: detector.labels, lambda: detector.indices(0), lambda: detector.fitter(0),
        )  # fmt: skip
        for call in questions:
            with pytest.raises(cylfuse.StateError, match="search a frame or points first"):
                call()
        with pytest.raises(cylfuse.StateError, match="intrinsics"):
            detector.detect(frame)
        frame.intrinsics = CAMERA
        with pytest.raises(cylfuse.StateError, match="depth"):
            detector.detect(frame)
        with pytest.raises(TypeError, match="frame is of the type ndarray; it must be of the type cylfuse.Frame"):
            detector.detect(DEPTH)  # type: ignore[arg-type]
        assert detector.detect_points(np.zeros((0, 3))) == [] and detector.labels.shape == (0,)
        assert detector.detect_points(np.full((4, 5, 3), np.nan)) == [] and detector.labels.shape == (4, 5)
    with pytest.raises(cylfuse.StateError, match="the detector is closed; make a new one"):
        detector.detect_points(POINTS)
    with pytest.raises(TypeError, match="a Detector cannot be copied or pickled"):
        pickle.dumps(detector)
    assert detector.closed


def test_progress() -> None:
    states: list[cylfuse.DetectionProgress] = []
    with cylfuse.Detector() as detector, make_frame() as frame:
        detector.on_progress(states.append)
        count = len(detector.detect(frame))
        assert [state.phase for state in states[:2]] == [cylfuse.DetectionPhase.SEARCH, cylfuse.DetectionPhase.FIT]
        assert [state.fits_done for state in states[1:]] == list(range(len(states) - 1))
        assert states[-1].fits_done == states[-1].fits >= count and states[0].fits == 0
        for stop in (lambda state: False, lambda state: detector.cancel(), lambda state: state.phase == 1):
            detector.on_progress(stop)
            with pytest.raises(cylfuse.CancelledError, match="cancelled by the caller"):
                detector.detect(frame)
        detector.on_progress(lambda state: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            detector.detect(frame)
        for call in (lambda state: detector.labels, lambda state: detector.detect(frame)):
            detector.on_progress(call)
            with pytest.raises(cylfuse.BusyError):
                detector.detect(frame)
        # The last scene is still there.
        assert len(detector.detections) == count
        detector.on_progress(None)
        detector.cancel()
        assert len(detector.detect(frame)) == count


def test_a_search_in_another_thread() -> None:
    running, go_on = threading.Event(), threading.Event()

    def wait(_: cylfuse.DetectionProgress) -> None:
        running.set()
        assert go_on.wait(900)

    with cylfuse.Detector() as detector, make_frame() as frame, ThreadPoolExecutor(1) as pool:
        detector.on_progress(wait)
        search = pool.submit(detector.detect, frame)
        assert running.wait(900)
        for call in (lambda: detector.detect(frame), lambda: detector.labels, lambda: detector.options):
            with pytest.raises(cylfuse.BusyError):
                call()
        detector.cancel()
        go_on.set()
        with pytest.raises(cylfuse.CancelledError):
            search.result()


def test_many_threads_may_read_a_scene() -> None:
    with cylfuse.Detector() as detector, make_frame() as frame, ThreadPoolExecutor(4) as pool:
        expected = models(detector.detect(frame)), detector.labels.tobytes(), detector.indices(1).tobytes()

        def read(_: int) -> bool:
            for _ in range(20):
                detector.fitter(1).close()
                seen = models(detector.detections), detector.labels.tobytes(), detector.indices(1).tobytes()
                if seen != expected:
                    return False
            return True

        assert all(pool.map(read, range(4)))


def test_a_forgotten_detector_is_closed() -> None:
    detector = cylfuse.Detector()
    detector.on_progress(lambda state: detector is not None)
    detector.detect_points(POINTS[::4, ::4])
    finalizer, gone = detector._handle.finalizer, weakref.ref(detector)
    detector = None  # type: ignore[assignment]
    gc.collect()
    assert gone() is None and not finalizer.alive


def test_a_search_that_was_cut_short_says_so() -> None:
    # Bumps in both directions, 12 pixels apart: more to look at than a search may.
    row, column = np.mgrid[:480, :640]
    bumps = 1.0 + 1.2 / 525.0 * np.sin(np.pi / 6.0 * column) * np.sin(np.pi / 6.0 * row)
    frame = cylfuse.Frame(cylfuse.Intrinsics(640, 480, 525, 525, 319.5, 239.5))
    frame.set_depth(bumps.astype(np.float32))
    detector = cylfuse.Detector()
    with pytest.raises(cylfuse.StateError, match="search a frame or points first"):
        _ = detector.is_complete
    with pytest.raises(cylfuse.StateError, match="search a frame or points first"):
        _ = detector.depth_moved
    detector.detect(frame)
    assert detector.is_complete is False
    detector.detect(make_frame())
    assert detector.is_complete is True
    assert detector.depth_moved == (0, 0)


def test_a_daemon_thread_in_a_search_does_not_abort_the_end() -> None:
    program = """
import threading, time
import numpy as np
import cylfuse
detector, running = cylfuse.Detector(), threading.Event()
detector.on_progress(lambda state: running.set() or time.sleep(0.001))
def loop():
    while True:
        detector.detect_points(np.random.default_rng(1).uniform(size=(40, 50, 3)))
threading.Thread(target=loop, daemon=True).start()
running.wait()
"""
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=900)
    assert run.returncode == 0, run.stderr
