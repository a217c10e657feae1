"""``teleopctl kinematics``: what each verb prints about a robot's file."""

import json
import math
import re

import pytest

from teleopctl.cli import main
from teleopctl.cli.completion.completing import TypedWords
from teleopctl.cli.verbs.kinematics import source
from teleopctl.commander import RunningRobot
from teleopctl.errors import UnavailableError, UsageError
from teleopctl.kinematics import find_groups
from teleopctl.robot import RobotDescription
from tests.kinematics.arms import SIX, THREE, arm_urdf

FINGER = """<link name="finger"/><joint name="finger_joint" type="prismatic">
<parent link="tool0"/><child link="finger"/><axis xyz="0 1 0"/>
<limit lower="0" upper="0.04" velocity="0.1" effort="5"/></joint>"""


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> str:
    file = tmp_path_factory.mktemp("arm") / "arm.urdf"
    file.write_text(arm_urdf(THREE, extra=FINGER))
    return str(file)


@pytest.fixture(scope="module")
def six(tmp_path_factory: pytest.TempPathFactory) -> str:
    file = tmp_path_factory.mktemp("six") / "six.urdf"
    file.write_text(arm_urdf(SIX))
    return str(file)


class Printed:
    """Runs commands, and returns what they print."""

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self._capsys = capsys
        self.status = 0
        self.errors = ""

    def __call__(self, *words: str) -> str:
        self._capsys.readouterr()
        self.status = main.run(["kinematics", *words])
        written, self.errors = self._capsys.readouterr()
        return written


@pytest.fixture
def printed(capsys: pytest.CaptureFixture[str]) -> Printed:
    return Printed(capsys)


def words(text: str) -> list[str]:
    """The words of a text; the sign of a zero, which depends on the processor, is left out."""
    return re.sub(r"-(0\.0+)\b", r"\1", text).split()


def test_fk_prints_the_pose_as_tf2_echo_does(printed, arm):
    assert words(printed("fk", arm, "1.5707963", "0.5", "0")) == words(
        "Pose of 'tool0' in 'base', moved by group 'arm'\n"
        "- Translation: [0.000, 0.264, 0.583]\n"
        "- Rotation: in Quaternion (xyzw) [-0.175, 0.175, 0.685, 0.685]\n"
        "- Rotation: in RPY (radian) [0.000, 0.500, 1.571]\n"
        "- Rotation: in RPY (degree) [0.000, 28.648, 90.000]\n"
        "- Matrix:\n"
        "  0.000 -1.000  0.000  0.000\n"
        "  0.878  0.000  0.479  0.264\n"
        " -0.479  0.000  0.878  0.583\n"
        "  0.000  0.000  0.000  1.000\n"
    )


def test_fk_takes_joints_by_name_states_tools_and_frames(printed, arm):
    by_name = json.loads(printed("fk", arm, "joint_2=0.5", "--json"))
    assert by_name["joints"] == {"joint_1": 0.0, "joint_2": 0.5, "joint_3": 0.0}
    assert json.loads(printed("fk", arm, "--named", "zero", "--json"))["position"] == {
        "x": 0.0,
        "y": 0.0,
        "z": pytest.approx(0.65),
    }
    link = json.loads(printed("fk", arm, "0", "0", "0", "--tool", "link_2", "--json"))
    assert link["position"]["z"] == pytest.approx(0.1)
    offset = json.loads(printed("fk", arm, "0", "0", "0", "--tool", "0,0,0.1", "--json"))
    assert offset["position"]["z"] == pytest.approx(0.75)
    framed = json.loads(printed("fk", arm, "0", "0", "0", "--frame", "link_3", "--json"))
    assert (framed["frame"], framed["position"]["z"]) == ("link_3", pytest.approx(0.25))


def test_fk_warns_of_positions_outside_the_limits_and_of_links_that_touch(printed, six):
    printed("fk", six, "0", "3", "0", "0", "0", "0")
    assert printed.errors == (
        "WARNING: Outside the joints' limits: joint_2 3 is outside -2.6 to 2.6\n"
    )
    printed("fk", six, "0.7", "-1.2", "-2.4", "-2.5", "1.6", "2.1")
    assert printed.errors == "WARNING: 'link_2' and 'link_6' touch at these positions\n"


def test_ik_prints_joints_that_fk_takes_back_to_the_position(printed, arm):
    lines = printed("ik", arm, "0.2", "0.1", "0.4").splitlines()
    assert printed.status == 0
    words = [line.split() for line in lines]
    assert [name for name, _ in words] == ["joint_1", "joint_2", "joint_3"]
    again = json.loads(printed("fk", arm, *(f"{name}={at}" for name, at in words), "--json"))
    assert list(again["position"].values()) == pytest.approx([0.2, 0.1, 0.4], abs=1e-3)


