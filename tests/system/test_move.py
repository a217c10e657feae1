"""``teleopctl move`` moves the arm of a running controller manager, and stops it on Ctrl-C."""

import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

import teleopctl
from teleopctl.cli import main
from teleopctl.testing import RosGraph, eventually
from tests.api.test_docstrings import NEEDS_A_ROBOT, failures
from tests.samples import sample

EXAMPLE = Path(__file__).parents[2] / "docs/examples/move_arm.py"


@pytest.fixture(scope="module")
def robot(shared_ros: RosGraph) -> RosGraph:
    """The tutorial's arm with its trajectory controllers, on mock hardware."""
    up = shared_ros.run("launch --detach controller.yaml", timeout=60)
    assert up.returncode == 0, up.stderr
    return shared_ros


class Command:
    """Runs commands in this process."""

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self._capsys = capsys
        self.status = 0
        self.errors = ""

    def __call__(self, line: str) -> str:
        self._capsys.readouterr()
        self.status = main.run(line.split())
        written, self.errors = self._capsys.readouterr()
        return written


@pytest.fixture
def command(robot: RosGraph, capsys: pytest.CaptureFixture[str]) -> Command:
    return Command(capsys)


@pytest.fixture(scope="module")
def arm(robot: RosGraph) -> Iterator[teleopctl.RunningArm]:
    """The arm, as a program moves it."""
    with teleopctl.RunningArm(node=robot.node) as running:
        yield running


def position(command: Command) -> list[float]:
    return list(json.loads(command("kinematics fk --json"))["position"].values())


def test_the_gripper_is_moved_to_a_position_and_the_result_is_said_in_words(command):
    written = command("move --to 0.3,0.9,1.4")
    assert command.status == 0
    assert written.startswith("'claw_support' is at [0.300, 0.900, 1.400] after ")
    assert written.endswith(" mm from the goal\n")
    assert command.errors.startswith("Planned a motion of ")
    assert position(command) == pytest.approx([0.3, 0.9, 1.4], abs=1e-3)


def test_the_gripper_is_moved_on_a_line_in_its_own_frame(command):
    command("move --named home")
    command("move --to 0,0,-0.05 --frame claw_support --linear --speed 0.5")
    assert command.status == 0
    assert position(command) == pytest.approx([-0.02, 0.82, 1.407], abs=2e-3)


def test_a_goal_may_be_in_a_frame_of_tf(robot, command):
    broadcast = robot.spawn(
        "tf static --frame-id world --child-frame-id table --x 0.3 --y 0.9 --z 1.0"
    )
    broadcast.wait_for_line("Spinning until stopped - publishing transform", stream="stderr")
    command("move --to 0,0,0.4 --frame table")
    broadcast.interrupt()
    assert command.status == 0, command.errors
    assert position(command) == pytest.approx([0.3, 0.9, 1.4], abs=1e-3)


def test_joints_states_and_the_gripper_are_moved_one_after_the_other(command):
    document = json.loads(command("move --joints joint_1=0.5,joint_2=0.1 --gripper open --json"))
    arm, gripper = document["executed"]
    assert (arm["result"], gripper["result"]) == ("succeeded", "succeeded")
    assert arm["joints"]["joint_1"] == pytest.approx(0.5, abs=1e-3)
    assert gripper["joints"]["joint_4"] == pytest.approx(-1.5708, abs=1e-2)
    command("move --gripper close")
    assert command.status == 0
    joints = json.loads(command("kinematics fk --json"))["joints"]
    assert joints["joint_1"] == pytest.approx(0.5, abs=1e-3)


def test_a_dry_run_plans_draws_and_moves_nothing(command, tmp_path):
    before = position(command)
    written = command("move --named zero --dry-run --plot")
    assert (command.status, "joint_1" in written) == (0, True)
    picture = tmp_path / "motion.svg"
    command(f"move --named zero --dry-run --plot -o {picture}")
    assert picture.is_file()
    planned = json.loads(command("move --named zero --dry-run --json"))["planned"]
    assert planned["points"][-1]["positions"] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
    assert position(command) == before


