"""Arrays of every kind: read in place, and refused before the call."""

from __future__ import annotations

import tracemalloc
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


@pytest.mark.parametrize(("name", "value", "error", "text"), [
    ("depth", np.zeros((4, 5)), TypeError, "depth has the type float64; it must be uint16 or float32"),
    ("depth", [[1, 2]], TypeError, "depth is a list"),
    ("depth", np.zeros((4, 5, 1), np.uint16), ValueError, "rows x columns"),
    ("depth", np.zeros((4, 5), ">u2"), TypeError, "uint16"),
    ("mask", np.zeros((480, 640), int), TypeError, "mask != 0 converts it"),
    ("image", np.zeros((480, 640, 3), np.uint8), ValueError, "take one channel, image[..., 1]"),
    ("edges", np.zeros((2, 3)), ValueError, "N x 4"),
    ("edges", [["a", "b", "c", "d"]], TypeError, "edges has the type"),
    ("intrinsics", np.eye(4), ValueError, "it must be (3, 3)"),
    ("depth_scale", "x", TypeError, ""),
])  # fmt: skip
def test_wrong_types_and_shapes(
    frame: dict[str, Any], name: str, value: Any, error: type[Exception], text: str
) -> None:
    with pytest.raises(error) as caught:
        cylfuse.fit(**{**frame, name: value})
    assert text in str(caught.value)
    assert not isinstance(caught.value, cylfuse.CylfuseError)


@pytest.mark.parametrize(("arguments", "text"), [
    ((np.zeros((5, 2)),), "points has the shape (5, 2)"),
    ((np.zeros(3),), "points has the shape (3,)"),
    ((pipe(), np.ones(3)), "weights have the shape (3,); it must be (200,)"),
    ((pipe(), None, np.ones((3, 3))), "normals have the shape (3, 3)"),
])  # fmt: skip
def test_wrong_clouds(arguments: Any, text: str) -> None:
    with pytest.raises(ValueError, match=text.replace("(", r"\(").replace(")", r"\)")):
        cylfuse.fit_points(*arguments)


def test_an_unknown_choice_names_the_known_ones() -> None:
    with pytest.raises(ValueError, match="Objective is 'best'; it must be one of robust, paper"):
        cylfuse.Options(objective="best")
    with pytest.raises(ValueError, match="seed is -1"):
        cylfuse.Options(seed=-1)
