"""The admittance controller: its rule against matrices, and what it commands, exports and refuses.

The gantry has a prismatic joint along each axis of its base, and a sensor that is turned about z.
"""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from teleopctl.control.controllers.admittance.rule import (
    AdmittanceFrames,
    AdmittanceGains,
    AdmittanceRule,
    damped_least_squares,
    rotation_vector,
)
from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.interfaces import get_message
from teleopctl.node import Parameter
from teleopctl.robot import RobotDescription, SerialChain
from teleopctl.testing import ControlStack
from teleopctl.tf import conjugate, matrix_from_quaternion, multiply, quaternion_from_axis_angle

TYPE = "admittance_controller/AdmittanceController"
NAMES = [f"{part}.{axis}" for part in ("force", "torque") for axis in "xyz"]
JOINTS = ["x", "y", "z"]
TwistPoint = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
WrenchStamped = get_message("geometry_msgs/msg/WrenchStamped")
GAINS = {
    "admittance.selected_axes": [True] * 6,
    "admittance.mass": [2.0, 4.0, 5.0, 1.0, 1.0, 1.0],
    "admittance.damping_ratio": [1.0] * 6,
    "admittance.stiffness": [50.0, 100.0, 200.0, 10.0, 10.0, 10.0],
    "admittance.joint_damping": 0.0,
    "gravity_compensation.CoG.pos": [0.0, 0.0, 0.0],
}
GANTRY = {
    "joints": JOINTS,
    "command_interfaces": ["position"],
    "state_interfaces": ["position"],
    "kinematics.plugin_name": "kinematics_interface_kdl/KinematicsInterfaceKDL",
    "kinematics.plugin_package": "kinematics_interface",
    "kinematics.base": "base",
    "kinematics.tip": "tool",
    "kinematics.alpha": 1e-9,
    "ft_sensor.name": "ft",
    "ft_sensor.frame.id": "sensor",
    "ft_sensor.filter_coefficient": 1.0,
    "control.frame.id": "base",
    "fixed_world_frame.frame.id": "base",
    "gravity_compensation.frame.id": "sensor",
    **GAINS,
}


def gantry():
    """The URDF of the gantry: base, x, y, z, and the sensor and the tool on z."""
    links = "".join(f'<link name="{name}"/>' for name in ("base", *JOINTS, "sensor", "tool"))
    joints = "".join(
        f'<joint name="{child}" type="prismatic"><parent link="{parent}"/><child link="{child}"/>'
        f'<axis xyz="{axis}"/><limit lower="-9" upper="9" effort="1" velocity="9"/></joint>'
        for parent, child, axis in (
            ("base", "x", "1 0 0"),
            ("x", "y", "0 1 0"),
            ("y", "z", "0 0 1"),
        )
    )
    fixed = "".join(
        f'<joint name="{child}_mount" type="fixed"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="0 0 0.1" rpy="0 0 {yaw}"/></joint>'
        for parent, child, yaw in (("z", "sensor", math.pi / 2), ("sensor", "tool", 0.0))
    )
    control = "".join(
        f'<joint name="{name}">'
        + "".join(f'<command_interface name="{kind}"/>' for kind in ("position", "velocity"))
        + '<state_interface name="position"><param name="initial_value">0.5</param>'
        '</state_interface><state_interface name="velocity"/></joint>'
        for name in JOINTS
    )
    states = "".join(f'<state_interface name="{name}"/>' for name in NAMES)
    return (
        f'<robot name="gantry">{links}{joints}{fixed}<ros2_control name="mock" type="system">'
        f"<hardware><plugin>mock_components/GenericSystem</plugin></hardware>{control}"
        f'<sensor name="ft">{states}</sensor></ros2_control></robot>'
    )


class Gantry:
    """An admittance controller of the gantry, at 100 Hz; the joints are where they are sent."""

    def __init__(self, *, activate=True, **changes):
        self.stack = ControlStack(gantry(), enforce_limits=False, last_only=True)
        options: dict[str, Any] = GANTRY | {
            name.replace("__", "."): value for name, value in changes.items()
        }
        controller = self.stack.load_controller("admittance", TYPE, options)
        assert isinstance(controller, ChainableControllerInterface)
        self.controller = controller
        self.node = self.stack.nodes["admittance"]
        self.push(*[0.0] * 6)
        if activate:
            self.stack.activate("admittance")

    def push(self, *wrench):
        for name, value in zip(NAMES, wrench, strict=True):
            self.stack.resources.state_interfaces[f"ft/{name}"].value = value

    def refer(self, positions=(), velocities=()):
        point = TwistPoint(positions=list(positions), velocities=list(velocities))
        self.node.receive("~/joint_references", point)

    def command(self, kind="position"):
        return [self.stack.command(f"{name}/{kind}") for name in JOINTS]

    @property
    def status(self):
        return self.node.published("~/status")[-1]


