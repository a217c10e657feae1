"""Comparison of a description as we read it with what yourdfpy reads, for ``robot check``."""

import dataclasses
from pathlib import Path

import pytest
import trimesh

from teleopctl.cli import main
from teleopctl.nodes.robot_check.report import check_robot
from teleopctl.nodes.robot_check.second_reading import read_again
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.urdf import Box, Joint, Limit, Mimic, Pose, Visual
from tests.robot.test_kinematics import ODD_ROBOT
from tests.sim.robots import box, joint, link, robot


def sentences(description: RobotDescription) -> list[str]:
    read = read_again(description)
    assert not read.error
    return [difference.sentence for difference in read.differences]


def visual(shape: str) -> str:
    return f"<visual><geometry>{shape}</geometry></visual>"


def test_every_kind_of_joint_and_shape_is_read_alike() -> None:
    read = read_again(RobotDescription.from_urdf(ODD_ROBOT))
    assert read.summary == "yourdfpy reads the same tree, limits, shapes and poses"
    shapes = ('<box size="1 2 3"/>', '<sphere radius="1"/>', '<cylinder radius="1" length="2"/>')
    assert sentences(robot(link("base", "".join(map(visual, shapes))))) == []


def test_what_yourdfpy_does_not_support_is_no_difference() -> None:
    """A capsule, a mimic joint of a mimic joint, axes of four digits, and planar joints."""
    follow = '<mimic joint="{}" multiplier="2" offset="0.1"/>'
    read = read_again(
        robot(
            link("base", visual('<capsule radius="0.1" length="0.2"/>')),
            *(link(name, "") for name in "abcdefg"),
            joint("floating", "base", "a", kind="floating"),
            joint("planar", "a", "b", kind="planar"),
            joint("slide", "b", "c", kind="prismatic", axis="0.7071 0.7071 0"),
            joint("turn", "c", "d", axis="0 0 3", limit='upper="3"'),
            joint("follow", "d", "e", content=follow.format("slide")),
            joint("follow_it", "e", "f", content=follow.format("follow")),
            joint("spin", "f", "g", kind="continuous", limit=""),
        )
    )
    assert (read.error, read.differences) == ("", ())
    assert read.summary.endswith("and poses; it does not support 1 capsule")


COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">0 0 0 10 0 0 0 20 5</float_array>
<technique_common><accessor source="#a" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><matrix>1 0 0 3 0 1 0 0 0 0 1 0 0 0 0 1</matrix>
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def test_meshes_have_the_same_size_whatever_their_format_unit_and_scale(tmp_path: Path) -> None:
    trimesh.creation.box((1.0, 2.0, 3.0)).export(tmp_path / "box.stl")
    trimesh.creation.icosphere(radius=0.3).export(tmp_path / "ball.obj")
    (tmp_path / "triangle.dae").write_text(COLLADA)
    meshes = [
        f'<mesh filename="{tmp_path / name}" scale="{scale}"/>'
        for name, scale in (
            ("box.stl", "1 -1 1"),
            ("ball.obj", "0.001"),
            ("triangle.dae", "1 1 1"),
            ("missing.stl", "1 1 1"),
        )
    ]
    read = read_again(robot(link("base", "".join(map(visual, meshes)))))
    assert read.differences == ()
    assert read.summary.endswith("and poses, and 3 meshes of the same size")


def test_a_mesh_that_only_one_reads_is_named(tmp_path: Path) -> None:
    whole = tmp_path / "box.stl"
    trimesh.creation.box((1.0, 1.0, 1.0)).export(whole)
    whole.write_bytes(whole.read_bytes()[:-50])  # ours takes the eleven triangles that are left
    assert sentences(robot(link("base", visual(f'<mesh filename="{whole}"/>')))) == [
        f"Mesh '{whole}': its content is read here and empty in yourdfpy"
    ]


ARM = (
    link("base", box("visual", "1 1 1")),
    link("upper", ""),
    link("tool", ""),
    joint("lift", "base", "upper"),
    joint("turn", "upper", "tool", axis="0 0 1"),
)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"type": "continuous"}, "its type is continuous here and revolute in yourdfpy"),
        ({"axis": (0.0, 1.0, 0.0)}, "its axis is 0 1 0 here and 1 0 0 in yourdfpy"),
        ({"limit": None}, "its <limit> is none here and given in yourdfpy"),
        ({"limit": Limit(-2, 1.5, 20, 3)}, "its limit 'upper' is 1.5 here and 2 in yourdfpy"),
        ({"limit": Limit(-2, 2, 20, 0)}, "its limit 'velocity' is 0 here and 3 in yourdfpy"),
        ({"mimic": Mimic("turn", 2, 1)}, "its <mimic> is 2 * 'turn' + 1 here and none in yourdfpy"),
    ],
)
def test_a_joint_that_was_read_differently_is_named_with_both_values(
    change: dict[str, object], expected: str
) -> None:
    read = robot(*ARM)
    lift = dataclasses.replace(read.joints["lift"], **change)  # type: ignore[arg-type]
    other = dataclasses.replace(read, joints={**read.joints, "lift": lift})
    assert f"Joint 'lift' (line 1): {expected}" in sentences(other)


