"""Filters of wrenches: lists of three forces (N) and three torques (Nm) along the frame's axes."""

from __future__ import annotations

import math
from typing import Any

from teleopctl.control.controllers.filters.base import WRENCH, FilterBase
from teleopctl.control.controllers.filters.doubles import low_pass_coefficients
from teleopctl.control.realtime_publisher import realtime_log
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, get_message
from teleopctl.tf import (
    TF_STATIC_TOPIC,
    TF_TOPIC,
    Buffer,
    Transform,
    TransformException,
    Vector3,
    rotate,
)

_GRAVITY = (0.0, 0.0, -9.81)
# Seconds between two reports of missing transforms, as in ROS 2.
_REPORT_S = 5.0


class WrenchLowPassFilter(FilterBase[list[float]]):
    """Low-pass filter of first order of each component of a wrench.

    Plug-in type ``control_filters/LowPassFilterWrench``; see the filter of single numbers.
    """

    data_type = WRENCH

    def configure(self) -> None:
        """Read frequencies and damping."""
        self.reconfigure()
        self.reset()

    def reconfigure(self) -> None:
        """Read frequencies and damping again."""
        self._feedback, self._feedforward = low_pass_coefficients(self)

    def reset(self) -> None:
        """Start again at the next wrench."""
        self._input: list[float] = []
        self._output: list[float] = []

    def update(self, data_in: list[float]) -> list[float] | None:
        """Return the filtered wrench; after NaN it starts again."""
        if not self._output or any(map(math.isnan, self._output)):
            self._input = self._output = data_in
        a, b = self._feedback, self._feedforward
        self._output = [b * x + a * y for x, y in zip(self._input, self._output, strict=True)]
        self._input = data_in
        return self._output


class GravityCompensation(FilterBase[list[float]]):
    """Filter that subtracts the weight of a tool from a wrench.

    Plug-in type ``control_filters/GravityCompensationWrench``.

    In the sensor frame, with the weight g of the tool at its centre of gravity p,
    ``force - g`` and ``torque - p x g``. The weight is given in the world frame. Transforms between
    the frames come from ``/tf``; without them there is no result.
    """

    data_type = WRENCH

    def configure(self) -> None:
        """Read frames and tool, and subscribe to transforms."""
        from teleopctl.node import DurabilityPolicy, QoSProfile

        self._subscriptions: list[Any] = []
        self._sensor, self._world = self.text("sensor_frame"), self.text("world_frame")
        self.reconfigure()
        controller = self.params.controller
        self._log = realtime_log(controller.params.publish_queue)
        self._reported_ns = -math.inf
        self._buffer = buffer = Buffer()

        # Any: message classes are generated at run time.
        def moved(message: Any) -> None:
            for transform in message.transforms:
                buffer.set_transform(transform)

        def fixed(message: Any) -> None:
            for transform in message.transforms:
                buffer.set_transform_static(transform)

        node, kind = controller.get_node(), get_message("tf2_msgs/msg/TFMessage")
        latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._subscriptions = [
            node.create_subscription(kind, TF_TOPIC, moved, 100),
            node.create_subscription(kind, TF_STATIC_TOPIC, fixed, latched),
        ]

    def reconfigure(self) -> None:
        """Read mass, centre of gravity and gravity again."""
        x, y, z = self._vector("tool.gravity_field", _GRAVITY)
        centre = self._vector("tool.CoG", ())
        mass = self.number("tool.mass")
        self._centre, self._weight = centre, (mass * x, mass * y, mass * z)

    def _vector(self, name: str, default: tuple[float, ...]) -> Vector3:
        values = self.numbers(name, default)
        if len(values) != len(_GRAVITY):
            raise self.invalid(name, f"has the length {len(values)} but must have the length 3")
        x, y, z = values
        return x, y, z

    def reset(self) -> None:
        """Forget transforms of the future, which are those before a simulation reset."""
        now_ns = self.params.controller.params.now_ns()
        if any(
            sample.stamp > now_ns + NANOSECONDS_PER_SECOND for _, sample in self._buffer.latest()
        ):
            self._buffer.clear()

    def close(self) -> None:
        """Destroy the subscriptions to transforms."""
        for subscription in self._subscriptions:
            self.params.controller.get_node().destroy_subscription(subscription)
        self._subscriptions = []

    def update(self, data_in: list[float]) -> list[float] | None:
        """Return the wrench without the tool's weight; None if a transform is unknown."""
        frame = self.params.frame_id
        try:
            _, to_sensor = self._buffer.lookup(self._sensor, frame, 0)
            _, world = self._buffer.lookup(self._sensor, self._world, 0)
        except TransformException as error:
            self._report(str(error))
            return None
        fx, fy, fz, tx, ty, tz = transformed_wrench(to_sensor, data_in)
        weight = rotate(world.rotation, self._weight)
        mx, my, mz = _cross(self._centre, weight)
        wx, wy, wz = weight
        compensated = [fx - wx, fy - wy, fz - wz, tx - mx, ty - my, tz - mz]
        return transformed_wrench(to_sensor.inverse(), compensated)

    def _report(self, problem: str) -> None:
        now_ns = self.params.controller.params.now_ns()
        if now_ns - self._reported_ns < _REPORT_S * NANOSECONDS_PER_SECOND:
            return
        self._reported_ns = now_ns
        frame = self.params.frame_id
        self._log.try_publish(
            (
                self.params.controller.logger.error,
                f"GravityCompensation update failed:{problem}, given frames are datain:{frame} "
                f"dataout:{frame} world:{self._world} sensor:{self._sensor}",
            )
        )


def transformed_wrench(transform: Transform, wrench: list[float]) -> list[float]:
    """Return a wrench in the parent's frame, about the parent's origin.

    A force along the child's axes has the torque ``p x force`` about the origin of the parent,
    where p is the child's origin in the parent's frame.
    """
    fx, fy, fz, tx, ty, tz = wrench
    force = rotate(transform.rotation, (fx, fy, fz))
    x, y, z = rotate(transform.rotation, (tx, ty, tz))
    mx, my, mz = _cross(transform.translation, force)
    return [*force, x + mx, y + my, z + mz]


def _cross(a: Vector3, b: Vector3) -> Vector3:
    ax, ay, az = a
    bx, by, bz = b
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
