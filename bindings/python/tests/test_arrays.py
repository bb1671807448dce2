"""Arrays of every kind: read in place, and refused before the call."""

from __future__ import annotations

import tracemalloc
import warnings
from typing import Any

import numpy as np
import pytest
from conftest import pipe

import cylfuse
from cylfuse import _arrays


def model(result: cylfuse.Result) -> list[float]:
    return [*result.model.point, *result.model.direction, result.model.radius]


def test_nothing_is_copied_in_python(frame: dict[str, Any]) -> None:
    depth = frame["depth"]
    assert depth.shape == (480, 640)
    view = _arrays.depth_view(depth, 1.0, 0.0, None)
    assert (view.data, view.row_stride, view.pixel_stride) == (depth.ctypes.data, 1280, 2)
    arrays = [depth, frame["mask"], frame["image"]]
    cylfuse.fit(**frame)
    tracemalloc.start()
    try:
        cylfuse.fit(**frame)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # numpy reports what it allocates; the smallest of the arrays has 307,200 bytes.
    assert peak < min(array.nbytes for array in arrays) / 10, peak


def test_strides_change_nothing(frame: dict[str, Any]) -> None:
    expected = model(cylfuse.fit(**frame))
    wide = np.zeros((480, 700), np.uint16)
    wide[:, 30:670] = frame["depth"]
    colours = np.stack([frame["image"]] * 3, axis=-1)
    upside_down = np.ascontiguousarray(frame["mask"][::-1])[::-1]
    column_major = np.asfortranarray(frame["mask"] != 0)
    for mask in (upside_down, column_major, frame["mask"] != 0):
        given = {**frame, "depth": wide[:, 30:670], "image": colours[..., 1], "mask": mask}
        assert model(cylfuse.fit(**given)) == expected


def test_depth_of_float64_is_converted(frame: dict[str, Any]) -> None:
    depth = frame["depth"] * frame["depth_scale"]
    narrow, wide = ({**frame, "depth": depth.astype(dtype), "depth_scale": 1.0} for dtype in (np.float32, np.float64))
    assert model(cylfuse.fit(**wide)) == model(cylfuse.fit(**narrow))


def test_images_in_color(frame: dict[str, Any]) -> None:
    rng = np.random.default_rng(1)
    gain = np.array([1.0, 0.7, 0.4])
    rgb = (frame["image"][..., None] * gain + rng.uniform(0, 20, 3)).clip(0, 255).astype(np.uint8)
    expected = model(cylfuse.fit(**{**frame, "image": rgb}))
    padded = np.zeros((480, 700, 3), np.uint8)
    padded[:, 5:645] = rgb
    rgba = np.concatenate([rgb, rng.integers(0, 255, (480, 640, 1), np.uint8)], axis=2)
    planes = np.ascontiguousarray(rgb.transpose(2, 0, 1)).transpose(1, 2, 0)
    for image in (padded[:, 5:645], rgba, planes, rgb[::-1].copy()[::-1]):
        assert model(cylfuse.fit(**{**frame, "image": image})) == expected
    bgra = np.ascontiguousarray(rgba[..., [2, 1, 0, 3]])
    for image in (bgra, bgra[..., :3]):
        assert model(cylfuse.fit(**{**frame, "image": image, "image_bgr": True})) == expected
        assert model(cylfuse.fit(**{**frame, "image": image})) != expected
    grey = rgb @ [0.2126, 0.7152, 0.0722]
    near = cylfuse.fit(**{**frame, "image": grey.astype(np.float32)})
    assert near.model.radius == pytest.approx(expected[6], rel=1e-4)


def test_one_label_of_a_mask(frame: dict[str, Any]) -> None:
    labels = np.where(frame["mask"] != 0, 7, 3).astype(np.uint8)
    models = []
    for mask, label in ((frame["mask"], 0), (labels, 7)):
        with cylfuse.Fitter(frame["intrinsics"]) as fitter:
            fitter.push_depth(frame["depth"], mask, frame["depth_scale"], label=label)
            models.append(model(fitter.fit()))
            with pytest.raises(ValueError, match="label is 256"):
                fitter.push_depth(frame["depth"], mask, frame["depth_scale"], label=256)
    assert models[0] == models[1]


