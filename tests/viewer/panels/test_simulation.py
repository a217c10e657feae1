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


def text(panel):
    return re.sub("<[^>]*>", "", panel._text.content)


def simulated_s(panel: Any) -> float:
    found = re.search(r"time ([\d.]+) s", text(panel))
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
    live.choose(panel._time, what)


def test_where_nothing_is_simulated_one_sentence_says_how_to_start(live, panel):
    del live
    assert panel._note.visible
    assert "teleopctl launch sim.yaml" in panel._note.content
    assert not panel._place.visible


def test_time_is_played_paused_stepped_and_paced(live, panel, simulator):
    live.until(lambda: panel._place.visible)
    live.until(lambda: simulated_s(panel) > 0.5)
    assert "running" in text(panel)
    live.until(lambda: 0.8 < panel.measured_factor() < 1.2)
    assert panel._pace.value == "1x"
    press(live, panel, "Pause")
    live.until(lambda: "paused" in text(panel))
    live.until(lambda: panel.measured_factor() == 0.0)
    take_what_is_under_way(live)
    stood = simulated_s(panel)
    # A millisecond each.
    live.choose(panel._steps, 50)
    press(live, panel, "Step")
    live.until(lambda: simulated_s(panel) == pytest.approx(stood + 0.05))
    press(live, panel, "Play")
    live.until(lambda: panel.is_running)
    live.choose(panel._pace, "5x")
    live.until(lambda: 4 < panel.measured_factor() < 6)
    live.choose(panel._pace, "as fast as possible")
    live.until(lambda: panel.measured_factor() > 6)
    # Steps are of a paused simulation: it is paused first.
    press(live, panel, "Step")
    live.until(lambda: not panel.is_running)
    assert live.told == []
    simulator.interrupt()
    live.until(lambda: panel._note.visible)


def test_the_pace_that_others_set_is_shown(live, panel, simulator, ros):
    del simulator
    live.until(lambda: panel._pace.visible)
    assert ros.run("param set /mujoco_sim real_time_factor 0.3").returncode == 0
    live.until(lambda: panel._pace.value == "0.3x")
    assert "0.3x" in panel._pace.options


def test_nobody_looks_and_nothing_is_listened_to(live, panel, simulator):
    del simulator
    live.until(lambda: simulated_s(panel) > 0.0)
    panel.ended()
    panel.graph_changed()
    live.until(lambda: live.node.count_subscribers("/clock") == 0)
    panel.began()
    live.until(lambda: panel.is_running)


def test_the_world_is_reset_and_a_refusal_is_told(live, panel, simulator):
    del simulator
    live.until(lambda: simulated_s(panel) > 0.1)
    live.click(panel._reset)
    press(live, panel, "Pause")
    live.until(lambda: "paused" in text(panel))
    assert live.told == []
    panel._call("Reset the world", "reset_world", "ResetWorld", lambda: None, keyframe="home")
    live.until(lambda: live.told)
    assert "home" in live.told[0][1]
