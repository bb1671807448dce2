"""Pictures of a fit with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import StateError
from .geometry import limb_points

if TYPE_CHECKING:
    from .result import Result


def circle(cylinder: Any, centre: Any, count: int = 90) -> Any:
    """Points on the circle of the surface around a point of the axis, shape (count, 3), the first one again last."""
    direction = cylinder.direction
    across = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    across /= np.linalg.norm(across)
    angle = np.linspace(0.0, 2.0 * np.pi, count)[:, None]
    return centre + cylinder.radius * (np.cos(angle) * across + np.sin(angle) * np.cross(direction, across))


def plot(result: Result, image: Any = None, ax: Any = None) -> Any:
    """Draws the limbs, the ends and the axis of a fit in the pixels of its camera, through the distortion of the
    lens.

    :param image: what to draw over, such as the grey image; None = nothing
    :param ax: where to draw; None = new axes
    :returns: the axes
    :raises StateError: the fit had no camera
    """
    import matplotlib.pyplot as plt

    camera = result._source().intrinsics
    if camera is None:
        raise StateError("plotting needs intrinsics; fit with a camera")
    cylinder, extent = result.cylinder, result.extent
    if ax is None:
        _, ax = plt.subplots()
    if image is not None:
        ax.imshow(image, cmap="gray" if np.ndim(image) == 2 else None)

    def line(points: Any, style: str, label: str) -> None:
        # Behind the camera there is no pixel.
        pixels = camera.pixels(points[points[:, 2] > 0.0])
        ax.plot(pixels[:, 0], pixels[:, 1], style, linewidth=1.2, label=label)

    steps = np.linspace(0.0, 1.0, 50)[:, None]
    for number, (start, end) in enumerate(limb_points(cylinder, extent.start, extent.end)):
        line(start + steps * (end - start), "C1-", "limbs" if number == 0 else "_")
    for number, (centre, state) in enumerate(
        [(extent.start, extent.start_state), (extent.end, extent.end_state)]
    ):
        line(circle(cylinder, centre), f"C{2 + number}-", f"{'start' if number == 0 else 'end'}: {state}")
    line(extent.start + steps * (extent.end - extent.start), "C0--", "axis")
    ax.set(xlim=(-0.5, camera.width - 0.5), ylim=(camera.height - 0.5, -0.5), aspect="equal")
    ax.set_title(f"radius {cylinder.radius:.5g} ± {result.radius_deviation:.2g}, length {extent.length:.5g}")
    ax.legend(loc="upper right", fontsize="small")
    return ax
