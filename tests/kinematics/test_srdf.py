"""SRDF files: what is read, what is wrong with its line, and that writing loses nothing."""

from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st

from teleopctl.errors import InvalidFileError
from teleopctl.kinematics import (
    EndEffector,
    JointGroup,
    KinematicModel,
    PoseTask,
    RobotGroups,
    allowed_by_sampling,
    find_groups,
    parse_srdf,
    read_srdf,
    write_srdf,
)
from teleopctl.kinematics.srdf import TASKS
from teleopctl.robot import RobotDescription
from teleopctl.tf import Transform, quaternion_from_rpy
from tests.kinematics.arms import SIX, THREE, Y, Z, arm_urdf

JAW = """<link name="jaw"/><joint name="jaw" type="revolute"><parent link="tool0"/>
<child link="jaw"/><axis xyz="0 1 0"/>
<limit lower="0" upper="1" velocity="1" effort="1"/></joint>"""
ARM = RobotDescription.from_urdf(arm_urdf(SIX, extra=JAW))
LINKS = list(ARM.links)


def test_groups_are_chains_joints_links_and_other_groups():
    groups = parse_srdf(
        """<robot name="arm">
        <group name="chain"><chain base_link="link_1" tip_link="link_4"/></group>
        <group name="joints"><joint name="joint_1"/><joint name="joint_2"/></group>
        <group name="links"><link name="link_5"/><link name="link_6"/><link name="tool0"/></group>
        <group name="all"><group name="links"/><group name="joints"/><group name="chain"/></group>
        </robot>""",
        ARM,
    )
    assert groups.warnings == ()
    assert groups.groups["chain"].joints == ("joint_2", "joint_3", "joint_4")
    assert groups.groups["chain"].tip == "link_4"
    assert groups.groups["joints"].tip == "link_2"
    assert groups.groups["links"].tip == "tool0"
    assert groups.groups["all"].joints == tuple(f"joint_{n}" for n in range(1, 7))


def test_a_group_s_end_effector_gives_it_its_tip():
    groups = parse_srdf(
        """<robot name="arm">
        <group name="arm"><chain base_link="base" tip_link="tool0"/></group>
        <group name="hand"><joint name="jaw"/></group>
        <end_effector name="claw" parent_link="tool0" group="hand"/></robot>""",
        ARM,
    )
    assert groups.end_effectors["claw"] == EndEffector("claw", "hand", "tool0", "arm")
    assert groups.gripper_of("arm") == JointGroup("hand", ("jaw",), "tool0")


def test_the_group_that_is_meant_without_a_name_is_no_end_effector():
    groups = parse_srdf(
        """<robot name="arm"><group name="hand"><link name="jaw"/></group>
        <group name="arm"><chain base_link="base" tip_link="tool0"/></group>
        <end_effector name="claw" parent_link="tool0" group="hand"/></robot>""",
        ARM,
    )
    assert groups.groups["hand"].tip == "jaw"
    assert groups.group().name == "arm"


TWO_FINGERS = "".join(
    f'''<link name="{side}"/><joint name="{side}" type="prismatic"><parent link="link_6"/>
<child link="{side}"/><limit lower="0" upper="0.04" velocity="1" effort="1"/></joint>'''
    for side in ("left", "right")
)


def test_an_arm_of_joints_ends_at_the_fixed_one_and_has_the_only_group_of_fingers_as_gripper():
    joints = "".join(f'<joint name="joint_{number}"/>' for number in range(1, 7))
    groups = parse_srdf(
        f"""<robot name="arm"><group name="arm">{joints}<joint name="tool"/></group>
        <group name="hand"><joint name="left"/><joint name="right"/></group>
        <end_effector name="end" parent_link="tool0" group="arm"/></robot>""",
        RobotDescription.from_urdf(arm_urdf(SIX, extra=TWO_FINGERS)),
    )
    assert groups.group().name == "arm"
    assert groups.group().tip == "tool0"
    gripper = groups.gripper_of("arm")
    assert gripper is not None
    assert gripper.name == "hand"
    (warning,) = groups.warnings
    assert "'arm' carries the link 'tool0', and is no gripper on it" in warning


