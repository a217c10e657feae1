"""robot_state_publisher at 1 kHz, against a process that passes as many bytes on.

Each state of a seven-joint arm says when it was sent, and its transforms when that was: the latency
is that of both ways, from one process over a second to a third. What differs between the two is the
second one: its work on the message, and that of a node's executor.
"""

import threading
import time
from pathlib import Path

import psutil
import pytest

from teleopctl.interfaces import get_message, to_nanoseconds
from teleopctl.testing import Process, RosGraph
from tests.benchmarks import state_peers
from tests.benchmarks.echo_peers import open_raw
from tests.benchmarks.figure import Figure

STATES = 10_000
LAST_ONES_S = 2.0
ROOT = Path(__file__).parents[2]

TFMessage = get_message("tf2_msgs/msg/TFMessage")


def seven_joints() -> str:
    links = "".join(f'<link name="link_{number}"/>' for number in range(8))
    joints = "".join(
        f'<joint name="{name}" type="revolute"><parent link="link_{number}"/>'
        f'<child link="link_{number + 1}"/><origin xyz="0.1 0 0.2" rpy="0.1 0.2 0.3"/>'
        '<axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>'
        for number, name in enumerate(state_peers.JOINTS)
    )
    return f'<robot name="arm">{links}{joints}</robot>'


def peer(ros: RosGraph, *words: str) -> Process:
    process = ros.spawn_module("tests.benchmarks.state_peers", words, cwd=ROOT)
    process.wait_for_line("ready")
    return process


class Arrivals:
    """When transforms came, after the states that they are of had been sent."""

    def __init__(self) -> None:
        self.latencies_ns: list[int] = []
        self.complete = threading.Event()

    def add(self, sent_ns: int) -> None:
        self.latencies_ns.append(time.time_ns() - sent_ns)
        if len(self.latencies_ns) == STATES:
            self.complete.set()


def measure(joints: Process, between: Process, arrivals: Arrivals) -> str:
    """Have the states sent: what became of them, and what it cost the process between."""
    watched = psutil.Process(between.pid)
    before, begun = watched.cpu_times(), time.monotonic()
    joints.send("\n")
    joints.wait_for_line("done")
    after, seconds = watched.cpu_times(), time.monotonic() - begun
    arrivals.complete.wait(LAST_ONES_S)
    share = (after.user + after.system - before.user - before.system) / seconds
    arrived = sorted(arrivals.latencies_ns)
    median, late = (arrived[int(len(arrived) * part)] / 1e6 for part in (0.5, 0.99))
    return (
        f"{share:4.0%} of a core, {STATES / seconds:.0f} Hz, {STATES - len(arrived)} of {STATES} "
        f"lost, latency median {median:.2f} ms, 99 % below {late:.2f} ms"
    )


@pytest.mark.timeout(180)
def test_a_kilohertz_of_joint_states(ros: RosGraph, figures: list[Figure]):
    description = ros.folder / "parameters.yaml"
    description.write_text(
        "robot_state_publisher:\n  ros__parameters:\n    publish_frequency: 1000.0\n"
        "    ignore_timestamp: true\n"
        f"    robot_description: '{seven_joints()}'\n"
    )
    publisher = ros.spawn_module(
        "teleopctl.nodes",
        "robot_state_publisher robot_state_publisher --ros-args "
        f"--params-file {description} -r __node:=robot_state_publisher",
    )
    publisher.wait_for_line("Robot initialized")
    arrivals = Arrivals()
    ros.node.create_subscription(
        TFMessage,
        "/tf",
        lambda message: arrivals.add(to_nanoseconds(message.transforms[0].header.stamp)),
        10,
        immediate=True,
    )
    ours = measure(peer(ros, "joints", "node", str(STATES)), publisher, arrivals)
    publisher.kill()

    raw_arrivals = Arrivals()
    relay = peer(ros, "relay")
    session = open_raw()
    session.declare_subscriber(
        state_peers.TF_KEY,
        lambda sample: raw_arrivals.add(int.from_bytes(sample.payload.to_bytes()[:8], "little")),
    )
    floor = measure(peer(ros, "joints", "raw", str(STATES)), relay, raw_arrivals)
    session.close()
    figures.append(Figure("joint states at 1 kHz", ours, f"raw Zenoh: {floor}"))
