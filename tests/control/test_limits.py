"""Commands outside a joint's limits are clamped, and reported once."""

import math

import pytest

from teleopctl.control.handles import CommandInterface, StateInterface
from teleopctl.control.limits import JointLimiter, limits_text
from teleopctl.robot.joint_rules import JointLimits
from teleopctl.testing import ControlStack, serial_robot

PERIOD = 0.01


class Joint:
    def __init__(self, limits, *interfaces):
        self.reports: list[str] = []
        self.command = {name: CommandInterface("joint", name) for name in interfaces}
        self.state = {
            name: StateInterface("joint", name, initial_value=0.0)
            for name in ("position", "velocity")
        }
        for command in self.command.values():
            command.owner = "somebody"
        self.limiter = JointLimiter("joint", limits, self.command, self.state, self.reports.append)

    def limit(self, interface, value, period=PERIOD):
        self.command[interface].value = value
        self.limiter.enforce(period)
        return self.command[interface].value


def test_a_position_is_clamped_into_its_limits():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0), "position")
    assert joint.limit("position", 5.0) == 1.0
    assert joint.limit("position", -5.0) == -1.0
    assert joint.limit("position", 0.5) == 0.5


def test_a_position_moves_no_faster_than_the_velocity_limit_from_the_last_command():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0, velocity=10.0), "position")
    assert joint.limit("position", 1.0) == pytest.approx(0.1)
    assert joint.limit("position", 1.0) == pytest.approx(0.2)


def test_it_is_reported_once_with_joint_value_and_limits():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0), "position")
    for _ in range(5):
        joint.limit("position", 5.0)
    (report,) = joint.reports
    assert "'joint'" in report
    assert "position 5 is clamped to 1" in report
    assert "[-1, 1]" in report
    joint.limit("position", 0.0)
    joint.limit("position", 5.0)
    assert len(joint.reports) == 1
    joint.limiter.reset("position")
    joint.limit("position", 5.0)
    assert len(joint.reports) == 2, "another controller takes the joint over"


@pytest.mark.parametrize(
    ("limits", "interface", "asked", "told"),
    [
        (JointLimits(velocity=1.0, line=7), "velocity", 6.0, "6 is clamped to 1 (velocity limit 1"),
        (JointLimits(-1.0, 1.0, line=7), "position", 2.0, "2 is clamped to 1 (position limits"),
        (
            JointLimits(-1.0, 1.0, velocity=10.0, line=9, lines={"velocity": 7}),
            "position",
            0.5,
            "position 0.5 is clamped to 0.1 (velocity limit 10",
        ),
        (JointLimits(effort=3.0, line=7), "effort", -5.0, "-5 is clamped to -3 (effort limit 3"),
    ],
)
def test_a_report_names_both_numbers_and_the_line_of_the_limit(limits, interface, asked, told):
    joint = Joint(limits, interface)
    joint.limit(interface, asked)
    (report,) = joint.reports
    assert report.startswith(f"Command of joint 'joint' is outside its limits: {interface} ")
    assert told in report
    assert report.endswith(", line 7 of the robot description)")


@pytest.mark.parametrize(
    ("distribution", "enforced"),
    [("", False), ("humble", False), ("jazzy", False), ("kilted", True), ("rolling", True)],
)
def test_the_distribution_decides_whether_limits_are_enforced(distribution, enforced, monkeypatch):
    monkeypatch.setenv("ROS_DISTRO", distribution)
    stack = ControlStack(serial_robot(limits='lower="-1" upper="1" effort="1" velocity="99"'))
    command = stack.resources.command_interfaces["joint1/position"]
    command.owner, command.value = "somebody", 3.0
    stack.step()
    assert command.value == (1.0 if enforced else 3.0)
    said = "enabled..." if enforced else "disabled. Command limits from URDF will be ignored."
    assert f"Enforcing command limits is {said}" in stack.log.texts("info")


def test_no_command_stays_no_command():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0, velocity=1.0), "position", "velocity")
    assert math.isnan(joint.limit("position", math.nan))
    assert math.isnan(joint.limit("velocity", math.nan))
    assert not joint.reports


def test_interfaces_that_nobody_owns_are_left_alone():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0), "position")
    joint.command["position"].owner = None
    assert joint.limit("position", 5.0) == 5.0


def test_a_velocity_is_clamped_and_stops_at_the_position_limit():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0, velocity=1.0), "velocity")
    assert joint.limit("velocity", 2.0) == 1.0
    joint.state["position"].value = 0.995
    assert joint.limit("velocity", 1.0) == pytest.approx(0.5)
    joint.state["position"].value = 1.01
    assert joint.limit("velocity", 1.0) == 0.0
    assert joint.limit("velocity", -1.0) == 0.0


def test_a_velocity_changes_no_faster_than_the_acceleration_limit():
    limits = JointLimits(velocity=10.0, acceleration=5.0, deceleration=5.0)
    joint = Joint(limits, "velocity")
    joint.limit("velocity", 0.0)
    assert joint.limit("velocity", 10.0) == pytest.approx(0.05)


def test_an_effort_does_not_push_outwards_at_a_position_limit():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0, effort=3.0, velocity=1.0), "effort")
    assert joint.limit("effort", 5.0) == 3.0
    joint.state["position"].value = 1.0
    assert joint.limit("effort", 5.0) == 0.0
    assert joint.limit("effort", -5.0) == -3.0
    joint.state["position"].value = 0.0
    joint.state["velocity"].value = 2.0
    assert joint.limit("effort", 5.0) == 0.0


def test_a_joint_outside_its_limits_is_led_back():
    joint = Joint(JointLimits(lower=-1.0, upper=1.0, velocity=1.0), "position")
    joint.state["position"].value = 1.5
    assert joint.limit("position", 0.0) == 1.0


def test_a_new_owner_starts_from_the_measured_position():
    joint = Joint(JointLimits(velocity=10.0), "position")
    joint.limit("position", 0.05)
    joint.state["position"].value = 0.5
    joint.limiter.reset("position")
    assert joint.limit("position", 0.55) == 0.55


def test_the_limits_of_a_joint_are_told_on_one_line():
    limits = JointLimits(lower=-1.0, upper=2.0, velocity=0.5)
    assert limits_text(limits) == "position [-1, 2], velocity 0.5"
    assert limits_text(JointLimits()) == "no limits"
