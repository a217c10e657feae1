"""The teleop arm is the one that the tutorial's users know."""

import math

import numpy as np
import pytest

from teleopctl.packages import package_share, resolve_uri
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.urdf import Mesh, Mimic
from teleopctl.robot.xacro.expansion import expand_xacro
from tests.robot.independent import link_frames, pose_matrix

QUARTER = math.pi / 2
MODEL = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"


def test_it_has_nine_links_below_world(teleop):
    assert teleop.root == "world"
    assert list(teleop.links) == [
        "world",
        "base_link",
        "base_plate",
        "forward_drive_arm",
        "horizontal_arm",
        "claw_support",
        "gripper_right",
        "gripper_left",
        "rgb_camera",
    ]


@pytest.mark.parametrize(
    ("name", "kind", "parent", "child", "xyz", "axis", "limits"),
    [
        ("virtual_joint", "fixed", "world", "base_link", (0, 0, 0), None, None),
        (
            "joint_1",
            "revolute",
            "base_link",
            "base_plate",
            (0, 0, 0.307),
            (0, 0, 1),
            (-QUARTER, QUARTER),
        ),
        (
            "joint_2",
            "revolute",
            "base_plate",
            "forward_drive_arm",
            (-0.02, 0, 0.35),
            (1, 0, 0),
            (-QUARTER, QUARTER),
        ),
        (
            "joint_3",
            "revolute",
            "forward_drive_arm",
            "horizontal_arm",
            (0, 0, 0.8),
            (1, 0, 0),
            (-QUARTER, QUARTER),
        ),
        (
            "horizontal_arm_to_claw_support",
            "fixed",
            "horizontal_arm",
            "claw_support",
            (0, 0.82, 0),
            None,
            None,
        ),
        (
            "joint_4",
            "revolute",
            "claw_support",
            "gripper_right",
            (-0.04, 0.13, -0.1),
            (0, 0, 1),
            (-QUARTER, 0),
        ),
        (
            "joint_5",
            "revolute",
            "claw_support",
            "gripper_left",
            (-0.22, 0.13, -0.1),
            (0, 0, 1),
            (0, QUARTER),
        ),
        ("rgb_camera_joint", "fixed", "base_link", "rgb_camera", (0, 0.4, 0.2), None, None),
    ],
)
def test_each_joint_stands_where_it_should(teleop, name, kind, parent, child, xyz, axis, limits):
    joint = teleop.joints[name]
    assert (joint.type, joint.parent, joint.child) == (kind, parent, child)
    assert joint.origin.xyz == pytest.approx(xyz)
    if axis is not None:
        assert joint.axis == axis
        assert (joint.limit.lower, joint.limit.upper) == pytest.approx(limits)
        assert (joint.limit.effort, joint.limit.velocity) == (30, 10)


def test_only_joint_5_follows_another_one(teleop):
    followers = {joint.name: joint.mimic for joint in teleop.joints.values() if joint.mimic}
    assert followers == {"joint_5": Mimic("joint_4", -1.0, 0.0)}


@pytest.mark.parametrize(
    ("link", "mass"),
    [
        ("base_link", 1.0),
        ("base_plate", 0.1),
        ("forward_drive_arm", 0.1),
        ("horizontal_arm", 0.1),
        ("claw_support", 0.05),
        ("gripper_right", 0.01),
        ("gripper_left", 0.01),
        ("rgb_camera", 0.01),
    ],
)
def test_each_inertia_is_that_of_a_solid_of_the_links_size(teleop, link, mass):
    inertial = teleop.links[link].inertial
    assert inertial.mass == mass
    a, b, c = sorted((inertial.ixx, inertial.iyy, inertial.izz))
    assert a > 0
    assert a + b >= c
    # no part reaches further than 1.1 m
    assert c < mass * 1.1**2 / 4


def test_the_claw_stands_at_its_place_when_all_joints_are_zero(teleop):
    claw = link_frames(teleop.urdf, {})["claw_support"]
    np.testing.assert_allclose(claw[:3, 3], (-0.02, 0.82, 1.457), atol=1e-12)
    np.testing.assert_allclose(claw[:3, :3], np.eye(3), atol=1e-12)


def test_the_camera_looks_along_the_reach_slightly_down(teleop):
    forward = link_frames(teleop.urdf, {})["rgb_camera"][:3, 0]
    assert forward[1] > 0.95
    assert -0.3 < forward[2] < 0


