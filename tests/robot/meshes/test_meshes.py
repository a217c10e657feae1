"""The mesh files are sound solids of the sizes that the links have."""

import numpy as np
import pytest
import trimesh

from teleopctl.packages import resolve_uri
from tests.robot.independent import pose_matrix


def in_link(teleop, link):
    (visual,) = teleop.links[link].visuals
    mesh = trimesh.load(resolve_uri(visual.geometry.uri))
    mesh.apply_transform(np.diag([*visual.geometry.scale, 1.0]))
    mesh.apply_transform(pose_matrix(visual.origin))
    return mesh


@pytest.mark.parametrize(
    ("link", "low", "high"),
    [
        ("base_link", (-0.5, -0.5, 0.0), (0.5, 0.5, 0.31)),
        ("base_plate", (-0.39, -0.39, 0.0), (0.39, 0.39, 0.45)),
        ("forward_drive_arm", (-0.2, -0.1, -0.1), (0.2, 0.1, 0.9)),
        ("horizontal_arm", (-0.25, -0.25, -0.1), (0.0, 0.82, 0.1)),
        ("claw_support", (-0.28, -0.05, -0.2), (0.02, 0.25, 0.1)),
        ("gripper_right", (-0.1, -0.1, -0.05), (0.12, 0.51, 0.05)),
        ("gripper_left", (-0.12, -0.1, -0.05), (0.1, 0.51, 0.05)),
        ("rgb_camera", (-0.06, -0.06, -0.06), (0.0, 0.06, 0.06)),
    ],
)
def test_a_mesh_fills_the_place_of_its_link(teleop, link, low, high):
    mesh = in_link(teleop, link)
    assert mesh.is_watertight
    assert mesh.volume > 0
    found_low, found_high = mesh.bounds
    assert (found_low >= np.array(low) - 1e-4).all(), found_low
    assert (found_high <= np.array(high) + 1e-4).all(), found_high
    # and it is no speck in it
    assert (mesh.extents > 0.4 * (np.array(high) - low)).all(), mesh.extents


def test_the_closed_fingers_nearly_meet(teleop):
    right, left = in_link(teleop, "gripper_right"), in_link(teleop, "gripper_left")
    tip = np.array([0.0, 0.45, 0.0])
    inner = [m.vertices[m.vertices[:, 1] > tip[1]][:, 0] for m in (right, left)]
    axes = 0.18
    gap = (axes + inner[0].min()) - inner[1].max()
    assert 0.0 < gap < 0.01


def test_files_are_binary_stl(teleop):
    for link in teleop.links.values():
        for visual in link.visuals:
            data = resolve_uri(visual.geometry.uri).read_bytes()
            triangles = int.from_bytes(data[80:84], "little")
            assert len(data) == 84 + 50 * triangles