def test_without_a_force_the_joints_stay():
    robot = Gantry()
    robot.stack.step(3)
    assert robot.command() == [0.5, 0.5, 0.5]


def test_a_first_update_is_newtons_law():
    robot = Gantry()
    robot.push(0.0, -3.0, 0.0, 0.0, 0.0, 0.0)  # the sensor's -y is the base's x
    robot.stack.step()
    speed = 3.0 / 2.0 * 0.01
    assert robot.command() == pytest.approx([0.5 + speed * 0.01, 0.5, 0.5])
    status = robot.status
    assert status.wrench_base.wrench.force.x == pytest.approx(3.0)
    assert list(status.joint_state.effort) == pytest.approx([1.5, 0.0, 0.0])
    assert status.admittance_acceleration.twist.linear.x == pytest.approx(1.5)
    assert status.admittance_velocity.twist.linear.x == pytest.approx(speed)


def test_a_constant_force_moves_the_sensor_against_its_spring():
    robot = Gantry()
    robot.push(0.0, 0.0, -10.0, 0.0, 0.0, 0.0)
    robot.stack.step(600)
    assert robot.command() == pytest.approx([0.5, 0.5, 0.5 - 10.0 / 200.0], abs=1e-6)
    robot.push(*[0.0] * 6)
    robot.stack.step(600)
    assert robot.command() == pytest.approx([0.5, 0.5, 0.5], abs=1e-6)


def test_stiffness_is_along_the_axes_of_the_control_frame():
    robot = Gantry(control__frame__id="sensor")
    robot.push(0.0, -10.0, 0.0, 0.0, 0.0, 0.0)
    robot.stack.step(900)
    # Along the base's x, which is the sensor's -y, of a stiffness of 100 N/m.
    assert robot.command()[0] == pytest.approx(0.5 + 10.0 / 100.0, abs=1e-4)


def test_axes_that_are_not_selected_do_not_give_way():
    robot = Gantry(admittance__selected_axes=[False, *[True] * 5])
    robot.push(10.0, -10.0, 0.0, 0.0, 0.0, 0.0)
    robot.stack.step(600)
    assert robot.command() == pytest.approx([0.5, 0.6, 0.5], abs=1e-6)


def test_the_weight_of_the_tool_is_not_a_force():
    robot = Gantry(
        gravity_compensation__CoG__force=23.0, gravity_compensation__CoG__pos=[0.1, 0.0, 0.0]
    )
    robot.push(0.0, 0.0, -23.0, 0.0, 2.3, 0.0)
    robot.stack.step(10)
    assert robot.command() == pytest.approx([0.5, 0.5, 0.5])
    torque = robot.status.wrench_base.wrench.torque
    assert (torque.x, torque.y, torque.z) == pytest.approx((0.0, 0.0, 0.0))


def test_the_wrench_is_filtered():
    robot = Gantry(ft_sensor__filter_coefficient=0.25)
    robot.push(0.0, 0.0, 8.0, 0.0, 0.0, 0.0)
    found = []
    for _ in range(3):
        robot.stack.step()
        found.append(robot.status.wrench_base.wrench.force.z)
    assert found == pytest.approx([8.0 * (1.0 - 0.75**n) for n in (1, 2, 3)])


def test_a_wrench_of_nan_is_none():
    robot = Gantry()
    robot.push(math.nan, 5.0, 5.0, 0.0, 0.0, 0.0)
    robot.stack.step()
    assert robot.command() == [0.5, 0.5, 0.5]


def test_references_come_from_a_topic():
    robot = Gantry()
    robot.refer([0.6, 0.7, math.nan])
    robot.stack.step()
    # The spring pulls for a cycle, until the sensor has arrived at its reference.
    assert robot.command() == pytest.approx([0.6, 0.7, 0.5], abs=0.001)
    robot.stack.step(300)
    assert robot.command() == pytest.approx([0.6, 0.7, 0.5], abs=1e-6)


