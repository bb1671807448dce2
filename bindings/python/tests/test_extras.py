"""What needs other packages: pictures, meshes, Dask, the notebook. Each is skipped where its package is missing."""

from __future__ import annotations

import os
import pathlib
from typing import Any

import numpy as np
import pytest
from conftest import FRAMES, ROOT, load, pipe

import cylfuse


def test_plot(frame: dict[str, Any], result: cylfuse.Result, tmp_path: pathlib.Path) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    ax = result.plot(frame["image"])
    labels = [line.get_label() for line in ax.lines]
    assert [label for label in labels if not label.startswith("_")] == [
        "limbs", f"start: {result.extent.start_state}", f"end: {result.extent.end_state}", "axis",
    ]  # fmt: skip
    # The limbs that are drawn lie where the given edges are, to the pixel that those are off.
    for edge in np.array(frame["edges"]).reshape(-1, 2, 2):
        middle = edge.mean(axis=0)
        drawn = [line.get_xydata() for line in ax.lines[:2]]
        assert min(np.linalg.norm(limb - middle, axis=1).min() for limb in drawn) < 3.0
    ax.figure.savefig(tmp_path / "plot.png")
    assert (tmp_path / "plot.png").stat().st_size > 10_000
    assert result.plot(ax=ax) is ax
    with pytest.raises(cylfuse.StateError, match="plotting needs intrinsics"):
        cylfuse.fit_points(pipe()).plot()


def test_trimesh(result: cylfuse.Result) -> None:
    pytest.importorskip("trimesh")
    mesh = result.to_trimesh()
    assert mesh.is_watertight
    # The corners of the mesh lie on the surface, but for the middles of the caps.
    distances = np.abs(result.cylinder.distances(np.asarray(mesh.vertices)))
    assert np.sort(distances)[:-2].max() < 1e-9
    along = (np.asarray(mesh.vertices) - result.extent.start) @ result.cylinder.direction
    assert along.min() == pytest.approx(0.0, abs=1e-9) and along.max() == pytest.approx(result.extent.length)


def test_open3d(result: cylfuse.Result) -> None:
    pytest.importorskip("open3d")
    vertices = np.asarray(result.to_open3d().vertices)
    distances = np.abs(result.cylinder.distances(vertices))
    assert np.sort(distances)[:-2].max() < 1e-9
    along = (vertices - result.extent.start) @ result.cylinder.direction
    assert along.min() == pytest.approx(0.0, abs=1e-9) and along.max() == pytest.approx(result.extent.length)


def load_or_fail(name: str) -> dict[str, Any]:
    if name == "deadly":
        os._exit(1)
    frame = load(FRAMES / name.removeprefix("dark "))
    if name.startswith("dark "):
        frame["depth"] = np.zeros_like(frame["depth"])
    return frame


def test_dask_on_two_workers() -> None:
    pytest.importorskip("distributed")
    import dask
    from distributed import Client, LocalCluster

    from cylfuse.dask import fit_frames

    names = sorted(path.name for path in FRAMES.iterdir())
    frames = [*names, "nowhere", *names, f"dark {names[0]}"]
    # A worker that is killed while it starts again is given up, and with both gone Dask waits for ever: one death will do.
    dask.config.set({"distributed.scheduler.allowed-failures": 0})
    # Any port that is free.
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster, Client(cluster) as client:
        rows = fit_frames(client, frames, load_or_fail)
        # By itself: whatever else waits on a worker that dies is given up with it.
        [killed] = fit_frames(client, ["deadly"], load_or_fail)
    assert [row["frame"] for row in rows] == frames
    assert "FileNotFoundError" in rows[len(names)]["error"]
    assert rows[-1]["error"].startswith("NoDepthError: none of the ")
    assert killed["frame"] == "deadly" and killed["error"].startswith("KilledWorker: ")
    for name, row in zip(names, rows):
        expected = cylfuse.fit(**load(FRAMES / name)).row()
        assert row.pop("error") is None and row.pop("frame") == name
        assert row == expected


def test_notebook() -> None:
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    path = ROOT / "bindings/python/examples/from_frame_to_fit.ipynb"
    notebook = nbformat.read(path, as_version=4)
    assert all(not cell.outputs for cell in notebook.cells if cell.cell_type == "code"), "commit it without outputs"
    resources = {"metadata": {"path": path.parent}}
    # On a busy machine a kernel takes its time.
    nbclient.NotebookClient(notebook, timeout=900, startup_timeout=900, resources=resources).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert any("text/html" in output.get("data", {}) for output in outputs)
    assert sum("image/png" in output.get("data", {}) for output in outputs) >= 2
