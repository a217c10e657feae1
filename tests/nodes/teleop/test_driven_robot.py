"""What is known of the robot that a hand drives, and what it costs."""

from collections.abc import Callable

import pytest

from teleopctl.interfaces import get_message
from teleopctl.nodes.teleop import driven_robot
from teleopctl.nodes.teleop.driven_robot import DrivenRobot
from teleopctl.testing import eventually

JointState = get_message("sensor_msgs/msg/JointState")


def test_for_a_display_joint_states_are_received_for_a_moment_only(
    shared_ros, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(driven_robot, "_GLANCE_S", 3600.0)
    publisher = shared_ros.node.create_publisher(JointState, "/looked_at/joint_states", 10)
    robot = DrivenRobot(shared_ros.node, "servo_node", namespace="/looked_at")

    def is_received() -> bool:
        return bool(publisher.has_subscribers)

    def is_seen(position: float, read: Callable[[], dict[str, float]]) -> bool:
        publisher.publish(JointState(name=["joint_1"], position=[position]))
        return read() == {"joint_1": position}

    assert robot.glance() == {}
    eventually(lambda: is_seen(0.5, robot.glance))
    eventually(lambda: not is_received())
    assert robot.glance() == {"joint_1": 0.5}
    assert not is_received()
    # Who steers by them gets each one, and none that is old.
    assert robot.measured == {}
    eventually(lambda: is_seen(0.7, lambda: robot.measured))
    eventually(is_received)
    assert robot.glance() == {"joint_1": 0.7}
