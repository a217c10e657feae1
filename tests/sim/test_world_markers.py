"""What the world looks like, as RViz is told."""

import math
from pathlib import Path
from typing import Any

import pytest
import trimesh

from teleopctl.mujoco_model import build_model
from teleopctl.robot import read_world
from teleopctl.sim.world_markers import world_markers
from tests.sim.robots import box, link, robot

SCENE = """<mujoco>
  <asset><material name="red" rgba="1 0 0 1"/><mesh name="b" file="b.stl"/></asset>
  <worldbody>
    <geom type="plane" size="0 0 1"/>
    <body name="post" pos="1 0 0"><body pos="0 0 1" euler="0 0 90">
      <geom type="ellipsoid" pos="0.5 0 0" size="0.1 0.2 0.3" rgba="0 1 0 0.5"/></body></body>
    <body name="can" pos="5 5 5" euler="90 0 0"><freejoint/>
      <geom type="capsule" size="0.1 0.2" material="red"/>
      <geom type="box" size="1 1 1" group="3"/></body>
    <body name="rock" pos="9 9 9"><freejoint/><geom type="mesh" mesh="b" pos="1 0 0"/></body>
  </worldbody>
</mujoco>"""


def markers(tmp_path: Path, root: str = "base") -> list[Any]:
    trimesh.creation.box((0.2, 0.4, 0.6)).export(tmp_path / "b.stl")
    file = tmp_path / "scene.xml"
    file.write_text(SCENE)
    arm = robot(link(root, box("visual", "1 1 1")))
    return world_markers(build_model(arm, world=read_world(file), fixed_base=True))


def values(place: Any, names: str = "xyz") -> list[float]:
    return [getattr(place, name) for name in names]


def test_every_shape_but_ground_robot_and_hidden_ones_is_there(tmp_path: Path) -> None:
    shown = markers(tmp_path)
    assert [marker.ns for marker in shown] == ["object1", "can", "can", "can", "rock"]
    assert [marker.id for marker in shown] == [0, 1, 2, 3, 4]
    kind = type(shown[0])
    assert [marker.type for marker in shown] == [
        kind.SPHERE, kind.CYLINDER, kind.SPHERE, kind.SPHERE, kind.TRIANGLE_LIST,
    ]  # fmt: skip


def test_what_stands_still_is_in_the_robots_root_and_what_moves_in_its_own_frame(
    tmp_path: Path,
) -> None:
    still, can, *_ = markers(tmp_path, "plinth")
    assert (still.header.frame_id, can.header.frame_id) == ("plinth", "can")
    assert still.frame_locked
    assert can.frame_locked
    assert values(still.pose.position) == pytest.approx([1.0, 0.5, 1.0])
    assert values(still.pose.orientation, "wz") == pytest.approx([math.sqrt(0.5)] * 2)
    assert values(can.pose.position) == pytest.approx([0.0, 0.0, 0.0])
    assert values(can.pose.orientation, "wxyz") == pytest.approx([1.0, 0.0, 0.0, 0.0])


def test_shapes_have_their_sizes_and_colours(tmp_path: Path) -> None:
    still, can, tip, other_tip, _ = markers(tmp_path)
    assert values(still.scale) == pytest.approx([0.2, 0.4, 0.6])
    assert values(still.color, "rgba") == pytest.approx([0.0, 1.0, 0.0, 0.5])
    assert values(can.scale) == pytest.approx([0.2, 0.2, 0.4])
    assert values(can.color, "rgba") == [1.0, 0.0, 0.0, 1.0]
    assert sorted([tip.pose.position.z, other_tip.pose.position.z]) == pytest.approx([-0.2, 0.2])


def test_a_mesh_is_its_triangles(tmp_path: Path) -> None:
    rock = markers(tmp_path)[-1]
    assert len(rock.points) == 12 * 3
    # MuJoCo turns a mesh to its principal axes.
    corner = math.dist(values(rock.points[0]), (0.0, 0.0, 0.0))
    assert corner == pytest.approx(math.dist((0.1, 0.2, 0.3), (0.0, 0.0, 0.0)))
    assert values(rock.pose.position) == pytest.approx([1.0, 0.0, 0.0])
    assert {round(part, 5) for part in values(rock.scale)} == {1.0}
