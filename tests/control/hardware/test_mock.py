"""mock_components/GenericSystem: what is commanded is measured."""

import math

import pytest

from teleopctl.testing import ControlStack, serial_robot

MIMIC_JOINT = (
    '<link name="follower"/><joint name="jointF" type="revolute"><parent link="link0"/>'
    '<child link="follower"/><axis xyz="0 0 1"/><limit lower="-9" upper="9" effort="9" '
    'velocity="9"/><mimic joint="joint1" multiplier="-2" offset="0.5"/></joint>'
)
MIMIC_CONTROL = (
    '<joint name="jointF"><state_interface name="position"/><state_interface name="velocity"/>'
    "</joint>"
)


def set_command(stack, name, value):
    command = stack.resources.command_interfaces[name]
    command.owner = "test"
    command.value = value


def test_states_start_at_their_initial_values_and_commands_are_unknown():
    stack = ControlStack(serial_robot(2, initial=(3.45, 2.78), states=("position", "velocity")))
    assert stack.resources.state_interfaces["joint1/position"].value == 3.45
    assert stack.resources.state_interfaces["joint2/velocity"].value == 0.0
    assert all(math.isnan(value) for value in stack.commands())


def test_states_follow_commands_at_the_next_read():
    stack = ControlStack(serial_robot(1))
    set_command(stack, "joint1/position", 1.2)
    assert stack.resources.state_interfaces["joint1/position"].value == 1.1
    stack.step()
    assert stack.resources.state_interfaces["joint1/position"].value == 1.2


def test_an_offset_is_added_to_positions():
    parameters = '<param name="position_state_following_offset">-3</param>'
    stack = ControlStack(serial_robot(1, parameters=parameters))
    set_command(stack, "joint1/position", 1.2)
    stack.step()
    assert stack.resources.state_interfaces["joint1/position"].value == pytest.approx(-1.8)


def test_disabled_commands_never_arrive():
    stack = ControlStack(serial_robot(1, parameters='<param name="disable_commands">true</param>'))
    set_command(stack, "joint1/position", 1.2)
    stack.step(3)
    assert stack.resources.state_interfaces["joint1/position"].value == 1.1


def test_a_mimic_joint_follows_its_leader():
    text = serial_robot(
        1, states=("position",), extra_joints=MIMIC_JOINT, extra_control=MIMIC_CONTROL
    )
    stack = ControlStack(text)
    set_command(stack, "joint1/position", 1.2)
    stack.step()
    assert stack.resources.state_interfaces["jointF/position"].value == pytest.approx(
        -2 * 1.2 + 0.5
    )


def test_an_infinite_command_is_an_error_of_the_component():
    stack = ControlStack(serial_robot(1), enforce_limits=False)
    set_command(stack, "joint1/position", math.inf)
    stack.step()
    (component,) = stack.resources.components.values()
    assert component.lifecycle_state.label == "unconfigured"
    assert not stack.resources.state_interfaces["joint1/position"].available


def test_dynamics_differentiate_positions():
    text = serial_robot(
        1,
        initial=(0.0,),
        commands=("position", "velocity"),
        states=("position", "velocity", "acceleration"),
        parameters='<param name="calculate_dynamics">true</param>',
    )
    stack = ControlStack(text, update_rate=10)
    assert stack.resources.prepare_command_mode_switch(["joint1/position"], [])
    set_command(stack, "joint1/position", 0.1)
    stack.step()
    assert stack.resources.state_interfaces["joint1/velocity"].value == pytest.approx(1.0)


def test_dynamics_integrate_velocities():
    text = serial_robot(
        1,
        initial=(0.0,),
        commands=("position", "velocity"),
        states=("position", "velocity"),
        parameters='<param name="calculate_dynamics">true</param>',
    )
    stack = ControlStack(text, update_rate=10)
    assert stack.resources.prepare_command_mode_switch(["joint1/velocity"], [])
    set_command(stack, "joint1/velocity", 1.0)
    stack.step()
    assert stack.resources.state_interfaces["joint1/position"].value == pytest.approx(0.1)
    both = ["joint1/position", "joint1/velocity"]
    assert not stack.resources.prepare_command_mode_switch(both, [])
