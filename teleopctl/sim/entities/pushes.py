"""External wrenches on bodies, applied for a number of physics steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.errors import RefusedError

Array = npt.NDArray[np.float64]

# Number of values of a push in a saved state.
_ROW = 12


@dataclass
class Push:
    """External force and torque on a body, for a number of physics steps.

    Attributes:
        body: Name of the body.
        force: Force along the world's axes, (3,), in N.
        torque: Torque along the world's axes, (3,), in N m.
        point: Point of application of the force in the body's frame, (3,), in metres.
        steps: Number of physics steps left.
        ramp: Number of last steps over which force and torque fade to zero.
    """

    body: str
    force: Array
    torque: Array
    point: Array
    steps: int
    ramp: int = 0


class Pushes:
    """All external wrenches of a simulation that are still active."""

    def __init__(self) -> None:
        self._active: list[Push] = []

    def __bool__(self) -> bool:
        return bool(self._active)

    def add(self, push: Push) -> None:
        """Add an external wrench, which acts from the next physics step on."""
        self._active.append(push)

    # Any stands for MuJoCo's model and data, which have no types.
    def end(self, body: str, data: Any) -> bool:
        """End all external wrenches on a body; return whether there were any."""
        before, self._active = self._active, [push for push in self._active if push.body != body]
        if not self._active:
            data.xfrc_applied[:] = 0.0
        return len(self._active) < len(before)

    def clear(self, data: Any) -> None:
        """End the external wrenches on all bodies."""
        self._active = []
        data.xfrc_applied[:] = 0.0

    def save(self, model: Any) -> Array:
        """Return all active wrenches as one array, for `read_pushes`."""
        rows = []
        for push in self._active:
            body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, push.body)
            if body >= 0:
                rows.append([body, *push.force, *push.torque, *push.point, push.steps, push.ramp])
        return np.array(rows, float).ravel()

    def begin_step(self, model: Any, data: Any) -> None:
        """Write the active wrenches into MuJoCo's data, and count the physics step that begins.

        Args:
            model: The ``mujoco.MjModel``; wrenches on bodies that it no longer has are ignored.
            data: Its ``mujoco.MjData``.
        """
        data.xfrc_applied[:] = 0.0
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        for push in self._active:
            body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, push.body)
            if body >= 0:
                share = min(1.0, push.steps / push.ramp) if push.ramp else 1.0
                place = data.xpos[body] + data.xmat[body].reshape(3, 3) @ push.point
                # MuJoCo's forces act at the centre of mass.
                turned = push.torque + np.cross(place - data.xipos[body], push.force)
                data.xfrc_applied[body] += share * np.concatenate([push.force, turned])
            push.steps -= 1

    def end_step(self, data: Any) -> None:
        """Remove the wrenches whose last step is over."""
        self._active = [push for push in self._active if push.steps > 0]
        if not self._active:
            data.xfrc_applied[:] = 0.0


# Any: likewise.
def read_pushes(model: Any, saved: Array) -> list[Push]:
    """Return the wrenches in an array that `Pushes.save` returned; raise if one is invalid.

    Raises:
        RefusedError: The array contains no valid wrenches.
    """
    found = []
    if saved.size % _ROW:
        raise RefusedError("The saved state is invalid: its wrenches are incomplete")
    for row in saved.reshape(-1, _ROW):
        body, steps, ramp = (int(row[place]) for place in (0, -2, -1))
        if not (0 <= body < model.nbody and steps > 0 and ramp >= 0):
            raise RefusedError("The saved state is invalid: it contains an invalid wrench")
        force, torque, point = np.split(row[1:10], 3)
        found.append(Push(model.body(body).name, force, torque, point, steps, ramp))
    return found
