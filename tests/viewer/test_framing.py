"""A robot fills the picture, whatever its size."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies

from teleopctl.packages import package_share
from teleopctl.robot import RobotDescription, expand_xacro
from teleopctl.tf import Transform, quaternion_from_rpy
from teleopctl.viewer.rviz_file import View
from teleopctl.viewer.scene.assets import load_mesh
from teleopctl.viewer.scene.shapes import mesh_uris
from teleopctl.viewer.scene_view import (
    FollowedFrame,
    SceneView,
    last_camera_pose,
    robot_view,
    round_down,
)


def chain(length):
    """Three links in a row, along x."""
    links = "".join(
        f'<link name="l{i}"><visual><geometry><sphere radius="1e-6"/></geometry></visual></link>'
        for i in range(3)
    )
    joints = "".join(
        f'<joint name="j{i}" type="fixed"><parent link="l{i}"/><child link="l{i + 1}"/>'
        f'<origin xyz="{length / 2} 0 0"/></joint>'
        for i in range(2)
    )
    return RobotDescription.from_urdf(f'<robot name="chain">{links}{joints}</robot>')


@given(strategies.floats(0.1, 100))
def test_the_view_is_as_far_away_as_the_robot_is_large(length):
    view, radius = robot_view(chain(length), {})
    assert view.focus == pytest.approx((length / 2, 0, 0))
    assert radius == pytest.approx(length / 2, rel=1e-3)
    assert math.dist(view.eye, view.focus) == pytest.approx(2.0 * radius, rel=0.05)
    assert view.eye[2] > view.focus[2]


def test_a_robot_without_size_is_seen_too():
    view, radius = robot_view(
        RobotDescription.from_urdf('<robot name="x"><link name="l"/></robot>'), {}
    )
    assert radius > 0
    assert math.dist(view.eye, view.focus) > 0


def test_the_teleop_arm_is_in_the_middle():
    file = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
    description = RobotDescription.from_urdf(expand_xacro(file))
    uris = mesh_uris([v.geometry for link in description.links.values() for v in link.visuals])
    view, radius = robot_view(description, {uri: load_mesh(uri) for uri in uris})
    # It stands on the ground, is about a metre and a half high, and reaches as far forward.
    assert 0.5 < view.focus[2] < 0.9
    assert 0.7 < radius < 1.5


@given(strategies.floats(1e-6, 1e6))
def test_a_round_number_is_the_next_lower_one(number):
    rounded = round_down(number)
    assert rounded <= number * (1 + 1e-6) < 2.5 * rounded * (1 + 1e-6)
    digits = f"{rounded:.6e}"
    assert digits[0] in "125"
    assert float(digits[1:].partition("e")[0]) == 0


def test_of_several_who_look_the_one_who_moved_last_is_the_one_seen_from():
    def camera(stamp: float, place: tuple[float, ...]) -> Any:
        # viser's cameras have z ahead and y down: this one looks along x
        turn = (0.5, -0.5, 0.5, -0.5)
        return SimpleNamespace(update_timestamp=stamp, position=place, wxyz=turn)

    assert last_camera_pose([]) is None
    seen = last_camera_pose([camera(8.0, (1.0, 0.0, 0.0)), camera(7.0, (2.0, 0.0, 0.0))])
    assert seen is not None
    assert seen.translation == (1.0, 0.0, 0.0)
    assert (seen @ Transform((1.0, 0.0, 0.0))).translation == (2.0, 0.0, 0.0)
    assert (seen @ Transform((0.0, 0.0, 1.0))).translation == (1.0, 0.0, 1.0)


class ReportingCamera:
    """Camera of a browser; `report` sets what a slow browser says of it."""

    def __init__(self):
        self.report((4.0, 3.0, 2.0), (1.0, 0.0, 0.0))

    def report(self, position, look_at):
        self.position, self.look_at = np.array(position), np.array(look_at)


def test_a_camera_follows_a_frame_though_the_browser_reports_it_late():
    camera: Any = ReportingCamera()
    followed = FollowedFrame("base")
    late = [(camera.position, camera.look_at)]
    for step in range(50):
        followed.move(camera, (0.1 * step, 0.0, 0.0))
        late.append((camera.position, camera.look_at))
        camera.report(*late[max(0, step - 5)])
    assert late[-1][1] == pytest.approx((5.9, 0.0, 0.0))
    assert late[-1][0] == pytest.approx((8.9, 3.0, 2.0))


def test_a_camera_that_follows_is_turned_and_moved_by_hand(monkeypatch):
    now_s = [100.0]
    monkeypatch.setattr("teleopctl.viewer.scene_view.time.monotonic", lambda: now_s[0])
    camera: Any = ReportingCamera()
    followed = FollowedFrame("base")
    for x in (0.0, 0.1):
        followed.move(camera, (x, 0.0, 0.0))
    # Turned about the point, in motion: it stays turned.
    camera.report((1.1, 5.0, 0.0), (1.1, 0.0, 0.0))
    followed.move(camera, (0.2, 0.0, 0.0))
    assert camera.position == pytest.approx((1.2, 5.0, 0.0))
    # Moved sideways while the frame is at rest: it stays there.
    now_s[0] += 5.0
    camera.report((1.2, 6.0, 0.0), (1.2, 1.0, 0.0))
    followed.move(camera, (0.3, 0.0, 0.0))
    assert camera.look_at == pytest.approx((1.3, 1.0, 0.0))


def test_a_robot_that_has_moved_is_seen_where_it_is_by_its_heading():
    at = Transform((5.0, 0.0, 0.0), quaternion_from_rpy(0.3, 0.0, math.pi / 2))
    frames = SimpleNamespace(by_name={"base": SimpleNamespace(pose=at)})
    scene: Any = SimpleNamespace(_stage=SimpleNamespace(frames=frames))
    view = SceneView._at_robot(scene, View((-2.0, 0.0, 1.0), (0.0, 0.0, 0.5)), "base")
    assert view.eye == pytest.approx((5.0, -2.0, 1.0))
    assert view.focus == pytest.approx((5.0, 0.0, 0.5))
