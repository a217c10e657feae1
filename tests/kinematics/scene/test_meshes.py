"""Meshes of objects as convex pieces: what is hollow stays hollow as far as that goes."""

import numpy as np
import pytest

from teleopctl.errors import UsageError
from teleopctl.kinematics import CollisionBody, CollisionScene, CollisionShape, KinematicModel

from ..arms import SIX, arm

CUBE = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float) * 0.05
FACES = np.array(
    [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]
)  # fmt: skip
# Without its bottom.
OPEN = np.delete(FACES, (8, 9), axis=0)


@pytest.fixture(scope="module")
def model() -> KinematicModel:
    return arm(SIX).model


def globe(rings: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a sphere of 0.1 m with 2 * rings * rings triangles."""
    polar = np.linspace(0.0, np.pi, rings + 1)
    turn = np.linspace(0.0, 2.0 * np.pi, rings, endpoint=False)
    p, t = np.meshgrid(polar, turn, indexing="ij")
    points = 0.1 * np.stack((np.sin(p) * np.cos(t), np.sin(p) * np.sin(t), np.cos(p)), axis=-1)
    at = np.arange((rings + 1) * rings).reshape(rings + 1, rings)
    right = np.roll(at, -1, axis=1)
    first = np.stack((at[:-1], at[1:], right[1:]), axis=-1).reshape(-1, 3)
    second = np.stack((at[:-1], right[1:], right[:-1]), axis=-1).reshape(-1, 3)
    return points.reshape(-1, 3), np.concatenate((first, second))


def nearest_m(model: KinematicModel, shape: CollisionShape, *at: float) -> float:
    scene = CollisionScene(model)
    pose = np.eye(4)
    pose[:3, 3] = at
    scene.add(CollisionBody("it", pose, (shape,), (np.eye(4),)))
    near = scene.compiled().clearance.near(2.0)
    return min(one.distance_m for one in near if "it" in one.bodies)


def test_a_closed_convex_mesh_is_one_piece_with_its_size(model):
    shape = CollisionShape.mesh(CUBE, FACES)
    assert len(shape.pieces) == 1
    assert not shape.warning
    assert nearest_m(model, shape, 0.3, 0.0, 0.9) == pytest.approx(0.3 - 0.05 - 0.03, abs=1e-5)


def test_a_box_without_a_bottom_is_hollow(model):
    shape = CollisionShape.mesh(10.0 * CUBE, OPEN)
    # The arm stands in a box of 1 m, whose roof is 0.21 m above it.
    assert nearest_m(model, shape, 0.0, 0.0, 0.9) == pytest.approx(0.21, abs=2e-3)
    assert nearest_m(model, CollisionShape.mesh(10.0 * CUBE, FACES), 0.0, 0.0, 0.9) < 0.0


def test_a_flat_mesh_is_an_obstacle(model):
    square = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], float)
    shape = CollisionShape.mesh(square, np.array([(0, 1, 2), (0, 2, 3)]))
    assert nearest_m(model, shape, 0.0, 0.0, 1.5) == pytest.approx(0.3 + 0.01, abs=2e-3)


def test_a_mesh_with_many_triangles_is_its_hull(model):
    vertices, triangles = globe(160)
    assert len(triangles) > 50_000
    hollow = triangles[: len(triangles) // 2]
    shape = CollisionShape.mesh(vertices, hollow)
    assert "more than 256, and collides as its convex hull" in shape.warning
    assert len(shape.pieces[0]) <= 1000
    closed = CollisionShape.mesh(vertices, triangles)
    assert not closed.warning
    assert nearest_m(model, closed, 0.3, 0.0, 0.9) == pytest.approx(0.3 - 0.1 - 0.03, abs=1e-3)


@pytest.mark.parametrize(
    ("vertices", "triangles", "problem"),
    [
        (CUBE[:2], FACES, "2 vertices, fewer than 3"),
        (np.full((3, 3), np.nan), [(0, 1, 2)], "not finite"),
        (CUBE, [(0, 1, 8)], "8 vertices, and a triangle with vertex 8"),
        (CUBE, np.zeros((0, 3), int), "no triangles"),
        (CUBE, [(0, 0, 1)], "no triangle with an area"),
    ],
)
def test_what_is_no_mesh_is_refused(vertices, triangles, problem):
    with pytest.raises(UsageError, match=problem):
        CollisionShape.mesh(vertices, np.array(triangles))
