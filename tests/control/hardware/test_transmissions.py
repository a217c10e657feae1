"""Hardware that has actuators: their values follow from those of the joints, and the reverse."""

import math

import pytest

from teleopctl.control.hardware.base import HardwareComponentInterface
from teleopctl.errors import TeleopctlError
from teleopctl.testing import ControlStack, serial_robot


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


def test_the_simulator_applies_those_of_an_mjcf_file_without_a_line():
    urdf = serial_robot(3, plugin="gz_ros2_control/GazeboSimSystem", extra_control=WRIST)
    for extension, lines in (("", 1), ('<mujoco file="file:///wrist.xml"/>', 0)):
        stack = ControlStack(urdf.replace("</robot>", f"{extension}</robot>"))
        assert len([text for text in stack.log.texts("warning") if "ransmission" in text]) == lines


def test_a_transmission_of_one_to_one_needs_no_line():
    stack = stack_of(SIMPLE, plugin="mock_components/GenericSystem")
    assert not stack.log.texts("warning")
