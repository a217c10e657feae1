"""Sensors of ``<ros2_control>``, and the force-torque sensor: judged by mechanics."""

import math

import pytest

from teleopctl.sim.building import SimulatedRobot, simulate
from tests.sim.robots import joint, link

GRAVITY = 9.81
TIP = """<inertial><origin xyz="0.1 0 0"/><mass value="0.2"/>
  <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial>"""
_LIMIT = 'lower="-4" upper="4" effort="90" velocity="9"'
WRENCH = "force.x force.y force.z torque.x torque.y torque.z"


def sensor(name: str, interfaces: str, frame: str = "") -> str:
    states = "".join(f'<state_interface name="{word}"/>' for word in interfaces.split())
    parameter = f'<param name="frame_id">{frame}</param>' if frame else ""
    return f'<sensor name="{name}">{states}{parameter}</sensor>'


class Hand:
    """A rod that is held at an angle, with a tip of 0.2 kg, 0.1 m out along its x axis."""

    def __init__(
        self,
        *parts: str,
        sensors: str = "",
        angle: float = 0.0,
        gps_origin: tuple[float, ...] = (),
    ) -> None:
        self.warnings: list[str] = []
        tags = "".join(
            (
                link("base", ""),
                link("rod"),
                link("tip", TIP),
                joint(
                    "hinge", "base", "rod", limit='lower="-4" upper="4" effort="90" velocity="9"'
                ),
                joint("mount", "rod", "tip", kind="fixed"),
                '<ros2_control name="h" type="system"><hardware><plugin>any/Hardware</plugin>'
                '</hardware><joint name="hinge"><command_interface name="position"/>'
                f'<state_interface name="position"><param name="initial_value">{angle}</param>'
                f"</state_interface></joint>{sensors}</ros2_control>",
                *parts,
            )
        )
        self.robot: SimulatedRobot = simulate(
            f'<robot name="hand">{tags}</robot>',
            fixed_base=True,
            control_period_ns=10_000_000,
            timestep_ns=1_000_000,
            warn=self.warnings.append,
            gps_origin=gps_origin,
        )
        self.robot.simulation.step(300)

    @property
    def values(self) -> dict[str, float]:
        interfaces = self.robot.interfaces
        return dict(
            zip(
                interfaces.names,
                interfaces.read(*self.robot.simulation.observe()),
                strict=True,
            )
        )

    def wrench(self) -> list[float]:
        return [self.values[f"fts/{name}"] for name in WRENCH.split()]


def force_torque(content: str = "", reference: str = "mount", name: str = "fts") -> str:
    return (
        f'<gazebo reference="{reference}"><sensor name="{name}" type="force_torque">{content}'
        "</sensor></gazebo>"
    )


@pytest.mark.parametrize("reference", ["mount", "tip"])
def test_a_force_torque_sensor_measures_the_weight_of_what_it_carries(reference: str) -> None:
    hand = Hand(force_torque(reference=reference), sensors=sensor("fts", WRENCH))
    weight = 0.2 * GRAVITY
    # The tip pulls its rod down, 0.1 m in front of it: y is z cross x.
    expected = [0, 0, -weight, 0, 0.1 * weight, 0]
    assert hand.wrench() == pytest.approx(expected, abs=1e-6)
    assert hand.warnings == []


def test_its_wrench_is_along_the_axes_and_in_the_direction_that_are_asked_for() -> None:
    weight, turn = 0.2 * GRAVITY, f"<pose>0 0 0 0 0 {math.pi / 2}</pose>"
    hand = Hand(
        force_torque(
            turn + "<force_torque><frame>sensor</frame>"
            "<measure_direction>parent_to_child</measure_direction></force_torque>"
        ),
        sensors=sensor("fts", WRENCH),
    )
    # y of the child is x of the sensor, which is turned by a quarter about z.
    assert hand.wrench() == pytest.approx([0, 0, weight, -0.1 * weight, 0, 0], abs=1e-6)


