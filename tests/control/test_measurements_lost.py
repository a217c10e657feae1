"""Hardware that returns NaN as position: controllers stop the joints, once explained.

Joints have a velocity limit of 1 rad/s, so that they decelerate by 5 rad/s²; cycles come at 100 Hz.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest

from teleopctl.interfaces import get_action, get_message
from teleopctl.node import GoalState
from teleopctl.testing import ControlStack, serial_robot

TRAJECTORY = "joint_trajectory_controller/JointTrajectoryController"
FollowJointTrajectory = get_action("control_msgs/action/FollowJointTrajectory")
GripperCommand = get_action("control_msgs/action/GripperCommand")
Point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
MultiDof = get_message("control_msgs/msg/MultiDOFCommand")
LOST = "Hardware does not measure 'joint1/position': it is not a number"


class Robot:
    """One joint at 0, whose position may become NaN."""

    def __init__(self, commands=("position",)):
        urdf = serial_robot(
            1,
            initial=(0.0,),
            commands=commands,
            states=("position", "velocity"),
            limits='lower="-9" upper="9" effort="10" velocity="1"',
            parameters=""
            if "effort" in commands
            else '<param name="calculate_dynamics">true</param>',
        )
        self.stack = ControlStack(urdf, enforce_limits=False)
        (component,) = self.stack.resources.components.values()
        self._hardware: Any = component.hardware
        self._read = self._hardware.read

    def load(self, kind, **parameters):
        self.stack.load_controller("arm", kind, parameters)
        self.stack.activate("arm")
        self.stack.step()
        return self

    def lose_position(self):
        def read(time_ns, period):
            outcome = self._read(time_ns, period)
            self.stack.resources.state_interfaces["joint1/position"].value = math.nan
            return outcome

        self._hardware.read = read

    def measure_again(self):
        self._hardware.read = self._read

    def send_goal(self, position=5.0, seconds=10):
        goal = FollowJointTrajectory.Goal()
        point = Point(positions=[position])
        point.time_from_start.sec = seconds
        goal.trajectory.joint_names, goal.trajectory.points = ["joint1"], [point]
        handle: Any = self.stack.action_servers["arm/follow_joint_trajectory"].send_goal(goal)
        return handle

    def reason(self, handle):
        server = self.stack.action_servers["arm/follow_joint_trajectory"]
        return server.result(handle).error_string

    def errors(self):
        return self.stack.nodes["arm"].log.texts("error")

    def commands(self, cycles, interface="position"):
        values = []
        for _ in range(cycles):
            self.stack.step()
            values.append(self.stack.command(f"joint1/{interface}"))
        return values


@pytest.fixture
def arm():
    """A trajectory controller, in the midst of a goal at 0.5 rad/s."""
    robot = Robot().load(
        TRAJECTORY,
        joints=["joint1"],
        command_interfaces=["position"],
        state_interfaces=["position", "velocity"],
    )
    robot.handle = robot.send_goal()
    robot.stack.step(100)
    return robot


def test_a_trajectory_decelerates_and_its_goal_ends_with_the_name_of_the_interface(arm):
    arm.lose_position()
    values = arm.commands(60)
    steps = [later - earlier for earlier, later in itertools.pairwise(values)]
    assert values[0] == pytest.approx(0.505, abs=0.01)
    assert max(steps) < 0.0051
    assert all(later - earlier > -0.0006 for earlier, later in itertools.pairwise(steps))
    assert steps[-1] == 0.0
    assert arm.handle.status == GoalState.ABORTED
    assert arm.reason(arm.handle) == LOST
    assert arm.errors() == [f"{LOST}: the joints decelerate and hold"]


def test_a_value_that_is_missing_once_changes_nothing(arm):
    arm.lose_position()
    arm.stack.step(5)
    arm.measure_again()
    arm.stack.step(5)
    assert arm.handle.is_active
    assert arm.errors() == []


def test_goals_end_at_once_until_all_joints_are_measured_again(arm):
    arm.lose_position()
    held = arm.commands(60)[-1]
    handle = arm.send_goal(1.0, 1)
    arm.stack.step(2)
    assert (handle.status, arm.reason(handle)) == (GoalState.ABORTED, LOST)
    arm.measure_again()
    assert arm.commands(20) == pytest.approx([held] * 20)
    handle = arm.send_goal(1.0, 1)
    arm.stack.step(110)
    assert handle.status == GoalState.SUCCEEDED


def test_a_stop_meanwhile_goes_on_when_the_joint_is_measured_again(arm):
    arm.lose_position()
    held = arm.commands(60)[-1]
    arm.stack.manager.robot_stop.hold("/button")
    arm.stack.step(5)
    arm.measure_again()
    assert arm.commands(20) == pytest.approx([held] * 20)
    assert arm.send_goal(1.0, 1) is None
    arm.stack.manager.robot_stop.hold("")
    arm.stack.step()
    handle = arm.send_goal(1.0, 1)
    arm.stack.step(110)
    assert handle.status == GoalState.SUCCEEDED


def test_a_velocity_that_follows_from_the_error_goes_to_zero():
    robot = Robot(commands=("velocity",)).load(
        TRAJECTORY,
        joints=["joint1"],
        command_interfaces=["velocity"],
        state_interfaces=["position", "velocity"],
        **{"gains.joint1.p": 10.0, "gains.joint1.ff_velocity_scale": 1.0},
    )
    robot.send_goal()
    robot.stack.step(100)
    robot.lose_position()
    assert robot.commands(60, "velocity")[-1] == 0.0


def test_a_goal_of_hardware_that_never_measured_ends():
    robot = Robot()
    robot.lose_position()
    robot.stack.step(20)
    robot.load(
        TRAJECTORY,
        joints=["joint1"],
        command_interfaces=["position"],
        state_interfaces=["position", "velocity"],
    )
    handle = robot.send_goal()
    robot.stack.step(20)
    assert (handle.status, robot.reason(handle)) == (GoalState.ABORTED, LOST)


def test_a_gripper_stops_at_the_last_measured_position_and_its_goal_ends():
    robot = Robot().load("position_controllers/GripperActionController", joint="joint1")
    goal = GripperCommand.Goal()
    goal.command.position = 5.0
    hardware: Any = robot._hardware
    robot.stack.resources.state_interfaces["joint1/position"].value = 0.2
    hardware.read = lambda *_: None
    handle: Any = robot.stack.action_servers["arm/gripper_cmd"].send_goal(goal)
    robot.stack.step(3)
    assert handle.is_active
    robot.stack.resources.state_interfaces["joint1/position"].value = math.nan
    assert robot.commands(20)[-1] == 0.2
    assert handle.status == GoalState.ABORTED
    assert robot.errors() == [f"{LOST}: the gripper stops, and goals are aborted"]
    handle = robot.stack.action_servers["arm/gripper_cmd"].send_goal(goal)
    robot.stack.step(2)
    assert handle.status == GoalState.ABORTED


def test_the_effort_of_a_pid_becomes_zero():
    robot = Robot(commands=("effort",)).load(
        "pid_controller/PidController",
        dof_names=["joint1"],
        command_interface="effort",
        reference_and_state_interfaces=["position"],
        **{"gains.joint1.p": 10.0},
    )
    robot.stack.nodes["arm"].receive(
        "~/reference", MultiDof(dof_names=["joint1"], values=[0.5], values_dot=[])
    )
    assert robot.commands(3, "effort")[-1] == 5.0
    robot.lose_position()
    assert robot.commands(20, "effort")[-1] == 0.0
    assert robot.errors() == [f"{LOST}: its command is 0, or stays if it is a position"]
