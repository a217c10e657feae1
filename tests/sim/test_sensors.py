"""Simulated sensors: judged by mechanics, and that they change nothing of the motion."""

import math
from typing import cast

import mujoco
import numpy as np
import pytest

from teleopctl.interfaces.store import get_message
from teleopctl.mujoco_model.model import build_model
from teleopctl.node import Node
from teleopctl.sim.sensors.base import Sensor
from teleopctl.sim.sensors.publishing import SensorPublisher, add_sensors, make_sensors
from teleopctl.sim.simulation import Simulation
from tests.sim.robots import control, joint, link, robot

PERIOD_NS = 10_000_000
GRAVITY = 9.81


def gazebo(reference: str, content: str, kind: str = "imu", name: str = "sensor") -> str:
    return (
        f'<gazebo reference="{reference}"><sensor name="{name}" type="{kind}">{content}</sensor>'
        "</gazebo>"
    )


class Measured:
    """A robot in simulation with its sensors."""

    def __init__(self, *parts: str) -> None:
        self.warnings: list[str] = []
        description = robot(*parts)
        self.sensors = make_sensors(description.gazebo.sensors, self.warnings.append)
        model = build_model(
            description,
            lambda spec: add_sensors(spec, self.sensors, self.warnings.append),
            fixed_base=True,
        )
        self.simulation = Simulation(model, control_period_ns=PERIOD_NS)

    def imu(self):
        message = get_message("sensor_msgs/msg/Imu")()
        (sensor,) = self.sensors
        sensor.read(*self.simulation.observe(), message)
        return message


def pendulum(content: str = "", commands: str = "effort") -> Measured:
    """An upright rod of 0.5 kg on a hinge about x, 0.5 m above the ground, with an IMU."""
    return Measured(
        link("base", ""),
        link("rod"),
        joint("hinge", "base", "rod", limit='lower="-4" upper="4" effort="20" velocity="30"'),
        control(hinge=commands),
        gazebo("rod", content),
    )


def vector(message) -> tuple[float, float, float]:
    return message.x, message.y, message.z


def quaternion(message) -> tuple[float, float, float, float]:
    return message.x, message.y, message.z, message.w


def test_at_rest_an_imu_measures_gravity_upwards_and_no_rotation() -> None:
    measured = pendulum(commands="position")
    measured.simulation.step(100)
    imu = measured.imu()
    assert vector(imu.linear_acceleration) == pytest.approx((0, 0, GRAVITY), abs=1e-3)
    assert vector(imu.angular_velocity) == pytest.approx((0, 0, 0), abs=1e-6)
    assert quaternion(imu.orientation) == pytest.approx((0, 0, 0, 1), abs=1e-6)
    assert not np.any(imu.orientation_covariance)


def test_an_imu_has_the_noise_of_each_axis_and_says_its_variance() -> None:
    noise = "<noise type='gaussian'><bias_mean>0.4</bias_mean><stddev>0.01</stddev></noise>"
    part = f"<imu><angular_velocity><y>{noise}</y></angular_velocity></imu>"
    part = part.replace("</imu>", "<enable_orientation>false</enable_orientation></imu>")
    measured = pendulum(part, commands="position")
    rates = []
    for _ in range(200):
        measured.simulation.step(10)
        imu = measured.imu()
        rates.append(imu.angular_velocity.y)
        assert (imu.angular_velocity.x, imu.angular_velocity.z) == pytest.approx((0, 0), abs=1e-6)
    assert abs(np.mean(rates)) == pytest.approx(0.4, abs=0.004)
    assert np.std(rates) == pytest.approx(0.01, rel=0.2)
    assert imu.angular_velocity_covariance[4] == pytest.approx(1e-4)
    assert imu.orientation_covariance[0] == -1.0
    again = pendulum(part, commands="position")
    again.simulation.step(2000)
    assert again.imu().angular_velocity.y == rates[-1]


def test_the_axes_are_those_of_the_sensor() -> None:
    measured = pendulum(f"<pose>0 0 0 {math.pi / 2} 0 0</pose>", commands="position")
    imu = measured.imu()
    half = math.sqrt(0.5)
    assert quaternion(imu.orientation) == pytest.approx((half, 0, 0, half), abs=1e-6)
    # Turned by a quarter about x, the sensor's y axis points up.
    assert vector(imu.linear_acceleration) == pytest.approx((0, GRAVITY, 0), abs=1e-3)


