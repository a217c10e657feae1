"""The simulator in lockstep with three controllers and without subscribers, as fast as it can.

Processor time of a control tick, of all processes that take part in it: one process, or simulator
and controller manager each in its own (``control:=topic``). Beside it, in the same run: MuJoCo
alone, which takes the same physics steps, and one Zenoh put of as many bytes as the joint states
have, received by another process. A tick over topics sends two such messages.
"""

import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import mujoco
import psutil
import pytest

from teleopctl.interfaces import get_message, get_service, to_nanoseconds
from teleopctl.mujoco_model.model import build_model
from teleopctl.node import qos_profile_latched
from teleopctl.robot import simulated
from teleopctl.robot.description import RobotDescription
from teleopctl.sim.simulation import Simulation
from teleopctl.testing import LONGEST_WAIT_S, RosGraph
from tests.benchmarks import tick_peer
from tests.benchmarks.figure import Figure
from tests.sim.robots import control, joint, link

NANOSECONDS = 1_000_000_000
RATES, JOINTS = (100, 1000), (4, 7, 30)
SECONDS, ROUNDS, PUTS, BETWEEN_PUTS_S = 2.0, 3, 3000, 0.0002
# Processor time of a tick over physics, of robots with at most seven joints.
AIM_S = {100: 80e-6, 1000: 40e-6}
MOST_MEMORY = 0.7
CONTROLLERS = """
controller_manager:
  ros__parameters:
    update_rate: {rate}
    joint_state_broadcaster: {{type: joint_state_broadcaster/JointStateBroadcaster}}
    arm: {{type: joint_trajectory_controller/JointTrajectoryController}}
    hand: {{type: joint_trajectory_controller/JointTrajectoryController}}
arm: {{ros__parameters: {{joints: [{arm}], {interfaces}}}}}
hand: {{ros__parameters: {{joints: [{hand}], {interfaces}}}}}
"""

INTERFACES = "command_interfaces: [position], state_interfaces: [position]"

Clock = get_message("rosgraph_msgs/msg/Clock")
JointState = get_message("sensor_msgs/msg/JointState")
String = get_message("std_msgs/msg/String")
SetPause = get_service("mujoco_ros2_control_msgs/srv/SetPause")


def chain(joints: int) -> str:
    """Return the URDF of a robot whose links hang from one another, at most six in a row."""
    names, parts, parent = [f"joint_{number}" for number in range(joints)], [link("base", "")], ""
    for number, name in enumerate(names):
        parent, place = (parent, "0 0 0.5") if number % 6 else ("base", f"{number} 0 0")
        axis = "0 1 0" if number % 2 else "0 0 1"
        parts += [
            link(f"link_{number}"),
            joint(name, parent, f"link_{number}", xyz=place, axis=axis),
        ]
        parent = f"link_{number}"
    drives = control(**dict.fromkeys(names, "position"))
    return simulated(f'<robot name="chain">{"".join(parts)}{drives}</robot>').urdf


class Cost(NamedTuple):
    """Cost of a control tick, in seconds, and memory of the processes, in bytes."""

    processor: float
    wall: float
    memory: int


class Robot:
    """A simulated robot with its three controllers, in one or two processes."""

    def __init__(self, ros: RosGraph, joints: int, rate: int, *, hosted: bool) -> None:
        self._ros, self._rate = ros, rate
        names = [f"joint_{number}" for number in range(joints)]
        file = ros.folder / "controllers.yaml"
        arm, hand = ", ".join(names[:-1]), names[-1]
        file.write_text(CONTROLLERS.format(rate=rate, arm=arm, hand=hand, interfaces=INTERFACES))
        manager = f"--ros-args --params-file {file}"
        settings = f"-p real_time_factor:=0.0 -p paused:=true -p update_rate:={rate}"
        words = [
            "mujoco_sim",
            "mujoco_sim",
            *([f"--controller-manager={manager}"] if hosted else []),
        ]
        self.processes = [
            ros.spawn_module("teleopctl.nodes", [*words, "--ros-args", *settings.split()])
        ]
        if not hosted:
            self.processes.append(
                ros.spawn_module(
                    "teleopctl.nodes", f"controller_manager ros2_control_node {manager}"
                )
            )
        spawned = ros.run("run controller_manager spawner joint_state_broadcaster arm hand")
        assert spawned.returncode == 0, spawned.stderr

    def _pause(self, paused: bool) -> None:
        client = self._ros.node.create_client(SetPause, "/mujoco_sim/set_pause")
        assert client.wait_for_service(LONGEST_WAIT_S)
        response = client.call(SetPause.Request(paused=paused), LONGEST_WAIT_S)
        assert response is not None
        assert response.success
        self._ros.node.destroy_client(client)

    def _ticks(self) -> float:
        """Return the number of ticks so far; paused, the clock is sent to a new subscriber."""
        message = self._ros.wait_for_message(Clock, "/clock")
        return to_nanoseconds(message.clock) * self._rate / NANOSECONDS

    def cost(self) -> Cost:
        """Let time run for a while, and return what a tick cost."""
        begun = self._ticks()
        watched = [psutil.Process(process.pid) for process in self.processes]
        before, start = [one.cpu_times() for one in watched], time.monotonic()
        self._pause(False)
        time.sleep(SECONDS)
        self._pause(True)
        wall = time.monotonic() - start
        processor = sum(
            now.user + now.system - then.user - then.system
            for now, then in zip([one.cpu_times() for one in watched], before, strict=True)
        )
        ticks = self._ticks() - begun
        memory = sum(one.memory_full_info().pss for one in watched)
        return Cost(processor / ticks, wall / ticks, memory)

    def close(self) -> None:
        for process in self.processes:
            process.kill()


