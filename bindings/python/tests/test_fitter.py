"""Life of a fitter, results, exceptions."""

from __future__ import annotations

import copy
import gc
import pickle
import weakref
from typing import Any

import numpy as np
import pytest
from conftest import FRAMES, load, pipe

import cylfuse
from cylfuse.plot import limb_points


def test_the_example_of_the_readme() -> None:
    readme = (FRAMES.parents[2] / "bindings/python/README.md").read_text()
    code = readme.split("```python\n")[1].split("```")[0]
    assert len([line for line in code.splitlines() if line]) <= 10
    names: dict[str, Any] = {}
    exec(code, names)
    assert abs(names["result"].cylinder.radius - 0.5) < 1e-9


def test_a_frame(frame: dict[str, Any], result: cylfuse.Result) -> None:
    assert result.limbs_located == 2 and result.termination == cylfuse.Termination.COST
    assert result.cylinder.radius == pytest.approx(result.model.radius)
    assert result.covariance.shape == (7, 7)
    assert np.sqrt(result.covariance[6, 6]) == pytest.approx(result.radius_deviation)
    residuals = result.residuals()
    assert residuals.shape == (result.points_used,)
    assert np.sqrt(np.mean(residuals**2)) == pytest.approx(result.point_rms)
    assert result.residuals("edges").shape == (2 * result.segments_used,)
    points = result.complete()
    assert points.shape[1] == 3 and np.abs(result.cylinder.distances(points)).max() < 1e-9
    organised = result.complete("organised", np.float32)
    assert organised.shape == (480, 640, 3) and organised.dtype == np.float32
    depth = result.complete_depth(np.uint16, frame["depth_scale"])
    assert depth.shape == (480, 640) and depth.dtype == np.uint16
    seen = depth > 0
    np.testing.assert_allclose(depth[seen] * frame["depth_scale"], organised[seen][:, 2], atol=frame["depth_scale"])
    extent = result.extent
    np.testing.assert_allclose(extent.end, extent.start + extent.length * result.cylinder.direction)
    assert extent.length_deviation > 0 and extent.center_covariance.shape == (3, 3)
    assert result.diagnostics.rank == 5


def test_evaluate_and_samples(frame: dict[str, Any]) -> None:
    with cylfuse.Fitter(frame["intrinsics"]) as fitter:
        fitter.push_depth(frame["depth"], frame["mask"], frame["depth_scale"])
        with pytest.raises(cylfuse.InvalidArgumentError, match="gamma of the image is 22"):
            fitter.push_image(frame["image"], gamma=22)
        fitter.push_image(frame["image"])
        fitter.push_edges(frame["edges"], weights=[1.0, 1.0])
        result = fitter.fit()
        samples = fitter.limb_samples()
        assert samples.pixel.shape == (len(samples.deviation), 2) and set(samples.limb) == {0, 1}
        assert fitter.evaluate(result.model).model.radius == result.model.radius
        assert fitter.result.cost == result.cost
        assert fitter.counts.points_used == result.points_used
        with pytest.raises(cylfuse.StateError, match="given model"):
            fitter.evaluate(result.model).residuals()


def test_selection_of_edges(frame: dict[str, Any], result: cylfuse.Result) -> None:
    limbs = np.array(frame["edges"]).reshape(-1, 4)
    elsewhere = [[10.0, 10.0, 600.0, 20.0], [20.0, 400.0, 30.0, 470.0]]
    found = np.concatenate([elsewhere, limbs])
    with cylfuse.Fitter(frame["intrinsics"]) as fitter:
        fitter.push_depth(frame["depth"], frame["mask"], frame["depth_scale"])
        with pytest.raises(cylfuse.StateError):
            fitter.select_edges(found)
        selected = fitter.select_edges(found, model=result.cylinder)
        assert selected.dtype == np.uint8 and sorted(selected) == [0, 0, 1, 2] and list(selected[:2]) == [0, 0]
        fitter.push_edges(found[selected > 0])
        assert fitter.fit().segments_used == 2
        assert len(fitter.select_edges([])) == 0


def test_more_limb_samples_than_guessed(monkeypatch: pytest.MonkeyPatch, frame: dict[str, Any]) -> None:
    result = cylfuse.fit(**frame)
    expected = result.limb_samples()
    original = cylfuse.Fitter._list
    monkeypatch.setattr(cylfuse.Fitter, "_list", lambda self, *a: original(self, *a[:-1], 1))
    assert (result.limb_samples().pixel == expected.pixel).all() and len(expected.deviation) > 1


