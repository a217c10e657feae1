"""A ``ros_timer`` that follows ``/clock``."""

import itertools

from teleopctl.interfaces import get_message
from teleopctl.testing import eventually

Clock = get_message("rosgraph_msgs/msg/Clock")

LAUNCH = """launch:
- arg: {name: who, default: robots}
- set_use_sim_time: {value: true}
- ros_timer:
    period: 5.0
    children: [log: {message: "the time of $(var who) has come"}]
- ros_timer:
    period: 5000.0
    children: [log: {message: never}]
"""


def test_it_waits_for_simulated_time_and_the_end_of_the_launch_cancels_it(ros):
    (ros.folder / "file.yaml").write_text(LAUNCH)
    launch = ros.spawn("launch file.yaml")
    launch.wait_for_line("Default logging verbosity")
    publisher = ros.node.create_publisher(Clock, "/clock", 10)
    seconds = itertools.count(9)

    # The time goes on: the timer may be made after the first message.
    def has_fired() -> bool:
        message = Clock()
        message.clock.sec = next(seconds)
        publisher.publish(message)
        return "[launch.user]: the time of robots has come\n" in launch.stdout

    eventually(has_fired)
    launch.interrupt()
    assert launch.wait() == 0
    assert "never" not in launch.stdout