def physics(joints: int, rate: int) -> Callable[[], float]:
    """Return a function that measures the processor time of MuJoCo's steps of one tick."""
    model = build_model(RobotDescription.from_urdf(chain(joints)))
    simulation = Simulation(model, control_period_ns=NANOSECONDS // rate)
    m, d = simulation.observe()
    data, steps, count = mujoco.MjData(m), simulation.steps_per_period, rate
    mujoco.mj_copyData(data, m, d)

    def measure() -> float:
        start = time.process_time()
        for _ in range(count):
            mujoco.mj_step(m, data, steps)
        return (time.process_time() - start) / count

    return measure


@pytest.fixture
def put(ros: RosGraph) -> Iterator[Callable[[int], float]]:
    """A function that measures the processor time of a Zenoh put of the states of some joints."""
    script = str(Path(tick_peer.__file__))
    publisher = ros.node.create_publisher(JointState, "/raw_states", 10)
    with subprocess.Popen(
        [sys.executable, script, "/unused"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as peer:  # fmt: skip
        assert peer.stdout is not None and peer.stdin is not None
        assert peer.stdout.readline() == "ready\n"
        assert ros.node.wait_for_subscribers("/raw_states", 1, LONGEST_WAIT_S)
        channel, attachment = publisher._channel, bytes(33)

        def measure(joints: int) -> float:
            payload = bytes(64 + 36 * joints)
            start = time.process_time()
            for _ in range(PUTS):
                time.sleep(BETWEEN_PUTS_S)
            sent = time.process_time()
            for _ in range(PUTS):
                channel.put(payload, attachment=attachment)
                # One after the other, as at the ticks.
                time.sleep(BETWEEN_PUTS_S)
            return (time.process_time() - sent - (sent - start)) / PUTS

        yield measure
        peer.stdin.close()


def least(costs: Sequence[Cost]) -> Cost:
    return Cost(*(min(column) for column in zip(*costs, strict=True)))


def describe(cost: Cost, rate: int) -> str:
    return f"{cost.processor * 1e6:.0f} us, {1 / (rate * cost.wall):.1f} times real time"


@pytest.mark.timeout(180)
@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("joints", JOINTS)
def test_a_control_tick(
    ros: RosGraph, put: Callable[[int], float], joints: int, rate: int, figures: list[Figure]
) -> None:
    publisher = ros.node.create_publisher(String, "/robot_description", qos_profile_latched)
    publisher.publish(String(data=chain(joints)))
    bare, costs = physics(joints, rate), dict[bool, Cost]()
    floors, puts = [], []
    for hosted in (True, False):
        robot, found = Robot(ros, joints, rate, hosted=hosted), []
        for _ in range(ROUNDS):
            found.append(robot.cost())
            floors.append(bare())
            puts.append(put(joints))
        robot.close()
        costs[hosted] = least(found)
    step, sent = min(floors), min(puts)
    one, two = costs[True], costs[False]
    floor = f"mj_step {step * 1e6:.0f} us, put {sent * 1e6:.0f} us"
    over, aim = one.processor - step, AIM_S[rate] if joints < 10 else None
    subject = f"{joints} joints, {rate} Hz"
    figures += [
        Figure(
            f"{subject}, one process: over physics {over * 1e6:.0f} us",
            describe(one, rate), floor, over / aim if aim else None, 1.0 if aim else None,
        ),
        Figure(f"{subject}, control:=topic", describe(two, rate), floor),
        Figure(
            f"{subject}, memory", f"{one.memory >> 20} MiB", f"two: {two.memory >> 20} MiB",
            one.memory / two.memory, MOST_MEMORY,
        ),
    ]  # fmt: skip