@pytest.mark.parametrize("points", [
    pipe()[::-1][::-1],
    np.asfortranarray(pipe()),
    pipe().tolist(),
    pipe().reshape(20, 10, 3),
    np.concatenate([pipe(), np.zeros((200, 2))], axis=1)[:, :3],
])  # fmt: skip
def test_clouds_of_every_form_are_the_same(points: Any) -> None:
    assert model(cylfuse.fit_points(points)) == model(cylfuse.fit_points(pipe()))


def test_edges_of_every_form_are_the_same(frame: dict[str, Any]) -> None:
    edges = np.array(frame["edges"])
    expected = model(cylfuse.fit(**frame))
    for given in (edges.reshape(-1, 4), edges.tolist(), np.repeat(edges.reshape(-1, 4), 2, axis=0)[::2]):
        assert model(cylfuse.fit(**{**frame, "edges": given})) == expected


def test_a_transposed_cloud_is_filled_in_columns() -> None:
    rows = np.ascontiguousarray(pipe().T)
    assert model(cylfuse.fit_points(rows.T)) == model(cylfuse.fit_points(pipe()))


def test_arrays_whose_elements_share_memory(frame: dict[str, Any]) -> None:
    # Of numpy.broadcast_to strides are 0, which for the library stands for packed elements.
    rows = np.broadcast_to(np.ones(640, bool), (480, 640))
    columns = np.broadcast_to(np.ones((480, 1), np.uint8), (480, 640))
    of_all = [model(cylfuse.fit(**{**frame, "mask": mask})) for mask in (rows, columns, np.ones((480, 640), bool))]
    assert of_all[0] == of_all[1] == of_all[2]
    points, up = pipe(), np.broadcast_to([0.0, 0.0, 1.0], (200, 3))
    weights = np.broadcast_to(1.0, 200)
    assert model(cylfuse.fit_points(points, weights)) == model(cylfuse.fit_points(points, np.ones(200)))
    for dtype in (np.float32, np.float64):
        of_both = [cylfuse.fit_points(points.astype(dtype), None, normals) for normals in (up, up.copy())]
        assert model(of_both[0]) == model(of_both[1])
    cylinder, numbers = cylfuse.Cylinder([0, 0, 2], [0, 1, 0], 0.5), np.arange(9.0)
    for shared in (up, np.lib.stride_tricks.sliding_window_view(numbers, 3)):
        assert (cylinder.distances(shared) == cylinder.distances(shared.copy())).all()
    edges = np.broadcast_to(np.array(frame["edges"]).reshape(-1, 4)[0], (3, 4))
    with cylfuse.Fitter(frame["intrinsics"]) as fitter:
        fitter.push_edges(edges)
        fitter.push_points(points)
        assert fitter.fit().segments_given == 3


def test_foreign_arrays(frame: dict[str, Any]) -> None:
    class Foreign:
        def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
            return pipe()

    expected = model(cylfuse.fit_points(pipe()))
    for points in (Foreign(), pipe().astype(">f8"), pipe().astype(np.longdouble)):
        assert model(cylfuse.fit_points(points)) == expected
    read_only = frame["depth"].view()
    read_only.flags.writeable = False
    assert model(cylfuse.fit(**{**frame, "depth": read_only})) == model(cylfuse.fit(**frame))


@pytest.mark.parametrize(("name", "value", "error", "text"), [
    ("depth", np.zeros((4, 5), np.int32), TypeError, "depth has the type int32; it must be uint16 or float32"),
    ("depth", [[1, 2]], TypeError, "depth is of the type list"),
    ("depth", np.zeros((4, 5, 1), np.uint16), ValueError, "rows x columns"),
    ("depth", np.zeros((4, 5), ">u2"), TypeError, "uint16"),
    ("mask", np.zeros((480, 640), int), TypeError, "mask != 0 converts it"),
    ("image", np.zeros((480, 640, 2), np.uint8), ValueError, "rows x columns x 3 or 4 of uint8"),
    ("image", np.zeros((480, 640, 3), np.float32), ValueError, "of uint8; (255 * image).astype(numpy.uint8)"),
    ("image", np.zeros((3, 480, 640), np.uint8), ValueError, "of uint8; numpy.moveaxis(image, 0, 2)"),
    ("image", np.zeros((480, 640)), TypeError, "image.astype(numpy.float32) converts it"),
    ("edges", np.zeros((2, 3)), ValueError, "N x 4"),
    ("edges", [["a", "b", "c", "d"]], TypeError, "edges have the type"),
    ("edges", {}, TypeError, "edges have the type dict"),
    ("intrinsics", np.eye(4), ValueError, "it must be (3, 3)"),
    ("intrinsics", np.array([[9, 0, 0], [0, 9, 0], [5, 4, 1]]), ValueError, "has 5 in row 2, column 0; it must be 0"),
    ("depth_scale", None, TypeError, "depth has the type uint16 and no scale; give the length of one unit of it: 0.001"),
    ("depth_scale", "x", TypeError, "the scale of the depth is 'x'; it must be a number"),
    ("min_depth", None, TypeError, "min_depth is None; it must be a number"),
    ("depth", np.ma.masked_equal(np.ones((4, 5), np.uint16), 0), TypeError, "depth.filled(0) makes a plain one"),
    ("mask", np.broadcast_to(np.uint8(1), (2**20, 2**20)), ValueError, "it must have at most 2^28"),
    ("options", {}, TypeError, "options is of the type dict; it must be of the type cylfuse.Options"),
])  # fmt: skip
def test_wrong_types_and_shapes(
    frame: dict[str, Any], name: str, value: Any, error: type[Exception], text: str
) -> None:
    with pytest.raises(error) as caught:
        cylfuse.fit(**{**frame, name: value})
    assert text in str(caught.value)
    assert not isinstance(caught.value, cylfuse.CylfuseError)


