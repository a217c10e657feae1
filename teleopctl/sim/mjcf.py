"""Ball joints, actuators and sensors that only robots in MJCF files have."""

from __future__ import annotations

import array
import math
from collections.abc import Callable, Mapping, Sequence
from math import asin, atan2, cos, isfinite, sin
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.errors import InvalidDescriptionError
from teleopctl.interfaces import get_message
from teleopctl.sim.sensors.base import Sensor

if TYPE_CHECKING:
    from teleopctl.mujoco_model import ActuatorTransmission, JointSpec
    from teleopctl.robot import JointActuator, SensorTag as Description

Array = npt.NDArray[np.float64]

# Least cosine of the middle angle: at a right angle, the speeds of the other two are not defined.
_NEARLY_UPRIGHT = 1e-6


class BallJoints:
    """Ball joints of a simulation, which ROS has as three revolute joints each.

    Args:
        joints: The robot's movable joints; three in a row with the same ``ball`` are a ball joint.
    """

    def __init__(self, joints: Sequence[JointSpec]) -> None:
        self._rows = {joint.ball: row - 2 for row, joint in enumerate(joints) if joint.ball}
        self._names = tuple(joint.name for joint in joints)

    def __len__(self) -> int:
        return len(self._rows)

    # Any stands for MuJoCo's types, which have no static ones.
    def read(self, data: Any, positions: Array, velocities: Array) -> None:
        """Write the three angles and velocities of each ball joint into arrays."""
        rotation = np.zeros(9)
        for ball, row in self._rows.items():
            joint = data.joint(ball)
            mujoco.mju_quat2Mat(rotation, joint.qpos)
            a = atan2(-rotation[5], rotation[8])
            b = asin(min(max(rotation[2], -1.0), 1.0))
            c = atan2(-rotation[1], rotation[0])
            x, y, z = joint.qvel
            first = (cos(c) * x - sin(c) * y) / max(cos(b), _NEARLY_UPRIGHT)
            positions[row : row + 3] = a, b, c
            velocities[row : row + 3] = first, sin(c) * x + cos(c) * y, z - sin(b) * first

    def put(self, data: Any, given: Mapping[str, float]) -> None:
        """Set the rotation of each ball joint that has a given angle; its missing angles are 0."""
        for ball, row in self._rows.items():
            turns = self._names[row : row + 3]
            if any(turn in given for turn in turns):
                angles = np.array([given.get(turn, 0.0) for turn in turns])
                mujoco.mju_euler2Quat(data.joint(ball).qpos, angles, "xyz")


_INTERFACES = ("position", "velocity", "effort")


