"""What stands around a robot is read from a file, whose mistakes are told with their place."""

import re

import pytest

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot import read_world

CUBE = """<robot name="w">
  <link name="world"/>
  <link name="cube"/>
  <joint name="free" type="floating">
    <parent link="world"/><child link="cube"/>
  </joint>
</robot>"""


BAD_BOX = """<link name="cube"><visual><geometry>
<box size="1 -1 1"/></geometry></visual></link>"""


def links(file):
    description = read_world(file).description
    assert description is not None
    return list(description.links)


def test_a_urdf_is_read(tmp_path):
    file = tmp_path / "cube.urdf"
    file.write_text(CUBE)
    assert read_world(file).path == file
    assert links(file) == ["world", "cube"]


def test_a_xacro_file_is_expanded(tmp_path):
    file = tmp_path / "cube.xacro"
    head = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"'
    named = '<xacro:property name="thing" value="box"/><link name="${thing}"/>'
    text = CUBE.replace("<robot", head).replace('<link name="cube"/>', named)
    file.write_text(text.replace('"cube"', '"${thing}"'))
    assert links(file) == ["world", "box"]


def test_a_scene_of_mujocos_is_left_to_mujoco(tmp_path):
    file = tmp_path / "scene.xml"
    file.write_text('<!-- a -- scene --><mujoco model="scene"><worldbody/></mujoco>')
    assert read_world(file).description is None


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "{file}:1: invalid XML: "),
        (b"<robot>\n<link>\n</robot>", "{file}:3: invalid XML: "),
        (b"\n<house/>", "{file}:2: <house> is no world"),
        (b'<robot name="\xff"/>', "{file}:1: invalid XML: "),
        (b'<?xml version="1.0" encoding="latin1"?><robot name="\xff"/>', "{file} is not text in"),
        (b"<robot/>", "{file}: No link elements found in urdf file"),
        (
            CUBE.replace("</joint>", '<origin xyz="inf 0 0"/></joint>').encode(),
            "{file}: <origin> (line 6): attribute 'xyz' should be finite, got 'inf 0 0'",
        ),
        (
            CUBE.replace('<link name="cube"/>', BAD_BOX).encode(),
            '{file}:4: size="1 -1 1" is no size',
        ),
        (
            CUBE.replace('name="world"', 'name="w"').replace('"world"', '"w"').encode(),
            "{file}:4: joint 'free' is floating but starts at link 'w'",
        ),
    ],
)
def test_a_mistake_is_told_with_file_and_line(tmp_path, content, message):
    file = tmp_path / "world.urdf"
    file.write_bytes(content)
    with pytest.raises(InvalidDescriptionError, match="^" + re.escape(message.format(file=file))):
        read_world(file)


def test_a_file_that_is_not_there_is_told(tmp_path):
    file = tmp_path / "none.urdf"
    with pytest.raises(InvalidDescriptionError, match=f"^Cannot read {file}: No such file"):
        read_world(file)
    with pytest.raises(InvalidDescriptionError, match=f"^Cannot read {tmp_path}: Is a directory"):
        read_world(tmp_path)


def test_a_world_reads_no_other_file_through_entities(tmp_path):
    (tmp_path / "secret").write_text("secret")
    file = tmp_path / "world.urdf"
    file.write_text(
        f'<!DOCTYPE robot [<!ENTITY e SYSTEM "{tmp_path}/secret">]>'
        '<robot name="w"><link name="a"/>&e;</robot>'
    )
    assert links(file) == ["a"]
