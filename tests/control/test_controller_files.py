"""What parameter files say of a controller."""

from pathlib import Path

import pytest

from teleopctl.control.controller_files import (
    controller_load_parameters,
    parameter_place,
    similar_types,
)
from teleopctl.control.in_memory.control_stack import ControlStack
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import AllowableParameterValue
from teleopctl.node import copy_mark
from teleopctl.testing import serial_robot

TYPE = "joint_trajectory_controller/JointTrajectoryController"


@pytest.fixture
def write(tmp_path):
    def one(name, text):
        file = tmp_path / name
        file.write_text(text)
        return str(file)

    return one


def test_the_type_stands_in_the_managers_section(write):
    file = write("a.yaml", f"controller_manager: {{ros__parameters: {{arm: {{type: {TYPE}}}}}}}")
    settings = controller_load_parameters("arm", "/controller_manager", [file])
    assert settings == {"params_file": [file], "type": TYPE}


def test_or_in_the_controllers_own(write):
    file = write("a.yaml", f"arm: {{ros__parameters: {{type: {TYPE}, joints: [a]}}}}")
    settings = controller_load_parameters("arm", "/controller_manager", [file])
    assert settings == {"params_file": [file], "type": TYPE}


def test_later_files_win(write):
    first = write("a.yaml", "arm: {ros__parameters: {type: x, fallback_controllers: [b]}}")
    second = write("b.yaml", "arm: {ros__parameters: {type: y}}")
    settings = controller_load_parameters("arm", "/controller_manager", [first, second])
    assert settings == {"params_file": [first, second], "type": "y", "fallback_controllers": ["b"]}


def test_without_files_there_is_nothing_to_set():
    assert controller_load_parameters("arm", "/controller_manager", []) == {}


@pytest.mark.parametrize("key", ["/left/arm", "/**/arm", "/**"])
def test_in_a_namespace_the_section_is_in_it_or_has_wildcards(write, key):
    file = write("a.yaml", f"{key}: {{ros__parameters: {{type: x}}}}")
    assert controller_load_parameters("arm", "/left/controller_manager", [file])["type"] == "x"


def test_a_section_outside_of_the_namespace_is_a_mistake(write):
    file = write("a.yaml", "arm: {ros__parameters: {type: x}}")
    with pytest.raises(TeleopctlError, match="Missing namespace : /left or wildcard"):
        controller_load_parameters("arm", "/left/controller_manager", [file])


def test_a_file_that_does_not_exist_is_named():
    with pytest.raises(TeleopctlError, match=r"Controller parameter file : nowhere\.yaml does not"):
        controller_load_parameters("arm", "/controller_manager", ["nowhere.yaml"])


def test_a_parameter_has_file_and_line_of_the_last_file_that_sets_it(write):
    first = write("a.yaml", "/**:\n  arm:\n    ros__parameters:\n      gains: {a: {p: 1.0}}\n")
    second = write(
        "b.yaml",
        "controller_manager:\n"
        "  ros__parameters:\n"
        "    arm: {type: x}\n"
        "shared: &shared\n"
        "  joints: [a]\n"
        "arm:\n"
        "  ros__parameters:\n"
        "    <<: *shared\n",
    )

    def place(parameter):
        return parameter_place("arm", "/controller_manager", [first, second, "no"], parameter)

    assert place("gains.a.p") == f"{first}:4"
    assert place("type") == f"{second}:3"
    assert place("joints") == f"{second}:5"
    assert place("gains") == ""


JOINTS: dict[str, AllowableParameterValue] = {
    "joints": ["joint1", "joint2"],
    "command_interfaces": ["position"],
    "state_interfaces": ["position"],
}


def test_an_unknown_parameter_is_reported_once_with_its_line_and_the_nearest_name(write):
    file = write(
        "arm.yaml",
        "arm:\n  ros__parameters:\n    constraints:\n      joint2: {gaol: 0.1}\n",
    )
    stack = ControlStack(serial_robot(2))
    stack.node.declare_parameter("arm.params_file", [file])
    stack.load_controller("arm", TYPE, JOINTS | {"constraints.joint2.gaol": 0.1})
    stack.activate("arm")
    stack.deactivate("arm")
    assert stack.manager.configure_controller("arm")
    assert stack.nodes["arm"].log.texts("warning") == [
        f"Parameter 'constraints.joint2.gaol' ({file}:4) is unknown and has no effect. "
        "Did you mean constraints.joint2.goal?"
    ]


def test_parameters_of_other_releases_of_ros2_controllers_are_known():
    stack = ControlStack(serial_robot(2))
    old: dict[str, AllowableParameterValue] = {
        "state_publish_rate": 50.0,
        "action_monitor_rate": 20.0,
        "allow_nonzero_velocity_at_trajectory_end": True,
        "gains.joint1.i_clamp": 1.0,
        "gains.joint1.angle_wraparound": True,
        "constraints.joint1.goal": 0.1,
        "qos_overrides./tf.publisher.depth": 3,
    }
    stack.load_controller("arm", TYPE, JOINTS | old)
    stack.activate("arm")
    assert stack.nodes["arm"].log.texts("warning") == [
        "Parameter 'gains.joint1.angle_wraparound' has no effect: ros2_controllers have dropped "
        "it: continuous joints of the description wrap around.",
        "Parameter 'state_publish_rate' has no effect: ros2_controllers have dropped it: each "
        "update publishes the state.",
    ]


def test_a_parameter_of_all_nodes_of_the_managers_process_is_no_mistake():
    stack = ControlStack(serial_robot(2), parameters={"joint_limits_file": ""})
    stack.load_controller("arm", TYPE, JOINTS | {"joint_limits_file": ""})
    stack.activate("arm")
    assert stack.nodes["arm"].log.texts("warning") == []


TYPES = [
    "effort_controllers/JointGroupEffortController",
    "gpio_controllers/GpioCommandController",
    "joint_state_broadcaster/JointStateBroadcaster",
    "joint_trajectory_controller/JointTrajectoryController",
    "pid_controller/PidController",
    "position_controllers/GripperActionController",
    "position_controllers/JointGroupPositionController",
]


@pytest.mark.parametrize(
    ("name", "similar"),
    [
        ("joint_state_broadcaster/JointStateBroadcastr", [TYPES[2]]),
        ("ur_controllers/ScaledJointTrajectoryController", [TYPES[3]]),
        ("effort_controllers/JointGroupPositionController", [TYPES[6], TYPES[0]]),
        ("ur_controllers/ForceModeController", []),
        ("ur_controllers/GPIOController", []),
        ("ur_controllers/FrictionModelController", []),
        ("no", []),
    ],
)
def test_similar_types_are_those_of_the_same_purpose(name, similar):
    assert similar_types(name, TYPES) == similar


def test_a_line_of_a_copy_has_the_place_of_the_original(write):
    original = write("mine.yaml", "arm:\n  ros__parameters:\n    joints: [$(var a)]\n")
    copy = write(
        "copy.yaml",
        "arm:\n  ros__parameters:\n    joints: [a]\n"
        f"{copy_mark(Path(original))}"
        "wheels:\n  ros__parameters: {radius: 1.0}\n",
    )
    manager = "/controller_manager"
    assert parameter_place("arm", manager, [copy], "joints") == f"{original}:3"
    assert parameter_place("wheels", manager, [copy], "radius") == f"{copy}:6"
