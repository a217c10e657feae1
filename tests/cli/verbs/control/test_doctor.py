"""``control doctor``: what keeps controllers from activation or joints from motion."""

import math
from dataclasses import replace

import pytest

import teleopctl
from teleopctl.cli.verbs.control.diagnosis import CHECKS, ManagerSnapshot
from teleopctl.control.lifecycle import State
from teleopctl.control.services import (
    controller_state,
    hardware_component_state,
    hardware_interface,
)
from teleopctl.control.statistics_publishers import introspection_names
from teleopctl.control.switching import SwitchRequest, switch_controller
from teleopctl.testing import ControlStack, serial_robot
from teleopctl.wire import EndpointQos, EndpointToken, EntityKind, Graph

teleopctl.activate()

FORWARD = "forward_command_controller/ForwardCommandController"
TRAJECTORY = "joint_trajectory_controller/JointTrajectoryController"
JOINTS = {"joints": ["joint1", "joint2"]}


@pytest.fixture
def stack():
    stack = ControlStack(serial_robot(2), enforce_limits=True)
    arm = {"command_interfaces": ["position"], "state_interfaces": ["position"]}
    stack.load_controller("arm", TRAJECTORY, JOINTS | arm)
    stack.load_controller("forward", FORWARD, JOINTS | {"interface_name": "position"})
    stack.activate("arm")
    assert stack.manager.configure_controller("forward")
    stack.step(2)
    return stack


def snapshot_of(stack, manager="/controller_manager", **others):
    resources = stack.resources
    states, commands = resources.state_interfaces, resources.command_interfaces
    values = [state.value for state in states.values()]
    for command in commands.values():
        values += (command.value, float(command.is_limited))
    return ManagerSnapshot(
        manager,
        [controller_state(stack.manager, spec) for spec in stack.manager.controllers.values()],
        [hardware_component_state(one) for one in resources.components.values()],
        {
            one.name: one.is_available
            for one in map(hardware_interface, (*states.values(), *commands.values()))
        },
        **{"values": dict(zip(introspection_names(states, commands), values, strict=True))}
        | others,
    )


def findings(snapshot, controller=None):
    return [
        f"{'' if finding.is_error else 'WARNING: '}{finding.text}\n  {finding.hint}"
        for check in CHECKS.values()
        for finding in check(snapshot, controller)
    ]


HELD = (
    "Controller 'forward' is inactive: 'arm' commands joint1/position, joint2/position.\n"
    "  teleopctl control switch_controllers --deactivate arm --activate forward"
)


def test_an_inactive_controller_is_an_error_if_its_joints_are_free_or_it_is_asked_about(stack):
    snapshot = snapshot_of(stack)
    assert findings(snapshot, "arm") == []
    assert findings(snapshot) == [f"WARNING: {HELD}"]
    assert findings(snapshot, "forward") == [HELD]
    stack.deactivate("arm")
    assert findings(snapshot_of(stack), "forward") == [
        "Controller 'forward' is inactive, and could be activated.\n"
        "  teleopctl control set_controller_state forward active"
    ]


def test_commands_name_a_manager_of_another_name(stack):
    (finding,) = findings(snapshot_of(stack, "/left/manager"), "forward")
    assert "switch_controllers -c /left/manager --deactivate arm" in finding
    (finding,) = findings(replace(snapshot_of(stack, "/left/manager"), controllers=[]))
    assert "spawner CONTROLLER -c /left/manager --param-file FILE" in finding


def test_a_controller_that_is_not_loaded_or_not_configured(stack):
    snapshot = snapshot_of(stack)
    assert findings(snapshot, "forwrad") == [
        "Controller 'forwrad' is not loaded; loaded are arm, forward. Did you mean forward?\n"
        "  teleopctl run controller_manager spawner forwrad --param-file FILE"
    ]
    assert findings(replace(snapshot, controllers=[])) == [
        "No controller is loaded.\n  teleopctl launch spawn_controllers.yaml controllers_file:=FILE"
    ]
    stack.load_controller("second", FORWARD, JOINTS | {"interface_name": "position"})
    assert findings(snapshot_of(stack), "second") == [
        "Controller 'second' is unconfigured.\n"
        "  teleopctl control load_controller second --set-state active"
    ]


def test_interfaces_that_nothing_has(stack):
    stack.load_controller("third", FORWARD, {"joints": ["joint9"], "interface_name": "position"})
    assert stack.manager.configure_controller("third")
    assert findings(snapshot_of(stack), "third") == [
        "Controller 'third' is inactive: neither hardware nor a controller has joint9/position. "
        "Did you mean joint1/position?\n"
        "  teleopctl control list_hardware_interfaces"
    ]


def test_hardware_that_failed_is_named_where_its_interfaces_are_missing(stack):
    stack.deactivate("arm")
    (component,) = stack.resources.components.values()
    assert component.change_state(State.UNCONFIGURED)
    activate = f"  teleopctl control set_hardware_component_state {component.name} active"
    assert findings(snapshot_of(stack, values=None), "arm") == [
        f"Hardware '{component.name}' is unconfigured: its joints do not move; if it has failed, "
        f"the manager's log says why.\n{activate}",
        "Controller 'arm' is inactive: joint1/position, joint2/position are not available, as "
        f"their hardware '{component.name}' is unconfigured.\n{activate}",
    ]