def test_a_wanted_wrench_is_added_to_the_measured_one():
    robot = Gantry()
    message = WrenchStamped()
    message.header.frame_id = "sensor"
    message.wrench.force.z = 10.0
    robot.node.receive("~/wrench_reference", message)
    robot.push(0.0, 0.0, -10.0, 0.0, 0.0, 0.0)
    robot.stack.step(5)
    assert robot.command() == [0.5, 0.5, 0.5]
    message.header.frame_id = "tool"
    robot.node.receive("~/wrench_reference", message)
    assert robot.node.log.texts("error") == [
        "Ignoring wrench reference as it is on the wrong frame: tool. Expected reference frame: "
        "sensor"
    ]


@pytest.mark.parametrize(
    ("positions", "text"),
    [
        ([1.0], "Ignoring joint reference with 1 positions: there are 3 joints (x, y, z)"),
        ([0.0, 0.0, math.inf], "Non-finite value received"),
    ],
)
def test_a_wrong_reference_is_dropped(positions, text):
    robot = Gantry()
    robot.refer(positions)
    robot.stack.step()
    assert robot.command() == [0.5, 0.5, 0.5]
    assert text in robot.node.log.lines[-1][1]


def test_another_controller_commands_the_references():
    robot = Gantry(activate=False)
    robot.stack.manager.configure_controller("admittance")
    names = [reference.name for reference in robot.controller.reference_interfaces]
    assert names == [
        f"admittance/{name}/{kind}" for kind in ("position", "velocity") for name in JOINTS
    ]
    robot.stack.load_controller(
        "forward",
        "forward_command_controller/ForwardCommandController",
        {"joints": [f"admittance/{name}" for name in JOINTS], "interface_name": "position"},
    )
    robot.stack.activate("admittance", "forward")
    data = get_message("std_msgs/msg/Float64MultiArray")(data=[0.1, 0.2, 0.3])
    robot.stack.nodes["forward"].receive("~/commands", data)
    robot.refer([9.0, 9.0, 9.0])
    robot.stack.step()
    assert robot.command() == pytest.approx([0.1, 0.2, 0.3], abs=0.002)


def test_the_wrench_may_come_from_a_force_torque_broadcaster():
    robot = Gantry(activate=False, ft_sensor__name="wrench/ft")
    robot.stack.load_controller(
        "wrench",
        "force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster",
        {"sensor_name": "ft", "frame_id": "sensor", "offset.force.z": 4.0},
    )
    robot.stack.activate("wrench", "admittance")
    robot.push(0.0, 0.0, -10.0, 0.0, 0.0, 0.0)
    robot.stack.step()
    assert robot.status.wrench_base.wrench.force.z == pytest.approx(-6.0)


def test_velocities_are_those_of_reference_and_offset():
    robot = Gantry(command_interfaces=["velocity", "position"])
    robot.refer(velocities=[0.25, 0.0, 0.0])
    robot.push(0.0, -3.0, 0.0, 0.0, 0.0, 0.0)
    robot.stack.step()
    assert robot.command("velocity") == pytest.approx([0.25 + 0.015, 0.0, 0.0])


def test_an_activation_begins_without_offset_and_at_the_measured_positions():
    robot = Gantry()
    robot.push(0.0, 0.0, -10.0, 0.0, 0.0, 0.0)
    robot.refer([0.6, 0.6, 0.6])
    robot.stack.step(20)
    robot.stack.deactivate("admittance")
    robot.push(*[0.0] * 6)
    there = [robot.stack.state(f"{name}/position") for name in JOINTS]
    robot.stack.activate("admittance")
    robot.stack.step()
    assert robot.command() == pytest.approx(there, abs=1e-4)


def test_a_stopped_robot_does_not_give_way_and_goes_on_without_a_jump():
    robot = Gantry()
    robot.push(0.0, 0.0, -10.0, 0.0, 0.0, 0.0)
    robot.stack.step(20)
    robot.stack.manager.robot_stop.hold("/a_node")
    robot.refer([9.0, 9.0, 9.0])
    robot.stack.step(200)
    stopped = robot.command()
    robot.stack.step()
    assert robot.command() == stopped
    assert "The reference on ~/joint_references is refused" in robot.node.log.texts("warning")[0]
    robot.stack.manager.robot_stop.hold("")
    robot.stack.step()
    assert robot.command() == pytest.approx(stopped, abs=0.001)
    robot.stack.step(600)
    assert robot.command()[2] == pytest.approx(0.45, abs=1e-6)