def test_ik_of_a_pose_that_three_joints_do_not_serve_says_so(printed, arm):
    printed("ik", arm, "0.2", "0.1", "0.4", "--rpy", "1,0,0")
    assert printed.status == 0
    assert printed.errors.startswith("The position is reached; 3 joints do not serve the rotation")


def test_ik_reaches_a_rotation_in_a_frame(printed, six):
    found = json.loads(
        printed(
            "ik", six, "0.1", "0", "0.8", "--quat", "0,0.6,0,0.8", "--frame", "link_1", "--json"
        )
    )
    assert found["reached"], found
    assert found["pose"]["orientation"] == pytest.approx(
        {"x": 0.0, "y": 0.6, "z": 0.0, "w": 0.8}, abs=1e-3
    )
    assert found["error_code"] == {"val": 1, "name": "SUCCESS"}


def test_ik_says_what_keeps_the_tool_from_a_position(printed, arm):
    assert printed("ik", arm, "0", "0", "1").splitlines() == [
        "Not reached (NO_IK_SOLUTION, -31): the arm is too short",
        "The nearest position that was found is 0.35 m away:",
        "- Translation in 'base': [0.000, 0.000, 0.650]",
        "- Rotation: in RPY (radian) [0.000, 0.000, 0.000]",
        "Its joints:",
        "joint_1  0.000000",
        "joint_2  0.000000",
        "joint_3  0.000000",
    ]
    assert printed.status == 1
    assert json.loads(printed("ik", arm, "0", "0", "1", "--json"))["error_code"]["val"] == -31
    assert printed.status == 1


def test_jacobian_prints_rows_of_velocities_and_how_near_a_singularity_is(printed, arm):
    assert printed("jacobian", arm, "0", "0.5", "1") == (
        "Jacobian of 'tool0' in 'base'\n"
        "     joint_1   joint_2   joint_3\n"
        "vx    0.0000    0.2810    0.0177\n"
        "vy    0.3932    0.0000    0.0000\n"
        "vz    0.0000   -0.3932   -0.2494\n"
        "wx    0.0000    0.0000    0.0000\n"
        "wy    0.0000    1.0000    1.0000\n"
        "wz    1.0000    0.0000    0.0000\n"
        "Singular values: 1.5015, 1.0745, 0.2042\n"
        "Singular values of the linear rows: 0.5310, 0.3932, 0.1189\n"
        "Manipulability of the position: 0.02482\n"
        "Condition of the position: 4.467\n"
    )
    assert "infinite (a singularity)" in printed("jacobian", arm, "0", "0", "0")


def test_workspace_draws_and_prints_extents(printed, arm, tmp_path):
    lines = printed("workspace", arm, "--samples", "2000").splitlines()
    assert lines[18].startswith("from above: x to the right, y up, 1.1")
    assert lines[19] == "Workspace of 'tool0' in 'base'"
    assert lines[22].startswith("z: -0.")
    assert lines[23] == "reach: 0.650 m from the axis of 'joint_1'"
    picture = tmp_path / "space.svg"
    assert printed("workspace", arm, "--samples", "50", "-o", str(picture)).splitlines()[-1] == str(
        picture
    )
    assert picture.read_text().startswith("<?xml")