def test_ctrl_c_stops_the_arm_and_ends_with_status_130(robot, command):
    command("move --named home")
    moving = robot.spawn("move --joints joint_1=1.5 --speed 0.01")
    eventually(lambda: json.loads(command("kinematics fk --json"))["joints"]["joint_1"] > 0.02)
    moving.interrupt()
    assert moving.wait() == 130
    assert moving.stderr.endswith("Stopped by Ctrl-C\n")
    stopped = json.loads(command("kinematics fk --json"))["joints"]["joint_1"]
    assert stopped < 1.4
    command("move --named home")
    assert command.status == 0


@pytest.mark.parametrize(
    ("line", "status", "sentence"),
    sample(
        [
            ("move", 2, "Give a goal: --to X,Y,Z"),
            ("move --to 1,2", 2, "--to takes 3 numbers, x,y,z; got '1,2'"),
            ("move --to 0,0,1 --named home", 2, "Give one goal, not --to and --named"),
            (
                "move --named home --rpy 1,0,0",
                2,
                "--rpy, --quat, --frame and --linear belong to --to",
            ),
            ("move --named up", 1, "The group 'arm' has no state 'up'"),
            ("move --joints 1,2", 2, "The group 'arm' has 3 joints, got 2 positions"),
            ("move --joints elbow=1", 1, "The group 'arm' has no joint 'elbow'"),
            ("move --named home --speed 0", 2, "--speed is a factor above 0 and at most 1, got 0"),
            ("move --gripper 1.5", 2, "--gripper is open, close or a number from 0"),
            ("move --gripper open --group gripper", 2, "The group 'gripper' moves no single tip"),
            ("move --named home --timeout 0", 2, "--timeout must be above 0 s, got 0"),
            ("move --to 0,0,9", 1, "The goal pose cannot be reached, the nearest is"),
            (
                "move --to 0,0,1 --frame moon",
                1,
                "Neither the robot nor /tf, within 2 s, has a frame 'moon'",
            ),
            ("move --named home -n moon", 1, "No robot runs: nothing publishes /moon/robot_descr"),
            ("move --named home -o a.png", 2, "-o writes the picture of --plot"),
        ],
        3,
    ),
)
def test_what_cannot_be_done_is_said_in_one_sentence_and_nothing_moves(
    command, line, status, sentence
):
    before = position(command)
    assert command(line) == ""
    assert sentence in command.errors.splitlines()[0]
    assert "Traceback" not in command.errors
    assert command.status == status
    assert position(command) == before


def test_a_stopped_robot_and_one_without_controllers_say_so(robot, command):
    command("stop --robot")
    command("move --joints joint_1=0.1")
    assert command.status == 1
    assert "the robot is stopped by /robot_stop" in command.errors
    command("stop --robot --release")
    command("control set_controller_state arm_controller inactive")
    command("move --joints joint_1=0.1")
    assert command.status == 1
    assert "No active controller takes trajectories of joint_1, joint_2, joint_3" in command.errors
    assert "Active: gripper_controller (joint_4)" in command.errors
    command("control set_controller_state arm_controller active")
    command("move --joints joint_1=0.1")
    assert command.status == 0