def test_the_axes_of_a_joint_that_turns_are_those_of_the_child_or_the_parent() -> None:
    angle, sensors = 0.5, sensor("fts", WRENCH)
    weight = (0.2 + 0.5) * GRAVITY
    of_child = Hand(force_torque(reference="hinge"), sensors=sensors, angle=angle).wrench()
    asked = "<force_torque><frame>parent</frame></force_torque>"
    of_parent = Hand(force_torque(asked, "hinge"), sensors=sensors, angle=angle).wrench()
    down = [0, -weight * math.sin(angle), -weight * math.cos(angle)]
    assert of_child[:3] == pytest.approx(down, abs=0.02)
    assert of_parent[:3] == pytest.approx([0, 0, -weight], abs=0.02)


def test_a_sensor_of_ros2_control_needs_no_gazebo_tag_where_it_names_a_frame() -> None:
    sensors = (
        sensor("fts", "force.z torque.y", frame="tip")
        + sensor("imu", "orientation.w linear_acceleration.z", frame="rod")
        + sensor("thermometer", "temperature")
        + sensor("other", "force.z")
    )
    hand = Hand(sensors=sensors)
    assert hand.values == pytest.approx(
        {
            "fts/force.z": -0.2 * GRAVITY,
            "fts/torque.y": 0.02 * GRAVITY,
            "imu/orientation.w": 1.0,
            "imu/linear_acceleration.z": GRAVITY,
        },
        abs=1e-3,
    )
    assert [text.partition(" measures nothing")[0] for text in hand.warnings] == [
        "Sensor 'thermometer' of <ros2_control>",
        "Sensor 'other' of <ros2_control>",
    ]


def test_interfaces_that_the_sensor_does_not_have_are_told() -> None:
    hand = Hand(force_torque(), sensors=sensor("fts", "force.x force.w"))
    assert list(hand.values) == ["fts/force.x"]
    assert hand.warnings == ["Nothing measures fts/force.w"]


def test_the_pose_of_a_link_is_measured_in_the_world() -> None:
    angle = 0.5
    interfaces = "position.x position.y position.z orientation.x orientation.y orientation.z "
    hand = Hand(sensors=sensor("mocap", interfaces + "orientation.w", frame="tip"), angle=angle)
    truth = hand.robot.simulation.link_pose("tip")
    values = list(hand.values.values())
    assert next(iter(hand.values)) == "mocap/position.x"
    assert values[:3] == pytest.approx(truth.position, abs=1e-9)
    assert values[3:] == pytest.approx([math.sin(angle / 2), 0, 0, math.cos(angle / 2)], abs=1e-3)
    assert not hand.warnings


def test_a_magnetometer_and_a_gps_are_known_by_their_interfaces() -> None:
    fix = "status service latitude longitude altitude latitude_covariance altitude_covariance"
    field = " ".join(f"magnetic_field.{axis}" for axis in "xyz")
    hand = Hand(
        sensors=sensor("gps", fix, frame="base") + sensor("compass", field, frame="base"),
        gps_origin=(52.0, 4.0, 10.0),
    )
    assert hand.values == pytest.approx(
        {
            "gps/status": 0.0,
            "gps/service": 1.0,
            "gps/latitude": 52.0,
            "gps/longitude": 4.0,
            "gps/altitude": 10.0,
            "gps/latitude_covariance": 0.0,
            "gps/altitude_covariance": 0.0,
            "compass/magnetic_field.x": 5.5645e-6,
            "compass/magnetic_field.y": 22.8758e-6,
            "compass/magnetic_field.z": -42.3884e-6,
        },
        abs=1e-9,
    )
    assert not hand.warnings


def test_a_sonar_measures_a_range() -> None:
    sonar = (
        '<gazebo reference="base"><sensor name="sonar" type="sonar"><sonar><min>0.1</min>'
        "<max>4</max><radius>0.1</radius></sonar></sensor></gazebo>"
    )
    hand = Hand(sonar, sensors=sensor("sonar", "range"))
    assert list(hand.values) == ["sonar/range"]
    assert not hand.warnings