def moved(joint: Joint, z: float) -> Joint:
    return dataclasses.replace(joint, origin=Pose((0.0, 0.0, z)))


def test_links_elsewhere_are_named_by_the_first_one_of_a_chain_at_both_configurations() -> None:
    read = robot(*ARM)
    other = dataclasses.replace(
        read, joints={**read.joints, "lift": moved(read.joints["lift"], 0.6)}
    )
    # A turn of 0.4 rad about x: 0.6 of the way from -2 to 2.
    assert sentences(other) == [
        "Link 'upper' behind joint 'lift' (line 1): its pose at zero is xyz 0 0 0.6 rpy 0 0 0 here "
        "and xyz 0 0 0.5 rpy 0 0 0 in yourdfpy",
        "Link 'upper' behind joint 'lift' (line 1): its pose with joints at 60% of their ranges is "
        "xyz 0 0 0.6 rpy 0.4 0 0 here and xyz 0 0 0.5 rpy 0.4 0 0 in yourdfpy",
    ]


def test_a_difference_of_a_hundredth_of_a_millimetre_counts_and_one_of_a_nanometre_does_not() -> (
    None
):
    read = robot(*ARM)
    for off, count in ((1e-5, 2), (1e-9, 0)):
        joints = {**read.joints, "lift": moved(read.joints["lift"], 0.5 + off)}
        assert len(sentences(dataclasses.replace(read, joints=joints))) == count


def test_links_and_shapes_that_only_one_has_are_named() -> None:
    read = robot(*ARM)
    cube = Visual(Box((1.0, 1.0, 2.0)), Pose((0.0, 0.0, 1.0)))
    links = {**read.links, "base": dataclasses.replace(read.links["base"], visuals=(cube,))}
    assert sentences(dataclasses.replace(read, links=links)) == [
        "Link 'base': the shape of <visual> is a box of 1 1 2 here and a box of 1 1 1 in yourdfpy",
        "Link 'base': the origin of <visual> is xyz 0 0 1 rpy 0 0 0 here and xyz 0 0 0 rpy 0 0 0 "
        "in yourdfpy",
    ]
    fewer = dataclasses.replace(
        read,
        links={name: one for name, one in read.links.items() if name != "tool"},
        joints={name: one for name, one in read.joints.items() if name != "turn"},
    )
    assert sentences(fewer) == [
        "Link 'tool': the number of links of this name is 0 here and 1 in yourdfpy",
        "Joint 'turn': the number of joints of this name is 0 here and 1 in yourdfpy",
    ]


def test_the_check_warns_of_a_file_that_two_readers_read_differently(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An axis of length 2 moves a link twice as far by yourdfpy, and as far as commanded by ROS."""
    file = tmp_path / "slide.urdf"
    slide = joint("slide", "base", "upper", kind="prismatic", axis="0 0 2")
    lost = joint("turn", "upper", "tool", content='<mimic joint="no_such"/>')
    file.write_text(f'<robot name="slide">\n{"".join(ARM[:3])}\n{slide}\n\n{lost}</robot>')
    assert main.run(["robot", "check", str(file)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[lines.index("yourdfpy reads it differently:") :] == [
        "yourdfpy reads it differently:",
        "  Joint 'slide' (line 3): its axis is 0 0 1 here and 0 0 2 in yourdfpy",
        "  Joint 'turn' (line 6): its <mimic> is none here and 1 * 'no_such' + 0 in yourdfpy",
        "It compiles; --simulate lets the robot stand for 5 s, then moves it",
    ]


def test_a_file_that_yourdfpy_rejects_is_no_fault_of_ours(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "commas.urdf"
    file.write_text(f'<robot name="commas">{"".join(ARM)}</robot>'.replace("0 0 0.5", "0,0,0.5"))
    assert main.run(["robot", "check", str(file)]) == 0
    said = "yourdfpy does not read it: ValueError: could not convert string to float: '0,0,0.5'\n"
    assert said in capsys.readouterr().out


def test_the_table_of_a_folder_takes_no_time_for_a_second_reading(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text(f'<robot name="arm">{"".join(ARM)}</robot>')
    assert check_robot(file, {}, compare_readers=False).second_reading is None
    assert check_robot(file, {}).second_reading is not None