class TestProgram:
    @pytest.mark.parametrize("name", sorted(NEEDS_A_ROBOT))
    def test_the_example_of_a_name_runs(self, robot, monkeypatch, name):
        for variable, value in robot.env.items():
            monkeypatch.setenv(variable, value)
        assert not failures(getattr(teleopctl, name), name)

    def test_the_example_program_moves_the_arm(self, robot):
        done = subprocess.run(
            [sys.executable, EXAMPLE],
            env={**os.environ, **robot.env},
            capture_output=True,
            text=True,
            timeout=100,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        reached, planned, is_home = done.stdout.splitlines()
        assert reached.startswith("'claw_support' is at [0.300, 0.900, 1.400] after ")
        assert planned.endswith(" s by straight")
        assert is_home.startswith("{'joint_1': ")

    def test_a_plan_moves_nothing_until_it_is_executed(self, arm):
        before = arm.positions
        plan = arm.plan(joints={"joint_1": before["joint_1"] + 0.2}, speed=0.5)
        assert (arm.positions, plan.planner) == (before, "straight")
        parts: list[float] = []
        reached = arm.execute(plan, parts.append)
        assert reached.joints["joint_1"] == pytest.approx(before["joint_1"] + 0.2, abs=0.01)
        assert reached.largest_joint_error < 0.01
        assert parts == sorted(parts)

    def test_stop_ends_a_motion_in_another_thread(self, arm):
        errors: list[teleopctl.ExecutionError] = []

        def move() -> None:
            try:
                arm.move(joints={"joint_1": -1.5}, speed=0.02)
            except teleopctl.ExecutionError as error:
                errors.append(error)

        before = arm.positions["joint_1"]
        moving = threading.Thread(target=move)
        moving.start()
        eventually(lambda: arm.positions["joint_1"] < before - 0.01)
        arm.stop()
        moving.join()
        assert errors[0].message == "The motion was stopped"
        assert -1.4 < errors[0].result.joints["joint_1"] < before

    @pytest.mark.parametrize(
        ("goal", "error", "sentence"),
        [
            ({}, "UsageError", "Give one goal: to, joints or named"),
            ({"to": [1, 2]}, "UsageError", "to is 3 finite numbers, x, y, z"),
            ({"to": [0, 0, float("nan")]}, "UsageError", "to is 3 finite numbers"),
            ({"named": "home", "linear": True}, "UsageError", "belong to the goal 'to'"),
            ({"named": "home", "speed": 2}, "UsageError", "speed is a factor above 0"),
            ({"named": "up"}, "NotFoundError", "The group 'arm' has no state 'up'"),
            ({"to": [0, 0, 9]}, "PlanningError", "The goal pose cannot be reached"),
        ],
    )
    def test_what_cannot_be_planned_is_an_error_of_a_class(self, arm, goal, error, sentence):
        with pytest.raises(teleopctl.TeleopctlError, match=sentence) as caught:
            arm.move(**goal)
        assert type(caught.value).__name__ == error


@pytest.mark.nightly
def test_where_move_group_runs_it_is_asked_with_its_scene(robot, command):
    up = robot.run("run --detach moveit_ros_move_group move_group", timeout=60)
    assert up.returncode == 0, up.stderr
    box = (
        "{header: {frame_id: world}, id: box, primitives: [{type: 1, dimensions: [0.3, 0.3, 0.3]}],"
        " primitive_poses: [{position: {x: 0.3, y: 0.9, z: 1.4}, orientation: {w: 1.0}}]}"
    )
    message = robot.run(
        ["topic", "pub", "--once", "/collision_object", "moveit_msgs/msg/CollisionObject", box]
    )
    assert message.returncode == 0, message.stderr
    eventually(lambda: "'box'" in command("kinematics ik 0.3 0.9 1.4"))
    written = command("kinematics ik 0.3 0.9 1.4")
    assert written.startswith("Not reached (NO_IK_SOLUTION, -31): ")
    assert "Reached, but for that, at:" in written
    command("move --to 0.3,0.9,1.4")
    assert (command.status, "GOAL_IN_COLLISION (-12)" in command.errors) == (1, True)
    command("kinematics ik 0.3 0.9 1.4 --direct")
    assert command.status == 0
    command("move --to -0.3,0.9,1.0 --speed 0.9")
    assert command.status == 0
    assert "(move_group, " in command.errors
    # Three joints do not hold the rotation: the place of the tool depends on what it comes to.
    written = command("move --tool 0,0.3,0 --to -0.3,1.1,1.2")
    assert (command.status, "(move_group, " in command.errors) == (0, True)
    assert written.startswith("'claw_support with its tool' is at [-0.300, 1.100, 1.200] after ")
    command("move --tool 0,0.3,0 --to -0.3,1.1,1.1 --linear")
    assert command.status == 2
    assert "With --direct (direct=True) the line is planned here" in command.errors