def test_tool_and_task_are_read_and_passed_over_by_moveit():
    groups = parse_srdf(
        """<robot name="arm"><group name="arm"><chain base_link="base" tip_link="tool0"/></group>
        <tool group="arm" xyz="0 0 0.1" rpy="0 1 0"/><task group="arm" type="position"/></robot>""",
        ARM,
    )
    assert groups.warnings == ()
    arm = groups.group()
    assert arm.tool == Transform((0.0, 0.0, 0.1), quaternion_from_rpy(0.0, 1.0, 0.0))
    assert arm.task == "position"
    assert [each.value for each in PoseTask] == list(TASKS)


def test_default_collisions_are_disabled_per_link_and_enabled_again_per_pair():
    groups = parse_srdf(
        """<robot name="arm"><disable_default_collisions link="jaw"/>
        <enable_collisions link1="jaw" link2="base"/>
        <disable_collisions link1="link_3" link2="link_1" reason="Never"/></robot>""",
        ARM,
    )
    assert groups.allowed_collisions["link_1", "link_3"] == "Never"
    assert ("base", "jaw") not in groups.allowed_collisions
    assert ("jaw", "link_2") in groups.allowed_collisions


MISTAKES = {
    '<group name="g"><joint name="elbow"/></group>': "group 'g': the robot has no joint 'elbow'",
    '<group name="g"><link name="hat"/></group>': "group 'g': the robot has no link 'hat'",
    '<group name="g"><chain base_link="tool0" tip_link="base"/></group>': (
        "group 'g': there is no chain from 'tool0' to 'base'"
    ),
    '<group name="g"><group name="g"/></group>': "group 'g': there is no group 'g' to include",
    '<group_state name="s" group="hand"/>': "state 's': there is no group 'hand'",
    '<group_state name="s" group="arm"><joint name="elbow" value="0"/></group_state>': (
        "state 's': the robot has no joint 'elbow'"
    ),
    '<group_state name="s" group="arm"><joint name="joint_1" value="x"/></group_state>': (
        "state 's': value 'x' is not one number"
    ),
    '<group_state name="s" group="arm"><joint name="joint_1" value="nan"/></group_state>': (
        "state 's': value 'nan' is not one number"
    ),
    '<group_state name="s" group="arm"><joint name="joint_1" value="3"/></group_state>': (
        "state 's': 3 of joint 'joint_1' is not within its limits -2.6 to 2.6"
    ),
    '<end_effector name="e" group="hand" parent_link="tool0"/>': (
        "end effector 'e': there is no group 'hand'"
    ),
    '<end_effector name="e" group="arm" parent_link="hat"/>': (
        "end effector 'e': the robot has no link 'hat'"
    ),
    '<passive_joint name="elbow"/>': "<passive_joint>: the robot has no joint 'elbow'",
    '<disable_collisions link1="hat" link2="base"/>': (
        "<disable_collisions>: the robot has no links 'hat' and 'base'"
    ),
    '<tool group="arm" xyz="0 0"/>': "<tool>: xyz '0 0' is not three numbers",
    '<task group="arm" type="dance"/>': ("<task>: type 'dance' is none of pose, axis, position"),
    "<frobnicate/>": "<frobnicate> is unknown and ignored",
}


@pytest.mark.parametrize(("tag", "sentence"), MISTAKES.items())
def test_what_the_robot_has_not_is_a_warning_with_its_line(tmp_path: Path, tag, sentence):
    file = tmp_path / "arm.srdf"
    file.write_text(
        '<robot name="arm">\n<group name="arm"><chain base_link="base" tip_link="tool0"/></group>\n'
        f"{tag}\n</robot>"
    )
    groups = read_srdf(file, ARM)
    assert groups.warnings == (f"{file}:3: {sentence}",)
    assert groups.group("arm").tip == "tool0"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is not XML"),
        ("<robot", "is not XML"),
        ("<launch/>", "its root is <launch> instead of <robot>"),
        ('<robot name="b"><group name="g"><joint name="x"/></group></robot>', "another robot, 'b'"),
    ],
)
def test_what_is_no_srdf_of_the_robot_is_refused(text, words):
    with pytest.raises(InvalidFileError, match=words):
        parse_srdf(text, ARM)


