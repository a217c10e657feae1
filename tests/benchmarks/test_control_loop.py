"""The control loop on the wall clock at 1 kHz, against a loop in Python that does nothing.

Seven joints of mock hardware, three controllers, and one subscriber of ``/joint_states``; idle and
with two processes that never sleep, with and without real-time priority. A period is missed if no
cycle began in it.
"""

import itertools
import json
import statistics
import subprocess
import sys
from collections.abc import Sequence

import pytest

from teleopctl.interfaces import get_message
from teleopctl.node import qos_profile_latched
from teleopctl.testing import Process, RosGraph, serial_robot
from tests.benchmarks.figure import Figure
from tests.benchmarks.loop_peers import PERIOD_NS

SECONDS, ROUNDS, HOGS = 5, 2, 2
MOST_MISSED_WITH_PRIORITY = 0.001
CONTROLLERS = """
controller_manager:
  ros__parameters:
    update_rate: 1000
    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}
    arm: {type: joint_trajectory_controller/JointTrajectoryController}
    wrist: {type: forward_command_controller/ForwardCommandController}
arm:
  ros__parameters:
    joints: [joint1, joint2, joint3, joint4]
    command_interfaces: [position]
    state_interfaces: [position]
wrist:
  ros__parameters:
    joints: [joint5, joint6, joint7]
    interface_name: position
"""

String = get_message("std_msgs/msg/String")
JointState = get_message("sensor_msgs/msg/JointState")


def share_missed(times: Sequence[int]) -> float:
    """Return the share of the periods in which no cycle began."""
    half, first = PERIOD_NS // 2, times[0]
    # The grid's place: half of the cycles begin within a tenth of a period around the median.
    place = statistics.median((moment - first + half) % PERIOD_NS - half for moment in times)
    origin = first + place - PERIOD_NS / 10
    periods = {(moment - origin) // PERIOD_NS for moment in times}
    return 1.0 - len(periods) / (max(periods) - min(periods) + 1)


def describe(runs: Sequence[Sequence[int]]) -> tuple[str, float]:
    """Return the errors of the periods in words, and the missed share."""
    errors = sorted(
        abs(later - earlier - PERIOD_NS) / 1e6
        for times in runs
        for earlier, later in itertools.pairwise(times)
    )
    at = [errors[min(len(errors) - 1, int(len(errors) * part))] for part in (0.5, 0.99, 0.999, 1)]
    missed = sum(map(share_missed, runs)) / len(runs)
    return f"{missed:.2%} missed, error " + "/".join(f"{error:.2f}" for error in at) + " ms", missed


def measure(loop: Process) -> list[int]:
    loop.send("\n")
    times: list[int] = json.loads(loop.wait_for_line(r"^\[\d.*\]$", SECONDS + 20)[0])
    return times


@pytest.fixture(params=["yes", "no"], ids=["priority", "no priority"])
def permitted(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.mark.timeout(180)
def test_a_kilohertz_on_the_wall_clock(ros: RosGraph, permitted: str, figures: list[Figure]):
    controllers = ros.folder / "controllers.yaml"
    controllers.write_text(CONTROLLERS)
    publisher = ros.node.create_publisher(String, "/robot_description", qos_profile_latched)
    publisher.publish(String(data=serial_robot(joints=7)))
    words = [str(SECONDS), permitted]
    manager = ros.spawn_module(
        "tests.benchmarks.loop_peers",
        ["manager", *words, "--ros-args", "--params-file", str(controllers)],
    )
    manager.wait_for_line("successfully initialized")
    spawned = ros.run("run controller_manager spawner joint_state_broadcaster arm wrist")
    assert spawned.returncode == 0, spawned.stderr
    bare = ros.spawn_module("tests.benchmarks.loop_peers", ["bare", *words])
    bare.wait_for_line("ready")
    ros.spawn("topic hz /joint_states").wait_for_line("average rate")
    for busy in (False, True):
        hogs = [
            subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(HOGS * busy)
        ]
        ours, floor = [], []
        for _ in range(ROUNDS):
            ours.append(measure(manager))
            floor.append(measure(bare))
        for hog in hogs:
            hog.kill()
            hog.wait()
        (text, missed), (floor_text, floor_missed) = describe(ours), describe(floor)
        most = MOST_MISSED_WITH_PRIORITY if permitted == "yes" else max(floor_missed, 1e-4)
        figures.append(
            Figure(
                f"1 kHz, {HOGS * busy} hogs, {'' if permitted == 'yes' else 'no '}priority",
                text,
                f"bare loop: {floor_text}",
                missed / most,
                1.0,
            )
        )
