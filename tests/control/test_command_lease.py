"""While a hand drives the robot, controllers take commands from it and its servo alone."""

from typing import Any, cast

import pytest

from teleopctl.interfaces import get_action, get_message
from teleopctl.node import GoalState, LeaseWatch
from teleopctl.testing import ControlStack, serial_robot

HAND, OTHER = b"hand", b"other"
Floats = get_message("std_msgs/msg/Float64MultiArray")
Trajectory = get_message("trajectory_msgs/msg/JointTrajectory")
Point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
FollowJointTrajectory = get_action("control_msgs/action/FollowJointTrajectory")
GripperCommand = get_action("control_msgs/action/GripperCommand")
REASON = "/teleop_page (keys) drives the robot"


class Lease:
    """Lease of a hand, as the controllers' manager follows it."""

    term = 1

    def refusal(self, sender):
        return REASON if sender == OTHER else ""


@pytest.fixture
def stack():
    stack = ControlStack(
        serial_robot(joints=1, initial=(0.0,), states=("position", "velocity")), update_rate=100
    )
    stack.lease = cast(LeaseWatch, Lease())
    return stack


def load(stack, kind, **parameters):
    stack.load_controller("arm", kind, parameters)
    stack.activate("arm")
    return stack.nodes["arm"]


def refusals(node):
    return [text for _, text in node.log.lines if "is refused" in text]


def trajectory(position):
    point = Point(positions=[position])
    point.time_from_start.nanosec = 10_000_000
    return Trajectory(joint_names=["joint1"], points=[point])


def test_a_stream_of_others_is_refused_with_one_line_and_moves_nothing(stack):
    node = load(
        stack,
        "forward_command_controller/ForwardCommandController",
        joints=["joint1"],
        interface_name="position",
    )
    for _ in range(3):
        node.receive("~/commands", Floats(data=[0.5]), OTHER)
    stack.step(2)
    assert stack.state("joint1/position") == 0.0
    assert refusals(node) == [f"The command on ~/commands is refused: {REASON}"]
    node.receive("~/commands", Floats(data=[0.25]), HAND)
    stack.step(2)
    assert stack.state("joint1/position") == 0.25


def test_trajectories_of_others_are_refused_and_their_goals_end_with_the_reason(stack):
    node = load(
        stack,
        "joint_trajectory_controller/JointTrajectoryController",
        joints=["joint1"],
        command_interfaces=["position"],
        state_interfaces=["position"],
    )
    node.receive("~/joint_trajectory", trajectory(0.5), OTHER)
    server: Any = stack.action_servers["arm/follow_joint_trajectory"]
    server.goal_sender = OTHER
    goal = server.send_goal(FollowJointTrajectory.Goal(trajectory=trajectory(0.5)))
    stack.step(10)
    assert stack.state("joint1/position") == 0.0
    assert goal.status == GoalState.ABORTED
    assert server.result(goal).error_string == REASON
    server.goal_sender = HAND
    goal = server.send_goal(FollowJointTrajectory.Goal(trajectory=trajectory(0.25)))
    stack.step(10)
    assert goal.status == GoalState.SUCCEEDED
    assert stack.state("joint1/position") == 0.25


def test_a_refused_goal_leaves_the_goal_that_runs(stack):
    load(
        stack,
        "joint_trajectory_controller/JointTrajectoryController",
        joints=["joint1"],
        command_interfaces=["position"],
        state_interfaces=["position"],
    )
    server: Any = stack.action_servers["arm/follow_joint_trajectory"]
    running = server.send_goal(FollowJointTrajectory.Goal(trajectory=trajectory(0.25)))
    server.goal_sender = OTHER
    server.send_goal(FollowJointTrajectory.Goal(trajectory=trajectory(0.5)))
    stack.step(10)
    assert running.status == GoalState.SUCCEEDED


def test_a_gripper_rejects_the_goals_of_others(stack):
    node = load(stack, "position_controllers/GripperActionController", joint="joint1")
    server: Any = stack.action_servers["arm/gripper_cmd"]
    server.goal_sender = OTHER
    assert server.send_goal(GripperCommand.Goal()) is None  # rejected
    assert refusals(node) == [f"The action goal is refused: {REASON}"]


def test_a_mobile_base_takes_velocities_of_the_hand_alone():
    wheels = serial_robot(2, commands=("velocity",), states=("position",), kind="continuous")
    stack = ControlStack(wheels)
    stack.lease = cast(LeaseWatch, Lease())
    node = load(
        stack,
        "diff_drive_controller/DiffDriveController",
        left_wheel_names=["joint1"],
        right_wheel_names=["joint2"],
        wheel_radius=0.1,
        wheel_separation=0.4,
        use_stamped_vel=False,
    )
    forward = get_message("geometry_msgs/msg/Twist")()
    forward.linear.x = 0.1
    for sender, speed in ((OTHER, 0.0), (HAND, 1.0)):
        node.receive("~/cmd_vel_unstamped", forward, sender)
        stack.step(2)
        assert stack.commands("velocity") == pytest.approx([speed, speed])
    assert refusals(node) == [f"The velocity command is refused: {REASON}"]
