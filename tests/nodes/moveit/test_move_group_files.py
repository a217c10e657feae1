"""Objects of a planning scene in files of MoveIt's format, and the URDF of a group."""

import numpy as np
import pytest
from lxml import etree

from teleopctl.errors import InvalidFileError
from teleopctl.kinematics import (
    CollisionBody,
    CollisionScene,
    CollisionShape,
    KinematicModel,
    ShapeKind,
    find_groups,
)
from teleopctl.nodes.moveit.move_group.file_services import group_urdf
from teleopctl.nodes.moveit.move_group.scene_files import read_scene, write_scene
from teleopctl.robot import RobotDescription
from tests.kinematics.arms import THREE, arm_urdf

# As MoveIt writes it.
TEXT = """(noname)
* table
0.5 0 0.25
0 0 0 1
2
box
1 0.8 0.05
0 0 0.2
0 0 0 1
0.1 0.2 0.3 1
cylinder
0.1 0.4
0 0 0
0 0 0 1
0.1 0.2 0.3 1
1
corner
0.5 0.4 0
0 0 0 1
* pyramid
0 0 0
0 0 0 1
1
mesh
4 4
0 0 0
1 0 0
0 1 0
0 0 0.5
0 2 1
0 1 3
1 2 3
2 0 3
0 0 0
0 0 0 1
0 0 0 0
0
.
"""


@pytest.fixture(scope="module")
def scene() -> CollisionScene:
    return CollisionScene(KinematicModel(RobotDescription.from_urdf(arm_urdf(THREE))))


def test_objects_are_written_as_moveit_does_and_read_again(scene, tmp_path):
    file = tmp_path / "a.scene"
    file.write_text(TEXT)
    name, objects = read_scene(file)
    assert name == "(noname)"
    (table, color), (pyramid, none) = objects
    assert [shape.kind for shape in table.shapes] == [ShapeKind.BOX, ShapeKind.CYLINDER]
    # In messages the height comes first.
    assert table.shapes[1].dimensions == (0.4, 0.1)
    assert table.pose[:3, 3].tolist() == [0.5, 0.0, 0.25]
    assert (list(table.subframes), color, none) == (["corner"], (0.1, 0.2, 0.3, 1.0), None)
    assert pyramid.shapes[0].vertices is not None
    for one in (table, pyramid):
        scene.add(one)
    scene.colors["table"] = (0.1, 0.2, 0.3, 1.0)
    assert write_scene(scene) == TEXT


def test_files_of_older_versions_have_no_pose_and_no_subframes(tmp_path):
    file = tmp_path / "old.scene"
    file.write_text("old\n* a box\n1\nbox\n1 2 3\n0 0 1\n0 0 0 1\n0 0 0 0\n.\n")
    name, (found,) = read_scene(file)
    assert (name, found[0].name) == ("old", "a box")
    assert (found[0].pose == np.eye(4)).all()


@pytest.mark.parametrize(
    ("before", "after", "sentence"),
    [
        (
            "1 0.8 0.05",
            "1 0.8",
            r":8: The z of a box must be above 0 m, got 0",
        ),
        ("box", "brick", r":6: 'brick' is no shape: the shapes are box, sphere"),
        ("1 0.8 0.05", "1 -0.8 0.05", r":7: The .* of a box must be above 0 m, got -0.8"),
        ("1 0.8 0.05", "1 nan 0.05", r":7: Expected a finite number .* of a box, got 'nan'"),
        ("0 0 0 1\n2", "0 0 0 0\n2", r":4: The quaternion of the pose of 'table' is zero"),
        ("2\nbox", "-2\nbox", r":5: Expected the number of shapes of 'table', got '-2'"),
        ("0\n.\n", "0\n", r"The file ends where '\*' before an object"),
        ("4 4", "4 999999999", r"The file ends|Expected a finite number"),
    ],
)
def test_a_file_of_another_format_is_refused_with_its_line(tmp_path, before, after, sentence):
    file = tmp_path / "bad.scene"
    file.write_text(TEXT.replace(before, after, 1))
    with pytest.raises(InvalidFileError, match=sentence):
        read_scene(file)
    with pytest.raises(InvalidFileError, match="cannot be read"):
        read_scene(tmp_path / "none.scene")


def test_the_urdf_of_a_group_has_its_links_joints_and_the_link_that_carries_them():
    urdf = arm_urdf(THREE)
    description = RobotDescription.from_urdf(urdf)
    made = group_urdf(urdf, description, find_groups(description).group())
    assert made.startswith('<?xml version="1.0" ?><robot name="arm">')
    again = RobotDescription.from_urdf(made)
    assert again.root == description.root
    assert {*again.links} == {"base", "link_1", "link_2", "link_3", "tool0"}
    root = etree.fromstring(made.encode())
    names = [element.get("name") for element in root.findall("joint")]
    assert names == sorted(names)


def test_a_box_of_a_scene_is_written_shortly(scene):
    box = CollisionShape.primitive(ShapeKind.BOX, (0.1, 1.0, 1e-3))
    scene.clear()
    scene.add(CollisionBody("box", np.eye(4), (box,), (np.eye(4),)))
    assert "\nbox\n0.1 1 0.001\n0 0 0\n0 0 0 1\n" in write_scene(scene)
