"""Intersection of a ray with the surface of a robot: triangles of its links, nearest hit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from teleopctl.errors import TeleopctlError
from teleopctl.robot import Box, Capsule, Cylinder, Geometry, RobotDescription, Sphere, read_mesh
from teleopctl.tf import Transform, Vector3, quaternion_from_rpy

if TYPE_CHECKING:
    from teleopctl.viewer.scene.assets import MeshFile

Triangles: TypeAlias = npt.NDArray[np.float64]
"""Corners of triangles in metres, of shape (n, 3, 3): triangle, corner, coordinate."""

_LEAST = 1e-12


def robot_triangles(
    description: RobotDescription, meshes: Mapping[str, MeshFile]
) -> dict[str, Triangles]:
    """Return the triangles of the visual geometry of each link, in the link's frame.

    Meshes that cannot be read are left out. It may take seconds, for another thread.

    Args:
        description: Description of the robot.
        meshes: Loaded meshes of the robot by URI.
    """
    found: dict[str, Triangles] = {}
    for name, link in description.links.items():
        parts = []
        for visual in link.visuals:
            triangles = _triangles_of(visual.geometry, meshes)
            if triangles is not None:
                turn = quaternion_from_rpy(*visual.origin.rpy)
                parts.append(_moved(triangles, Transform(visual.origin.xyz, turn)))
        if parts:
            found[name] = np.concatenate(parts)
    return found


def _triangles_of(geometry: Geometry, meshes: Mapping[str, MeshFile]) -> Triangles | None:
    from trimesh import creation

    # Any: trimesh's meshes.
    made: Any
    if isinstance(geometry, Box):
        made = creation.box(extents=geometry.size)
    elif isinstance(geometry, Cylinder):
        made = creation.cylinder(radius=geometry.radius, height=geometry.length)
    elif isinstance(geometry, Capsule):
        made = creation.capsule(radius=geometry.radius, height=geometry.length)
        made.apply_translation((0.0, 0.0, -made.bounds.mean(axis=0)[2]))
    elif isinstance(geometry, Sphere):
        made = creation.uv_sphere(radius=geometry.radius)
    else:
        file = meshes.get(geometry.uri)
        if file is None:
            return None
        vertices, faces = file.vertices, file.faces
        if vertices is None or faces is None:
            try:
                vertices, faces = read_mesh(file.path).triangles()
            except TeleopctlError:
                return None
        corners = np.asarray(vertices, dtype=float) * np.asarray(geometry.scale)
        return np.asarray(corners[np.asarray(faces)])
    return np.asarray(made.triangles, dtype=float)


def _moved(triangles: Triangles, pose: Transform) -> Triangles:
    ends = (pose @ Transform(axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    origin = np.asarray(pose.translation)
    rotation = np.asarray([end.translation for end in ends]) - origin
    return np.asarray(triangles @ rotation + origin)


def nearest_hit(triangles: Triangles, origin: Vector3, direction: Vector3) -> float | None:
    """Return the distance to the nearest hit, in lengths of the direction; None without a hit.

    The test of Möller and Trumbore (1997), for all triangles at once.

    Args:
        triangles: The triangles.
        origin: Start of the ray.
        direction: Direction of the ray.
    """
    start, along = np.asarray(origin), np.asarray(direction)
    corner = triangles[:, 0]
    one, two = triangles[:, 1] - corner, triangles[:, 2] - corner
    across = np.cross(along, two)
    volume = np.einsum("ij,ij->i", one, across)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = 1.0 / volume
        offset = start - corner
        u = share * np.einsum("ij,ij->i", offset, across)
        other = np.cross(offset, one)
        v = share * (other @ along)
        way = share * np.einsum("ij,ij->i", two, other)
        hits = (np.abs(volume) > _LEAST) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (way > 0.0)
    return float(way[hits].min()) if hits.any() else None