def test_limbs_ends_and_weights(frame: dict[str, Any]) -> None:
    result = cylfuse.fit(**frame)
    for number, limb in enumerate(result.limbs()):
        assert (limb.view, limb.limb, limb.status) == (0, number, cylfuse.LimbStatus.LOCATED)
        assert limb.line.shape == (2, 2) and 0 < limb.deviation < 1
        assert limb.samples == (result.limb_samples().limb == number).sum()
    ends = result.end_samples()
    by_image = [cylfuse.EndSource.IMAGE == source for source in (result.extent.start_source, result.extent.end_source)]
    assert [number in ends.end for number in (0, 1)] == by_image and any(by_image)
    np.testing.assert_allclose(np.linalg.norm(ends.normal, axis=1), 1.0)
    weights, inliers = result.point_weights()
    assert weights.shape == inliers.shape == (result.points_used,) and inliers.dtype == bool
    # Outliers are far away.
    residuals = np.abs(result.residuals())
    assert np.median(residuals[~inliers]) > 3 * result.point_deviation > 0
    assert ((weights > 0) == inliers).all() and result.independent_points > 0
    body = result.point_parts() == cylfuse.Part.BODY
    assert body.shape == inliers.shape and body[inliers].mean() > 0.95
    without = cylfuse.fit(**{**frame, "image": None})
    assert {limb.status for limb in without.limbs()} == {cylfuse.LimbStatus.NOT_SEARCHED}


def moved(radians: float) -> cylfuse.Pose:
    sine, cosine = np.sin(radians), np.cos(radians)
    return cylfuse.Pose([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]], [0.3, -0.2, 0.1])


def test_views_share_one_cylinder(frame: dict[str, Any], result: cylfuse.Result) -> None:
    pose, points = moved(0.4), result.complete()
    with cylfuse.Fitter() as fitter:
        for index, of_view in enumerate((cylfuse.Pose(), pose)):
            fitter.select_view(index)
            assert fitter.selected_view == index and fitter.view_count == index + 1
            fitter.set_pose(of_view)
            fitter.push_points(of_view.inverse().points(points[index::2]))
            assert fitter.counts.view == index
        both = fitter.fit()
        angle, distance, radius = both.cylinder.compare(result.cylinder)
        assert max(angle, distance, abs(radius)) < 1e-6
        assert both.points_used == len(points) and len(both.residuals()) == len(points[1::2])
        assert [len(view.pose.rotation) for view in both.views] == [3, 3]
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = pose.rotation, pose.translation
        fitter.set_pose(matrix)
        assert (fitter.pose.rotation == pose.rotation).all()
        assert fitter.fit().model.radius == both.model.radius
        with pytest.raises(cylfuse.InvalidArgumentError, match="rotation"):
            fitter.set_pose(cylfuse.Pose(2 * np.eye(3)))
        with pytest.raises(ValueError, match="it must be a cylfuse.Pose, or a 4 x 4 matrix"):
            fitter.set_pose(np.eye(3))
        with pytest.raises(cylfuse.InvalidArgumentError):
            fitter.select_view(3)
        fitter.clear()
        assert fitter.view_count == 1 and fitter.selected_view == 0


def test_a_moved_view_moves_the_result(frame: dict[str, Any], result: cylfuse.Result) -> None:
    pose = moved(-0.3)
    with cylfuse.Fitter(frame["intrinsics"]) as fitter:
        fitter.set_pose(pose)
        fitter.push_depth(frame["depth"], frame["mask"], frame["depth_scale"])
        fitter.push_image(frame["image"])
        fitter.push_edges(frame["edges"])
        other = fitter.fit()
        expected = pose.cylinder(result.cylinder)
        angle, distance, radius = other.cylinder.compare(expected)
        assert max(angle, distance, abs(radius)) < 1e-6
        assert other.extent.length == pytest.approx(result.extent.length, abs=1e-6)
        assert np.abs(expected.distances(other.complete())).max() < 1e-6