@pytest.mark.parametrize(("arguments", "text"), [
    ((np.zeros((5, 2)),), "points have the shape (5, 2)"),
    ((np.zeros(3),), "points have the shape (3,)"),
    ((pipe(), np.ones(3)), "weights have the shape (3,); it must be (200,)"),
    ((pipe(), None, np.ones((3, 3))), "normals have the shape (3, 3)"),
])  # fmt: skip
def test_wrong_clouds(arguments: Any, text: str) -> None:
    with pytest.raises(ValueError, match=text.replace("(", r"\(").replace(")", r"\)")):
        cylfuse.fit_points(*arguments)


def test_a_masked_cloud_is_refused() -> None:
    with pytest.raises(TypeError, match=r"points\.filled\(numpy\.nan\) makes a plain one"):
        cylfuse.fit_points(np.ma.masked_less(pipe(), 0.2))


@pytest.mark.parametrize(("call", "text"), [
    (lambda: cylfuse.Fitter(np.eye(3)), "intrinsics is of the type ndarray; it must be of the type cylfuse.Intrinsics"),
    (lambda: cylfuse.Fitter(options=cylfuse.Options), "options is the class Options"),
    (lambda: cylfuse.Fitter().set_start_model([1, 2, 3]), "model is of the type list"),
    (lambda: cylfuse.Fitter().evaluate(None), "model is of the type NoneType"),
    (lambda: cylfuse.Fitter().reserve(1.5), "points is 1.5; it must be a whole number"),
    (lambda: cylfuse.Fitter().select_edges([[1, 2, 3, 4]], "far"), "reach is 'far'; it must be a number"),
    (lambda: cylfuse.Fitter().on_progress(5), "callback is 5; it must be a function, or None"),
    (lambda: cylfuse.Fitter().on_log("print"), "callback is 'print'"),
    (lambda: cylfuse.Fitter().push_edges([[1, 2, 3, 4]], "a"), "weights have the type"),
    (lambda: cylfuse.Options(max_iterations=5.5), "max_iterations is 5.5; it must be a whole number"),
    (lambda: cylfuse.Options(radius_min="a"), "radius_min is 'a'; it must be a number"),
    (lambda: cylfuse.Options(axis=None), "axis is None; it must be 3 numbers"),
    (lambda: cylfuse.Intrinsics(640.0, 480, 1, 1, 1, 1), "width is 640.0; it must be a whole number"),
    (lambda: cylfuse.Intrinsics(640, 480, None, 1, 1, 1), "fx is None; it must be a number"),
    (lambda: cylfuse.Intrinsics(640, 480, 1, 1, 1, 1, "none", None), "distortion is None"),
    (lambda: cylfuse.Cylinder("abc", [0, 0, 1], 1), "point is 'abc'; it must be 3 numbers"),
    (lambda: cylfuse.Cylinder([0, 0, 1], [0, 0, 1], 1).compare([1]), "other is of the type list"),
    (lambda: cylfuse.Cylinder([0, 0, 1], [0, 0, 1], 1).project(np.eye(3)), "intrinsics is of the type ndarray"),
    (lambda: cylfuse.fit_points(None), "points have the type NoneType"),
    (lambda: cylfuse.fit_many([], threads=1.5), "threads is 1.5; it must be a whole number"),
    (lambda: cylfuse.fit_many(None), "not iterable"),
])  # fmt: skip
def test_wrong_objects_are_named_before_the_call(call: Any, text: str) -> None:
    with pytest.raises(TypeError) as caught:
        call()
    assert text in str(caught.value)


