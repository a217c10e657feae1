"""Plug-ins of Gazebo that the simulator runs itself: ground-truth odometry and planar move."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
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
    """Sensor that publishes a link's true pose and velocity as ``nav_msgs/msg/Odometry``.

    Args:
        truth: Link, topic and settings of the odometry.
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
        """Check that the odometry's links are in the spec, raise if not; nothing is added.

        Raises:
            InvalidDescriptionError: A link is missing.
        """
        for link in (self._truth.link, self._truth.relative_to):
            if link and spec.body(link) is None:
                raise InvalidDescriptionError(f"the robot has no link '{link}'")

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill an Odometry message with the link's true pose, and its velocity with noise."""
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
        """Return position, quaternion (w x y z), linear and angular velocity."""
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
    """Sensor that publishes a link's true pose as TFMessage, on the plug-in's TF topic.

    Args:
        truth: Link, topic and settings of the odometry.
    """

    message_type = "tf2_msgs/msg/TFMessage"

    def __init__(self, truth: GroundTruth) -> None:
        super().__init__(truth, truth.tf_topic)

    # Any: as the base class has it.
    def headers(self, message: Any) -> Sequence[Any]:
        """Add the transform to a new TFMessage, and return a list of the transform's header."""
        from teleopctl.interfaces import get_message

        transform = get_message("geometry_msgs/msg/TransformStamped")
        message.transforms = [transform(child_frame_id=self._truth.child_frame_id)]
        return [message.transforms[0].header]

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Fill a TFMessage with the link's true pose."""
        position, quaternion, _, _ = self._state(model, data)
        transform = message.transforms[0].transform
        place, turn = transform.translation, transform.rotation
        place.x, place.y, place.z = position
        turn.w, turn.x, turn.y, turn.z = quaternion


def ground_truth(truths: Sequence[GroundTruth]) -> list[Sensor]:
    """Return the sensors that publish the true odometry which Gazebo plug-ins request.

    Args:
        truths: Links, topics and settings of the plug-ins.
    """
    found: list[Sensor] = []
    for truth in truths:
        if truth.topic:
            found.append(OdometrySensor(truth))
        if truth.tf_topic:
            found.append(OdometryTransformSensor(truth))
    return found


def _velocity(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> tuple[Array, Array]:
    """Return the linear and angular velocity of a body's frame, along the world's axes."""
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


# Time constant (s) with which the base reaches a velocity. The velocity that is lost to ground
# friction is added to the command, by this fraction in each control period and up to these limits
# (m/s, rad/s).
_LAG_S = 5e-4
_CORRECTION, _MOST = 0.2, (0.1, 0.1, 1.0)
_AXES = ((0, "x"), (1, "y"), (5, "yaw"))


class PlanarMove:
    """Gazebo's planar-move plug-in: moves a free base by velocities in x, y and yaw.

    Gazebo's plug-in sets the base's velocity again and again. Here velocity actuators without a
    force limit hold the velocity.

    Args:
        topic: Topic of the commanded ``geometry_msgs/msg/Twist``.
        link: Link of the base, which is on a free joint.
    """

    def __init__(self, topic: str, link: str) -> None:
        self.topic = topic
        self._link = link
        self.stop()
        # Any: the ``mujoco.MjModel`` that the motors are tuned to.
        self._tuned: Any = None

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add the base's velocity actuators to a MuJoCo spec; raise if the base is fixed.

        Raises:
            InvalidDescriptionError: The base is fixed to the world.
        """
        body = spec.body(self._link)
        joint = body.joints[0] if body is not None and body.joints else None
        if joint is None or joint.type != mujoco.mjtJoint.mjJNT_FREE:
            raise InvalidDescriptionError(f"'{self._link}' is fixed to the world")
        for place, axis in _AXES:
            gear = [0.0] * 6
            gear[place] = 1.0
            motor = spec.add_actuator(
                name=self._name(axis), target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT
            )
            motor.gear = gear
            motor.set_to_velocity(kv=1.0)

    def _name(self, axis: str) -> str:
        return f"{self._link}_planar_{axis}"

    # Any: a message, whose class is made at run time.
    def receive(self, message: Any) -> None:
        """Set the commanded velocity from a Twist message if finite; on the transport's thread."""
        wanted = (message.linear.x, message.linear.y, message.angular.z)
        if all(map(math.isfinite, wanted)):
            self._wanted = wanted

    def stop(self) -> None:
        """Drop the commanded velocity, so that the base stops."""
        self._wanted = (0.0, 0.0, 0.0)
        self._more = np.zeros(3)

    def plan_period(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Set the actuators' controls for the control period that begins now.

        Args:
            model: The ``mujoco.MjModel``, in which the actuators' gains are set.
            data: Its ``mujoco.MjData``.
        """
        motors = [model.actuator(self._name(axis)).id for _, axis in _AXES]
        body = model.body(self._link)
        first = int(body.dofadr[0])
        if model is not self._tuned:
            self._tuned = model
            mass = np.zeros((model.nv, model.nv))
            mujoco.mj_fullM(model, data, mass)
            for motor, (place, _) in zip(motors, _AXES, strict=True):
                gain = mass[first + place, first + place] / _LAG_S
                model.actuator_gainprm[motor, 0] = gain
                model.actuator_biasprm[motor, 2] = -gain
        x, y, turn = self._wanted
        forwards = data.xmat[body.id].reshape(3, 3)[:, 0]
        yaw = math.atan2(forwards[1], forwards[0])
        cosine, sine = math.cos(yaw), math.sin(yaw)
        wanted = np.array((x * cosine - y * sine, x * sine + y * cosine, turn))
        missing = wanted - [data.qvel[first + place] for place, _ in _AXES]
        self._more = np.clip(self._more + _CORRECTION * missing, np.negative(_MOST), _MOST)
        data.ctrl[motors] = wanted + self._more


def add_movers(
    spec: mujoco.MjSpec, movers: list[PlanarMove], warn: Callable[[str], object]
) -> None:
    """Add planar-move plug-ins to a MuJoCo spec; drop failing ones from the list, with warnings."""
    for mover in list(movers):
        try:
            mover.add_to(spec)
        except InvalidDescriptionError as error:
            movers.remove(mover)
            warn(f"{mover.topic} moves nothing: {error.message}")