def test_a_frame_for_many_fitters(frame: dict[str, Any], result: cylfuse.Result) -> None:
    with cylfuse.Frame() as shared:
        with pytest.raises(cylfuse.StateError, match="set the intrinsics first"):
            shared.set_depth(frame["depth"], frame["depth_scale"])
    with cylfuse.Frame(frame["intrinsics"]) as shared, cylfuse.Fitter() as fitter, cylfuse.Fitter() as other:
        shared.set_depth(frame["depth"], frame["depth_scale"])
        shared.set_image(frame["image"])
        fitter.use_frame(shared, frame["mask"])
        assert fitter.intrinsics == frame["intrinsics"]
        other.use_frame(shared, frame["mask"])
        shared.close()
        with pytest.raises(cylfuse.StateError, match="the frame is closed"):
            shared.set_image(frame["image"])
        radii = set()
        for one in (fitter, other):
            one.push_edges(frame["edges"])
            radii.add(one.fit().model.radius)
        assert radii == {result.model.radius}
    with pytest.raises(TypeError, match="make one where it is used"):
        pickle.dumps(shared)


def test_a_depth_camera_of_its_own(frame: dict[str, Any], result: cylfuse.Result) -> None:
    # The depth camera is the colour camera: registered or not is the same then, but for the rounding to pixels.
    own = cylfuse.fit(**frame, depth_camera=frame["intrinsics"], depth_pose=np.eye(4))
    assert own.model.radius == pytest.approx(result.model.radius, rel=0.01)
    with cylfuse.Fitter(frame["intrinsics"]) as fitter:
        fitter.set_depth_camera(cylfuse.Intrinsics(320, 240, 285, 285, 159.5, 119.5), moved(0.0))
        with pytest.raises(cylfuse.SizeMismatchError):
            fitter.push_depth(frame["depth"], scale=frame["depth_scale"])
        fitter.set_depth_camera(None)
        fitter.push_depth(frame["depth"], frame["mask"], frame["depth_scale"])


def test_some_inputs_go(frame: dict[str, Any]) -> None:
    with cylfuse.Fitter(frame["intrinsics"]) as fitter:
        fitter.push_depth(frame["depth"], frame["mask"], frame["depth_scale"])
        fitter.push_edges(frame["edges"])
        fitter.clear_input("edges", cylfuse.Input.DEPTH)
        assert fitter.counts.segments_given == 0 and fitter.counts.points_used > 0
        assert fitter.fit().extent.end_source == cylfuse.EndSource.POINTS
        with pytest.raises(ValueError, match="Input is 'colour'"):
            fitter.clear_input("colour")


def test_the_extent_stays(frame: dict[str, Any], result: cylfuse.Result) -> None:
    with cylfuse.Fitter(frame["intrinsics"]) as fitter:
        fitter.push_depth(frame["depth"], frame["mask"], frame["depth_scale"])
        fitter.push_image(frame["image"])
        fitter.push_edges(frame["edges"])
        of_fit = fitter.fit()
        fitter.clear()
        fitter.push_depth(frame["depth"], None, frame["depth_scale"])
        assert of_fit.extent.length == result.extent.length
        with pytest.raises(cylfuse.StateError, match="something else"):
            of_fit.residuals()


def test_the_extent_stays_whatever_view_is_selected(frame: dict[str, Any]) -> None:
    with cylfuse.Fitter(frame["intrinsics"]) as fitter:
        fitter.push_depth(frame["depth"], frame["mask"], frame["depth_scale"])
        length = fitter.fit().extent.length
        fitter.select_view(1)
        of_fit = fitter.fit()
        fitter.clear()
        assert of_fit.extent.length == pytest.approx(length, rel=1e-4)


def test_text_of_a_result(result: cylfuse.Result) -> None:
    assert "radius: 0." in repr(result) and "warnings: " in repr(result)
    assert "<th>radius</th>" in result._repr_html_()
    row = result.row()
    assert row["radius"] == result.model.radius and row["length"] == result.extent.length
    assert set(result.to_dict()) <= set(dir(result))
    with pytest.raises(AttributeError):
        result.struct_size


def test_a_result_of_earlier_data_says_so() -> None:
    with cylfuse.Fitter() as fitter:
        fitter.push_points(pipe())
        result = fitter.fit()
        assert len(result.residuals()) == 200
        fitter.push_points(pipe())
        with pytest.raises(cylfuse.StateError, match="something else"):
            result.residuals()
        assert result.model.radius == pytest.approx(0.5)


def test_the_next_frame() -> None:
    with cylfuse.Fitter() as fitter:
        fitter.reserve(200)
        for _ in range(3):
            fitter.clear()
            fitter.push_points(pipe())
            assert fitter.fit().model.radius == pytest.approx(0.5)
        assert fitter.counts.points_given == 200
    with pytest.raises(ValueError, match="points is -1"):
        cylfuse.Fitter().reserve(-1)


