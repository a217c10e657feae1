"""The controller of omni wheels: wheel speeds by its formula, odometry, references; 100 Hz."""

import math

import pytest
from hypothesis import given, strategies as st

from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.control.controllers.mobile_base.omni_wheel import OmniWheelDriveController
from teleopctl.control.controllers.mobile_base.velocity_input import BaseVelocity
from teleopctl.interfaces import get_message, set_stamp
from teleopctl.testing import ControlStack, serial_robot

TYPE = "omni_wheel_drive_controller/OmniWheelDriveController"
TwistStamped = get_message("geometry_msgs/msg/TwistStamped")
SPEED = st.floats(-2.0, 2.0)


class Base:
    """A base on omni wheels, which turn as commanded; the joint in front is ``joint1``."""

    def __init__(self, wheels=4, **parameters):
        robot = serial_robot(
            wheels,
            initial=(0.0,),
            commands=("velocity",),
            states=("position", "velocity"),
            kind="continuous",
            parameters='<param name="calculate_dynamics">true</param>',
        )
        self.stack = ControlStack(robot, enforce_limits=False)
        self.names = [f"joint{number + 1}" for number in range(wheels)]
        options = {
            "wheel_names": self.names,
            "wheel_offset": 0.0,
            "robot_radius": 0.2,
            "wheel_radius": 0.02,
            **{name.replace("__", "."): value for name, value in parameters.items()},
        }
        controller = self.stack.load_controller("omni", TYPE, options)
        assert isinstance(controller, OmniWheelDriveController)
        self.controller = controller
        self.node = self.stack.nodes["omni"]

    def drive(self, x, y, angular, updates=1):
        message = TwistStamped()
        set_stamp(message.header.stamp, self.stack.time_ns)
        message.twist.linear.x, message.twist.linear.y = x, y
        message.twist.angular.z = angular
        self.node.receive("~/cmd_vel", message)
        self.stack.step(updates)

    @property
    def speeds(self):
        return [self.stack.command(f"{name}/velocity") for name in self.names]


@pytest.mark.parametrize(
    ("velocity", "wheels"),
    [
        # Front, left, back and right wheel; 1 m/s is 50 rad/s.
        ((1.0, 0.0, 0.0), [0.0, 50.0, 0.0, -50.0]),
        ((0.0, 1.0, 0.0), [-50.0, 0.0, 50.0, 0.0]),
        ((0.0, 0.0, 1.0), [-10.0, -10.0, -10.0, -10.0]),
    ],
)
def test_wheels_roll_at_right_angles_to_their_radius(velocity, wheels):
    base = Base()
    base.stack.activate("omni")
    base.drive(*velocity)
    assert base.speeds == pytest.approx(wheels)
    base.stack.deactivate("omni")
    assert base.speeds == pytest.approx([0.0] * 4)


def test_three_wheels_may_begin_at_an_angle():
    base = Base(wheels=3, wheel_offset=math.pi / 6)
    base.stack.activate("omni")
    base.drive(1.0, 0.0, 0.0)
    angles = [math.pi / 6 + math.tau / 3 * number for number in range(3)]
    assert base.speeds == pytest.approx([math.sin(angle) / 0.02 for angle in angles])


@given(count=st.integers(3, 7), offset=st.floats(-3.0, 3.0), x=SPEED, y=SPEED, angular=SPEED)
def test_the_odometry_inverts_the_wheel_speeds(count, offset, x, y, angular):
    base = Base(count, wheel_offset=offset, position_feedback=False)
    base.stack.manager.configure_controller("omni")
    velocity = BaseVelocity(x, y, angular)
    wheels = base.controller.wheel_commands(velocity)
    moved = base.controller.displacement(wheels, wheels, 0.5)
    assert moved == pytest.approx([0.5 * value for value in velocity], abs=1e-9)


@pytest.mark.parametrize("position_feedback", [True, False])
def test_the_odometry_follows_the_wheels(position_feedback):
    base = Base(position_feedback=position_feedback, diagonal_covariance__pose=[1.0] * 6)
    base.stack.activate("omni")
    base.stack.step()
    base.drive(0.5, 0.25, 0.0, updates=40)
    message = base.node.published("~/odom")[-1]
    assert message.header.frame_id == "odom"
    assert message.twist.twist.linear.y == pytest.approx(0.25)
    position = message.pose.pose.position
    assert (position.x, position.y) == pytest.approx((0.2, 0.1), abs=0.01)
    assert message.pose.covariance[7] == 1.0
    assert base.node.published("/tf")[-1].transforms[0].child_frame_id == "base_link"


def test_another_controller_commands_the_references():
    base = Base()
    assert isinstance(base.controller, ChainableControllerInterface)
    base.stack.manager.configure_controller("omni")
    names = [reference.name for reference in base.controller.reference_interfaces]
    assert names == ["omni/linear/x/velocity", "omni/linear/y/velocity", "omni/angular/z/velocity"]
    forward = "forward_command_controller/MultiInterfaceForwardCommandController"
    base.stack.load_controller(
        "driver",
        forward,
        {"joint": "omni", "interface_names": [name.partition("/")[2] for name in names]},
    )
    base.stack.activate("omni", "driver")
    data = get_message("std_msgs/msg/Float64MultiArray")(data=[1.0, 0.0, 0.0])
    base.stack.nodes["driver"].receive("~/commands", data)
    base.stack.step()
    assert base.speeds == pytest.approx([0.0, 50.0, 0.0, -50.0])


def test_the_base_stops_after_the_timeout():
    base = Base()
    base.stack.activate("omni")
    base.drive(1.0, 0.0, 0.0, updates=49)
    assert base.speeds[1] == pytest.approx(50.0)
    base.stack.step(3)
    assert base.speeds == pytest.approx([0.0] * 4)


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        ({"wheel_names": ["joint1", "joint2"]}, "The number of wheels is less than 3"),
        ({"wheel_offset": math.nan}, "'wheel_offset' has no value"),
        ({"robot_radius": 0.0}, "'robot_radius' is 0: it must be above 0"),
        (
            {"diagonal_covariance__twist": [0.1] * 7},
            "Length of parameter 'diagonal_covariance.twist' is 7 but must be equal to 6",
        ),
        ({"wheel_radius": -1.0}, "'wheel_radius' is -1: it must be above 0"),
    ],
)
def test_wrong_parameters_are_refused(parameters, text):
    base = Base(**parameters)
    assert not base.stack.manager.configure_controller("omni")
    assert text in base.node.log.texts("error")[0]
