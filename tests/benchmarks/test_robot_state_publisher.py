"""Processor time of robot_state_publisher at 1 kHz, and of a process that passes as many bytes on.

Each state of a seven-joint arm says when it was sent, and its transforms when that was: the latency
is that of both ways, from one process over a second to a third. What differs between the two is the
second one: its work on the message, and that of a node's executor.
"""

import time
from pathlib import Path

import psutil
import pytest

from teleopctl.interfaces import get_message, to_nanoseconds
from teleopctl.testing import Process, RosGraph, eventually
from tests.benchmarks import state_peers
from tests.benchmarks.echo_peers import open_raw
from tests.benchmarks.figure import Figure

STATES, ROUNDS = 4000, 4
# Aim: times the processor time of raw Zenoh.
MOST = 1.3
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


class Relay:
    """A process that answers each joint state, and the one that sends the states.

    Args:
        joints: Process that sends the states.
        between: Process that is measured.
    """

    def __init__(self, joints: Process, between: Process) -> None:
        self._joints, self._watched = joints, psutil.Process(between.pid)
        self._rounds = 0
        self._latencies_ns: list[int] = []
        self._costs_s: list[float] = []

    def add(self, sent_ns: int) -> None:
        """Note the answer to a state that was sent at a time; Zenoh's thread calls it."""
        self._latencies_ns.append(time.time_ns() - sent_ns)

    def measure(self) -> None:
        """Have states sent, and note the processor time of the process between for each."""
        before = self._watched.cpu_times()
        self._rounds += 1
        self._joints.send("\n")
        eventually(lambda: self._joints.stdout.count("done") == self._rounds)
        after = self._watched.cpu_times()
        self._costs_s.append((after.user + after.system - before.user - before.system) / STATES)

    @property
    def cost_s(self) -> float:
        """Processor time for a state, in seconds: the least of all rounds."""
        return min(self._costs_s)

    def describe(self) -> str:
        arrived, sent = sorted(self._latencies_ns), STATES * self._rounds
        median, late = (arrived[int(len(arrived) * part)] / 1e6 for part in (0.5, 0.99))
        return (
            f"{self.cost_s * 1e6:.0f} us, {sent - len(arrived)} of {sent} lost, latency median "
            f"{median:.2f} ms, 99 % below {late:.2f} ms"
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
    relay = peer(ros, "relay")
    session = open_raw()
    # The senders wait for these subscribers.
    ours: Relay
    floor: Relay
    ros.node.create_subscription(
        TFMessage,
        "/tf",
        lambda message: ours.add(to_nanoseconds(message.transforms[0].header.stamp)),
        10,
        immediate=True,
    )
    session.declare_subscriber(
        state_peers.TF_KEY,
        lambda sample: floor.add(int.from_bytes(sample.payload.to_bytes()[:8], "little")),
    )
    ours = Relay(peer(ros, "joints", "node", str(STATES)), publisher)
    floor = Relay(peer(ros, "joints", "raw", str(STATES)), relay)
    for _ in range(ROUNDS):
        ours.measure()
        floor.measure()
    session.close()
    figures.append(
        Figure(
            "processor time of a joint state at 1 kHz",
            ours.describe(),
            f"raw Zenoh: {floor.describe()}",
            ours.cost_s / floor.cost_s,
            MOST,
        )
    )
