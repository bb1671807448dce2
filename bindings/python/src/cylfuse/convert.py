"""The visible piece of a cylinder for other libraries, where they are installed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .geometry import across

if TYPE_CHECKING:
    from .result import Result


def to_trimesh(result: Result) -> Any:
    """A closed ``trimesh.Trimesh`` between the ends, in the camera frame."""
    import trimesh

    extent = result.extent
    return trimesh.creation.cylinder(radius=result.cylinder.radius, segment=np.stack([extent.start, extent.end]))


def to_open3d(result: Result) -> Any:
    """A closed ``open3d.geometry.TriangleMesh`` between the ends, in the camera frame. Completed points go into
    ``open3d.geometry.PointCloud(open3d.utility.Vector3dVector(result.complete()))``."""
    import open3d

    extent = result.extent
    mesh = open3d.geometry.TriangleMesh.create_cylinder(result.cylinder.radius, extent.length)
    transform = np.eye(4)
    transform[:3, :2], transform[:3, 2] = across(result.cylinder.direction).T, result.cylinder.direction
    transform[:3, 3] = extent.center
    return mesh.transform(transform)
