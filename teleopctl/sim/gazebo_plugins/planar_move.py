"""A base that moves over the ground as a topic asks, whatever it stands on."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np

from teleopctl.errors import InvalidDescriptionError

# Time constant in s with which the base takes up a velocity. What friction on the ground takes of
# that is made up for, this part of it in each control period and so much at most (m/s, rad/s).
_LAG_S = 5e-4
_CORRECTION, _MOST = 0.2, (0.1, 0.1, 1.0)
_AXES = ((0, "x"), (1, "y"), (5, "yaw"))


class PlanarMove:
    """Moves a free base by velocities along x and y and about z.

    Gazebo's plug-in sets the base's velocity again and again. Here motors hold it, as strong as
    they need to be.

    Args:
        topic: Where ``geometry_msgs/msg/Twist`` come from.
        link: The base's link, which is on a free joint.
    """

    def __init__(self, topic: str, link: str) -> None:
        self.topic = topic
        self._link = link
        self.forget()
        # Any: the ``mujoco.MjModel`` that the motors are tuned to.
        self._tuned: Any = None

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add the base's actuators to a spec.

        Raises:
            InvalidDescriptionError: The base stands still.
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
        """Set the commanded velocity, in the base's frame; called on the transport's thread."""
        wanted = (message.linear.x, message.linear.y, message.angular.z)
        if all(map(math.isfinite, wanted)):
            self._wanted = wanted

    def forget(self) -> None:
        """Stop until the next command."""
        self._wanted = (0.0, 0.0, 0.0)
        self._more = np.zeros(3)

    def plan_period(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Set the actuators for the control period that begins now.

        Args:
            model: The ``mujoco.MjModel``, on which the motors are tuned.
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
    """Add the planar movers to a robot's spec; those that cannot be added are removed."""
    for mover in list(movers):
        try:
            mover.add_to(spec)
        except InvalidDescriptionError as error:
            movers.remove(mover)
            warn(f"{mover.topic} moves nothing: {error.message}")
