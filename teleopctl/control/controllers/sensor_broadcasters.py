"""Broadcasters of sensors: IMU, force and torque, range, GPS and magnetic field."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, ClassVar

from teleopctl.control.controllers.base import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.control.controllers.filters.base import WRENCH, FilterChain
from teleopctl.control.handles import StateInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.control.realtime_publisher import RealtimePublisher
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, set_stamp
from teleopctl.tf import Quaternion, conjugate, multiply, quaternion_from_rpy, rotate

_COVARIANCE_LENGTH = 9
_AXES = "xyz"
_LARGEST_BYTE = 255
# Constants of sensor_msgs/NavSatStatus, which Humble's message lacks.
_STATUS_UNKNOWN, _SERVICE_UNKNOWN = -2, 0
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

    def read_covariance(self, name: str) -> list[float] | None:
        """Return a parameter of a 3 by 3 covariance, row by row; log an error for other lengths."""
        values: list[float] = self.auto_declare(name, [0.0] * _COVARIANCE_LENGTH)
        if len(values) != _COVARIANCE_LENGTH:
            self.logger.error(
                f"Length of parameter '{name}' is {len(values)} but must be {_COVARIANCE_LENGTH}"
            )
            return None
        return [float(value) for value in values]

    def has_names(self) -> bool:
        """Return whether sensor and frame are named; log an error if not."""
        for name in ("sensor_name", "frame_id"):
            if not self.auto_declare(name, ""):
                self.logger.error(f"Parameter '{name}' cannot be empty")
                return False
        return True

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
        if not self.has_names():
            return CallbackReturn.ERROR
        covariances: dict[str, list[float]] = {}
        for part in ("orientation", "angular_velocity", "linear_acceleration"):
            covariance = self.read_covariance(f"static_covariance_{part}")
            if covariance is None:
                return CallbackReturn.ERROR
            covariances[part] = covariance
        roll, pitch, yaw = (
            self.auto_declare(f"rotation_offset.{name}", 0.0) for name in ("roll", "pitch", "yaw")
        )
        self._mounting = quaternion_from_rpy(roll, pitch, yaw)
        self.create_publisher()
        for part, values in covariances.items():
            # The orientation's covariance is in the world frame, independent of the mounting.
            turned = values if part == "orientation" else _turned_matrix(values, self._mounting)
            setattr(self._message, f"{part}_covariance", list(turned))
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
        qx, qy, qz, qw, wx, wy, wz, ax, ay, az = values
        orientation, rate, acceleration = (qx, qy, qz, qw), (wx, wy, wz), (ax, ay, az)
        if self._mounting[3] != 1.0:
            # Orientation of `frame_id`: that of the sensor, rotated back by its mounting.
            orientation = multiply(orientation, conjugate(self._mounting))
            rate, acceleration = (rotate(self._mounting, v) for v in (rate, acceleration))
        message = self._message
        for part, axes, numbers in (
            (message.orientation, "xyzw", orientation),
            (message.angular_velocity, _AXES, rate),
            (message.linear_acceleration, _AXES, acceleration),
        ):
            for axis, number in zip(axes, numbers, strict=True):
                setattr(part, axis, number)


class ForceTorqueSensorBroadcaster(_SensorBroadcaster, ChainableControllerInterface):
    """Controller that publishes force and torque interfaces as WrenchStamped.

    Plug-in type ``force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster``.

    The published value of each axis is ``(measured + offset) * multiplier``; NaN for an axis
    without an interface. These values are also exported as states for other controllers. With the
    filters of ``sensor_filter_chain``, their result is published on ``~/wrench_filtered``.
    """

    message_type = "geometry_msgs/msg/WrenchStamped"
    topic = "~/wrench"

    def on_init(self) -> None:
        """Declare the parameters ``sensor_name`` and ``frame_id``; register for changes."""
        super().on_init()
        self._chain: FilterChain[list[float]] | None = None
        self.get_node().add_post_set_parameters_callback(self._parameters_changed)

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters; create the publishers of ``~/wrench`` and ``~/wrench_filtered``."""
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
        frame = self.auto_declare("frame_id", "")
        if not frame:
            self.logger.error("Parameter 'frame_id' cannot be empty")
            return CallbackReturn.ERROR
        self._sensor = sensor
        self._names = [f"{sensor}/{p}.{a}" for p, a in _WRENCH] if sensor else given
        self._read_calibration()
        chain: FilterChain[list[float]] = FilterChain(self, WRENCH, "sensor_filter_chain", frame)
        self._chain = chain
        # As in ROS 2, the raw values are published even if the chain is invalid.
        if chain.configure() and len(chain):
            self.logger.info(f"Filter active with {len(chain)} filters!")
        self.create_publisher()
        # Any: message classes are generated at run time. The message is reused.
        kind: Any = get_message(self.message_type)
        self._filtered_message: Any = kind()
        self._filtered_message.header.frame_id = frame
        node = self.get_node()
        self._filtered_publisher = node.create_publisher(kind, "~/wrench_filtered", 10)
        self._realtime_filtered = RealtimePublisher(
            self.params.publish_queue, self._publish_filtered
        )
        self.logger.info("configure successful")
        return None

    def _read_calibration(self) -> None:
        self._offsets = [self.auto_declare(f"offset.{p}.{a}", 0.0) for p, a in _WRENCH]
        self._factors = [self.auto_declare(f"multiplier.{p}.{a}", 1.0) for p, a in _WRENCH]

    # Any: parameters of any type.
    def _parameters_changed(self, parameters: Sequence[Any]) -> None:
        del parameters
        if self._chain is None:
            return
        try:
            self._read_calibration()
        except TeleopctlError as error:
            self.logger.error(f"{error}: the sensor keeps the earlier value")
        self._chain.parameters_changed()

    def on_cleanup(self) -> None:
        """Destroy the publishers and the filters."""
        super().on_cleanup()
        self.get_node().destroy_publisher(self._filtered_publisher)
        if self._chain is not None:
            self._chain.close()
        self._chain = None

    def on_activate(self) -> None:
        """Reset the filters."""
        if self._chain is not None:
            self._chain.reset()

    def on_restart(self) -> None:
        """Reset the filters after a simulation reset."""
        self.on_activate()

    def interface_names(self) -> Sequence[str]:
        """Return the full names of the configured force and torque state interfaces."""
        return [name for name in self._names if name]

    def on_export_state_interfaces_list(self) -> list[StateInterface]:
        """Return a new state interface for each configured axis of the wrench."""
        prefix = f"{self.name}/{self._sensor}".removesuffix("/")
        return [
            StateInterface(prefix, name.removeprefix(f"{self._sensor}/"))
            for name in self._names
            if name
        ]

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Export the corrected wrench, filter it, and queue both for publishing."""
        del period
        measured = iter([state.value for state in self.state_interfaces])
        wrench = [
            ((next(measured) if name else math.nan) + offset) * factor
            for name, offset, factor in zip(self._names, self._offsets, self._factors, strict=True)
        ]
        exported = iter(self.exported_state_interfaces)
        for name, value in zip(self._names, wrench, strict=True):
            if name:
                next(exported).value = value
        self._realtime_publisher.try_publish((time_ns, wrench))
        if self._chain:
            filtered = self._chain.update(wrench)
            if filtered is not None:
                self._realtime_filtered.try_publish((time_ns, filtered))
        return None

    def fill_message(self, values: Sequence[float]) -> None:
        """Copy the corrected values into the wrench message."""
        _fill_wrench(self._message.wrench, values)

    def _publish_filtered(self, value: tuple[int, Sequence[float]]) -> None:
        time_ns, values = value
        set_stamp(self._filtered_message.header.stamp, time_ns)
        _fill_wrench(self._filtered_message.wrench, values)
        self._filtered_publisher.publish(self._filtered_message)


# Any: message classes are generated at run time.
def _fill_wrench(wrench: Any, values: Sequence[float]) -> None:
    for (part, axis), value in zip(_WRENCH, values, strict=True):
        setattr(getattr(wrench, part), axis, value)


class RangeSensorBroadcaster(_SensorBroadcaster):
    """Controller that publishes a measured distance as sensor_msgs/Range.

    Plug-in type ``range_sensor_broadcaster/RangeSensorBroadcaster``.
    """

    message_type = "sensor_msgs/msg/Range"
    topic = "~/range"

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters, and create the publisher of ``~/range``."""
        read = self.auto_declare
        self._sensor = read("sensor_name", "")
        if not self._sensor:
            self.logger.error("'sensor_name' parameter has to be specified.")
            return CallbackReturn.ERROR
        if not read("frame_id", ""):
            self.logger.error("'frame_id' parameter has to be provided.")
            return CallbackReturn.ERROR
        radiation = read("radiation_type", 0)
        if not 0 <= radiation <= _LARGEST_BYTE:
            self.logger.error(
                f"Parameter 'radiation_type' is {radiation}: it must be 0 (ultrasound) or 1 "
                "(infrared)"
            )
            return CallbackReturn.ERROR
        self.create_publisher()
        message = self._message
        message.radiation_type = radiation
        message.field_of_view = read("field_of_view", 0.52)
        message.min_range = read("min_range", 0.52)
        message.max_range = read("max_range", 4.0)
        variance = read("variance", 0.0)
        if hasattr(message, "variance"):  # Humble's message has no such field.
            message.variance = variance
        return None

    def interface_names(self) -> Sequence[str]:
        """Return the full name of the range interface."""
        return [f"{self._sensor}/range"]

    def fill_message(self, values: Sequence[float]) -> None:
        """Copy the measured range (m) into the message."""
        self._message.range = values[0]


