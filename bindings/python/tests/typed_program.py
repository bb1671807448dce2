"""What a user writes, for checkers of types: mypy --strict finds nothing wrong in it but the line that says so."""

from __future__ import annotations

import functools
import pathlib
from typing import Any

import numpy as np
import numpy.typing as npt

import cylfuse


def load(path: pathlib.Path) -> dict[str, Any]:
    camera = cylfuse.Intrinsics(640, 480, 570, 570, 319.5, 239.5, "brown_conrady", [0.1, 0.01])
    return {"depth": np.load(path), "intrinsics": camera}


def slow(state: cylfuse.Progress) -> bool:
    return state.iteration < 100 or state.phase == cylfuse.Phase.START


points: npt.NDArray[np.float64] = np.zeros((10, 3))
options = cylfuse.Options(objective="paper", start=cylfuse.Start.MODEL, axis=[0, 0, 1], seed=7)
result: cylfuse.Result = cylfuse.fit_points(points, options=options)
vector: npt.NDArray[np.float64] = result.cylinder.point + result.residuals().mean()
length: float = result.extent.length
distances: npt.NDArray[np.float64] = cylfuse.Cylinder([0, 0, 1], (0, 1, 0), 0.5).distances(points.tolist())
if cylfuse.ResultFlags.NOT_CONVERGED in result.flags or result.termination == cylfuse.Termination.COST:
    names: list[str] = result.flags.names + result.flags.descriptions + [result.termination.description]
with cylfuse.Fitter(cylfuse.Intrinsics.from_matrix(np.eye(3), 640, 480), options) as fitter:
    fitter.on_progress(slow)
    fitter.on_log(lambda level, text: print(level, text), "debug")
    fitter.push_edges([[1.0, 2.0, 3.0, 4.0]], weights=[1])
    pixels: npt.NDArray[np.float64] = fitter.limb_samples().pixel
    fitter.select_view(1)
    fitter.set_pose(np.eye(4))
    fitter.set_depth_camera(None)
    fitter.clear_input("points", cylfuse.Input.IMAGE)
    located: bool = fitter.limbs()[0].status == cylfuse.LimbStatus.LOCATED
    inliers: npt.NDArray[np.bool_] = fitter.point_weights().inliers
    body: npt.NDArray[np.bool_] = fitter.point_parts() == cylfuse.Part.BODY
    start: cylfuse.EndState = fitter.extent(mask=np.ones((480, 640), bool)).start_state
with cylfuse.Frame(cylfuse.Intrinsics(640, 480, 570, 570, 319.5, 239.5), cylfuse.Pose()) as frame:
    frame.set_image(np.zeros((480, 640, 3), np.uint8), bgr=True)
    cylfuse.Fitter().use_frame(frame, np.ones((480, 640), np.uint8), label=1)
with cylfuse.Detector(cylfuse.DetectorOptions(image_use="ignore", max_count=3), cylfuse.Options(seed=1)) as detector:
    detector.on_progress(lambda state: state.phase == cylfuse.DetectionPhase.SEARCH or state.fits_done < state.fits)
    found: list[cylfuse.Detection] = detector.detect(frame) + detector.detect_points([[0.0, 0.0, 1.0]])
    labels: npt.NDArray[np.uint16] = detector.labels
    ends: list[npt.NDArray[np.float64]] = [one.extent.end for one in found if one.extent is not None]
    rows: npt.NDArray[np.float64] = points[detector.indices(0)] * found[0].score
    again: cylfuse.Result = detector.fitter(0).fit()
for outcome in cylfuse.fit_many([functools.partial(load, pathlib.Path("frame.npy"))], threads=4, progress=True):
    if isinstance(outcome, cylfuse.CylfuseError):
        print(outcome.name, outcome.status, outcome.message)
    else:
        print(outcome.row()["radius"], cylfuse.__version__)
        print(outcome.radios)  # type: ignore[attr-defined]
