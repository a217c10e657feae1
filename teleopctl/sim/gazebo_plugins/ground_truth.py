"""Odometry as physics has it, for plug-ins of Gazebo that publish it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot import SensorTag as Description
from teleopctl.sim.sensors.base import Sensor

if TYPE_CHECKING:
    from teleopctl.robot import GroundTruth

Array = npt.NDArray[np.float64]
_BODY = mujoco.mjtObj.mjOBJ_XBODY


class OdometrySensor(Sensor):
    """Publishes a link's true pose and velocity as ``nav_msgs/msg/Odometry``.

    Args:
        truth: Which link's, and how it is told.
    """

    message_type = "nav_msgs/msg/Odometry"

    def __init__(self, truth: GroundTruth, topic: str | None = None) -> None:
        super().__init__(
            Description(
                name=truth.name,
                type="odometry",
                link=truth.link,
                update_rate=truth.rate_hz,
                topic=truth.topic if topic is None else topic,
                frame=truth.frame_id,
            )
        )
        self._truth = truth
        self._turned = np.zeros(4)
        mujoco.mju_euler2Quat(self._turned, np.array(truth.offset.rpy), "XYZ")
        # The same noise in each run.
        self._random = np.random.default_rng(0)

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Check that the links exist.

        Raises:
            InvalidDescriptionError: One of them is not.
        """
        for link in (self._truth.link, self._truth.relative_to):
            if link and spec.body(link) is None:
                raise InvalidDescriptionError(f"the robot has no link '{link}'")

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill an Odometry message."""
        truth = self._truth
        message.child_frame_id = truth.child_frame_id
        position, quaternion, linear, angular = self._state(model, data)
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        place.x, place.y, place.z = position
        turn.w, turn.x, turn.y, turn.z = quaternion
        if truth.noise:
            linear += self._random.normal(0.0, truth.noise, 3)
            angular += self._random.normal(0.0, truth.noise, 3)
        twist = message.twist.twist
        twist.linear.x, twist.linear.y, twist.linear.z = linear
        twist.angular.x, twist.angular.y, twist.angular.z = angular
        for part, variance in (
            (message.pose, truth.pose_variance),
            (message.twist, truth.twist_variance),
        ):
            part.covariance = np.diag(variance).ravel()

    def _state(
        self, model: mujoco.MjModel, data: mujoco.MjData
    ) -> tuple[Array, Array, Array, Array]:
        """Position, quaternion (w x y z), linear and angular velocity."""
        truth = self._truth
        body = model.body(truth.link).id
        position, quaternion = np.array(data.xpos[body]), np.array(data.xquat[body])
        linear, angular = _velocity(model, data, body)
        if truth.relative_to:
            other = model.body(truth.relative_to).id
            back = np.zeros(4)
            mujoco.mju_negQuat(back, data.xquat[other])
            other_linear, other_angular = _velocity(model, data, other)
            position = _rotated(position - data.xpos[other], back)
            linear = _rotated(linear - other_linear, back)
            angular = _rotated(angular - other_angular, back)
            quaternion = _product(back, quaternion)
        position += truth.offset.xyz
        quaternion = _product(self._turned, quaternion)
        if truth.in_child_frame:
            back = np.zeros(4)
            mujoco.mju_negQuat(back, quaternion)
            linear, angular = _rotated(linear, back), _rotated(angular, back)
        return position, quaternion, linear, angular


class OdometryTransformSensor(OdometrySensor):
    """Publishes a link's true pose as a transform on /tf.

    Args:
        truth: Which link's, and how it is told.
    """

    message_type = "tf2_msgs/msg/TFMessage"

    def __init__(self, truth: GroundTruth) -> None:
        super().__init__(truth, truth.tf_topic)

    # Any: as the base class has it.
    def headers(self, message: Any) -> Sequence[Any]:
        """Return the header of the message's only transform."""
        from teleopctl.interfaces import get_message

        transform = get_message("geometry_msgs/msg/TransformStamped")
        message.transforms = [transform(child_frame_id=self._truth.child_frame_id)]
        return [message.transforms[0].header]

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill a transform message."""
        position, quaternion, _, _ = self._state(model, data)
        transform = message.transforms[0].transform
        place, turn = transform.translation, transform.rotation
        place.x, place.y, place.z = position
        turn.w, turn.x, turn.y, turn.z = quaternion


def ground_truth(truths: Sequence[GroundTruth]) -> list[Sensor]:
    """Return the sensors that publish the true odometry requested by plug-ins.

    Args:
        truths: What they ask for.
    """
    found: list[Sensor] = []
    for truth in truths:
        if truth.topic:
            found.append(OdometrySensor(truth))
        if truth.tf_topic:
            found.append(OdometryTransformSensor(truth))
    return found


def _velocity(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> tuple[Array, Array]:
    """Linear and angular velocity of a body's frame, along the world's axes."""
    twist = np.zeros(6)
    mujoco.mj_objectVelocity(model, data, _BODY, body, twist, 0)
    return twist[3:], twist[:3]


def _rotated(vector: Array, quaternion: Array) -> Array:
    turned = np.zeros(3)
    mujoco.mju_rotVecQuat(turned, vector, quaternion)
    return turned


def _product(first: Array, second: Array) -> Array:
    product = np.zeros(4)
    mujoco.mju_mulQuat(product, first, second)
    return product
