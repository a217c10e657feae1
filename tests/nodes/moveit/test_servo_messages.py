"""Commands and controllers as servo understands them."""

from types import SimpleNamespace

import numpy as np
import pytest

from teleopctl.errors import UsageError
from teleopctl.interfaces import get_message
from teleopctl.nodes.moveit.servo.commands import parts_of_limit, twist_of
from teleopctl.nodes.moveit.servo.outputs import ARRAY_TYPE, TRAJECTORY_TYPE, Target, choose_targets

TwistStamped = get_message("geometry_msgs/msg/TwistStamped")
JTC = "joint_trajectory_controller/JointTrajectoryController"
FORWARD = "forward_command_controller/ForwardCommandController"


def controller(name, kind, *claimed, state="active"):
    return SimpleNamespace(name=name, type=kind, state=state, claimed_interfaces=list(claimed))


def twist(*values):
    message = TwistStamped()
    linear, angular = message.twist.linear, message.twist.angular
    linear.x, linear.y, linear.z, angular.x, angular.y, angular.z = values
    return message


class TestControllers:
    def test_a_trajectory_controller_takes_trajectories_of_all_its_joints(self):
        arm = controller("arm", JTC, "a/position", "b/position", "a/velocity", "b/velocity")
        assert choose_targets([arm], ["a"], "/") == [
            Target("/arm/joint_trajectory", TRAJECTORY_TYPE, ("a", "b"))
        ]

    @pytest.mark.parametrize("quantity", ["position", "velocity"])
    def test_a_forward_controller_takes_arrays_in_its_own_order(self, quantity):
        arm = controller("arm", FORWARD, f"b/{quantity}", f"a/{quantity}")
        assert choose_targets([arm], ["a", "b"], "/left") == [
            Target("/left/arm/commands", ARRAY_TYPE, ("b", "a"), quantity)
        ]

    def test_controllers_that_share_the_joints_are_commanded_together(self):
        both = [controller("one", FORWARD, "a/position"), controller("two", JTC, "b/position")]
        assert [target.topic for target in choose_targets(both, ["a", "b"], "/")] == [
            "/one/commands",
            "/two/joint_trajectory",
        ]

    def test_controllers_of_other_joints_are_left_alone(self):
        both = [controller("one", FORWARD, "a/position"), controller("hand", JTC, "g/position")]
        assert [target.topic for target in choose_targets(both, ["a"], "/")] == ["/one/commands"]

    @pytest.mark.parametrize(
        "found",
        [
            controller("arm", JTC, "a/position", "b/position", state="inactive"),
            controller("arm", JTC, "a/position"),
            controller("arm", FORWARD, "a/effort", "b/effort"),
        ],
    )
    def test_without_controllers_of_all_joints_nothing_is_commanded(self, found):
        assert choose_targets([found], ["a", "b"], "/") == []


class TestTwists:
    def test_unitless_values_are_parts_of_the_largest_speeds(self):
        found = twist_of(twist(1, -0.5, 0, 0, 0, 0.25), unitless=True, linear=0.4, rotational=0.8)
        assert found == pytest.approx([0.4, -0.2, 0, 0, 0, 0.2])

    @pytest.mark.parametrize("value", [1.5, -1e9])
    def test_unitless_values_above_one_are_refused_as_by_moveit(self, value):
        message = twist(0, 0, value, 0, 0, 0)
        with pytest.raises(UsageError, match=r"unitless commands are -1 to 1"):
            twist_of(message, unitless=True, linear=0.4, rotational=0.8)
        with pytest.raises(UsageError, match="The command has the value"):
            parts_of_limit(np.array([0.1, value]), "The command")

    def test_speeds_in_units_are_limited_and_keep_their_direction(self):
        message = twist(3, 4, 0, 0, 0, -1e9)
        found = twist_of(message, unitless=False, linear=0.5, rotational=0.8)
        assert found == pytest.approx([0.3, 0.4, 0, 0, 0, -0.8])

    @pytest.mark.parametrize("value", [float("nan"), float("inf")])
    def test_what_is_no_number_is_refused(self, value):
        with pytest.raises(UsageError, match="not a finite number"):
            twist_of(twist(0, value, 0, 0, 0, 0), unitless=False, linear=0.4, rotational=0.8)
