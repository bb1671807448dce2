"""Pictures of a fit with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from ._arrays import Array, Floats
from .errors import StateError
from .geometry import Cylinder, across, limb_points

if TYPE_CHECKING:
    from .result import Result


def circle(cylinder: Cylinder, centre: Floats, count: int = 90) -> Any:
    """Points on the circle of the surface around a point of the axis, shape (count, 3), the first one again last."""
    angle = np.linspace(0.0, 2.0 * np.pi, count)
    return centre + cylinder.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1) @ across(cylinder.direction)


def plot(result: Result, image: Optional[Array] = None, ax: Any = None) -> Any:
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

    def line(points: Floats, style: str, label: str) -> None:
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
