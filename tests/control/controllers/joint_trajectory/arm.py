"""Arm with a joint trajectory controller: three joints at (1.1, 2.1, 3.1) rad, 100 Hz."""

from typing import Any

import pytest

from teleopctl.control.switching import SwitchRequest, switch_controller
from teleopctl.interfaces.store import get_message
from teleopctl.testing import ControlStack, serial_robot

TYPE = "joint_trajectory_controller/JointTrajectoryController"
JOINTS = ["joint1", "joint2", "joint3"]

JointTrajectory = get_message("trajectory_msgs/msg/JointTrajectory")
JointTrajectoryPoint = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
Duration = get_message("builtin_interfaces/msg/Duration")
Time = get_message("builtin_interfaces/msg/Time")
Float64MultiArray = get_message("std_msgs/msg/Float64MultiArray")


def near(values, tolerance=1e-3):
    return pytest.approx(values, abs=tolerance)


def duration(seconds):
    sec, nanosec = divmod(round(seconds * 1e9), 10**9)
    return Duration(sec=sec, nanosec=nanosec)


def point(seconds, positions=(), velocities=(), accelerations=(), effort=()):
    return JointTrajectoryPoint(
        positions=list(positions),
        velocities=list(velocities),
        accelerations=list(accelerations),
        effort=list(effort),
        time_from_start=duration(seconds),
    )


def trajectory(*points, joints=JOINTS, stamp_ns=0):
    message = JointTrajectory(joint_names=list(joints), points=list(points))
    sec, nanosec = divmod(stamp_ns, 10**9)
    message.header.stamp = Time(sec=sec, nanosec=nanosec)
    return message


class Arm:
    """Joint trajectory controller on mock hardware; `up` configures and activates it."""

    def __init__(self, *, robot=None, enforce_limits=None, **parameters):
        self.stack = ControlStack(robot or serial_robot(), enforce_limits=enforce_limits)
        options = {
            "joints": JOINTS,
            "command_interfaces": ["position"],
            "state_interfaces": ["position"],
            **parameters,
        }
        dotted = {name.replace("__", "."): value for name, value in options.items()}
        self.controller: Any = self.stack.load_controller("arm", TYPE, dotted)
        self.node = self.stack.nodes["arm"]

    def configure(self):
        return self.stack.manager.configure_controller("arm")

    def activate(self):
        ok, message = switch_controller(self.stack.manager, SwitchRequest(["arm"], []))
        assert ok, message
        return self

    def deactivate(self):
        ok, message = switch_controller(self.stack.manager, SwitchRequest([], ["arm"]))
        assert ok, message

    def up(self):
        assert self.configure(), self.node.log.lines
        return self.activate()

    def send(self, message):
        self.node.receive("~/joint_trajectory", message)

    def command(self, *positions):
        self.node.receive("~/commands", Float64MultiArray(data=list(positions)))

    def step(self, seconds):
        self.stack.step(round(seconds * 100))

    def freeze(self, **values):
        """Set state interfaces to values that no longer follow the commands."""
        hardware: Any = self.stack.resources.components["Hardware"].hardware
        hardware._pairs = []
        for name, value in values.items():
            self.stack.resources.state_interfaces[name.replace("_", "/")].value = value

    @property
    def commands(self):
        return self.stack.commands()

    @property
    def state_messages(self):
        return self.node.published("~/controller_state")

    def rejections(self):
        return self.node.log.texts("error")
