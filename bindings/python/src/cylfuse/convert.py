"""The visible piece of a cylinder for other libraries, where they are installed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from .result import Result


def _from_z(direction: Any) -> Any:
    """A rotation that takes the z axis to a direction of length 1."""
    across = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    across /= np.linalg.norm(across)
    return np.column_stack([across, np.cross(direction, across), direction])


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
    transform[:3, :3], transform[:3, 3] = _from_z(result.cylinder.direction), extent.center
    return mesh.transform(transform)