def test_parameters_change_at_once_or_at_the_next_activation():
    robot = Gantry()
    robot.push(0.0, 0.0, -10.0, 0.0, 0.0, 0.0)
    stiffer = [Parameter("admittance.stiffness", value=[400.0] * 6)]
    robot.node.set_parameters(stiffer)
    robot.stack.step(600)
    assert robot.command()[2] == pytest.approx(0.475, abs=1e-6)
    robot.node.set_parameters([Parameter("admittance.mass", value=[0.0] * 6)])
    assert (
        "Value 0 in parameter 'admittance.mass' must be between 0.0001 and 1e+06"
        in (robot.node.log.texts("error")[0])
    )
    robot = Gantry(enable_parameter_update_without_reactivation=False)
    robot.push(0.0, 0.0, -10.0, 0.0, 0.0, 0.0)
    robot.node.set_parameters(stiffer)
    robot.stack.step()
    assert list(robot.status.stiffness.data) == GAINS["admittance.stiffness"]
    robot.stack.deactivate("admittance")
    robot.stack.activate("admittance")
    robot.stack.step()
    assert list(robot.status.stiffness.data) == [400.0] * 6


def test_the_status_has_parameters_frames_and_offsets():
    robot = Gantry(control__frame__id="sensor")
    robot.push(0.0, 0.0, -10.0, 0.0, 0.0, 0.0)
    robot.stack.step(600)
    status = robot.status
    assert list(status.selected_axes.data) == [1] * 6
    assert list(status.damping.data)[:3] == pytest.approx(
        [2.0 * math.sqrt(m * k) for m, k in ((2.0, 50.0), (4.0, 100.0), (5.0, 200.0))]
    )
    assert status.rot_base_control.z == pytest.approx(math.sqrt(0.5))
    assert status.ft_sensor_frame.data == "sensor"
    reference, offset = status.ref_trans_base_ft, status.admittance_position
    assert (reference.header.frame_id, reference.child_frame_id) == ("base", "sensor")
    assert reference.transform.translation.z == pytest.approx(0.6)
    assert (offset.header.frame_id, offset.child_frame_id) == ("base", "admittance_offset")
    assert offset.transform.translation.z == pytest.approx(-0.05, abs=1e-5)
    assert list(status.joint_state.name) == JOINTS
    assert status.joint_state.position[2] == pytest.approx(-0.05, abs=1e-5)


def test_new_code_goes_on_with_the_offsets():
    robot = Gantry()
    robot.push(0.0, 0.0, -10.0, 0.0, 0.0, 0.0)
    robot.stack.step(600)
    state = robot.controller.export_state()
    robot.stack.deactivate("admittance")
    robot.stack.activate("admittance")
    robot.controller.import_state(state)
    robot.stack.step()
    assert robot.command()[2] == pytest.approx(0.45, abs=1e-4)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"joints": []}, "Parameter 'joints' cannot be empty"),
        ({"joints": ["x", "y"]}, "must have the joints that move tool in the frame of base"),
        ({"command_joints": ["x"]}, "'command_joints' parameter has to have the same size"),
        ({"command_interfaces": ["effort"]}, "Command interface type 'effort' not allowed!"),
        ({"state_interfaces": ["velocity"]}, "Position state interface is required."),
        (
            {"chainable_command_interfaces": ["acceleration"]},
            "chainable interface type acceleration is not supported. Supported types are position",
        ),
        ({"kinematics__tip": "gripper"}, "The robot has no link 'gripper'"),
        ({"kinematics__base": ""}, "Parameter 'kinematics.base' cannot be empty"),
        ({"kinematics__alpha": 0.0}, "Parameter 'kinematics.alpha' is 0: it must be above 0"),
        ({"control__frame__id": "flange"}, "The robot has no link 'flange'"),
        ({"ft_sensor__filter_coefficient": 0.0}, "'ft_sensor.filter_coefficient' is 0"),
        ({"admittance__mass": [1.0]}, "Length of parameter 'admittance.mass' is 1 but must be"),
        ({"admittance__stiffness": [-1.0] * 6}, "Value -1 in parameter 'admittance.stiffness'"),
        ({"admittance__joint_damping": -1.0}, "'admittance.joint_damping' is -1"),
    ],
)
def test_wrong_parameters_are_refused(changes, text):
    robot = Gantry(activate=False, **changes)
    assert not robot.stack.manager.configure_controller("admittance")
    assert text in robot.node.log.texts("error")[0]


