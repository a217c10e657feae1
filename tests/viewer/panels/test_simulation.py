"""The simulation's panel, against a real simulator."""

from __future__ import annotations

import itertools
import re
from typing import Any

import pytest

from teleopctl.interfaces import get_message, get_service
from teleopctl.node import Node, qos_profile_latched
from teleopctl.testing import LONGEST_WAIT_S, serial_robot
from teleopctl.viewer.panels.simulation import SimulationPanel

GetParameters = get_service("rcl_interfaces/srv/GetParameters")
String = get_message("std_msgs/msg/String")
JointState = get_message("sensor_msgs/msg/JointState")
URDF = serial_robot(1, plugin="gz_ros2_control/GazeboSimSystem", initial=(0.5,))


@pytest.fixture
def panel(live):
    panel = SimulationPanel(live)
    live.show(panel)
    return panel


@pytest.fixture
def simulator(live, ros):
    """A simulator's process, with a robot of one joint."""
    node = Node("robot", context=live.context)
    publisher = node.create_publisher(String, "/robot_description", qos_profile_latched)
    publisher.publish(String(data=URDF))
    return ros.spawn("run mujoco_sim mujoco_sim")


def simulated_s(panel: Any) -> float:
    found = re.match(r"([\d.]+) s", panel._row.label)
    return float(found[1]) if found else 0.0


def take_what_is_under_way(live):
    """Receive what the simulator had published before it answers a request of now."""
    client = live.node.create_client(GetParameters, "/mujoco_sim/get_parameters")
    assert client.wait_for_service(LONGEST_WAIT_S)
    answer = client.call_async(GetParameters.Request())
    live.until(answer.done)
    rounds = itertools.count()
    live.until(lambda: next(rounds) > 50)


def press(live, panel, what):
    live.choose(panel._row, what)


def test_time_is_played_paused_stepped_and_paced(live, panel, simulator):
    assert not SimulationPanel.is_needed(live.node)
    live.until(lambda: SimulationPanel.is_needed(live.node))
    live.until(lambda: simulated_s(panel) > 0.5)
    assert panel.state_word == "running"
    live.until(lambda: 0.8 < panel.measured_factor() < 1.2)
    assert panel._factor == 1.0
    press(live, panel, "Pause")
    live.until(lambda: panel.state_word == "paused" and "paused" in panel._row.label)
    assert panel._row.options[0] == "Play"
    live.until(lambda: panel.measured_factor() == 0.0)
    take_what_is_under_way(live)
    stood = simulated_s(panel)
    # A millisecond each.
    panel._steps = 50
    press(live, panel, "Step")
    # The row shows hundredths, of which two may be rounded to either side: 0.04 to 0.06 s apart.
    live.until(lambda: simulated_s(panel) > stood + 0.035)
    live.until(lambda: not panel._calls.is_waiting)
    press(live, panel, "Play")
    live.until(lambda: panel.is_running)
    panel._set_pace("5x")
    live.until(lambda: 4 < panel.measured_factor() < 6)
    panel._set_pace("as fast as possible")
    live.until(lambda: panel.measured_factor() > 6)
    # Steps are of a paused simulation: it is paused first.
    press(live, panel, "Step")
    live.until(lambda: not panel.is_running)
    assert live.told == []
    simulator.interrupt()
    live.until(lambda: not SimulationPanel.is_needed(live.node))


def test_what_others_set_is_taken_and_nothing_is_listened_to_unseen(live, panel, simulator, ros):
    del simulator
    live.until(lambda: panel._factor == 1.0)
    assert ros.run("param set /mujoco_sim real_time_factor 0.3").returncode == 0
    live.until(lambda: panel._factor == 0.3)
    press(live, panel, "Reset")
    press(live, panel, "Pause")
    live.until(lambda: panel.state_word == "paused")
    assert live.told == []
    panel._call("Reset the world", "reset_world", "ResetWorld", lambda: None, keyframe="home")
    live.until(lambda: live.told)
    assert "home" in live.told[0][1]
    press(live, panel, "Play")
    panel.ended()
    panel.graph_changed()
    live.until(lambda: live.node.count_subscribers("/clock") == 0)
    panel.began()
    live.until(lambda: panel.is_running)