# --- writing ------------------------------------------------------------------------------------

NAMES = st.text("abcdefghij_äß<&\"'", min_size=1, max_size=8)
NUMBERS = st.floats(-2.5, 2.5).map(lambda value: float(f"{value:.9g}"))


@st.composite
def robots_groups(draw: st.DrawFn) -> RobotGroups:
    groups = {}
    for name in draw(st.lists(NAMES, min_size=1, max_size=3, unique=True)):
        first = draw(st.integers(1, 6))
        last = draw(st.integers(first, 6))
        joints = tuple(f"joint_{n}" for n in range(first, last + 1))
        base = "base" if first == 1 else f"link_{first - 1}"
        tip = draw(st.sampled_from(["tool0", "link_6"])) if last == 6 else f"link_{last}"
        tool = draw(st.none() | st.tuples(NUMBERS, NUMBERS, NUMBERS))
        task = draw(st.sampled_from(["", *TASKS]))
        groups[name] = JointGroup(
            name, joints, base, tip, None if tool is None else Transform(tool), task
        )
    states: dict[str, dict[str, dict[str, float]]] = {}
    for name, group in groups.items():
        for state in draw(st.lists(NAMES, max_size=2, unique=True)):
            positions = draw(st.dictionaries(st.sampled_from(group.joints), NUMBERS))
            states.setdefault(name, {})[state] = positions
    pairs = draw(
        st.dictionaries(
            st.tuples(st.sampled_from(LINKS), st.sampled_from(LINKS)).filter(
                lambda pair: pair[0] < pair[1]
            ),
            st.sampled_from(["Adjacent", "Never", "User"]),
            max_size=4,
        )
    )
    passive = draw(st.frozensets(st.sampled_from(["jaw", "joint_1"])))
    return RobotGroups("arm", groups, states, {}, passive, pairs)


@settings(max_examples=25)
@given(robots_groups())
def test_what_is_written_is_read_again(groups):
    again = parse_srdf(write_srdf(groups, ARM), ARM)
    assert again == groups


def test_what_is_found_in_a_description_is_written_and_read_again():
    groups = find_groups(ARM)
    assert set(groups.groups) == {"arm", "gripper"}
    assert parse_srdf(write_srdf(groups, ARM), ARM) == groups


def test_pairs_of_links_are_sorted_as_by_moveit_s_setup_assistant():
    # The last link reaches the first one only folded back; the ball is always in the second one.
    ball = """<link name="ball"><collision><geometry><sphere radius="0.2"/></geometry></collision>
    </link><joint name="ball" type="revolute"><parent link="base"/><child link="ball"/>
    <origin xyz="0 0 0.1"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>"""
    arm = ((Z, 0.1), (Y, 0.3), (Y, 0.25), (Y, 0.25))
    description = RobotDescription.from_urdf(arm_urdf(arm, extra=ball, limit=3.1))
    model = KinematicModel(description)
    allowed = allowed_by_sampling(
        description, model.mj_model, model.joints, model.links, model.mj_data.qpos.copy(), 500
    )
    assert allowed["link_1", "link_2"] == "Adjacent"
    assert allowed["ball", "link_2"] == "Always"
    # Folded, they touch at some positions: these are checked.
    assert ("link_2", "link_4") not in allowed
    signature = set(model.mj_model.exclude_signature.tolist())
    assert -1 not in signature, "the model is as before"


def test_links_without_shapes_that_never_touch_need_no_check():
    description = RobotDescription.from_urdf(arm_urdf(THREE, limit=0.3))
    model = KinematicModel(description)
    allowed = allowed_by_sampling(
        description, model.mj_model, model.joints, model.links, model.mj_data.qpos.copy(), 200
    )
    assert allowed == {
        ("link_1", "link_2"): "Adjacent",
        ("link_1", "link_3"): "Never",
        ("link_2", "link_3"): "Adjacent",
    }
