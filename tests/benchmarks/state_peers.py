"""Peer processes of the robot_state_publisher benchmark.

``python state_peers.py joints node|raw COUNT`` publishes, for each line on its standard input, the
states of seven joints COUNT times at 1 kHz, and prints ``done``. ``node`` is a teleopctl node,
``raw`` plain Zenoh with as many bytes. ``python state_peers.py relay`` replaces
robot_state_publisher without computing anything: it answers each raw state with as many bytes as
the transforms have.

The first eight bytes of raw data are the time of publishing in nanoseconds since the epoch.
"""

import math
import sys
import time
from collections.abc import Callable, Iterator

from teleopctl.testing import LONGEST_WAIT_S
from tests.benchmarks.echo_peers import open_raw

JOINTS = [f"joint_{number}" for number in range(1, 8)]
PERIOD_S = 0.001
STATE_KEY, TF_KEY = "benchmark/joint_states", "benchmark/tf"
# Sizes in CDR for seven joints.
STATE_BYTES, TF_BYTES = 300, 628


def every_millisecond(count: int, send: Callable[[int], object]) -> None:
    begun = time.perf_counter()
    for number in range(count):
        time.sleep(max(0.0, begun + number * PERIOD_S - time.perf_counter()))
        send(number)


def raw_joints(count: int) -> None:
    session = open_raw()
    publisher = session.declare_publisher(STATE_KEY)
    rest = bytes(STATE_BYTES - 8)
    for _ in starts():
        every_millisecond(
            count, lambda _: publisher.put(time.time_ns().to_bytes(8, "little") + rest)
        )
    session.close()


def node_joints(count: int) -> None:
    from teleopctl.interfaces import get_message, set_stamp
    from teleopctl.node import Node, init

    with init(args=[]), Node("joints") as node:
        message = get_message("sensor_msgs/msg/JointState")(name=JOINTS)
        publisher = node.create_publisher(type(message), "joint_states", 10)

        def send(number: int) -> None:
            message.position = [math.sin(number * PERIOD_S + joint) for joint in range(7)]
            message.velocity = message.effort = [0.0] * 7
            set_stamp(message.header.stamp, time.time_ns())
            publisher.publish(message)

        for topic in ("/joint_states", "/tf"):
            assert node.wait_for_subscribers(topic, 1, LONGEST_WAIT_S)
        for _ in starts():
            every_millisecond(count, send)


def relay() -> None:
    session = open_raw()
    publisher = session.declare_publisher(TF_KEY)
    rest = bytes(TF_BYTES - 8)
    session.declare_subscriber(
        STATE_KEY, lambda sample: publisher.put(sample.payload.to_bytes()[:8] + rest)
    )
    print("ready", flush=True)
    sys.stdin.read()
    session.close()


def starts() -> Iterator[None]:
    """Yield for each line on the standard input; print when a line may come, and after it."""
    print("ready", flush=True)
    for _ in sys.stdin:
        yield
        print("done", flush=True)


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["joints", "node", count]:
            node_joints(int(count))
        case ["joints", "raw", count]:
            raw_joints(int(count))
        case ["relay"]:
            relay()
