"""The controller manager in the simulator's process: the same robot as in two processes."""

import os
import re

import pytest

from teleopctl.interfaces import get_message
from teleopctl.node import qos_profile_latched
from teleopctl.robot import expand_xacro
from teleopctl.testing import eventually
from tests.samples import sample
from tests.system.test_control_in_simulation import CONTROLLERS, MODEL, run

PROCESSES = ("process", "topic")

SLEEPER = """
import time
from teleopctl.control import (
    ControllerInterface, InterfaceConfiguration, InterfaceConfigurationType)

NOTHING = InterfaceConfiguration(InterfaceConfigurationType.NONE)

class Sleeper(ControllerInterface):
    def state_interface_configuration(self):
        return NOTHING

    command_interface_configuration = state_interface_configuration

    def update(self, time_ns, period):
        time.sleep(1000)
"""


@pytest.mark.nightly
def test_the_bits_of_a_run_are_those_of_two_processes(ros):
    urdf = expand_xacro(MODEL, {"hardware": "sim"})
    hosted, apart = (run(ros, urdf, 40, hosted=hosted)[0] for hosted in (True, False))

    def raw(states):
        return [(s.header.stamp, list(s.name), s.position.tobytes()) for s in states]

    assert raw(hosted) == raw(apart)
    assert hosted[-1].position[0] == pytest.approx(0.5, abs=2e-3)


@pytest.fixture(scope="module", params=PROCESSES)
def graph(request, shared_ros):
    """Place of the manager, and what commands print while ``sim.yaml`` runs, by command."""
    arm = shared_ros.launch("sim.yaml", "camera:=false", f"control:={request.param}")
    commands = ("node list", "service list -t", "topic list -t", "action list -t")
    printed = {command: shared_ros.run(command).stdout for command in commands}
    printed["/robot_joint_commands"] = shared_ros.run(
        "topic echo --once /robot_joint_commands"
    ).stdout
    printed["/robot_joint_states"] = shared_ros.run("topic echo --once /robot_joint_states").stdout
    printed["ps"] = shared_ros.run("ps").stdout
    arm.stop()
    return request.param, printed


_seen: dict[str, dict[str, str]] = {}


def test_nodes_services_topics_and_actions_are_the_same(graph):
    where, printed = graph
    _seen[where] = {command: text for command, text in printed.items() if " list" in command}
    assert "/controller_manager\n" in printed["node list"]
    assert ("ros2_control_node" in printed["ps"]) == (where == "topic")
    if len(_seen) == len(PROCESSES):
        assert _seen["process"] == _seen["topic"]


def test_states_and_commands_are_published_for_who_subscribes(graph):
    _, printed = graph
    for topic in ("/robot_joint_commands", "/robot_joint_states"):
        names = re.findall(r"^- (joint_\d)$", printed[topic], re.MULTILINE)
        assert {"joint_1", "joint_2", "joint_3", "joint_4"} <= set(names), printed[topic]


@pytest.mark.parametrize("words", sample(["--controler-manager=x", "x"], 2))
def test_other_arguments_are_refused(ros, words):
    done = ros.run_module("teleopctl.nodes", f"mujoco_sim mujoco_sim {words}")
    assert done.returncode == 2
    assert f"unrecognized arguments: {words}" in done.stderr
    assert "usage: mujoco_sim [-h] [--controller-manager ARGUMENTS]" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "status", "reason"),
    sample(
        [
            (
                "--ros-args -p update_rate:=-5",
                1,
                "'update_rate' is -5, expected an integer from 1 to 65535",
            ),
            (
                "--ros-args -p update_rate:=0",
                1,
                "'update_rate' is 0, expected an integer from 1 to 65535",
            ),
            ("--ros-args -p cycle_timeout:=soon", 1, "'cycle_timeout' must be a number of seconds"),
            ("--ros-args --params-file nope.yaml", 1, "Cannot read nope.yaml"),
            ("--ros-args -r broken", 2, "Couldn't parse the rule 'broken'"),
            ("'", 2, "Cannot split --controller-manager"),
        ],
        3,
    ),
)
def test_what_is_wrong_with_the_manager_ends_the_process_with_the_reason(
    ros, arguments, status, reason
):
    process = ros.spawn_module(
        "teleopctl.nodes", ["mujoco_sim", "mujoco_sim", f"--controller-manager={arguments}"]
    )
    assert process.wait() == status
    assert reason in process.stderr
    assert "Traceback" not in process.stderr


@pytest.mark.skipif(os.name == "nt", reason="a named pipe")
def test_controllers_can_be_activated_once_the_model_is_built(ros):
    world = ros.folder / "world.yaml"
    # The simulator builds no model until its world has been written.
    os.mkfifo(world)
    string = get_message("std_msgs/msg/String")
    description = ros.node.create_publisher(string, "/robot_description", qos_profile_latched)
    description.publish(string(data=expand_xacro(MODEL, {"hardware": "sim"})))
    simulator = ros.spawn_module(
        "teleopctl.nodes",
        [
            *("mujoco_sim", "mujoco_sim"),
            f"--controller-manager=--ros-args --params-file {CONTROLLERS}",
            *("--ros-args", "-p", f"world:={world}"),
        ],
    )
    load, switch = (f"/controller_manager/{name}_controller" for name in ("load", "switch"))
    eventually(lambda: ros.node.count_services(load))
    assert not ros.node.count_services(switch)
    world.write_text("things: {}\n")
    eventually(lambda: ros.node.count_services(switch))
    assert "Simulation is running" in simulator.stderr


@pytest.mark.nightly
def test_a_controller_that_never_returns_is_named_and_ends_the_process(ros):
    (ros.folder / "sleepers.py").write_text(SLEEPER)
    ros.env["PYTHONPATH"] = str(ros.folder)
    controllers = ros.folder / "controllers.yaml"
    more = 'sleeper: {type: "sleepers:Sleeper"}\n    cycle_timeout: 1.5\n    arm_controller:'
    controllers.write_text(CONTROLLERS.read_text().replace("arm_controller:", more, 1))
    launch = ros.spawn(f"launch sim.yaml camera:=false controllers_file:={controllers}")
    stands_still = r"Controller 'sleeper' has not returned from update\(\) for 1\.\d s"
    launch.wait_for_line(f"ERROR.*{stands_still}: the control cycle stands still")
    launch.wait_for_line(rf"\[mujoco_sim-1\] {stands_still}$")
    launch.wait_for_line(r"\[mujoco_sim-1\]: process has died .*exit code 1")
