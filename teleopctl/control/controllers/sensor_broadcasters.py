"""Broadcasters of sensors: inertial measurement units and force-torque sensors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, ClassVar

from teleopctl.control.controllers.base import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.control.realtime_publisher import RealtimePublisher
from teleopctl.interfaces import get_message, set_stamp

_COVARIANCE_LENGTH = 9
_AXES = "xyz"
_WRENCH = tuple((part, axis) for part in ("force", "torque") for axis in _AXES)


class _SensorBroadcaster(ControllerInterface):
    """Base of broadcasters that publish state interfaces as one message in each update."""

    message_type: ClassVar[str]
    topic: ClassVar[str]

    def on_init(self) -> None:
        """Declare the parameters ``sensor_name`` and ``frame_id``."""
        self.auto_declare("sensor_name", "")
        self.auto_declare("frame_id", "")

    def create_publisher(self) -> None:
        """Create the sensor message, which is reused, and its publisher."""
        # Any: message classes are generated at run time. The message is reused.
        kind: Any = get_message(self.message_type)
        self._message: Any = kind()
        self._message.header.frame_id = self.auto_declare("frame_id", "")
        self._publisher = self.get_node().create_publisher(kind, self.topic, 10)
        self._realtime_publisher = RealtimePublisher(self.params.publish_queue, self._publish)

    def on_cleanup(self) -> None:
        """Destroy the publisher of the sensor's message."""
        self.get_node().destroy_publisher(self._publisher)

    def interface_names(self) -> Sequence[str]:
        """Return the names of the sensor's state interfaces; implemented by each broadcaster."""
        raise NotImplementedError

    def fill_message(self, values: Sequence[float]) -> None:
        """Copy state values into the broadcaster's message; implemented by each broadcaster."""
        raise NotImplementedError

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Return the state interfaces of the sensor."""
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, self.interface_names())

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Queue the measured values for publishing as one message."""
        del period
        self._realtime_publisher.try_publish(
            (time_ns, [state.value for state in self.state_interfaces])
        )
        return None

    def _publish(self, value: tuple[int, Sequence[float]]) -> None:
        time_ns, values = value
        set_stamp(self._message.header.stamp, time_ns)
        self.fill_message(values)
        self._publisher.publish(self._message)


class IMUSensorBroadcaster(_SensorBroadcaster):
    """Controller that publishes an IMU's state interfaces as sensor_msgs/Imu.

    Plug-in type ``imu_sensor_broadcaster/IMUSensorBroadcaster``.

    The parameters ``rotation_offset.roll``, ``pitch`` and ``yaw`` rotate the measured values: they
    are the sensor's mounting in ``frame_id``.
    """

    message_type = "sensor_msgs/msg/Imu"
    topic = "~/imu"

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters, and create the publisher of ``~/imu``."""
        self._sensor = self.auto_declare("sensor_name", "")
        for name in ("sensor_name", "frame_id"):
            if not self.auto_declare(name, ""):
                self.logger.error(f"Parameter '{name}' cannot be empty")
                return CallbackReturn.ERROR
        covariances: dict[str, list[float]] = {}
        for part in ("orientation", "angular_velocity", "linear_acceleration"):
            name = f"static_covariance_{part}"
            covariances[part] = self.auto_declare(name, [0.0] * _COVARIANCE_LENGTH)
            if len(covariances[part]) != _COVARIANCE_LENGTH:
                self.logger.error(f"Parameter '{name}' must have {_COVARIANCE_LENGTH} values")
                return CallbackReturn.ERROR
        roll, pitch, yaw = (
            self.auto_declare(f"rotation_offset.{name}", 0.0) for name in ("roll", "pitch", "yaw")
        )
        self._mounting = _quaternion(roll, pitch, yaw)
        self.create_publisher()
        for part, values in covariances.items():
            # The orientation's covariance is in the world frame, independent of the mounting.
            turned = values if part == "orientation" else _turned_matrix(values, self._mounting)
            setattr(self._message, f"{part}_covariance", [float(value) for value in turned])
        return None

    def interface_names(self) -> Sequence[str]:
        """Return the full names of orientation, angular velocity and acceleration interfaces."""
        return [
            f"{self._sensor}/{part}.{axis}"
            for part, axes in (
                ("orientation", "xyzw"),
                ("angular_velocity", _AXES),
                ("linear_acceleration", _AXES),
            )
            for axis in axes
        ]

    def fill_message(self, values: Sequence[float]) -> None:
        """Copy the measured values into the Imu message, rotated by the sensor's mounting."""
        orientation, rate, acceleration = values[:4], values[4:7], values[7:]
        x, y, z, w = self._mounting
        if w != 1.0:
            # Orientation of `frame_id`: that of the sensor, rotated back by its mounting.
            orientation = _product(orientation, (-x, -y, -z, w))
            rate, acceleration = (_turned(v, self._mounting) for v in (rate, acceleration))
        message = self._message
        for part, axes, numbers in (
            (message.orientation, "xyzw", orientation),
            (message.angular_velocity, _AXES, rate),
            (message.linear_acceleration, _AXES, acceleration),
        ):
            for axis, number in zip(axes, numbers, strict=True):
                setattr(part, axis, number)


