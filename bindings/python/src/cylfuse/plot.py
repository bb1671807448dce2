"""Pictures of a fit with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from ._arrays import Array, Floats
from .errors import EdgeGeometryError, StateError
from .geometry import Cylinder, Intrinsics, Pose, across

if TYPE_CHECKING:
    from .result import Result


def circle(cylinder: Cylinder, centre: Floats, count: int = 90) -> Any:
    """Points on the circle of the surface around a point of the axis, shape (count, 3), the first one again last."""
    angle = np.linspace(0.0, 2.0 * np.pi, count)
    return centre + cylinder.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1) @ across(cylinder.direction)


def limb_points(cylinder: Cylinder, points: Floats, camera: Intrinsics) -> list[Floats]:
    """Points of the axis moved to either limb in the frame of the camera. Empty from inside the cylinder."""
    try:
        lines = cylinder.project(camera)
    except EdgeGeometryError:
        return []
    # The plane through a limb line and the camera touches the surface along the limb.
    a, b, c = lines.T
    normals = np.stack([a * camera.fx, b * camera.fy, a * camera.cx + b * camera.cy + c], axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return [points - np.outer(points @ normal, normal) for normal in normals]


def plot(result: Result, image: Optional[Array] = None, ax: Any = None, view: int = 0) -> Any:
    """Draws the limbs, the ends and the axis of a fit in the pixels of a camera, through the distortion of the lens.

    :param image: what to draw over, such as the image of the view; None = nothing
    :param ax: where to draw; None = new axes
    :param view: the view in whose pixels
    :returns: the axes
    :raises StateError: the view had no camera
    """
    import matplotlib.pyplot as plt

    camera, pose = result.views[view] if view < len(result.views) else (None, Pose())
    if camera is None:
        raise StateError("plotting needs intrinsics; fit with a camera")
    into_view, extent = pose.inverse(), result.extent
    cylinder = into_view.cylinder(result.cylinder)
    ends = into_view.points(np.stack([extent.start, extent.end]))
    if ax is None:
        _, ax = plt.subplots()
    if image is not None:
        ax.imshow(image, cmap="gray" if np.ndim(image) == 2 else None)

    def line(points: Floats, style: str, label: str) -> None:
        # What the camera does not see is NaN, which leaves a gap.
        pixels = camera.project(points)
        ax.plot(pixels[:, 0], pixels[:, 1], style, linewidth=1.2, label=label)

    axis = ends[0] + np.linspace(0.0, 1.0, 50)[:, None] * (ends[1] - ends[0])
    for number, points in enumerate(limb_points(cylinder, axis, camera)):
        line(points, "C1-", "limbs" if number == 0 else "_")
    for number, (centre, state) in enumerate(zip(ends, [extent.start_state, extent.end_state])):
        line(circle(cylinder, centre), f"C{2 + number}-", f"{'start' if number == 0 else 'end'}: {state}")
    line(axis, "C0--", "axis")
    ax.set(xlim=(-0.5, camera.width - 0.5), ylim=(camera.height - 0.5, -0.5), aspect="equal")
    ax.set_title(f"radius {cylinder.radius:.5g} ± {result.radius_deviation:.2g}, length {extent.length:.5g}")
    ax.legend(loc="upper right", fontsize="small")
    return ax
