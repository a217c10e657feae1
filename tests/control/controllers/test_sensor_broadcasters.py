"""Broadcasters of sensors: IMU, force and torque, range, GPS and magnetic field."""

import math
from typing import Any

import pytest

from teleopctl.testing import ControlStack, serial_robot

IMU = "imu_sensor_broadcaster/IMUSensorBroadcaster"
FORCE_TORQUE = "force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster"
RANGE = "range_sensor_broadcaster/RangeSensorBroadcaster"
GPS = "gps_sensor_broadcaster/GPSSensorBroadcaster"
MAGNETOMETER = "magnetometer_broadcaster/MagnetometerBroadcaster"
TOPICS = {
    IMU: "~/imu",
    FORCE_TORQUE: "~/wrench",
    RANGE: "~/range",
    GPS: "~/gps/fix",
    MAGNETOMETER: "~/magnetic_field",
}
GPS_NAMES = ["status", "service", "latitude", "longitude", "altitude"]
VARIANCES = [f"{name}_covariance" for name in GPS_NAMES[2:]]
FIELD_NAMES = [f"magnetic_field.{axis}" for axis in "xyz"]
IMU_NAMES = [
    *(f"orientation.{axis}" for axis in "xyzw"),
    *(f"angular_velocity.{axis}" for axis in "xyz"),
    *(f"linear_acceleration.{axis}" for axis in "xyz"),
]
WRENCH_NAMES = [f"{part}.{axis}" for part in ("force", "torque") for axis in "xyz"]
HALF = math.sqrt(0.5)


def publish(kind: str, names: list[str], values: list[float], **parameters: Any) -> Any:
    """The message of one update, where a sensor measures these values."""
    states = "".join(f'<state_interface name="{name}"/>' for name in names)
    stack = ControlStack(serial_robot(1, extra_control=f'<sensor name="sensor">{states}</sensor>'))
    for name, value in zip(names, values, strict=True):
        stack.resources.state_interfaces[f"sensor/{name}"].value = value
    options = {"sensor_name": "sensor", "frame_id": "tool", **parameters}
    dotted = {name.replace("__", "."): value for name, value in options.items()}
    stack.load_controller("broadcaster", kind, dotted)
    stack.activate("broadcaster")
    stack.step()
    (message,) = stack.nodes["broadcaster"].published(TOPICS[kind])
    assert message.header.frame_id == "tool"
    assert message.header.stamp.sec == 1000
    return message


