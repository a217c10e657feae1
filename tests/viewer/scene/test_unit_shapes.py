"""Shapes that are drawn many at a time: closed, of size 1, and rounder where there are few."""

import math

import numpy as np
import pytest
import trimesh

from teleopctl.tf import Transform
from teleopctl.viewer.scene.canvas import Canvas
from teleopctl.viewer.scene.drawing import RED, Drawing
from teleopctl.viewer.scene.unit_shapes import unit_shape
from teleopctl.viewer.scene_view import SceneView
from tests.viewer.conftest import FakePage

VOLUMES = {
    "box": 1.0,
    "sphere": math.pi / 6,
    "cylinder": math.pi / 4,
    "cone": math.pi / 12,
}


@pytest.mark.parametrize(("fine", "tolerance"), [(False, 0.05), (True, 0.01)])
@pytest.mark.parametrize(("name", "volume"), VOLUMES.items())
def test_a_unit_shape_is_closed_and_has_its_volume_around_the_origin(
    name: str, volume: float, fine: bool, tolerance: float
) -> None:
    corners, faces = unit_shape(name, fine=fine)
    mesh = trimesh.Trimesh(corners, faces, process=False)
    mesh.merge_vertices()
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(volume, rel=tolerance), "faces look outwards"
    assert np.allclose(mesh.bounds, [[-0.5] * 3, [0.5] * 3], atol=0.01)


def test_a_few_spheres_are_rounder_than_thousands(page: FakePage) -> None:
    canvas = Canvas(page.scene, "/it")

    def corners(count: int) -> int:
        drawing = Drawing()
        for number in range(count):
            drawing.solid("sphere", Transform((number, 0.0, 0.0)), (1.0, 1.0, 1.0), RED)
        canvas.show(drawing)
        return len(canvas.nodes["sphere"].vertices)

    few, many = corners(3), corners(3000)
    assert many < few / 4
    assert few == corners(1)


def test_the_picture_has_lights_of_its_own_from_the_side(page: FakePage) -> None:
    SceneView(page.server, page)
    lights = [page.scene.get_handle_by_name(f"/light{number}") for number in range(2)]
    assert all(light is not None for light in lights)
    for light in lights:
        x, y, z = light.position  # type: ignore[union-attr]
        assert math.hypot(x, y) > 0.8 * z > 0.0
