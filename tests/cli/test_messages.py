"""``--filter``."""

import pytest

from teleopctl.cli.messages import filter_predicate
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces.store import get_message

Pose = get_message("geometry_msgs/msg/PoseStamped")
Transforms = get_message("tf2_msgs/msg/TFMessage")
Transform = get_message("geometry_msgs/msg/TransformStamped")
JointState = get_message("sensor_msgs/msg/JointState")


def test_a_filter_is_python_with_the_message_as_m():
    wanted = filter_predicate("m.pose.position.x > 1")
    pose = Pose()
    assert not wanted(pose)
    pose.pose.position.x = 2.0
    assert wanted(pose)


def test_a_filter_that_is_no_python_is_wrong_usage():
    with pytest.raises(TeleopctlError, match="Invalid filter expression") as failure:
        filter_predicate("m.data >")
    assert failure.value.exit_status == 2


def test_a_filter_that_fails_says_so():
    with pytest.raises(TeleopctlError, match="has no attribute"):
        filter_predicate("m.data > 3")(Pose())
