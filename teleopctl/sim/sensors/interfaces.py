"""State interfaces of the ``<sensor>`` tags in ``<ros2_control>``, fed by simulated sensors.

Values come from the sensor of the same name in ``<gazebo>``, as in gz_ros2_control. Without such a
sensor, the type of sensor follows from the interfaces, and its link from the parameter
``frame_id``, by default the link with the sensor's name.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from teleopctl.interfaces import get_message
from teleopctl.robot import RobotDescription, SensorTag as Description
from teleopctl.sim.sensors.base import Sensor
from teleopctl.sim.sensors.geodesy import GeoPoint
from teleopctl.sim.sensors.pose import PoseSensor
from teleopctl.sim.sensors.publishing import make_sensors

if TYPE_CHECKING:
    import mujoco

    from teleopctl.robot import ComponentInfo

_PLACES = ("latitude", "longitude", "altitude")
# Variances of a satellite fix: the diagonal of a 3 by 3 matrix.
_VARIANCES = {
    f"{name}_covariance": ("position_covariance", str(4 * axis))
    for axis, name in enumerate(_PLACES)
}
# First parts of interfaces' names, and the type of sensor that measures all of them.
_POSE = "pose"
_TYPES = (
    ({"orientation", "angular_velocity", "linear_acceleration"}, "imu"),
    ({"force", "torque"}, "force_torque"),
    ({"position", "orientation"}, _POSE),
    ({"magnetic_field"}, "magnetometer"),
    ({"status", "service", *_PLACES, *_VARIANCES}, "navsat"),
)


@dataclass(frozen=True)
class _Read:
    """Mapping from a sensor's message to the values of its state interfaces.

    Attributes:
        sensor: The simulated sensor.
        message: Message that is filled at each reading. Any: its class is made at run time.
        paths: Names of the nested attributes of the message that lead to each value.
        names: Full names of the state interfaces that the values are for.
    """

    sensor: Sensor
    message: Any
    paths: tuple[tuple[str, ...], ...]
    names: tuple[str, ...]


class SensorInterfaces:
    """Values of the state interfaces of a robot's ``<ros2_control>`` sensors.

    Args:
        reads: Sensors, with the values in their messages.

    Attributes:
        names: Full names of the interfaces, such as ``imu/orientation.x``, in the order of the
            values.
    """

    def __init__(self, reads: Sequence[_Read] = ()) -> None:
        self._reads = reads
        self.names = tuple(name for read in reads for name in read.names)

    @property
    def sensors(self) -> list[Sensor]:
        """The simulated sensors that measure the interfaces' values."""
        return [read.sensor for read in self._reads]

    def only(self, sensors: Sequence[Sensor]) -> SensorInterfaces:
        """Return the interfaces of the given sensors only."""
        return SensorInterfaces([read for read in self._reads if read.sensor in sensors])

    def read(self, model: mujoco.MjModel, data: mujoco.MjData) -> list[float]:
        """Measure all sensors, and return the interfaces' values in the order of ``names``."""
        values = []
        for read in self._reads:
            read.sensor.read(model, data, read.message)
            values += [float(_value(read.message, path)) for path in read.paths]
        return values


def sensor_interfaces(
    description: RobotDescription,
    published: Sequence[Sensor],
    warn: Callable[[str], object],
    seed: int = 0,
    origin: GeoPoint | None = None,
) -> SensorInterfaces:
    """Return the state interfaces of ``<ros2_control>`` sensors; create missing sensors.

    Args:
        description: The robot.
        published: Sensors that exist already, for topics.
        warn: Called with a sentence for each sensor that nothing measures.
        seed: Seed of the noise of sensors that are created here.
        origin: Position of the world's origin on the earth, for these sensors.
    """
    made = {sensor.description.name: sensor for sensor in published}
    reads = []
    for component in description.ros2_control:
        for tag in component.sensors:
            sensor = made.get(tag.name) or _make(tag, description, warn)
            if sensor is None:
                continue
            message = get_message(sensor.message_type)()
            paths = {i.name: _path(message, i.name) for i in tag.state_interfaces}
            unknown = [name for name, path in paths.items() if path is None]
            if unknown:
                warn(f"Nothing measures {', '.join(f'{tag.name}/{name}' for name in unknown)}")
            found = {name: path for name, path in paths.items() if path is not None}
            names = tuple(f"{tag.name}/{name}" for name in found)
            if tag.name not in made:
                sensor.seed, sensor.origin = seed, origin or sensor.origin
            reads.append(_Read(sensor, message, tuple(found.values()), names))
    return SensorInterfaces(reads)


def _make(
    tag: ComponentInfo, description: RobotDescription, warn: Callable[[str], object]
) -> Sensor | None:
    """Return a sensor that no ``<gazebo>`` tag describes; None, with a warning, if impossible."""
    parts = {i.name.partition(".")[0] for i in tag.state_interfaces}
    kind = next((kind for known, kind in _TYPES if parts and parts <= known), "")
    frame = tag.parameters.get("frame_id", "").strip() or tag.name
    if not kind or frame not in description.links:
        warn(
            f"Sensor '{tag.name}' of <ros2_control> measures nothing: it needs a <gazebo> sensor "
            "of its name, or the interfaces of an IMU, a force-torque sensor, a magnetometer, a "
            "GPS or a pose, and a parameter frame_id that names a link"
        )
        return None
    described = Description(name=tag.name, type=kind, link=frame)
    if kind == _POSE:
        return PoseSensor(described)
    made = make_sensors((described,), warn)
    return made[0] if made else None


def _path(message: object, name: str) -> tuple[str, ...] | None:
    """Return the attributes that lead to a number of a message, such as ``orientation.x``, or None.

    The name of the part of the message that is the measurement, such as ``wrench``, may be omitted.
    """
    wanted = _VARIANCES.get(name) or tuple(name.split("."))
    parts = [part for part in getattr(message, "__slots__", ()) if part.strip("_") != "header"]
    for prefix in ((), *((part.lstrip("_"),) for part in parts)):
        try:
            value = _value(message, (*prefix, *wanted))
        except (AttributeError, IndexError):
            continue
        if isinstance(value, (float, int)):
            return (*prefix, *wanted)
    return None


# Any: a message's attribute.
def _value(message: Any, path: Sequence[str]) -> Any:
    value = message
    for name in path:
        value = value[int(name)] if name.isdecimal() else getattr(value, name)
    return value
