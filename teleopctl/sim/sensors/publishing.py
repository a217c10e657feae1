"""Creation of a robot's sensors from its description, and their publishers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl import plugins
from teleopctl.errors import TeleopctlError, UnknownPluginError
from teleopctl.interfaces import get_message, set_stamp
from teleopctl.mujoco_model import CAMERA_TYPES
from teleopctl.robot import ros_topic
from teleopctl.sim.pacing import PeriodicSchedule
from teleopctl.sim.sensors.base import Sensor
from teleopctl.sim.sensors.geodesy import GeoPoint
from teleopctl.sim.simulation import Simulation

if TYPE_CHECKING:
    import mujoco

    from teleopctl.node import Node
    from teleopctl.robot import SensorTag as Description

_SOMEWHERE = GeoPoint()


def make_sensors(
    descriptions: tuple[Description, ...],
    warn: Callable[[str], object],
    seed: int = 0,
    origin: GeoPoint = _SOMEWHERE,
) -> list[Sensor]:
    """Return new sensors for ``<sensor>`` tags other than cameras; warn of each that is left out.

    Args:
        descriptions: The ``<sensor>`` tags.
        warn: Called with a sentence for each sensor that is left out.
        seed: Seed of the sensors' noise.
        origin: Position of the world's origin on the earth.
    """
    sensors: list[Sensor] = []
    for description in descriptions:
        if description.type in CAMERA_TYPES:
            continue  # the camera node renders these, in a process of its own
        line = f" (line {description.line})" if description.line else ""
        where = f"Sensor '{description.name}' on link '{description.link}'{line} is left out"
        try:
            sensor = plugins.load(plugins.SENSORS, description.type)(description)
            sensors += [sensor, *sensor.companions()]
        except UnknownPluginError:
            known = ", ".join(sorted((*CAMERA_TYPES, *plugins.available(plugins.SENSORS))))
            warn(f"{where}: nothing simulates the type '{description.type}', only {known}")
        except Exception as error:  # noqa: BLE001 -- a sensor of an extension stops nothing else
            warn(f"{where}: {_text_of(error)}")
    for sensor in sensors:
        sensor.seed, sensor.origin = seed, origin
    return sensors


def add_sensors(spec: mujoco.MjSpec, sensors: list[Sensor], warn: Callable[[str], object]) -> None:
    """Add sensors to a MuJoCo spec; remove those that fail from the list, with a warning."""
    for sensor in list(sensors):
        try:
            sensor.add_to(spec)
        except Exception as error:  # noqa: BLE001 -- a sensor of an extension stops nothing else
            sensors.remove(sensor)
            warn(f"Sensor '{sensor.description.name}' is left out: {_text_of(error)}")


class SensorPublisher:
    """Publisher of a robot's simulated sensors; each is measured only while it has subscribers.

    Args:
        node: Node of the publishers.
        simulation: Simulation to measure.
        sensors: Sensors, already added to the simulation's model.
    """

    def __init__(self, node: Node, simulation: Simulation, sensors: list[Sensor]) -> None:
        self._simulation = simulation
        self._logger = node.get_logger()
        self._channels = [
            _Channel(node, sensor, 1e9 / simulation.control_period_ns) for sensor in sensors
        ]
        # Whether any sensor has subscribers, or had some at the last sample.
        self._is_used = False

    def on_graph_change(self) -> None:
        """Update which sensors have subscribers; called when the ROS graph has changed."""
        for channel in self._channels:
            channel.watched = channel.publisher.get_subscription_count() > 0
        self._is_used = True

    def go_on(self, time_ns: int) -> None:
        """Continue the schedules of the subscribed sensors at a simulated time."""
        for channel in self._channels:
            channel.running = channel.watched
            channel.schedule.skip_to(time_ns)

    def restart(self) -> None:
        """Restart the schedules of all sensors, after a reset of simulated time to zero."""
        for channel in self._channels:
            channel.schedule.restart()

    def next_ns(self) -> int | None:
        """Return the simulated time at which the next subscribed sensor is due, or None."""
        return min((c.schedule.next_ns for c in self._channels if c.running), default=None)

    def sample(self, time_ns: int) -> None:
        """Measure and publish the subscribed sensors that are due at a simulated time."""
        if not self._is_used:
            return
        self._is_used = False
        due = [channel for channel in self._channels if channel.is_due(time_ns)]
        if any(channel.watched for channel in self._channels):
            self._is_used = True
        self._publish(due, time_ns)

    def show(self, time_ns: int) -> None:
        """Publish the subscribed sensors of state, such as contacts, at once with a given stamp."""
        shown = [one for one in self._channels if one.watched and one.sensor.is_state]
        self._publish(shown, time_ns)

    def subscription_counts(self) -> dict[str, int]:
        """Return subscription counts by topic of the sensors of state, such as contacts."""
        return {
            one.publisher.topic_name: one.publisher.get_subscription_count()
            for one in self._channels
            if one.sensor.is_state
        }

    def _publish(self, due: list[_Channel], time_ns: int) -> None:
        if not due:
            return
        model, data = self._simulation.observe()
        for channel in due:
            try:
                channel.publish(model, data, time_ns)
            except Exception as error:  # noqa: BLE001 -- a sensor of an extension stops nothing else
                self._channels.remove(channel)
                name = channel.sensor.description.name
                self._logger.error(f"Sensor '{name}' is disabled: {_text_of(error)}")


class _Channel:
    """Simulated sensor with its publisher, message and schedule."""

    def __init__(self, node: Node, sensor: Sensor, default_rate_hz: float) -> None:
        message_class = get_message(sensor.message_type)
        self.sensor = sensor
        topic = ros_topic(sensor.topic)
        if topic != sensor.topic:
            node.get_logger().warning(
                f"'{sensor.topic}' is not a valid topic name: sensor '{sensor.description.name}' "
                f"publishes on '{topic}'"
            )
        self.publisher = node.create_publisher(message_class, topic, 10)
        self.schedule = PeriodicSchedule(sensor.description.update_rate or default_rate_hz)
        self.watched = False
        self.running = False
        self._message: Any = message_class()
        self._headers = sensor.headers(self._message)
        for header in self._headers:
            header.frame_id = sensor.frame_id

    def is_due(self, time_ns: int) -> bool:
        """Return whether the sensor is subscribed and due at a time; if so, schedule the next."""
        if self.watched and not self.running:
            self.schedule.skip_to(time_ns)
        self.running = self.watched
        return self.running and self.schedule.poll(time_ns)

    def publish(self, model: mujoco.MjModel, data: mujoco.MjData, time_ns: int) -> None:
        for header in self._headers:
            set_stamp(header.stamp, time_ns)
        self.sensor.read(model, data, self._message)
        self.publisher.publish(self._message)


def _text_of(error: Exception) -> str:
    if isinstance(error, TeleopctlError):
        return error.message
    return f"{type(error).__name__}: {error}"
