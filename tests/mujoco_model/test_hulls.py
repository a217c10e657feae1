"""How hollow a mesh is: what touches in its place, also in an installation without scipy."""

import math
from pathlib import Path

import pytest
import trimesh

from teleopctl.mujoco_model.convex import measure_hull, surface_slabs


@pytest.fixture(autouse=True)
def no_scipy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("trimesh.convex.ConvexHull", None)


@pytest.mark.parametrize("size_m", [0.02, 1.0, 100.0])
def test_a_hull_has_its_volume_at_any_size(tmp_path: Path, size_m: float) -> None:
    file = tmp_path / "torus.stl"
    trimesh.creation.torus(size_m, size_m / 10.0).export(file)
    # The hull is a disc as thick as the ring, and the outer half of that; by Pappus.
    radius = size_m / 10.0
    ring = 2.0 * math.pi**2 * size_m * radius**2
    disc = 2.0 * math.pi * size_m**2 * radius
    edge = math.pi * radius**2 / 2.0 * math.tau * (size_m + 4.0 * radius / (3.0 * math.pi))
    assert measure_hull(file).ratio == pytest.approx((disc + edge) / ring, rel=0.02)


def test_walls_around_a_room_are_not_filled(tmp_path: Path) -> None:
    file = tmp_path / "walls.stl"
    trimesh.creation.annulus(4.0, 4.2, 1.0, sections=12).export(file)
    assert len(surface_slabs(file, (1.0, 1.0, 1.0))) > 12


def test_what_is_flat_has_no_hull_to_speak_of(tmp_path: Path) -> None:
    file = tmp_path / "sheet.stl"
    sheet = trimesh.creation.box((1.0, 1.0, 1.0))
    sheet.vertices[:, 2] *= 1e-9
    sheet.export(file)
    assert measure_hull(file).ratio == 1.0
