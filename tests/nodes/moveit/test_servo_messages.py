"""Commands as servo understands them."""

import numpy as np
import pytest

from teleopctl.errors import UsageError
from teleopctl.interfaces import get_message
from teleopctl.nodes.moveit.servo.commands import parts_of_limit, twist_of

TwistStamped = get_message("geometry_msgs/msg/TwistStamped")


def twist(*values):
    message = TwistStamped()
    linear, angular = message.twist.linear, message.twist.angular
    linear.x, linear.y, linear.z, angular.x, angular.y, angular.z = values
    return message


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