def test_srdf_is_written_and_checked_with_lines(printed, arm, tmp_path):
    file = tmp_path / "arm.srdf"
    assert printed("srdf", arm, "--samples", "200", "-o", str(file)).splitlines() == [
        "group 'arm': 3 joints, moves 'tool0'; states home, zero",
        "group 'gripper': 1 joints; states home, zero",
        "end effector 'gripper': group 'gripper' on 'tool0'",
        "pairs of links that may touch: 2 Adjacent, 1 Never",
        str(file),
    ]
    assert printed("srdf", arm, "--samples", "200") == file.read_text()
    assert printed("srdf", arm, "--check", str(file)).splitlines()[0].startswith("group 'arm'")
    assert printed.status == 0
    file.write_text(file.read_text().replace('"joint_2" value="0"', '"elbow" value="0"', 1))
    (line,) = printed("srdf", arm, "--check", str(file)).splitlines()
    assert line.startswith(f"{file}:")
    assert line.endswith("state 'home': the robot has no joint 'elbow'")
    assert printed.status == 1
    printed("srdf", arm, "-o", str(file))
    assert printed.errors == f"teleopctl: {file} exists\n  --force replaces it.\n"


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("fk ARM 1 2", "The group 'arm' has 3 joints, got 2 positions"),
        ("fk ARM elbow=1", "The group 'arm' has no joint 'elbow' that moves by itself"),
        ("fk ARM joint_1=x", "'x' for the position of joint 'joint_1' is no finite number"),
        ("fk ARM nan 0 0", "nan is no finite number"),
        ("fk ARM 0 0 0 joint_1=1", "Give positions in the joints' order, by name, or a named"),
        ("fk ARM --named up", "The group 'arm' has no state 'up'"),
        ("fk ARM --group leg", "The robot 'arm' has no group 'leg'"),
        ("fk ARM --group gripper", "The group 'gripper' moves no single tip"),
        ("fk ARM --tool hat", "The group 'arm' knows no link 'hat'"),
        ("fk ARM --tool base", "The group 'arm' does not move link 'base'"),
        ("fk ARM --tool 1,2", "--tool takes 3 numbers"),
        ("fk ARM --frame hat", "The robot has no frame 'hat'"),
        ("fk ARM -p 20", "The precision is 0 to 17 digits, not 20"),
        ("fk no/robot.urdf", "There is no file no/robot.urdf"),
        ("fk arm:=1", "arm:= is an argument of a xacro file, and no file is given"),
        ("ik ARM 1 2", "A position is three numbers, x y z in m; got '1 2'"),
        ("ik ARM 1 2 x", "A position is three numbers, x y z in m; got '1 2 x'"),
        ("ik ARM 0 0 1 --rpy 1,2", "--rpy takes 3 numbers, roll,pitch,yaw; got '1,2'"),
        ("ik ARM 0 0 1 --quat 0,0,0,0", "The quaternion has length 0, and is no rotation"),
        ("ik ARM 0 0 1 --quat 0,0,0,1 --rpy 0,0,0", "Give --rpy or --quat, not both"),
        ("ik ARM 0 0 1 -n robot", "--namespace is about the running robot"),
        ("workspace ARM --samples 0", "The number of samples must be at least 1, got 0"),
        ("workspace ARM -o a.txt", "A picture is a file *.png, *.svg, *.pdf, not a.txt"),
        ("srdf ARM --samples 0", "--samples must be at least 1, got 0"),
        ("srdf ARM --check no.srdf", "no.srdf"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(printed, arm, words, sentence):
    assert printed(*words.replace("ARM", arm).split()) == ""
    assert printed.status in (1, 2)
    first = printed.errors.splitlines()[0]
    assert sentence in first
    assert "Traceback" not in printed.errors


def test_words_are_sorted_into_file_arguments_numbers_and_joints():
    found = source.sorted_words(["a.xacro", "ur:=5", "-0.5", "1,2", "j=3", "name"])
    assert found == source.Words("a.xacro", {"ur": "5"}, [-0.5, 1.0, 2.0], {"j": 3.0}, ["name"])
    with pytest.raises(UsageError):
        source.sorted_words(["inf"])


def test_a_joint_without_a_measured_position_is_no_joint_at_rest():
    description = RobotDescription.from_urdf(arm_urdf(THREE))
    groups = find_groups(description)
    measured = {"joint_1": 0.1, "joint_2": 0.2, "joint_3": 0.3}
    arm, _ = RunningRobot(description, groups, measured).arm()
    assert arm.positions.tolist() == [0.1, 0.2, 0.3]
    for positions in ({"joint_1": 0.1, "joint_3": 0.2}, {**measured, "joint_2": math.nan}):
        with pytest.raises(UnavailableError, match="no position of joint_2"):
            RunningRobot(description, groups, positions).arm()


def test_completion_offers_joints_groups_links_and_states_of_the_file(arm):
    typed = TypedWords({"words": [arm]})
    assert source.complete_joints(typed, "joint_") == ["joint_1=", "joint_2=", "joint_3="]
    assert source.complete_groups(typed, "") == ["arm", "gripper"]
    assert source.complete_links(typed, "link_") == ["link_1", "link_2", "link_3"]
    assert source.complete_all_links(typed, "b") == ["base"]
    assert source.complete_named_states(typed, "") == ["home", "zero"]
    assert source.complete_groups(TypedWords({"words": ["no/file.urdf"]}), "") == []


def test_a_tool_of_the_srdf_is_used(printed, arm, tmp_path):
    file = tmp_path / "tool.srdf"
    file.write_text(
        '<robot name="arm"><group name="arm"><chain base_link="base" tip_link="tool0"/></group>'
        '<tool group="arm" xyz="0 0 0.1"/></robot>'
    )
    document = json.loads(printed("fk", arm, "0", "0", "0", "--srdf", str(file), "--json"))
    assert document["position"]["z"] == pytest.approx(0.75)