def test_after_close_every_call_says_so() -> None:
    fitter = cylfuse.Fitter()
    fitter.close()
    fitter.close()
    assert fitter.closed
    for call in (fitter.fit, fitter.clear, fitter.cancel, lambda: fitter.push_points(pipe()), fitter.residuals):
        with pytest.raises(cylfuse.StateError, match="the fitter is closed"):
            call()


def test_a_forgotten_fitter_is_closed() -> None:
    fitter = cylfuse.Fitter()
    finalizer, gone = fitter._handle.finalizer, weakref.ref(fitter)
    del fitter
    gc.collect()
    assert gone() is None and not finalizer.alive


def test_a_forgotten_fitter_with_callbacks_is_closed_at_once() -> None:
    gc.disable()
    try:
        fitter = cylfuse.Fitter()
        fitter.on_progress(lambda state: None)
        fitter.on_log(lambda level, text: None)
        fitter.push_points(pipe())
        fitter.fit()
        finalizer = fitter._handle.finalizer
        del fitter
        assert not finalizer.alive
    finally:
        gc.enable()


def test_a_result_keeps_its_fitter_alive() -> None:
    result = cylfuse.fit_points(pipe())
    gc.collect()
    assert len(result.residuals()) == 200


def test_what_would_have_no_effect_is_not_assigned() -> None:
    fitter, detector, frame = cylfuse.Fitter(), cylfuse.Detector(), cylfuse.Frame()
    for owner in (fitter, detector):
        with pytest.raises(AttributeError, match=r"on_progress is a method of a \w+; call it: \w+\.on_progress\("):
            setattr(owner, "on_progress", print)
    with pytest.raises(AttributeError, match="a Fitter has no attribute 'intrinsic'; did you mean 'intrinsics'?"):
        setattr(fitter, "intrinsic", None)
    with pytest.raises(AttributeError, match="a Detector has no attribute 'fit_option'; did you mean 'fit_options'?"):
        setattr(detector, "fit_option", None)
    with pytest.raises(AttributeError, match="a Frame has no attribute 'xyz'$"):
        setattr(frame, "xyz", None)
    with pytest.raises(AttributeError):
        setattr(fitter, "result", None)

    class Named(cylfuse.Fitter):
        def __init__(self, name: str) -> None:
            super().__init__()
            self.name = name

    assert Named("left").name == "left"


def test_fitters_cannot_be_pickled() -> None:
    with pytest.raises(TypeError, match="make one where it is used"):
        pickle.dumps(cylfuse.Fitter())
    camera = cylfuse.Intrinsics(640, 480, 570, 570, 319.5, 239.5, "kannala_brandt", [0.1])
    assert pickle.loads(pickle.dumps(camera)) == camera
    options = cylfuse.Options(objective="paper", axis=[0, 0, 1])
    assert pickle.loads(pickle.dumps(options)) == options


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda value: pickle.loads(pickle.dumps(value))])
def test_a_copied_result_has_the_numbers(frame: dict[str, Any], copied: Any) -> None:
    result = cylfuse.fit(**frame)
    assert result.extent.length > 0
    again = copied(result)
    assert repr(again) == repr(result) and again.row() == result.row()
    assert (again.covariance == result.covariance).all() and again.extent.length == result.extent.length
    with pytest.raises(cylfuse.StateError, match="or a copy"):
        again.residuals()
    assert len(result.residuals()) == result.points_used
    for value in (result.model, result.diagnostics, result._fitter.counts, cylfuse.PlanarPointsError("flat")):
        assert repr(copied(value)) == repr(value)
    assert copied(cylfuse.PlanarPointsError("flat")).status == -21


def test_options_come_back() -> None:
    options = cylfuse.Options("fused", "paper", "model", "off", "local", "as_given", "located", 2, 7, 1e-9, 1e-8, 1e-7,
                              0.5, 3.0, 1e6, 0.25, 2**40, 9, 0.1, 50.0, 0.01, 2.0, 0.3, 0.9, 0.7, 1.5, 0.1, 0.2,
                              (0.0, 1.0, 0.0), 0.5)  # fmt: skip
    with cylfuse.Fitter(options=options) as fitter:
        assert fitter.options == options
        with pytest.raises(cylfuse.InvalidArgumentError, match="options.edge_weight is 1.4"):
            fitter.options = cylfuse.Options(edge_weight=1.4)
        assert fitter.options == options