class ForceTorqueSensorBroadcaster(_SensorBroadcaster):
    """Controller that publishes force and torque interfaces as WrenchStamped.

    Plug-in type ``force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster``.

    The published value of each axis is ``(measured + offset) * multiplier``; NaN for an axis
    without an interface.
    """

    message_type = "geometry_msgs/msg/WrenchStamped"
    topic = "~/wrench"

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters, and create the publisher of ``~/wrench``."""
        sensor = self.auto_declare("sensor_name", "")
        given = [self.auto_declare(f"interface_names.{p}.{a}", "") for p, a in _WRENCH]
        if not sensor and not any(given):
            self.logger.error(
                "'sensor_name' or at least one 'interface_names.[force|torque].[x|y|z]' parameter "
                "has to be specified."
            )
            return CallbackReturn.ERROR
        if sensor and any(given):
            self.logger.error(
                "both 'sensor_name' and 'interface_names.[force|torque].[x|y|z]' parameters can "
                "not be specified together."
            )
            return CallbackReturn.ERROR
        if not self.auto_declare("frame_id", ""):
            self.logger.error("Parameter 'frame_id' cannot be empty")
            return CallbackReturn.ERROR
        self._names = [f"{sensor}/{p}.{a}" for p, a in _WRENCH] if sensor else given
        self._offsets = [self.auto_declare(f"offset.{p}.{a}", 0.0) for p, a in _WRENCH]
        self._factors = [self.auto_declare(f"multiplier.{p}.{a}", 1.0) for p, a in _WRENCH]
        if any(self.get_node().has_parameter(f"sensor_filter_chain.filter{n}.type") for n in "12"):
            self.logger.warning(
                "Parameter 'sensor_filter_chain' has no effect: there is no ~/wrench_filtered"
            )
        self.create_publisher()
        return None

    def interface_names(self) -> Sequence[str]:
        """Return the full names of the configured force and torque state interfaces."""
        return [name for name in self._names if name]

    def fill_message(self, values: Sequence[float]) -> None:
        """Copy the measured values into the wrench, with offsets and multipliers applied."""
        measured = iter(values)
        for (part, axis), name, offset, factor in zip(
            _WRENCH, self._names, self._offsets, self._factors, strict=True
        ):
            value = next(measured) if name else math.nan
            setattr(getattr(self._message.wrench, part), axis, (value + offset) * factor)


def _quaternion(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """Return the quaternion (x y z w) of rotations about fixed axes x, then y, then z."""
    (sr, cr), (sp, cp), (sy, cy) = (
        (math.sin(angle / 2.0), math.cos(angle / 2.0)) for angle in (roll, pitch, yaw)
    )
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def _product(a: Sequence[float], b: Sequence[float]) -> tuple[float, float, float, float]:
    """Return the quaternion (x y z w) of rotation b followed by a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _turned(vector: Sequence[float], rotation: Sequence[float]) -> Sequence[float]:
    x, y, z, w = rotation
    return _product(_product(rotation, (*vector, 0.0)), (-x, -y, -z, w))[:3]


def _turned_matrix(matrix: Sequence[float], rotation: Sequence[float]) -> Sequence[float]:
    """Return ``R M R^T`` of a 3 by 3 matrix M, row by row."""
    columns = [
        _turned([matrix[3 * row + column] for row in range(3)], rotation) for column in range(3)
    ]
    rows = [_turned([columns[column][row] for column in range(3)], rotation) for row in range(3)]
    return [value for row in rows for value in row]