def test_numbers_of_numpy_will_do() -> None:
    camera = cylfuse.Intrinsics(*np.array([640, 480]), *np.array([570, 570, 319.5, 239.5], np.float32))
    options = cylfuse.Options(max_iterations=np.int32(7), seed=np.uint64(2**63), radius_max=np.float32(0.5))
    with cylfuse.Fitter(camera, options) as fitter:
        assert fitter.options == options and type(fitter.options.max_iterations) is int
        fitter.reserve(np.int64(10), np.uint8(2))
    assert camera == cylfuse.Intrinsics(640, 480, 570, 570, 319.5, 239.5)


def test_an_unknown_choice_names_the_known_ones() -> None:
    with pytest.raises(ValueError, match="Objective is 'best'; it must be one of robust, paper"):
        cylfuse.Options(objective="best")
    with pytest.raises(ValueError, match="seed is -1"):
        cylfuse.Options(seed=-1)
    with pytest.raises(ValueError, match=r"threads is 0; it must lie in \[1, 2\^16\)"):
        cylfuse.fit_many([], threads=0)


def test_choices_in_texts() -> None:
    assert f"{cylfuse.EndState.SEEN} {cylfuse.Termination.COST!s:>6}" == "seen   cost"


def test_depth_without_a_scale(frame: dict[str, Any]) -> None:
    with cylfuse.Fitter(frame["intrinsics"]) as fitter, cylfuse.Frame(frame["intrinsics"]) as shared:
        for take in (fitter.push_depth, shared.set_depth):
            with pytest.raises(TypeError, match="depth has the type uint16 and no scale"):
                take(frame["depth"])
            take(frame["depth"].astype(np.float32))


def test_distortion_means_brown_conrady() -> None:
    camera = cylfuse.Intrinsics(640, 480, 570, 570, 319.5, 239.5, distortion=[-0.04, 0.01])
    assert camera.distortion_model == cylfuse.Distortion.BROWN_CONRADY
    assert cylfuse.Intrinsics(640, 480, 570, 570, 319.5, 239.5).distortion_model == cylfuse.Distortion.NONE
    with pytest.raises(cylfuse.InvalidIntrinsicsError, match="set distortion_model"):
        cylfuse.Fitter(cylfuse.Intrinsics(640, 480, 570, 570, 319.5, 239.5, "none", [-0.04]))


def test_a_principal_point_that_looks_swapped_is_a_warning() -> None:
    with pytest.warns(UserWarning, match=r"the principal point is \(239.5, 319.5\) .* are cx and cy swapped"):
        cylfuse.Intrinsics(640, 480, 570, 570, 239.5, 319.5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Of a piece of an image, and of a square one.
        cylfuse.Intrinsics(640, 480, 570, 570, 20, 100)
        cylfuse.Intrinsics(480, 480, 570, 570, 230, 245)


def test_focal_lengths_that_are_no_pixels_are_a_warning() -> None:
    with pytest.warns(UserWarning, match="3.6 and 3.6 .* not in millimetres"):
        cylfuse.Intrinsics(640, 480, 3.6, 3.6, 319.5, 239.5)
    with pytest.warns(UserWarning, match="fx is 319.5 and fy is 570, .* check them"):
        cylfuse.Intrinsics(640, 480, 319.5, 570, 319.5, 239.5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cylfuse.Intrinsics(640, 480, 570, 565, 319.5, 239.5)
        cylfuse.Intrinsics(640, 480, 100, 100, 319.5, 239.5, "kannala_brandt")


def test_intrinsics_that_are_missing_are_named(frame: dict[str, Any]) -> None:
    with pytest.raises(TypeError, match="intrinsics is None"):
        cylfuse.fit(**{**frame, "intrinsics": None})


def test_a_whole_scene_is_a_poor_fit(frame: dict[str, Any], result: cylfuse.Result) -> None:
    assert cylfuse.ResultFlags.POOR_FIT not in result.flags
    whole = cylfuse.fit(**{**frame, "mask": None, "edges": None})
    assert "POOR_FIT" in whole.flags.names
