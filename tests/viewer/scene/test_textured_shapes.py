"""Shapes with a picture on them: closed, of size 1, and the picture upright from outside."""

from __future__ import annotations

import numpy as np
import pytest

from teleopctl.viewer.scene.unit_shapes import TexturedShape, textured_shape


def triangles(shape: TexturedShape) -> tuple[np.ndarray, np.ndarray]:
    """The corners of the triangles that have a size, and where they are in the picture."""
    corners, uv = shape.corners.reshape(-1, 3, 3), shape.uv.reshape(-1, 3, 2)
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    return corners[area > 1e-9], uv[area > 1e-9]


@pytest.mark.parametrize(
    ("name", "volume"), [("box", 1.0), ("cylinder", np.pi / 4), ("sphere", np.pi / 6)]
)
def test_a_shape_is_closed_and_of_size_1_and_looks_outwards(name: str, volume: float):
    shape = textured_shape(name)
    np.testing.assert_allclose(np.ptp(shape.corners, axis=0), [1, 1, 1], atol=5e-3)
    np.testing.assert_allclose(np.linalg.norm(shape.normals, axis=1), 1.0)
    corners, _ = triangles(shape)
    # the sum of the pyramids below all triangles, which is too small where any is turned inwards
    found = np.einsum("ni,ni->n", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert found == pytest.approx(volume, rel=0.02)
    assert (np.einsum("ni,ni->n", shape.corners, shape.normals) > 0).all()


@pytest.mark.parametrize("name", ["box", "cylinder", "sphere"])
def test_no_picture_is_mirrored_and_the_whole_of_it_is_used(name: str):
    corners, uv = triangles(textured_shape(name))
    a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    # Counter-clockwise from outside is clockwise in the picture, whose second axis points down.
    assert (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] <= 1e-12).all()
    assert (uv.min(), uv.max()) == (0.0, 1.0)
    # upright: on what faces the horizon, above is above
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    level = np.abs(normals[:, 2]) < 0.3 * np.linalg.norm(normals, axis=1)
    heights, downs = corners[level][..., 2].ravel(), uv[level][..., 1].ravel()
    assert np.corrcoef(heights, downs)[0, 1] < -0.99