class GPSSensorBroadcaster(_SensorBroadcaster):
    """Controller that publishes a satellite fix as sensor_msgs/NavSatFix.

    Plug-in type ``gps_sensor_broadcaster/GPSSensorBroadcaster``.

    The covariance is the parameter ``static_position_covariance``, or, with
    ``read_covariance_from_interface``, has the variances of three more interfaces as its diagonal.
    """

    message_type = "sensor_msgs/msg/NavSatFix"
    topic = "~/gps/fix"

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters, and create the publisher of ``~/gps/fix``."""
        self._sensor = self.auto_declare("sensor_name", "")
        covariance = self.read_covariance("static_position_covariance")
        if not self.has_names() or covariance is None:
            return CallbackReturn.ERROR
        self._measures_variance = self.auto_declare("read_covariance_from_interface", False)
        self.create_publisher()
        message = self._message
        if self._measures_variance:
            message.position_covariance_type = message.COVARIANCE_TYPE_DIAGONAL_KNOWN
        else:
            message.position_covariance_type = message.COVARIANCE_TYPE_KNOWN
            message.position_covariance = covariance
        return None

    def interface_names(self) -> Sequence[str]:
        """Return the full names of status, service, position and, if configured, variances."""
        places = ("latitude", "longitude", "altitude")
        variances = [f"{place}_covariance" for place in places] if self._measures_variance else []
        return [f"{self._sensor}/{name}" for name in ("status", "service", *places, *variances)]

    def fill_message(self, values: Sequence[float]) -> None:
        """Copy the measured fix into the message; an invalid status or service is unknown."""
        message = self._message
        status, service, message.latitude, message.longitude, message.altitude, *variances = values
        message.status.status = whole_number(status, -128, 127, otherwise=_STATUS_UNKNOWN)
        message.status.service = whole_number(service, 0, 65535, otherwise=_SERVICE_UNKNOWN)
        if variances:
            x, y, z = variances
            message.position_covariance = [x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z]


class MagnetometerBroadcaster(_SensorBroadcaster):
    """Controller that publishes a measured magnetic field as sensor_msgs/MagneticField.

    Plug-in type ``magnetometer_broadcaster/MagnetometerBroadcaster``.
    """

    message_type = "sensor_msgs/msg/MagneticField"
    topic = "~/magnetic_field"

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters, and create the publisher of ``~/magnetic_field``."""
        self._sensor = self.auto_declare("sensor_name", "")
        covariance = self.read_covariance("static_covariance")
        if not self.has_names() or covariance is None:
            return CallbackReturn.ERROR
        self.create_publisher()
        self._message.magnetic_field_covariance = covariance
        return None

    def interface_names(self) -> Sequence[str]:
        """Return the full names of the field's three components."""
        return [f"{self._sensor}/magnetic_field.{axis}" for axis in _AXES]

    def fill_message(self, values: Sequence[float]) -> None:
        """Copy the measured field (T) into the message."""
        field = self._message.magnetic_field
        field.x, field.y, field.z = values


def whole_number(value: float, lowest: int, highest: int, *, otherwise: int) -> int:
    """Return an interface's value as an integer within bounds; another one if that is impossible.

    Args:
        value: Value of a state interface that encodes an integer, such as a status.
        lowest: Lowest value of the message's field.
        highest: Highest value of the message's field.
        otherwise: Result for NaN and for values outside the bounds.
    """
    return int(value) if lowest <= value <= highest else otherwise


def _turned_matrix(matrix: Sequence[float], rotation: Quaternion) -> Sequence[float]:
    """Return ``R M R^T`` of a 3 by 3 matrix M, row by row."""
    columns = [
        rotate(rotation, (matrix[column], matrix[3 + column], matrix[6 + column]))
        for column in range(3)
    ]
    x, y, z = columns
    rows = [rotate(rotation, (x[row], y[row], z[row])) for row in range(3)]
    return [value for row in rows for value in row]