def test_exceptions_are_of_their_kind(frame: dict[str, Any]) -> None:
    plane = np.c_[np.arange(40) % 8, np.arange(40) // 8, np.ones(40)]
    with pytest.raises(cylfuse.PlanarPointsError) as caught:
        cylfuse.fit_points(plane)
    assert isinstance(caught.value, cylfuse.DataError) and caught.value.name == "PLANAR_POINTS"
    assert caught.value.status == -21 and "plane" in caught.value.message
    with pytest.raises(cylfuse.SizeMismatchError, match="mask is 640 x 2"):
        cylfuse.fit(**{**frame, "mask": np.ones((2, 640), bool)})
    with pytest.raises(ValueError, match="fx is nan|fx is NaN"):
        cylfuse.Fitter(cylfuse.Intrinsics(640, 480, float("nan"), 1, 1, 1))
    with pytest.raises(cylfuse.StateError, match="set the intrinsics first"):
        cylfuse.Fitter().push_depth(frame["depth"], scale=frame["depth_scale"])
    with pytest.raises(cylfuse.InvalidArgumentError):
        cylfuse.Cylinder([0, 0, 1], [0, 0, 0], 1).distances(pipe())


def test_start_model() -> None:
    with cylfuse.Fitter(options=cylfuse.Options(start="model")) as fitter:
        fitter.push_points(pipe())
        fitter.set_start_model(cylfuse.Cylinder([0, 0, 2.1], [0.1, 1, 0], 0.4))
        result = fitter.fit()
        assert result.start_kind == cylfuse.Start.MODEL and result.start_model.radius == pytest.approx(0.4)
        fitter.set_start_model(None)
        with pytest.raises(cylfuse.StateError):
            fitter.fit()


def test_geometry() -> None:
    cylinder = cylfuse.Cylinder([0, 0, 2], [0, 2, 0], 0.5)
    assert cylinder.distances([[0, 5, 2], [1, 0, 2]]).tolist() == [-0.5, 0.5]
    assert cylinder.distances(pipe().reshape(10, 20, 3)).shape == (10, 20)
    angle, distance, radius = cylinder.compare(cylfuse.Cylinder([1, 0, 2], [0, 1, 0], 1.0))
    assert (angle, distance, radius) == (0.0, 1.0, 1.0)
    camera = cylfuse.Intrinsics.from_matrix([[100, 0, 50], [0, 100, 40], [0, 0, 1]], 100, 80)
    lines = cylinder.project(camera)
    limbs = limb_points(cylinder, np.array([[0, -1.0, 2], [0, 1.0, 2]]), camera)
    assert np.abs(cylinder.distances(np.concatenate(limbs))).max() < 1e-9
    for (a, b, c), limb in zip(lines, limbs):
        np.testing.assert_allclose(camera.project(limb) @ [a, b] + c, 0.0, atol=1e-9)
    assert limb_points(cylfuse.Cylinder([0, 0, 0], [0, 0, 1], 0.5), np.ones((2, 3)), camera) == []


@pytest.mark.parametrize("model", ["none", "brown_conrady", "kannala_brandt"])
def test_projection_and_back(model: str) -> None:
    camera = cylfuse.Intrinsics(640, 480, 570, 571, 319.5, 239.5, model, [] if model == "none" else [0.05, -0.02])
    pixels = np.array([[0.0, 0.0], [319.5, 239.5], [640.0, 100.0]])
    rays = camera.unproject(pixels)
    assert rays.shape == (3, 3) and (rays[:, 2] == 1.0).all()
    np.testing.assert_allclose(camera.project(3.0 * rays), pixels, atol=1e-6)
    assert camera.project(rays.reshape(1, 3, 3)).shape == (1, 3, 2)
    assert np.isnan(camera.project([[0, 0, -1], [np.nan, 0, 1]])).all() and camera.unproject([]).shape == (0, 3)
    with pytest.raises(ValueError, match="it must be N x 2"):
        camera.unproject(np.ones((2, 3)))


@pytest.mark.parametrize("name", [path.name for path in sorted(FRAMES.iterdir())])
def test_all_frames(name: str) -> None:
    result = cylfuse.fit(**load(FRAMES / name))
    assert result.extent.length > 0 and cylfuse.ResultFlags.NOT_CONVERGED not in result.flags