def test_hardware_that_is_not_active(stack):
    stack.deactivate("arm")
    (component,) = stack.resources.components.values()
    assert component.change_state(State.INACTIVE)
    activate = f"  teleopctl control set_hardware_component_state {component.name} active"
    assert findings(snapshot_of(stack, values=None), "arm") == [
        f"Hardware '{component.name}' is inactive: its joints do not move.\n{activate}",
        f"Controller 'arm' is inactive, as is its hardware '{component.name}'.\n{activate}",
    ]


def test_a_stopped_robot_and_a_paused_simulation(stack):
    assert findings(snapshot_of(stack, is_stopped=True, is_paused=True, values=None), "arm") == [
        "The robot is stopped: commands and goals are refused.\n  teleopctl stop --robot --release",
        "The simulation is paused: no control cycle runs.\n  teleopctl sim play",
    ]
    (finding,) = findings(snapshot_of(stack, values=None), "arm")
    assert finding.startswith("/controller_manager runs no control cycle: ")


def test_a_forward_command_controller_without_a_command():
    stack = ControlStack(serial_robot(2))
    stack.load_controller("forward", FORWARD, JOINTS | {"interface_name": "position"})
    stack.activate("forward")
    stack.step(2)
    text = (
        "Controller 'forward' is active, and has no command for joint1/position, joint2/position "
        "yet (NaN).\n  teleopctl topic pub --once /forward/commands std_msgs/msg/Float64MultiArray "
        "'{data: [1.1, 2.1]}'"
    )
    assert findings(snapshot_of(stack), "forward") == [text]
    assert findings(snapshot_of(stack)) == [f"WARNING: {text}"]


def test_no_command_of_nan_is_proposed():
    stack = ControlStack(serial_robot(1))
    stack.load_controller("forward", FORWARD, {"joints": ["joint1"], "interface_name": "position"})
    stack.activate("forward")
    stack.resources.state_interfaces["joint1/position"].value = math.nan
    assert findings(snapshot_of(stack), "forward") == [
        "Controller 'forward' is active, and has no command for joint1/position yet (NaN); its "
        "hardware measures NaN, too.\n  teleopctl control list_hardware_components -v"
    ]


def token(kind, node, topic, type_name):
    return EndpointToken(
        0, "a", 0, 0, kind, "%", "/", node, topic, type_name, "hash", EndpointQos()
    )


def test_publishers_of_another_type_or_of_a_wrong_number_of_values(stack):
    topic, right = "/arm/commands", "std_msgs/msg/Float64MultiArray"
    graph = Graph(
        [
            token(EntityKind.MS, "arm", topic, right),
            token(EntityKind.MP, "probe", topic, "std_msgs/msg/Float64"),
            token(EntityKind.MP, "good", topic, right),
        ]
    )
    assert findings(snapshot_of(stack, graph=graph, lengths={topic: 1}), "arm") == [
        f"/probe publishes std_msgs/msg/Float64 on {topic}, where 'arm' takes {right}.\n"
        f"  teleopctl topic info --verbose {topic}",
        f"Messages on {topic} have 1 value, 'arm' takes 2: joint1, joint2.\n"
        f"  teleopctl topic echo --once {topic}",
    ]


def test_a_second_manager_of_the_same_robot(stack):
    def manager(namespace, description):
        string, services = "std_msgs/msg/String", "controller_manager_msgs/srv/ListControllers"
        names = f"{namespace}/controller_manager/list_controllers", description
        return [
            token(kind, "controller_manager", name, type_name)._replace(namespace=namespace or "/")
            for kind, name, type_name in (
                (EntityKind.SS, names[0], services),
                (EntityKind.MS, names[1], string),
            )
        ]

    left = manager("/left", "/left/robot_description")
    graph = Graph([*manager("", "/robot_description"), *left])
    assert findings(snapshot_of(stack, graph=graph), "arm") == []
    both = Graph([*graph.endpoints, *manager("/other", "/robot_description")])
    assert findings(snapshot_of(stack, graph=both), "arm") == [
        "/other/controller_manager takes the robot description on /robot_description, too: two "
        "controller managers command the same joints.\n  teleopctl ps"
    ]


def test_commands_that_are_clamped(stack):
    stack.deactivate("arm")
    assert switch_controller(stack.manager, SwitchRequest(["forward"], []))[0]
    message = stack.nodes["forward"]
    from std_msgs.msg import Float64MultiArray

    message.receive("~/commands", Float64MultiArray(data=[199.0, 0.0]))
    stack.step(400)
    (finding,) = findings(snapshot_of(stack), "forward")
    assert finding == (
        "Controller 'forward' commands more than the limits of its joints: joint1/position "
        "(clamped to 100, measured 100).\n"
        "  teleopctl topic echo --once /forward/commands"
    )


def test_commands_beyond_limits_that_the_manager_does_not_enforce(stack):
    values = {
        "command_interface.joint1/position": 9.0,
        "command_interface.joint2/position": 1.0,
        "state_interface.joint1/position": 1.57,
    }
    ranges = {f"{joint}/position": (-1.5, 1.57) for joint in ("joint1", "joint2")}
    (finding,) = findings(snapshot_of(stack, values=values, ranges=ranges), "arm")
    assert finding == (
        "Controller 'arm' commands more than the limits of its joints: joint1/position (9, limits "
        "[-1.5, 1.57], measured 1.57).\n"
        "  teleopctl topic echo --once /arm/controller_state"
    )