@pytest.mark.parametrize(
    ("link", "file", "xyz", "rpy"),
    [
        ("base_link", "basement.STL", (-0.5, -0.5, 0), (0, 0, 0)),
        ("base_plate", "base_plate.STL", (-0.39, -0.39, -0.56), (0, 0, 0)),
        (
            "forward_drive_arm",
            "forward_drive_arm.STL",
            (0.19, 0.06, -0.08),
            (0, -QUARTER, QUARTER),
        ),
        ("horizontal_arm", "horizontal_arm.STL", (-0.03, -0.4, -0.06), (QUARTER, 0, QUARTER)),
        ("claw_support", "claw_support.STL", (0, -0.05, -0.15), (0, 0, QUARTER)),
        ("gripper_right", "right_finger.STL", (-0.1, 0.5, -0.1), (0, 0, -QUARTER)),
        ("gripper_left", "left_finger.STL", (-0.04, 0.5, -0.1), (0, 0, -QUARTER)),
    ],
)
def test_each_link_is_drawn_with_its_mesh(teleop, link, file, xyz, rpy):
    (visual,) = teleop.links[link].visuals
    assert visual.geometry == Mesh(f"package://teleop_description/meshes/{file}", (0.01,) * 3)
    assert visual.origin.xyz == pytest.approx(xyz)
    assert visual.origin.rpy == pytest.approx(rpy)
    assert visual.material.rgba is not None
    assert resolve_uri(visual.geometry.uri).is_file()


def test_every_moving_link_can_touch_things(teleop):
    moving = [joint.child for joint in teleop.joints.values() if joint.is_single_axis]
    assert all(teleop.links[name].collisions for name in moving)


def test_control_commands_four_joints_and_reads_five(teleop):
    (system,) = teleop.ros2_control
    assert (system.name, system.type) == ("RobotSystem", "system")
    assert system.hardware_plugin_name == "gazebo_ros2_control/GazeboSystem"
    assert system.warnings == ()
    commanded = {
        joint.name: [(i.name, float(i.min), float(i.max)) for i in joint.command_interfaces]
        for joint in system.joints
    }
    arm = [("position", pytest.approx(-QUARTER), pytest.approx(QUARTER))]
    assert commanded == {
        "joint_1": arm,
        "joint_2": arm,
        "joint_3": arm,
        "joint_4": [("position", pytest.approx(-QUARTER), 0.0)],
        "joint_5": [],
    }
    assert all([i.name for i in j.state_interfaces] == ["position"] for j in system.joints)
    assert system.joints[4].mimic == Mimic("joint_4", -1.0)
    assert system.joints[4].parameters == {"mimic": "joint_4", "multiplier": "-1"}


def test_each_motor_has_a_simple_transmission(teleop):
    found = [
        (t.name, t.type, t.actuators[0].name, t.actuators[0].role, t.joints[0].name)
        for t in teleop.transmissions
    ]
    assert found == [
        (
            f"transmission_{n}",
            "transmission_interface/SimpleTransmission",
            f"motor_{n}",
            "actuator1",
            f"joint_{n}",
        )
        for n in (1, 2, 3, 4)
    ]
    assert {t.joints[0].mechanical_reduction for t in teleop.transmissions} == {1.0}


def test_the_camera_sensor_is_the_tutorials(teleop):
    (sensor,) = teleop.gazebo.sensors
    assert (sensor.name, sensor.type, sensor.link) == ("rgb_camera", "camera", "rgb_camera")
    assert sensor.update_rate == 30.0
    camera = sensor.camera
    assert (camera.width, camera.height, camera.format) == (2304, 1296, "R8G8B8")
    assert camera.horizontal_fov == 1.15
    assert {camera.k1, camera.k2, camera.k3, camera.p1, camera.p2} == {0.0}
    (plugin,) = sensor.plugins
    assert plugin.filename == "libgazebo_ros_camera.so"
    assert plugin.parameter("frame_name") == "rgb_camera"
    assert plugin.parameter("hack_baseline") == "0.2"
    assert plugin.parameters["ros/remapping"] == (
        "~/image_raw:=image_raw",
        "~/camera_info:=camera_info",
    )


@pytest.mark.parametrize(
    ("hardware", "plugin"),
    [
        ("sim", "gazebo_ros2_control/GazeboSystem"),
        ("mock", "mock_components/GenericSystem"),
        ("my_servos/SerialBus", "my_servos/SerialBus"),
    ],
)
def test_an_argument_chooses_the_hardware(hardware, plugin):
    robot = RobotDescription.from_urdf(expand_xacro(MODEL, {"hardware": hardware}))
    assert robot.ros2_control[0].hardware_plugin_name == plugin


def test_arguments_move_the_camera():
    urdf = expand_xacro(MODEL, {"camera_xyz": "1 2 3", "camera_rpy": "0 0.5 0"})
    origin = RobotDescription.from_urdf(urdf).joints["rgb_camera_joint"].origin
    assert (origin.xyz, origin.rpy) == ((1, 2, 3), (0, 0.5, 0))


def test_the_gears_of_the_fingers_do_not_touch(teleop):
    right, left = (teleop.links[name].collisions[0] for name in ("gripper_right", "gripper_left"))
    axes = [teleop.joints[name].origin.xyz[0] for name in ("joint_4", "joint_5")]
    assert right.geometry.radius + left.geometry.radius < axes[0] - axes[1]


def test_the_pads_of_the_closed_fingers_do_not_touch(teleop):
    frames = link_frames(teleop.urdf, {})
    edges = []
    for link, side in (("gripper_right", -1), ("gripper_left", 1)):
        pad = teleop.links[link].collisions[-1]
        centre = frames[link] @ pose_matrix(pad.origin)
        edges.append(centre[0, 3] + side * pad.geometry.size[0] / 2)
    assert 0 < edges[0] - edges[1] < 0.01
