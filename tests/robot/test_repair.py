"""What urdfdom lets pass costs nobody the robot, and is told."""

import pytest

from teleopctl.mujoco_model import build_model
from teleopctl.robot import Material, RobotDescription
from teleopctl.robot.urdf import Dynamics, Link, Pose

BOX = '<geometry><box size="1 1 1"/></geometry>'
RED = '<material name="x"><color rgba="1 0 0 1"/></material>'


def read(link: str, more: str = "") -> tuple[Link, tuple[str, ...]]:
    """The link `a` of a robot, and what was repaired; MuJoCo is to take it as well."""
    description = RobotDescription.from_urdf(
        f'<robot name="r"><link name="a">{link}</link>{more}</robot>'
    )
    model = build_model(description)
    assert model.warnings[: len(description.repairs)] == description.repairs
    return description.links["a"], description.repairs


def colour(link: Link) -> Material | None:
    return link.visuals[0].material


def test_of_two_materials_the_first_is_taken() -> None:
    link, notes = read(f'<visual>{BOX}{RED}<material name="y"/></visual>')
    assert colour(link) == Material("x", (1.0, 0.0, 0.0, 1.0))
    assert notes == ("Of several <material> in one <visual> the first is used (line 1)",)


@pytest.mark.parametrize("texture", ["<texture/>", '<texture filename=""/>'])
@pytest.mark.parametrize("whose", ["visual", "robot"])
def test_a_texture_without_a_file_leaves_the_colour(texture: str, whose: str) -> None:
    material = RED.replace("<color", f"{texture}<color")
    if whose == "visual":
        link, notes = read(f"<visual>{BOX}{material}</visual>")
    else:
        link, notes = read(f'<visual>{BOX}<material name="x"/></visual>', material)
    assert colour(link) == Material("x", (1.0, 0.0, 0.0, 1.0))
    assert notes == ("A <texture> without a file is dropped (line 1)",)


@pytest.mark.parametrize(
    ("origin", "pose", "note"),
    [
        ('xyz="1 2 3" rpy=""', Pose((1.0, 2.0, 3.0)), 'rpy="" counts as 0 0 0'),
        ('xyz="" rpy="1 2 3"', Pose(rpy=(1.0, 2.0, 3.0)), 'xyz="" counts as 0 0 0'),
        ('xyz="1, 2, 3"', Pose((1.0, 2.0, 3.0)), "Commas between numbers are read as spaces"),
    ],
)
def test_places_may_be_empty_and_have_commas(origin: str, pose: Pose, note: str) -> None:
    link, notes = read(f"<collision><origin {origin}/>{BOX}</collision>\n" * 2)
    assert [part.origin for part in link.collisions] == [pose, pose]
    assert notes == (f"{note} (line 1, 2)",)


def test_one_scale_of_a_mesh_counts_for_all_axes() -> None:
    link, notes = read(
        '<visual><geometry><mesh filename="a.stl" scale="0.001"/></geometry></visual>'
    )
    assert getattr(link.visuals[0].geometry, "scale", None) == (0.001, 0.001, 0.001)
    assert notes == ('scale="0.001" is used for all three axes (line 1)',)


@pytest.mark.parametrize(
    ("part", "reason"),
    [
        ("<visual/>", "has no <geometry> with a shape"),
        ("<collision><geometry/></collision>", "has no <geometry> with a shape"),
        ("<visual><geometry><torus/></geometry></visual>", "unknown shape"),
        (f'<visual>{BOX}<material><color rgba="1"/></material></visual>', "should be 4 numbers"),
        ('<collision><geometry><box size="1 1"/></geometry></collision>', "should be 3 numbers"),
        ("<inertial/>", "needs a <mass> and an <inertia>"),
        ('<inertial><inertia ixx="1" iyy="1" izz="1"/></inertial>', "needs a <mass>"),
        ('<inertial><mass value="-1"/><inertia/></inertial>', "a mass of -1 kg"),
        ('<inertial><mass value="inf"/><inertia/></inertial>', "should be a finite number"),
        (f'<visual><origin xyz="0 inf 0"/>{BOX}</visual>', "should be finite, got '0 inf 0'"),
    ],
)
def test_a_part_that_cannot_be_read_is_left_out_and_the_others_stay(part: str, reason: str) -> None:
    whole = f"<visual>{BOX}</visual><collision>{BOX}</collision>"
    link, (note,) = read(whole + part)
    assert (len(link.visuals), len(link.collisions), link.inertial) == (1, 1, None)
    assert note.startswith(f"<{part[1:].partition('>')[0].strip('/')}> of link 'a' is left out: ")
    assert reason in note


def test_products_of_inertia_that_are_not_written_are_zero() -> None:
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
    link, notes = read(inertial)
    assert (link.inertial is not None, notes) == (True, ())


def test_a_joint_that_mimics_none_moves_on_its_own() -> None:
    follower = '<parent link="a"/><child link="b"/><mimic joint="k"/>'
    description = RobotDescription.from_urdf(
        f'<robot name="r"><link name="a"/><link name="b"/>'
        f'<joint name="j" type="continuous">{follower}</joint></robot>'
    )
    assert description.joints["j"].mimic is None
    assert description.repairs == (
        "Joint 'j' mimics the joint 'k', which does not exist: it moves independently",
    )


def test_what_slows_a_joint_down_does_not_push_it() -> None:
    content = '<parent link="a"/><child link="b"/><dynamics damping="-2" friction="1"/>'
    description = RobotDescription.from_urdf(
        '<robot name="r"><link name="a"/><link name="b"/>'
        f'<joint name="j" type="continuous">{content}</joint></robot>'
    )
    assert description.repairs == ("A negative damping counts as 0 (line 1)",)
    assert description.joints["j"].dynamics == Dynamics(0.0, 1.0)


def test_the_description_itself_stays_as_it_was_written() -> None:
    text = '<robot name="r"><link name="a"><visual/></link></robot>'
    assert RobotDescription.from_urdf(text).urdf == text
