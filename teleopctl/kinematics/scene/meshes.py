"""Meshes as convex pieces, which MuJoCo collides: hulls, or a thin prism for each triangle."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.errors import UsageError
from teleopctl.kinematics.poses import Array

Indices = npt.NDArray[np.intp]

MOST_PRISMS = 256
"""Most triangles of a mesh that collides as its surface; one with more collides as its hull."""
# Half the thickness of a prism, m.
_HALF_M = 5e-4
# Most vertices of a hull: of a sphere, this many lie within 0.2 % of the radius.
_MOST_HULL_VERTICES = 1000
# Most vertices from which a hull is computed; of more, those that are the farthest in so many
# directions are taken.
_MOST_VERTICES, _DIRECTIONS = 20_000, 2000
# Deviation from a convex shape, as part of the mesh's size, that is due to rounding.
_ROUNDING = 1e-4
# A mesh whose hull has more than this multiple of its volume is reported.
_HOLLOW = 1.05
# Triangles smaller than this (m²) have no direction.
_LEAST_AREA_M2 = 1e-14


def convex_pieces(vertices: Array, triangles: Indices) -> tuple[list[Array], str]:
    """Return convex pieces of a mesh.

    A closed convex mesh is one piece. Of another one with at most 256 triangles, each triangle is
    a prism of 1 mm thickness, so that what is hollow stays hollow; with more triangles it is its
    convex hull.

    Args:
        vertices: Vertices, (n, 3), m.
        triangles: Numbers of the vertices of each triangle, (m, 3).

    Returns:
        The vertices of each piece, (k, 3), m, and a warning; empty if the pieces fit the mesh.

    Raises:
        UsageError: The mesh has no triangle with an area, or its numbers are no mesh.
    """
    _check(vertices, triangles)
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(normals, axis=1)
    has_area = areas > _LEAST_AREA_M2
    if not has_area.any():
        raise UsageError("The mesh has no triangle with an area")
    corners, normals = corners[has_area], normals[has_area] / (2.0 * areas[has_area, None])
    if len(triangles) <= MOST_PRISMS:
        if _is_closed(vertices, triangles) and _is_convex(vertices, corners, normals):
            return [_hull(vertices)[0]], ""
        return [
            np.concatenate((three + _HALF_M * normal, three - _HALF_M * normal))
            for three, normal in zip(corners, normals, strict=True)
        ], ""
    hull, hull_volume = _hull(vertices)
    volume = (
        abs(
            float(
                np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()
            )
        )
        / 6.0
    )
    if hull_volume <= _HOLLOW * volume and (
        len(triangles) > _MOST_VERTICES or _is_closed(vertices, triangles)
    ):
        return [hull], ""
    return [hull], (
        f"it has {len(triangles)} triangles, more than {MOST_PRISMS}, and collides as its convex "
        "hull, without its hollows"
    )


def _check(vertices: Array, triangles: Indices) -> None:
    if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) < 3:
        raise UsageError(f"The mesh has {len(vertices)} vertices, fewer than 3")
    if not np.isfinite(vertices).all():
        raise UsageError("The mesh has a vertex that is not finite")
    if triangles.ndim != 2 or triangles.shape[1] != 3 or not len(triangles):
        raise UsageError("The mesh has no triangles")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise UsageError(
            f"The mesh has {len(vertices)} vertices, and a triangle with vertex "
            f"{int(triangles.max())}"
        )


def _is_closed(vertices: Array, triangles: Indices) -> bool:
    """Return whether each edge belongs to two triangles, with equal vertices as one."""
    size = float(np.ptp(vertices, axis=0).max()) or 1.0
    places = np.round(vertices / (1e-6 * size)).astype(np.int64)
    same = np.unique(places, axis=0, return_inverse=True)[1].ravel()
    edges = np.sort(same[triangles[:, [0, 1, 1, 2, 2, 0]]].reshape(-1, 2), axis=1)
    edges = edges[edges[:, 0] != edges[:, 1]]
    _, counts = np.unique(edges, axis=0, return_counts=True)
    return bool((counts % 2 == 0).all())


def _is_convex(vertices: Array, corners: Array, normals: Array) -> bool:
    """Return whether all vertices lie on one side of each triangle."""
    size = float(np.ptp(vertices, axis=0).max())
    heights = vertices @ normals.T - np.einsum("ij,ij->i", corners[:, 0], normals)
    above, below = heights.max(axis=0), -heights.min(axis=0)
    return bool((np.minimum(above, below) <= _ROUNDING * size).all())


def _hull(vertices: Array) -> tuple[Array, float]:
    """Return the vertices of a convex hull, (k, 3), and its volume, m³."""
    if len(vertices) > _MOST_VERTICES:
        vertices = vertices[_farthest(vertices)]
    size = float(np.ptp(vertices, axis=0).max())
    centre = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    try:
        model = _compiled((vertices - centre) / size)
    except ValueError:
        # Flat: as thick as a prism.
        thin = np.linalg.svd(vertices - vertices.mean(axis=0), full_matrices=False)[2][2]
        vertices = np.concatenate((vertices + _HALF_M * thin, vertices - _HALF_M * thin))
        try:
            model = _compiled((vertices - centre) / size)
        except ValueError as error:
            raise UsageError(
                f"The mesh has no convex hull: {' '.join(str(error).split())}"
            ) from error
    count = int(model.mesh_graph[0])
    numbers = model.mesh_graph[2 + count : 2 + 2 * count]
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[0])
    # MuJoCo keeps meshes in the frame of their inertia.
    own = model.mesh_vert[numbers] @ turn.reshape(3, 3).T + model.mesh_pos[0]
    volume = float(model.body_mass[1]) * size**3
    if count >= _MOST_HULL_VERTICES:
        # Vertices were left out: the rest is enlarged to enclose them.
        centred = (vertices - centre) / size
        directions = _directions()
        own *= float(np.max((centred @ directions).max(axis=0) / (own @ directions).max(axis=0)))
    return np.asarray(own * size + centre, np.float64), volume


# Any: MuJoCo's model, which has no types.
def _compiled(vertices: Array) -> Any:
    spec = mujoco.MjSpec()
    mesh = spec.add_mesh(name="mesh", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX)
    mesh.uservert = vertices.ravel().tolist()
    mesh.maxhullvert = _MOST_HULL_VERTICES
    body = spec.worldbody.add_body()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh", density=1.0)
    return spec.compile()


def _directions() -> Array:
    """Return unit vectors that are evenly spread, (3, d): Fibonacci's lattice on the sphere."""
    place = np.arange(_DIRECTIONS) + 0.5
    polar, turn = np.arccos(1.0 - 2.0 * place / _DIRECTIONS), np.pi * (1.0 + 5.0**0.5) * place
    sine = np.sin(polar)
    return np.stack((np.cos(turn) * sine, np.sin(turn) * sine, np.cos(polar)))


def _farthest(vertices: Array) -> Indices:
    """Return the indices of the farthest vertices in evenly spread directions."""
    directions = _directions().T.astype(np.float32)
    best = np.full(_DIRECTIONS, -np.inf, np.float32)
    which = np.zeros(_DIRECTIONS, dtype=np.intp)
    for first in range(0, len(vertices), _MOST_VERTICES):
        part = vertices[first : first + _MOST_VERTICES].astype(np.float32)
        # Rows lie together in memory, which makes the search five times as fast.
        reach = directions @ part.T
        found = reach.argmax(axis=1)
        height = reach[np.arange(_DIRECTIONS), found]
        nearer = height > best
        best[nearer], which[nearer] = height[nearer], first + found[nearer]
    return np.unique(which)
