"""Transmissions of hardware that has actuators: the formulas of transmission_interface."""

import math

import pytest
from hypothesis import given, strategies as st

from teleopctl.control.hardware.base import HardwareComponentInterface
from teleopctl.control.hardware.transmissions import (
    DifferentialTransmission,
    FourBarLinkageTransmission,
    SimpleTransmission,
)
from teleopctl.errors import TeleopctlError
from teleopctl.testing import ControlStack, serial_robot

KINDS = (SimpleTransmission, DifferentialTransmission, FourBarLinkageTransmission)
VALUE = st.floats(-100.0, 100.0)
REDUCTION = st.floats(0.1, 200.0) | st.floats(-200.0, -0.1)


@st.composite
def transmissions(draw):
    kind = draw(st.sampled_from(KINDS))
    actuators = (1.0,) if kind is SimpleTransmission else draw(st.tuples(REDUCTION, REDUCTION))
    joints, offsets = (
        draw(st.lists(one, min_size=kind.size, max_size=kind.size)) for one in (REDUCTION, VALUE)
    )
    return kind(actuators, joints, offsets)


def values(draw, transmission):
    return draw(st.lists(VALUE, min_size=transmission.size, max_size=transmission.size))


@given(st.data(), transmissions(), st.sampled_from(SimpleTransmission.quantities))
def test_from_joints_to_actuators_and_back(data, transmission, quantity):
    joints = values(data.draw, transmission)
    actuators = transmission.joint_to_actuator(quantity, joints)
    assert transmission.actuator_to_joint(quantity, actuators) == pytest.approx(
        tuple(joints), rel=1e-6, abs=1e-6
    )


@given(st.data(), transmissions())
def test_actuators_and_joints_have_the_same_power(data, transmission):
    velocities, efforts = (values(data.draw, transmission) for _ in range(2))
    joint_velocities = transmission.actuator_to_joint("velocity", velocities)
    joint_efforts = transmission.actuator_to_joint("effort", efforts)
    power = sum(v * e for v, e in zip(velocities, efforts, strict=True))
    joint_power = sum(v * e for v, e in zip(joint_velocities, joint_efforts, strict=True))
    assert joint_power == pytest.approx(power, rel=1e-6, abs=1e-3)


@pytest.mark.parametrize(
    ("transmission", "quantity", "actuators", "joints"),
    [
        (SimpleTransmission([1], [10], [1]), "position", [50], [6]),
        (SimpleTransmission([1], [-10], [1]), "velocity", [50], [-5]),
        (SimpleTransmission([1], [10], [1]), "effort", [50], [500]),
        (SimpleTransmission([1], [10], [1]), "absolute_position", [50], [6]),
        (DifferentialTransmission([10, 10], [2, 2], [-2, 4]), "position", [30, 50], [0, 3.5]),
        (DifferentialTransmission([10, 10], [2, 2], [-2, 4]), "velocity", [30, 50], [2, -0.5]),
        (DifferentialTransmission([10, 10], [2, 2], [0, 0]), "effort", [3, 5], [160, -40]),
        (FourBarLinkageTransmission([10, 10], [2, 2], [-2, 4]), "position", [30, 50], [-0.5, 5.75]),
        (FourBarLinkageTransmission([10, 10], [2, 2], [0, 0]), "velocity", [30, 50], [1.5, 1.75]),
        (FourBarLinkageTransmission([10, 10], [2, 2], [0, 0]), "effort", [3, 5], [110, 100]),
    ],
)
def test_formulas(transmission, quantity, actuators, joints):
    assert transmission.actuator_to_joint(quantity, actuators) == pytest.approx(tuple(joints))
    assert transmission.joint_to_actuator(quantity, joints) == pytest.approx(tuple(actuators))


class Motors(HardwareComponentInterface):
    """Motors that reach their commands at once."""

    def on_init(self):
        self.motors = self.actuator_interfaces()

    def read(self, time_ns, period):
        for name, state in self.motors.states.items():
            command = self.motors.commands.get(name)
            if command is not None and math.isfinite(command.value):
                state.value = command.value
        self.motors.actuators_to_joints()

    def write(self, time_ns, period):
        self.motors.joints_to_actuators()


