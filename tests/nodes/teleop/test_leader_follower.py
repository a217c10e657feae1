"""What ends the following of a leader arm, besides its jumps."""

import time
from types import SimpleNamespace
from typing import Any

import pytest

from teleopctl.node import Node, init, try_shutdown
from teleopctl.nodes.teleop.leader_follower import LeaderFollower
from teleopctl.teleop import HandSample, JointFollowing, LeaderMapping


@pytest.mark.parametrize(
    ("age_s", "is_stopped", "problem"),
    [
        (-60.0, False, ""),
        (60.0, False, "the leader is silent: engage again"),
        (-60.0, True, "the robot is stopped"),
    ],
)
def test_silence_and_the_stop_of_the_robot_end_it(ros, age_s, is_stopped, problem):
    del ros
    pulls: list[Any] = []
    robot = SimpleNamespace(need_states=lambda: None)
    driver: Any = SimpleNamespace(is_stopped=is_stopped, pull=pulls.append, robot_state=robot)
    init(args=[])
    try:
        with Node("follower") as node:
            follower = LeaderFollower(node, driver, LeaderMapping(), "/leader", 0.25)
            follower._following = JointFollowing(["a"])
            follower._following.engage({"a": 0.0}, 0.0)
            follower._sample = HandSample(received_s=time.monotonic() - age_s)
            follower.check()
    finally:
        try_shutdown()
    assert follower.is_engaged == (not problem)
    assert follower.problem == problem
    assert pulls == ([None] if problem else [])