@pytest.mark.parametrize(
    ("reference", "heading"),
    [
        ("<localization>ENU</localization>", "x"),
        # Of a sensor that looks east: seen from north, it is turned to the right, east is y.
        ("<localization>NED</localization>", "y"),
        ("<localization>NWU</localization>", "-y"),
        (
            "<localization>CUSTOM</localization>"
            "<custom_rpy parent_frame='world'>0 0 3.141592653589793</custom_rpy>",
            "-x",
        ),
    ],
)
def test_an_orientation_is_told_in_the_frame_that_is_asked_for(
    reference: str, heading: str
) -> None:
    content = f"<orientation_reference_frame>{reference}</orientation_reference_frame>"
    measured = pendulum(f"<imu>{content}</imu>", commands="position")

    turn = np.zeros(3)
    x, y, z, w = quaternion(measured.imu().orientation)
    mujoco.mju_rotVecQuat(turn, np.array([1.0, 0.0, 0.0]), np.array([w, x, y, z]))

    axis = np.eye(3)["xyz".index(heading[-1])]
    assert turn == pytest.approx(-axis if heading[0] == "-" else axis, abs=1e-6)
    assert vector(measured.imu().linear_acceleration) == pytest.approx((0, 0, GRAVITY), abs=1e-3)


def test_on_a_falling_pendulum_an_imu_measures_the_rate_and_the_angle_of_the_joint() -> None:
    measured = pendulum()
    simulation = measured.simulation
    simulation.apply(["hinge"], effort=[0.05])  # it stands in balance
    simulation.step(simulation.steps_per_period)
    for _ in range(160):
        simulation.apply(["hinge"], effort=[0.0])
        simulation.step(simulation.steps_per_period)
        simulation.read()
    angle, speed = float(simulation.positions[0]), float(simulation.velocities[0])
    assert speed > 0.5
    imu = measured.imu()
    assert vector(imu.angular_velocity) == pytest.approx((speed, 0, 0), abs=1e-9)
    expected = (math.sin(angle / 2), 0, 0, math.cos(angle / 2))
    assert quaternion(imu.orientation) == pytest.approx(expected, abs=1e-9)


def test_away_from_the_axis_an_imu_measures_the_centripetal_acceleration() -> None:
    radius = 0.4
    at_axis, outside = pendulum(), pendulum(f"<pose>0 0 {radius} 0 0 0</pose>")
    for measured in (at_axis, outside):
        for _ in range(35):
            measured.simulation.apply(["hinge"], effort=[1.3])
            measured.simulation.step(10)
    at_axis.simulation.read()
    speed = float(at_axis.simulation.velocities[0])
    difference = outside.imu().linear_acceleration.z - at_axis.imu().linear_acceleration.z
    assert speed > 1.0
    assert difference == pytest.approx(-(speed**2) * radius, rel=1e-6)


def test_reading_a_sensor_changes_no_bit_of_the_motion() -> None:
    runs = []
    for looked_at in (False, True):
        measured = pendulum()
        simulation = measured.simulation
        states = []
        for _ in range(50):
            simulation.apply(["hinge"], effort=[0.7])
            simulation.step(simulation.steps_per_period)
            if looked_at:
                measured.imu()
            simulation.read()
            states.append(simulation.positions.tobytes() + simulation.velocities.tobytes())
        runs.append(states)
    assert runs[0] == runs[1]


def test_a_type_that_nothing_simulates_is_told_once_for_each_sensor() -> None:
    measured = Measured(
        link("base", ""), gazebo("base", "", "thermal", "a"), gazebo("base", "", "magic", "b")
    )
    assert [warning.partition(":")[0] for warning in measured.warnings] == [
        "Sensor 'a' on link 'base' (line 1) is left out",
        "Sensor 'b' on link 'base' (line 1) is left out",
    ]
    assert "'thermal', only air_pressure, altimeter, boundingbox, " in measured.warnings[0]