MOTORS = "tests.control.hardware.test_transmissions:Motors"
# The second joint and the second actuator stand first: the roles order them.
WRIST = """
<transmission name="wrist"><plugin>transmission_interface/DifferentialTransmission</plugin>
<joint name="joint2" role="joint2"><mechanical_reduction>4</mechanical_reduction></joint>
<joint name="joint1" role="joint1"><mechanical_reduction>2</mechanical_reduction>
<offset>0.5</offset></joint>
<actuator name="right" role="actuator2"><mechanical_reduction>20</mechanical_reduction></actuator>
<actuator name="left" role="actuator1"><mechanical_reduction>10</mechanical_reduction></actuator>
</transmission>"""


def stack_of(tags, plugin=MOTORS, **options):
    return ControlStack(serial_robot(3, plugin=plugin, extra_control=tags, **options))


def set_command(stack, name, value):
    command = stack.resources.command_interfaces[name]
    command.owner, command.value = "test", value


def test_hardware_reads_and_writes_actuators_in_the_order_of_the_roles():
    stack = stack_of(WRIST)
    for name, value in (("joint1", 1.0), ("joint2", 0.25), ("joint3", 3.0)):
        set_command(stack, f"{name}/position", value)
    stack.step()
    motors = stack.resources.components["Hardware"].hardware.motors
    # (1 - 0.5) * 2 = 1 and 0.25 * 4 = 1: their sum moves the left motor, the difference the right.
    wanted = {name: command.value for name, command in motors.commands.items()}
    assert wanted == {"left/position": 20.0, "right/position": 0.0, "joint3/position": 3.0}
    stack.step()
    found = [stack.state(f"joint{number}/position") for number in (1, 2, 3)]
    assert found == [1.0, 0.25, 3.0]
    assert not [text for text in stack.log.texts("warning") if "ransmission" in text]


def test_a_joint_whose_actuators_are_not_measured_keeps_its_state():
    stack = stack_of(WRIST)
    stack.step(2)
    assert stack.state("joint1/position") == 1.1


@pytest.mark.parametrize(
    ("old", "new", "error"),
    [
        ("DifferentialTransmission", "MagicTransmission", "is unknown"),
        (">4<", ">0<", "Transmission reduction ratios cannot be zero."),
        (
            "DifferentialTransmission",
            "SimpleTransmission",
            "A SimpleTransmission has 1 actuators and 1 joints, not 2 and 2",
        ),
    ],
)
def test_a_wrong_transmission_is_refused_by_hardware_that_applies_it(old, new, error):
    stack = ControlStack()
    with pytest.raises(TeleopctlError, match="failed to initialize"):
        stack.load_urdf(serial_robot(3, plugin=MOTORS, extra_control=WRIST.replace(old, new)))
    (text,) = (text for text in stack.log.texts("error") if "raised in on_init" in text)
    assert "Transmission 'wrist' (line 2 of the robot description)" in text
    assert error in text


SIMPLE = """
<transmission name="gear"><plugin>transmission_interface/SimpleTransmission</plugin>
<joint name="joint1" role="joint1"/><actuator name="motor" role="actuator1"/></transmission>"""


def test_hardware_without_actuators_names_its_transmissions_on_one_line():
    geared = SIMPLE.replace(
        "/><act", "><mechanical_reduction>50</mechanical_reduction></joint><act"
    )
    stack = stack_of(WRIST + geared, plugin="mock_components/GenericSystem")
    (text,) = (text for text in stack.log.texts("warning") if "ransmission" in text)
    assert text == (
        "Transmissions of hardware 'Hardware' have no effect: 'wrist' (line 2), 'gear' (line 9) of "
        "the robot description. 'mock_components/GenericSystem' measures and commands joints"
    )


def test_a_transmission_of_one_to_one_needs_no_line():
    stack = stack_of(SIMPLE, plugin="mock_components/GenericSystem")
    assert not stack.log.texts("warning")
