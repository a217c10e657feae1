"""mock_components/GenericSystem: what is commanded is measured."""

import math

import pytest

from teleopctl.control.lifecycle import State
from teleopctl.errors import TeleopctlError
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


OFFSET = '<param name="position_state_following_offset">-3</param>'


def dynamic(*commands, states=("position", "velocity", "acceleration")):
    """Return a stack of one joint at 0 with dynamics, at 10 Hz."""
    text = serial_robot(
        1,
        initial=(0.0,),
        commands=commands,
        states=states,
        parameters='<param name="calculate_dynamics">true</param>',
    )
    return ControlStack(text, update_rate=10)


def switch(stack, *interfaces):
    assert stack.resources.prepare_command_mode_switch(interfaces, [])
    assert stack.resources.perform_command_mode_switch(interfaces, [])


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
    switch(stack, "joint1/position")
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
    switch(stack, "joint1/velocity")
    set_command(stack, "joint1/velocity", 1.0)
    stack.step()
    assert stack.resources.state_interfaces["joint1/position"].value == pytest.approx(0.1)


def test_dynamics_integrate_accelerations():
    stack = dynamic("position", "acceleration")
    switch(stack, "joint1/acceleration")
    set_command(stack, "joint1/acceleration", 2.0)
    stack.step(2)
    # Backward Euler with steps of 0.1 s: v = 0.2, 0.4 and p = 0.02, 0.06.
    assert stack.state("joint1/velocity") == pytest.approx(0.4)
    assert stack.state("joint1/position") == pytest.approx(0.06)


def test_with_dynamics_a_joint_is_commanded_by_one_of_its_three_quantities():
    stack = dynamic("position", "velocity", "effort")
    for interfaces, error in (
        (["joint1/position", "joint1/velocity"], "Got multiple (2) starting interfaces for joint"),
        (["joint1/effort"], "'joint1' has to have 'position', 'velocity', or 'acceleration'"),
    ):
        assert not stack.resources.prepare_command_mode_switch(interfaces, [])
        assert error in stack.log.texts("error")[-1]
    assert stack.resources.prepare_command_mode_switch(["joint1/effort", "joint1/position"], [])


def test_with_dynamics_a_switch_that_is_only_prepared_changes_nothing():
    stack = dynamic("position", "velocity")
    switch(stack, "joint1/velocity")
    set_command(stack, "joint1/velocity", 1.0)
    assert stack.resources.prepare_command_mode_switch(["joint1/position"], ["joint1/velocity"])
    stack.step()
    assert stack.state("joint1/position") == pytest.approx(0.1)


def test_with_dynamics_a_joint_whose_velocity_nobody_commands_any_more_stops():
    stack = dynamic("position", "velocity")
    set_command(stack, "joint1/position", -5.0)
    switch(stack, "joint1/velocity")
    set_command(stack, "joint1/velocity", 1.0)
    stack.step()
    assert stack.resources.perform_command_mode_switch([], ["joint1/velocity"])
    stack.step(2)
    assert stack.state("joint1/position") == pytest.approx(0.1)
    assert stack.state("joint1/velocity") == 0.0


def test_with_dynamics_efforts_follow_commands():
    stack = dynamic("position", "effort", states=("position", "effort"))
    switch(stack, "joint1/position", "joint1/effort")
    set_command(stack, "joint1/effort", 3.0)
    stack.step()
    assert stack.state("joint1/effort") == 3.0


def test_an_offset_holds_from_the_start_and_once():
    stack = ControlStack(serial_robot(1, parameters=OFFSET))
    assert stack.state("joint1/position") == pytest.approx(-1.9)
    component = stack.resources.components["Hardware"]
    component.change_state(State.UNCONFIGURED)
    component.change_state(State.ACTIVE)
    assert stack.state("joint1/position") == pytest.approx(-1.9)


def test_a_custom_interface_follows_positions_with_an_offset():
    custom = '<param name="custom_interface_with_following_offset">actual_position</param>'
    robot = serial_robot(1, states=("position", "actual_position"), parameters=OFFSET + custom)
    stack = ControlStack(robot)
    set_command(stack, "joint1/position", 1.2)
    stack.step()
    assert stack.state("joint1/position") == 1.2
    assert stack.state("joint1/actual_position") == pytest.approx(-1.8)
    assert any("offset 'actual_position' found." in text for text in stack.log.texts("info"))


def test_a_custom_interface_that_no_joint_has_is_named():
    custom = '<param name="custom_interface_with_following_offset">absent</param>'
    stack = ControlStack(serial_robot(1, parameters=OFFSET + custom))
    assert any("'absent' does not exist" in text for text in stack.log.texts("warning"))


def test_an_offset_that_is_no_number_is_refused():
    with pytest.raises(TeleopctlError, match="failed to initialize"):
        ControlStack(
            serial_robot(1, parameters='<param name="position_state_following_offset">x</param>')
        )


PARTS = (
    '<sensor name="tcp"><state_interface name="fx"><param name="initial_value">1.5</param>'
    '</state_interface><state_interface name="fy"/></sensor>'
    '<gpio name="io"><command_interface name="valve"/><state_interface name="valve"/>'
    '<state_interface name="button"/></gpio>'
)


def parts(parameter=""):
    enabled = f'<param name="{parameter}">True</param>' if parameter else ""
    return ControlStack(serial_robot(1, extra_control=PARTS, parameters=enabled))


def commanded(stack):
    return [name for name in stack.resources.command_interfaces if not name.startswith("joint")]


def test_a_gpio_state_follows_the_command_of_the_same_name():
    stack = parts()
    assert commanded(stack) == ["io/valve"]
    assert math.isnan(stack.state("io/valve"))
    set_command(stack, "io/valve", 1.0)
    stack.step()
    assert stack.state("io/valve") == 1.0
    assert math.isnan(stack.state("io/button"))


def test_mock_gpio_commands_adds_a_command_for_every_gpio_state():
    stack = parts("mock_gpio_commands")
    assert commanded(stack) == ["io/valve", "io/button"]
    set_command(stack, "io/button", 0.25)
    stack.step()
    assert stack.state("io/button") == 0.25


def test_mock_sensor_commands_adds_a_command_for_every_sensor_state():
    stack = parts("mock_sensor_commands")
    assert commanded(stack) == ["io/valve", "tcp/fx", "tcp/fy"]
    set_command(stack, "tcp/fy", -2.5)
    stack.step()
    assert (stack.state("tcp/fx"), stack.state("tcp/fy")) == (1.5, -2.5)


def test_sensors_keep_their_initial_values_without_mock_commands():
    stack = parts()
    stack.step(3)
    assert stack.state("tcp/fx") == 1.5


def test_an_infinite_command_of_a_sensor_is_an_error_of_the_component():
    stack = parts("mock_sensor_commands")
    set_command(stack, "tcp/fy", math.inf)
    stack.step()
    assert stack.resources.components["Hardware"].lifecycle_state is State.UNCONFIGURED


def test_commands_and_booleans_start_at_their_initial_values():
    gpio = (
        '<gpio name="io"><command_interface name="speed"><param name="initial_value">0.7</param>'
        '</command_interface><state_interface name="speed"/>'
        '<state_interface name="ready" data_type="bool"><param name="initial_value">true</param>'
        '</state_interface><state_interface name="open" data_type="bool"/></gpio>'
    )
    stack = ControlStack(serial_robot(1, extra_control=gpio))
    assert stack.command("io/speed") == 0.7
    assert (stack.state("io/ready"), stack.state("io/open")) == (1.0, 0.0)
    stack.step()
    assert stack.state("io/speed") == 0.7
