"""Commands as servo understands them."""

from typing import Any

import numpy as np
import pytest

from teleopctl.errors import UsageError
from teleopctl.interfaces import get_message
from teleopctl.nodes.moveit.servo.commands import LateCommands, parts_of_limit, twist_of

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


class TestLateCommands:
    """Commands at 50 Hz of a sender whose clock is a day ahead."""

    AHEAD_S = 86_400.0

    @pytest.fixture
    def is_late(self):
        late = LateCommands()

        def is_late(sent_s, received_s):
            source_ns = round(1e9 * (sent_s + self.AHEAD_S))
            info: Any = {"publisher_gid": b"hand", "source_timestamp": source_ns}
            return late.is_late(info, round(1e9 * received_s))

        assert not any(is_late(0.02 * number, 0.02 * number + 0.001) for number in range(50))
        return is_late

    def test_those_that_come_at_once_after_a_pause_are_old_but_for_the_last(self, is_late):
        sent = [1.0 + 0.02 * number for number in range(150)]
        late = [is_late(sent_s, 4.0 + 1e-4 * number) for number, sent_s in enumerate(sent)]
        assert all(each for each, sent_s in zip(late, sent, strict=True) if sent_s < 3.4)
        assert not any(each for each, sent_s in zip(late, sent, strict=True) if sent_s > 3.6)

    def test_a_slower_way_is_no_late_one(self, is_late):
        assert not is_late(1.0, 1.4)

    def test_a_clock_that_is_set_back_holds_the_hand_up_for_a_second(self, is_late):
        late = [is_late(0.02 * number, 1.0 + 0.02 * number) for number in range(100)]
        assert late[:50] == [True] * 50
        assert not any(late[53:])