def test_a_sensor_on_a_link_that_the_robot_lacks_is_left_out() -> None:
    measured = Measured(link("base", ""), gazebo("hand", ""))
    assert measured.sensors == []
    assert measured.warnings == ["Sensor 'sensor' is left out: the robot has no link 'hand'"]


@pytest.mark.parametrize(
    ("content", "topic", "frame"),
    [
        ("", "sensor", "base"),
        ("<topic>imu</topic><gz_frame_id>imu_link</gz_frame_id>", "imu", "imu_link"),
        (
            '<plugin name="p" filename="libgazebo_ros_imu_sensor.so"><ros>'
            "<remapping>~/out:=imu/data</remapping></ros><frame_name>f</frame_name></plugin>",
            "imu/data",
            "f",
        ),
    ],
)
def test_topic_and_frame_are_those_of_the_description(content: str, topic: str, frame: str) -> None:
    (sensor,) = Measured(link("base", ""), gazebo("base", content)).sensors
    assert (sensor.topic, sensor.frame_id) == (topic, frame)


class FakeNode:
    """Publishers that somebody listens to, or not, and a log."""

    def __init__(self) -> None:
        self.published: list[tuple[int, object]] = []
        self.errors: list[str] = []
        self.warnings: list[str] = []
        self.topics: list[str] = []
        self.listeners = 0

    def get_logger(self):
        return self

    def error(self, text: str) -> None:
        self.errors.append(text)

    def warning(self, text: str) -> None:
        self.warnings.append(text)

    def create_publisher(self, _, topic: str, *__):
        self.topics.append(topic)
        return self

    def get_subscription_count(self) -> int:
        return self.listeners

    def publish(self, message) -> None:
        stamp = message.header.stamp
        self.published.append((stamp.sec * 10**9 + stamp.nanosec, message.header.frame_id))


def test_what_is_no_topic_in_ros_is_told_and_made_one() -> None:
    measured = Measured(
        link("base", ""),
        gazebo("base", "", name="my imu"),
        gazebo("base", "<topic>/front-imu/2nd</topic>", name="b"),
        gazebo("base", "<topic>/imu_1/data</topic>", name="c"),
    )
    node = FakeNode()
    SensorPublisher(cast(Node, node), measured.simulation, measured.sensors)

    assert node.topics == ["my_imu", "/front_imu/_2nd", "/imu_1/data"]
    assert node.warnings == [
        "'my imu' is not a valid topic name: sensor 'my imu' publishes on 'my_imu'",
        "'/front-imu/2nd' is not a valid topic name: sensor 'b' publishes on '/front_imu/_2nd'",
    ]


def test_a_sensor_is_read_at_its_rate_and_only_while_somebody_listens() -> None:
    measured = pendulum("<update_rate>50</update_rate>")
    node = FakeNode()
    publisher = SensorPublisher(cast(Node, node), measured.simulation, measured.sensors)
    publisher.on_graph_change()
    publisher.sample(0)
    assert publisher.next_ns() is None
    node.listeners = 1
    publisher.on_graph_change()
    publisher.sample(33_000_000)
    assert publisher.next_ns() == 40_000_000
    for time_ns in (39_000_000, 40_000_000, 60_000_000, 61_000_000):
        publisher.sample(time_ns)
    assert node.published == [(40_000_000, "rod"), (60_000_000, "rod")]
    node.listeners = 0
    publisher.on_graph_change()
    publisher.sample(80_000_000)
    assert publisher.next_ns() is None
    assert len(node.published) == 2


def test_a_sensor_that_fails_is_reported_once_and_read_no_more() -> None:
    class Broken(Sensor):
        message_type = "sensor_msgs/msg/Range"

        def read(self, model, data, message) -> None:
            raise ValueError("no echo")

    measured = pendulum()
    node = FakeNode()
    node.listeners = 1
    sensors = [Broken(measured.sensors[0].description), *measured.sensors]
    publisher = SensorPublisher(cast(Node, node), measured.simulation, sensors)
    publisher.on_graph_change()
    for time_ns in (0, 10_000_000):
        publisher.sample(time_ns)
    assert node.errors == ["Sensor 'sensor' is disabled: ValueError: no echo"]
    assert len(node.published) == 2