def test_nothing_is_commanded_before_the_first_measured_positions():
    robot = Gantry(activate=False)
    robot.stack.manager.configure_controller("admittance")
    position = robot.stack.resources.state_interfaces["y/position"]
    position.value = math.nan
    robot.stack.activate("admittance")
    robot.controller.update(0, 0.01)
    assert all(map(math.isnan, robot.command()))
    position.value = 0.25
    robot.controller.update(0, 0.01)
    assert robot.command() == [0.5, 0.25, 0.5]


def test_another_kinematics_plug_in_is_named():
    robot = Gantry(kinematics__plugin_name="ikfast/Arm")
    assert "Kinematics plugin 'ikfast/Arm' is not loaded" in robot.node.log.texts("warning")[0]


# -- the rule, against matrices --------------------------------------------------------------------

ARM = RobotDescription.from_urdf(
    '<robot name="arm"><link name="l0"/>'
    + "".join(
        f'<link name="l{n + 1}"/><joint name="j{n}" type="continuous"><parent link="l{n}"/>'
        f'<child link="l{n + 1}"/><origin xyz="0.2 0 {0.1 * n}" rpy="{n} 0.5 0"/>'
        f'<axis xyz="0 {n % 2} {1 - n % 2}"/></joint>'
        for n in range(6)
    )
    + "</robot>"
)
SIX = st.tuples(*[st.floats(-1.0, 1.0)] * 6)


@settings(max_examples=20)
@given(positions=SIX, reference=SIX, wrench=SIX, speeds=SIX)
def test_the_rule_is_that_of_its_matrices(positions, reference, wrench, speeds):
    chain = SerialChain(ARM, "l0", "l6")
    frames = AdmittanceFrames(*map(chain.frame, ("l6", "l3", "l0", "l6")))
    gains = AdmittanceGains(
        (True, False, True, True, True, False),
        (1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
        (0.5, 0.6, 0.7, 0.8, 0.9, 1.0),
        (10.0, 20.0, 30.0, 40.0, 50.0, 60.0),
        5.0,
        1.0,
        0.0,
        (0.0, 0.0, 0.0),
    )
    rule = AdmittanceRule(chain, frames, 0.01, gains)
    # A first update with the same speeds makes them known as the velocity of the sensor.
    rule.joint_velocities = list(speeds)
    rule.update(positions, wrench, reference, 0.0)
    rule.update(positions, wrench, reference, 0.01)

    def pose(joints, link):
        frame = chain.frame(link)
        return chain.joint_poses(joints)[frame.joints] @ frame.offset

    jacobian = np.array(chain.jacobian(frames.sensor, chain.joint_poses(positions))).T
    here, there = pose(positions, "l6"), pose(reference, "l6")
    rotation = np.array(matrix_from_quaternion(pose(positions, "l3").rotation))
    both = np.kron(np.eye(2), rotation)
    stiffness = both @ np.diag(gains.stiffness) @ both.T
    damping = both @ np.diag(gains.damping) @ both.T
    sensor = np.kron(np.eye(2), np.array(matrix_from_quaternion(here.rotation)))
    force = both @ np.diag(np.array(gains.selected_axes, float)) @ both.T @ sensor @ wrench
    turn = rotation_vector(multiply(here.rotation, conjugate(there.rotation)))
    offset = np.array([*np.subtract(here.translation, there.translation), *turn])
    acceleration = (force - damping @ (jacobian @ speeds) - stiffness @ offset) / gains.mass
    inverse = np.linalg.inv(jacobian.T @ jacobian + 0.01 * np.eye(6)) @ jacobian.T
    expected = inverse @ acceleration - 5.0 * np.array(speeds)
    assert rule.joint_accelerations == pytest.approx(expected, rel=1e-6, abs=1e-6)
    assert rule.joint_velocities == pytest.approx(speeds + expected * 0.01, abs=1e-6)


@given(axis=st.sampled_from([(1.0, 0.0, 0.0), (0.0, 0.6, -0.8)]), angle=st.floats(-3.1, 3.1))
def test_a_rotation_vector_is_axis_times_angle(axis, angle):
    found = rotation_vector(quaternion_from_axis_angle(axis, angle))
    assert found == pytest.approx([part * angle for part in axis], abs=1e-9)


def test_a_matrix_without_inverse_has_no_solution():
    assert damped_least_squares([(1.0, 0.0), (1.0, 0.0)], (1.0, 0.0), 0.0) is None
