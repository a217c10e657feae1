"""Sensors that MuJoCo reads as the robot's file has them.

``touch``, ``rangefinder``, and ``mujoco`` for all that is told as it is.
"""

from __future__ import annotations

import array
import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.errors import InvalidDescriptionError
from teleopctl.interfaces import get_message
from teleopctl.sim.sensors.base import Sensor

if TYPE_CHECKING:
    from teleopctl.robot import SensorTag as Description

Array = npt.NDArray[np.float64]


class _OfFile(Sensor):
    """A sensor of an MJCF file, with the noise that the file says."""

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Find the MuJoCo sensor of the file."""
        kind = self.description.type
        self._sensor = self.description.texts.get(f"{kind}/sensor", "")
        sensor = spec.sensor(self._sensor)
        if sensor is None:
            raise InvalidDescriptionError(f"it is one of MJCF files, with its name in <{kind}>")
        # The topic has the period. MuJoCo would repeat what it has kept of earlier steps, and it
        # keeps nothing of those that nobody looks at.
        sensor.delay, sensor.nsample = 0.0, 0
        sensor.interval = np.zeros(2)

    def _values(self, data: mujoco.MjData) -> Array:
        return np.array(data.sensor(self._sensor).data)

    def _disturbed(self, values: Array, data: mujoco.MjData) -> Array:
        return self.noise(self.description.type).disturb(values, float(data.time))


class Touch(_OfFile):
    """Touch sensor: sum of the normal contact forces within its site, in N."""

    message_type = "std_msgs/msg/Float64"

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill the message with the force."""
        del model
        message.data = float(self._disturbed(self._values(data), data)[0])


class Rangefinder(_OfFile):
    """Range finder: distance along a ray to the nearest shape.

    What meets nothing, or nothing until the cutoff, is infinite (REP 117).
    """

    message_type = "sensor_msgs/msg/Range"

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill the message with the distance; -1 of MuJoCo means none."""
        cutoff = float(model.sensor(self._sensor).cutoff[0])
        message.radiation_type = 1  # infrared
        message.max_range = cutoff or math.inf
        value = self._values(data)
        met = value[0] >= 0.0 and (not cutoff or value[0] < cutoff)
        message.range = max(0.0, float(self._disturbed(value, data)[0])) if met else math.inf


class AsItIs(_OfFile):
    """Sensor that publishes the values of a MuJoCo sensor of an MJCF file.

    Args:
        description: What the tag says; its ``<message>`` is the type of the message.
    """

    def __init__(self, description: Description) -> None:
        super().__init__(description)
        self.message_type = description.texts.get("mujoco/message", "")
        if self.message_type not in _FILLS:
            raise InvalidDescriptionError(f"<message> is none of {', '.join(_FILLS)}")

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Copy the sensor's values."""
        del model
        values = self._disturbed(self._values(data), data)
        _FILLS[self.message_type](message, values)
        if self.message_type == _NUMBERS and not message.layout.dim:
            dimension, count = get_message("std_msgs/msg/MultiArrayDimension"), len(values)
            message.layout.dim = [dimension(label=self._sensor, size=count, stride=count)]


# Any, here and below: messages are of classes that are made from their definitions.
def _fill_number(message: Any, values: Array) -> None:
    message.data = float(values[0])


def _fill_numbers(message: Any, values: Array) -> None:
    message.data = array.array("d", values)


def _fill_vector(message: Any, values: Array) -> None:
    vector = message.vector
    vector.x, vector.y, vector.z = map(float, values)


def _fill_point(message: Any, values: Array) -> None:
    point = message.point
    point.x, point.y, point.z = map(float, values)


def _fill_rotation(message: Any, values: Array) -> None:
    q = message.quaternion
    q.w, q.x, q.y, q.z = map(float, values)


_NUMBERS = "std_msgs/msg/Float64MultiArray"
_FILLS: Mapping[str, Callable[[Any, Array], None]] = {
    "std_msgs/msg/Float64": _fill_number,
    _NUMBERS: _fill_numbers,
    "geometry_msgs/msg/Vector3Stamped": _fill_vector,
    "geometry_msgs/msg/PointStamped": _fill_point,
    "geometry_msgs/msg/QuaternionStamped": _fill_rotation,
}
