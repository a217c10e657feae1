"""Plug-ins of Gazebo that the simulator itself stands for: planar motion and true odometry."""

import math
from typing import Any

import pytest

from teleopctl.interfaces import get_message
from teleopctl.sim.building import SimulatedRobot, simulate

MOVE = """<gazebo><plugin name="move" filename="libgazebo_ros_planar_move.so">
  <ros><namespace>/cart</namespace></ros><odometry_frame>map</odometry_frame>
  <robot_base_frame>foot</robot_base_frame></plugin></gazebo>"""
P3D = """<gazebo><plugin name="truth" filename="libgazebo_ros_p3d.so"><body_name>mast</body_name>
  <frame_name>{frame}</frame_name><xyz_offset>0 0 2</xyz_offset>
  <ros><remapping>odom:=/where</remapping></ros></plugin></gazebo>"""
SILENT = MOVE.replace("<ros>", "<publish_odom>0</publish_odom><ros>")
Twist = get_message("geometry_msgs/msg/Twist")
SOLID = """<inertial><mass value="2"/><inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0"
  iyz="0"/></inertial><collision><geometry><box size="0.4 0.4 0.2"/></geometry></collision>"""


def sled(*tags: str) -> str:
    """A box that lies on the ground, with a mast in front."""
    return f"""<robot name="sled"><link name="base">{SOLID}</link><link name="mast"/>
      <joint name="front" type="fixed"><parent link="base"/><child link="mast"/>
        <origin xyz="0.2 0 0.3"/></joint>{"".join(tags)}</robot>"""


def simulated(*tags: str, warn: Any = pytest.fail, **options: Any) -> SimulatedRobot:
    robot = simulate(
        sled(*tags),
        control_period_ns=10_000_000,
        timestep_ns=1_000_000,
        warn=warn,
        **options,
    )
    robot.simulation.step_to(200_000_000)
    return robot


def drive(robot: SimulatedRobot, x: float, y: float, turn: float, seconds: float) -> None:
    message: Any = Twist()
    message.linear.x, message.linear.y, message.angular.z = x, y, turn
    (mover,) = robot.simulation.movers
    mover.receive(message)
    robot.simulation.step_to(robot.simulation.time_ns + round(seconds * 1e9))


def read(robot: SimulatedRobot, kind: str) -> Any:
    """What the plug-in's odometry, or its transform, says now."""
    sensor = next(sensor for sensor in robot.sensors if sensor.message_type == kind)
    message: Any = get_message(kind)()
    for header in sensor.headers(message):
        header.frame_id = sensor.frame_id
    sensor.read(*robot.simulation.observe(), message)
    return message


def test_a_base_with_planar_move_goes_sideways_and_turns_whatever_it_lies_on() -> None:
    robot = simulated(MOVE)
    (mover,) = robot.simulation.movers
    assert mover.topic == "/cart/cmd_vel"
    height = robot.simulation.link_pose("base").position[2]
    drive(robot, 0.3, 0.4, 0.0, 1.0)
    assert robot.simulation.link_pose("base").position == pytest.approx(
        (0.3, 0.4, height), abs=0.02
    )
    drive(robot, 0.0, 0.0, math.pi / 2.0, 1.0)
    drive(robot, 0.3, 0.0, 0.0, 1.0)
    assert robot.simulation.link_pose("base").position == pytest.approx(
        (0.3, 0.7, height), abs=0.03
    )
    odometry = read(robot, "nav_msgs/msg/Odometry")
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("map", "foot")
    place, twist = odometry.pose.pose.position, odometry.twist.twist
    assert (place.x, place.y) == pytest.approx((0.3, 0.7), abs=0.03)
    assert (twist.linear.x, twist.linear.y) == pytest.approx((0.3, 0.0), abs=0.01)
    assert list(odometry.twist.covariance)[::7] == [1e-5, 1e-5, 1e12, 1e12, 1e12, 1e-3]
    (transform,) = read(robot, "tf2_msgs/msg/TFMessage").transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("map", "foot")
    assert transform.transform.rotation.z == pytest.approx(math.sin(math.pi / 4.0), abs=0.02)


def test_a_reset_stops_the_base() -> None:
    robot = simulated(MOVE)
    drive(robot, 0.3, 0.0, 0.0, 0.5)
    robot.simulation.reset()
    robot.simulation.step_to(500_000_000)
    assert robot.simulation.link_pose("base").position[0] == pytest.approx(0.0, abs=0.001)


def test_p3d_tells_a_link_in_the_world_and_in_another_links_frame() -> None:
    robot = simulated(SILENT, P3D.format(frame="world"))
    drive(robot, 0.0, 0.0, math.pi / 2.0, 1.0)
    odometry = read(robot, "nav_msgs/msg/Odometry")
    place, twist = odometry.pose.pose.position, odometry.twist.twist
    assert (place.x, place.y, place.z) == pytest.approx((0.0, 0.2, 2.4), abs=0.01)
    # Along the axes of the world, where the mast goes along its circle.
    assert (twist.linear.x, twist.linear.y) == pytest.approx((-0.2 * math.pi / 2.0, 0.0), abs=0.06)
    assert "/where" in [sensor.topic for sensor in robot.sensors]

    robot = simulated(SILENT, P3D.format(frame="base"))
    drive(robot, 0.0, 0.0, math.pi / 2.0, 1.0)
    place = read(robot, "nav_msgs/msg/Odometry").pose.pose.position
    assert (place.x, place.y, place.z) == pytest.approx((0.2, 0.0, 2.3), abs=1e-6)


def test_a_base_that_stands_still_is_not_moved_and_that_is_told() -> None:
    told: list[str] = []
    robot = simulated(MOVE, warn=told.append, fixed_base=True)
    assert robot.simulation.movers == []
    assert told == ["/cart/cmd_vel moves nothing: 'base' is fixed to the world"]
