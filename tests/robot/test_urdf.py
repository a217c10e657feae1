"""URDF is read as it is meant, and what is wrong in it is named."""

import pytest

from teleopctl.errors import TeleopctlError
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.urdf import Box, Capsule, Cylinder, Mesh, Pose, Sphere

LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'


def robot(body):
    return RobotDescription.from_urdf(f'<robot name="r">{body}</robot>')


def joint(name="j", kind="revolute", parent="a", child="b", inside=LIMIT):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/>{inside}</joint>'
    )


def links(*names):
    return "".join(f'<link name="{name}"/>' for name in names)


def test_defaults_are_those_of_the_format():
    found = robot(links("a", "b") + joint())
    moved = found.joints["j"]
    assert moved.axis == (1.0, 0.0, 0.0)
    assert moved.origin == Pose()
    assert (moved.dynamics.damping, moved.dynamics.friction) == (0.0, 0.0)
    assert found.links["a"].inertial is None


def test_shapes_are_read():
    shapes = (
        '<box size="1 2 3"/>',
        '<cylinder radius="1" length="2"/>',
        '<capsule radius="1" length="2"/>',
        '<sphere radius="1"/>',
        '<mesh filename="package://p/m.stl"/>',
    )
    body = "".join(
        f'<collision name="c"><geometry>{shape}</geometry></collision>' for shape in shapes
    )
    found = robot(f'<link name="a">{body}</link>').links["a"].collisions
    assert [part.geometry for part in found] == [
        Box((1, 2, 3)),
        Cylinder(1, 2),
        Capsule(1, 2),
        Sphere(1),
        Mesh("package://p/m.stl"),
    ]


def test_a_visual_takes_its_colour_from_the_material_of_that_name():
    found = robot(
        '<material name="red"><color rgba="1 0 0 1"/></material><link name="a"><visual>'
        '<geometry><sphere radius="1"/></geometry><material name="red"/></visual></link>'
    )
    assert found.links["a"].visuals[0].material.rgba == (1, 0, 0, 1)


def test_an_axis_is_made_a_unit_vector():
    body = links("a", "b") + joint(inside=f'<axis xyz="0 3 4"/>{LIMIT}')
    assert robot(body).joints["j"].axis == pytest.approx((0, 0.6, 0.8))


def test_joints_are_ordered_from_the_root_to_the_tips():
    body = (
        links("c", "b", "a", "d")
        + joint("second", parent="b", child="c")
        + joint("first", parent="a", child="b")
        + joint("third", parent="c", child="d")
    )
    found = robot(body)
    assert found.root == "a"
    assert [each.name for each in found.tree] == ["first", "second", "third"]


def test_comments_and_declared_encodings_do_no_harm():
    text = (
        '<?xml version="1.0" encoding="ISO-8859-1"?><!-- ä --><robot name="ä"><link name="a">'
        "<!-- nothing --></link></robot>"
    )
    assert RobotDescription.from_urdf(text).name == "ä"


def test_entities_do_not_read_files(tmp_path):
    secret = tmp_path / "secret"
    secret.write_text("secret")
    text = (
        f'<!DOCTYPE robot [<!ENTITY x SYSTEM "{secret.as_uri()}">]>'
        '<robot name="r"><link name="a"/><gazebo><plugin filename="f"><p>&x;</p></plugin></gazebo>'
        "</robot>"
    )
    (plugin,) = RobotDescription.from_urdf(text).gazebo.plugins
    assert "secret" not in str(plugin)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty URDF passed to robot"),
        ("<robot", "invalid URDF passed in to robot parser: "),
        ("<sdf/>", "the robot tag is not root element in URDF"),
        ("<robot name='r'/>", "No link elements found in urdf file"),
    ],
)
def test_what_is_no_robot_is_refused(text, message):
    with pytest.raises(TeleopctlError, match=message):
        RobotDescription.from_urdf(text)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (links("a", "a"), "link 'a' is not unique"),
        (links("a", "b") + joint() + joint(), "joint 'j' is not unique"),
        ("<link/>", "no attribute 'name' in 'link' tag"),
        (links("a", "b") + joint(kind="bendy"), r"Joint 'j' has no known type: 'bendy' \(line 1\)"),
        (links("a", "b") + joint(inside=""), "does not specify limits"),
        (links("a", "b") + joint(inside=f'<axis xyz="0 0 0"/>{LIMIT}'), "axis of length zero"),
        (links("a", "b") + joint(inside=f'<axis xyz="0 1"/>{LIMIT}'), "should be 3 numbers"),
        (links("a", "b") + joint(inside='<limit lower="low"/>'), "should be a number, got 'low'"),
        (links("a", "b") + joint(inside=f'<mimic joint="j"/>{LIMIT}'), "mimics itself"),
        (links("a") + joint(), r"child link \[b\] of joint \[j\] not found \(line 1\)"),
        (links("a", "b"), r"Two root links found: \[a\] and \[b\]"),
        (
            links("a", "b") + joint() + joint("k", parent="b", child="a"),
            "No root link found",
        ),
        (
            links("r", "a", "b") + joint() + joint("k", parent="b", child="a"),
            "form a cycle",
        ),
        (
            links("a", "b", "c") + joint() + joint("k", parent="c", child="b"),
            r"link \[b\] has two parents: joints \[j\] and \[k\]",
        ),
        ("<joint name='j' type='fixed'><parent link='a'/></joint>", "Joint 'j' has no <child>"),
    ],
)
def test_what_is_wrong_is_named(body, message):
    with pytest.raises(TeleopctlError, match=message):
        robot(body)


def test_a_mistake_for_control_does_not_keep_the_robot_from_being_shown():
    found = robot(links("a") + '<ros2_control name="x" type="system"><bad/></ros2_control>')
    assert list(found.links) == ["a"]
    with pytest.raises(TeleopctlError, match="invalid tag name 'bad'"):
        _ = found.ros2_control


def test_a_robot_without_control_says_so_when_control_is_asked_for():
    found = robot(links("a"))
    assert found.ros2_control == ()
    with pytest.raises(TeleopctlError, match="no 'ros2_control' tag found in the URDF"):
        found.require_ros2_control()