class FileActuators:
    """Actuators of an MJCF file, by the joints that they move.

    Args:
        model: The ``mujoco.MjModel``.
        data: Its ``mujoco.MjData``.
        joints: The robot's movable joints.
        transmissions: Transmissions between actuators and joints that several of them move.
    """

    # Any stands for MuJoCo's types, which have no static ones.
    def __init__(
        self,
        model: Any,
        data: Any,
        joints: Sequence[JointSpec],
        transmissions: Sequence[ActuatorTransmission] = (),
    ) -> None:
        self._m, self._d = model, data
        self._transmissions = [
            (one, [int(model.actuator(actuator.name).id) for actuator in one.actuators])
            for one in transmissions
        ]
        self._moved = {joint for one in transmissions for joint in one.joints}
        self._parts = {
            joint.name: [
                (
                    _INTERFACES.index(actuator.interface),
                    int(model.actuator(actuator.name).id),
                    actuator,
                )
                for actuator in joint.actuators
            ]
            for joint in joints
            if joint.actuators
        }
        self._limits = {joint.name: joint.limits.mechanical for joint in joints}

    def __len__(self) -> int:
        return len(self._parts) + len(self._moved)

    def __contains__(self, joint: object) -> bool:
        return joint in self._parts or joint in self._moved

    def hold_present(self) -> None:
        """Set position actuators to the present positions of their joints."""
        for joint, parts in self._parts.items():
            position = float(self._d.joint(joint).qpos[0])
            for interface, number, actuator in parts:
                self._hold(interface, number, actuator, position)
        for one, numbers in self._transmissions:
            positions = [float(self._d.joint(joint).qpos[0]) for joint in one.joints]
            lengths = one.transmission.joint_to_actuator("position", positions)
            for number, actuator, length in zip(numbers, one.actuators, lengths, strict=True):
                self._hold(_INTERFACES.index(one.interface), number, actuator, length)

    def _hold(self, interface: int, number: int, actuator: JointActuator, position: float) -> None:
        first = int(self._m.actuator_actadr[number])
        if interface == 0:
            self._d.ctrl[number] = _control(actuator, position)
        if first >= 0 and interface < 2:
            # Actuators that filter positions or integrate velocities have a state.
            self._d.act[first] = _control(actuator, position)

    def apply(
        self,
        names: Sequence[str],
        position: Sequence[float],
        velocity: Sequence[float],
        effort: Sequence[float],
    ) -> None:
        """Set the controls from joint commands; missing velocities and efforts become zero."""
        given = [
            values if len(values) == len(names) else () for values in (position, velocity, effort)
        ]
        columns = {name: column for column, name in enumerate(names) if name in self}
        for joint, parts in self._parts.items():
            column = columns.get(joint)
            limits = self._limits[joint]
            for interface, number, actuator in parts:
                values = given[interface]
                value = float(values[column]) if column is not None and values else float("nan")
                if isfinite(value):
                    if interface == 0:
                        value = min(max(value, limits.lower), limits.upper)
                    self._d.ctrl[number] = _control(actuator, value)
                elif interface:
                    self._d.ctrl[number] = _control(actuator, 0.0)
        for one, numbers in self._transmissions:
            values = given[_INTERFACES.index(one.interface)]
            wanted = [
                float(values[columns[joint]]) if values and joint in columns else math.nan
                for joint in one.joints
            ]
            self._apply_transmission(one, numbers, wanted)

    def _apply_transmission(
        self, one: ActuatorTransmission, numbers: list[int], wanted: list[float]
    ) -> None:
        """Set the controls of actuators that move joints together; NaN is no command."""
        instead: Sequence[float] = [0.0] * len(wanted)
        if one.interface == "position":
            if not any(map(isfinite, wanted)):
                return
            lengths = [
                (float(self._d.ctrl[number]) - actuator.offset) / actuator.scale
                for number, actuator in zip(numbers, one.actuators, strict=True)
            ]
            instead = one.transmission.actuator_to_joint("position", lengths)
            limits = [self._limits[joint] for joint in one.joints]
            wanted = [
                min(max(value, limit.lower), limit.upper) if isfinite(value) else value
                for value, limit in zip(wanted, limits, strict=True)
            ]
        filled = [
            value if isfinite(value) else other
            for value, other in zip(wanted, instead, strict=True)
        ]
        commands = one.transmission.joint_to_actuator(one.interface, filled)
        for number, actuator, command in zip(numbers, one.actuators, commands, strict=True):
            self._d.ctrl[number] = _control(actuator, command)

    def hold(self) -> None:
        """Set velocity and effort actuators to zero; position actuators keep their targets."""
        self.apply((), (), (), ())


def _control(actuator: JointActuator, command: float) -> float:
    return actuator.scale * command + actuator.offset


class _OfFile(Sensor):
    """Sensor of an MJCF file, with the noise of the file."""

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Get the MuJoCo sensor of the file, and make it measure without delay."""
        kind = self.description.type
        self._sensor = self.description.texts.get(f"{kind}/sensor", "")
        sensor = spec.sensor(self._sensor)
        if sensor is None:
            raise InvalidDescriptionError(f"it is a sensor of MJCF files, named in <{kind}>")
        # The topic has the sensor's period. MuJoCo would repeat recorded values of earlier steps,
        # and records none in steps with sensors disabled.
        sensor.delay, sensor.nsample = 0.0, 0
        sensor.interval = np.zeros(2)

    def _values(self, data: mujoco.MjData) -> Array:
        return np.array(data.sensor(self._sensor).data)

    def _disturbed(self, values: Array, data: mujoco.MjData) -> Array:
        return self.noise(self.description.type).add_noise(values, float(data.time))


class Touch(_OfFile):
    """Touch sensor of an MJCF file: sum of the normal contact forces within its site, in N."""

    message_type = "std_msgs/msg/Float64"

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill a Float64 message with the touch force in N, with noise."""
        del model
        message.data = float(self._disturbed(self._values(data), data)[0])


class Rangefinder(_OfFile):
    """Range finder of an MJCF file: distance along a ray to the nearest shape.

    The distance is infinite if the ray meets nothing, or nothing before the cutoff (REP 117).
    """

    message_type = "sensor_msgs/msg/Range"

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill a Range message with the distance; infinite if the ray meets nothing."""
        cutoff = float(model.sensor(self._sensor).cutoff[0])
        message.radiation_type = 1  # infrared
        message.max_range = cutoff or math.inf
        value = self._values(data)
        met = value[0] >= 0.0 and (not cutoff or value[0] < cutoff)
        message.range = max(0.0, float(self._disturbed(value, data)[0])) if met else math.inf


class MjcfSensor(_OfFile):
    """Sensor of an MJCF file, published in a message of the type that the description names.

    Args:
        description: The ``<sensor>`` tag; its ``<message>`` is the type of the message.
    """

    def __init__(self, description: Description) -> None:
        super().__init__(description)
        self.message_type = description.texts.get("mujoco/message", "")
        if self.message_type not in _FILLS:
            raise InvalidDescriptionError(f"<message> is not one of {', '.join(_FILLS)}")

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill the message with the values of the MuJoCo sensor, with noise."""
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