def xyz(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def test_an_imu_is_published_as_it_measures() -> None:
    values = [HALF, 0.0, 0.0, HALF, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]
    message = publish(
        IMU, IMU_NAMES, values, static_covariance_angular_velocity=[float(n) for n in range(9)]
    )
    orientation = [*xyz(message.orientation), message.orientation.w]
    assert orientation + xyz(message.angular_velocity) + xyz(message.linear_acceleration) == values
    assert list(message.angular_velocity_covariance) == list(range(9))
    assert not any(message.orientation_covariance)


def test_an_imu_that_is_mounted_askew_is_turned_into_its_frame() -> None:
    # The sensor's x is the frame's y; the frame stands upright, so the sensor is turned back.
    message = publish(
        IMU,
        IMU_NAMES,
        [0.0, 0.0, -HALF, HALF, 1.0, 0.0, 3.0, 0.0, 1.0, 9.81],
        rotation_offset__yaw=math.pi / 2,
        static_covariance_linear_acceleration=[1.0, 0, 0, 0, 2.0, 0, 0, 0, 3.0],
    )
    assert xyz(message.angular_velocity) == pytest.approx([0.0, 1.0, 3.0])
    assert xyz(message.linear_acceleration) == pytest.approx([-1.0, 0.0, 9.81])
    assert [*xyz(message.orientation), message.orientation.w] == pytest.approx([0, 0, -1, 0])
    covariance = list(message.linear_acceleration_covariance)
    assert covariance == pytest.approx([2, 0, 0, 0, 1, 0, 0, 0, 3])


def test_a_wrench_is_corrected_by_offset_and_then_by_multiplier() -> None:
    message = publish(
        FORCE_TORQUE,
        WRENCH_NAMES,
        [1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        offset__force__x=10.0,
        multiplier__force__x=2.0,
        multiplier__torque__z=-1.0,
    )
    assert xyz(message.wrench.force) == [22.0, 2.0, 3.0]
    assert xyz(message.wrench.torque) == [4.0, 5.0, -6.0]


def test_axes_of_a_wrench_may_be_named_one_by_one() -> None:
    message = publish(
        FORCE_TORQUE,
        WRENCH_NAMES,
        [1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        sensor_name="",
        interface_names__force__z="sensor/force.x",
        interface_names__torque__x="sensor/torque.z",
    )
    assert xyz(message.wrench.force) == pytest.approx([math.nan, math.nan, 1.0], nan_ok=True)
    assert xyz(message.wrench.torque) == pytest.approx([6.0, math.nan, math.nan], nan_ok=True)


def test_a_range_is_published_with_the_properties_of_its_sensor() -> None:
    message = publish(RANGE, ["range"], [1.5], radiation_type=1, max_range=7.0, variance=0.25)
    assert (message.range, message.min_range, message.max_range) == pytest.approx((1.5, 0.52, 7.0))
    assert (message.radiation_type, message.variance) == (message.INFRARED, 0.25)
    assert message.field_of_view == pytest.approx(0.52)


def test_a_fix_has_a_static_covariance() -> None:
    covariance = [float(number) for number in range(9)]
    message = publish(
        GPS, GPS_NAMES, [2.0, 9.0, 52.1, 4.3, -3.5], static_position_covariance=covariance
    )
    assert (message.latitude, message.longitude, message.altitude) == (52.1, 4.3, -3.5)
    assert message.status.status == message.status.STATUS_GBAS_FIX
    assert message.status.service == 9
    assert list(message.position_covariance) == covariance
    assert message.position_covariance_type == message.COVARIANCE_TYPE_KNOWN


def test_a_fix_has_the_variances_that_its_sensor_measures() -> None:
    message = publish(
        GPS,
        GPS_NAMES + VARIANCES,
        [0.0, 1.0, 52.1, 4.3, -3.5, 0.1, 0.2, 0.3],
        read_covariance_from_interface=True,
    )
    assert list(message.position_covariance) == [0.1, 0, 0, 0, 0.2, 0, 0, 0, 0.3]
    assert message.position_covariance_type == message.COVARIANCE_TYPE_DIAGONAL_KNOWN


@pytest.mark.parametrize(("status", "service"), [(math.nan, math.nan), (1000.0, -1.0)])
def test_a_fix_of_impossible_status_is_unknown(status: float, service: float) -> None:
    message = publish(GPS, GPS_NAMES, [status, service, 1.0, 2.0, 3.0])
    assert message.status.status == message.status.STATUS_UNKNOWN
    assert message.status.service == message.status.SERVICE_UNKNOWN


def test_a_magnetic_field_is_published_with_a_static_covariance() -> None:
    covariance = [float(number) for number in range(9)]
    message = publish(MAGNETOMETER, FIELD_NAMES, [1e-5, -2e-5, 3e-5], static_covariance=covariance)
    assert xyz(message.magnetic_field) == [1e-5, -2e-5, 3e-5]
    assert list(message.magnetic_field_covariance) == covariance


@pytest.mark.parametrize(
    ("kind", "mistake"),
    [
        (RANGE, {"sensor_name": ""}),
        (RANGE, {"frame_id": ""}),
        (RANGE, {"radiation_type": 256}),
        (GPS, {"sensor_name": ""}),
        (GPS, {"static_position_covariance": [1.0]}),
        (MAGNETOMETER, {"frame_id": ""}),
        (MAGNETOMETER, {"static_covariance": [1.0] * 10}),
        (IMU, {"sensor_name": ""}),
        (IMU, {"frame_id": ""}),
        (IMU, {"static_covariance_orientation": [1.0]}),
        (FORCE_TORQUE, {"sensor_name": ""}),
        (FORCE_TORQUE, {"frame_id": ""}),
        (FORCE_TORQUE, {"interface_names__force__x": "sensor/force.x"}),
    ],
)
def test_a_broadcaster_without_its_parameters_is_refused(kind: str, mistake: Any) -> None:
    with pytest.raises(AssertionError, match="Could not configure"):
        publish(kind, WRENCH_NAMES, [0.0] * 6, **mistake)
