"""Recovery from diverging physics: unstable objects are reset, everything else continues.

MuJoCo resets a whole simulation if a single number diverges. If that number belongs to an object
around the robot, the block of steps is repeated with that object at its start and at rest, so that
a crate of 1e300 kg does not make the robot jump.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from teleopctl.sim.state.physics import Array

if TYPE_CHECKING:
    from teleopctl.mujoco_model import RobotModel
    from teleopctl.sim.state.slip_correction import PhysicsStepper

# Integers, since MuJoCo's enumerations are slow as numbers. _ALL is all that a step starts from, to
# the last bit.
_ALL = int(mujoco.mjtState.mjSTATE_INTEGRATION)
_W = mujoco.mjtWarning
_BAD_POSITION = int(_W.mjWARN_BADQPOS)
_BROKEN = (_BAD_POSITION, int(_W.mjWARN_BADQVEL), int(_W.mjWARN_BADQACC))


class DivergenceRecovery:
    """Stepper that resets objects of the world whose physics becomes unstable.

    Args:
        robot: Model of the robot and its world.
        model: The robot's ``mujoco.MjModel``, or a copy of it.
        data: Its ``mujoco.MjData``.
        physics: Stepper of the physics.
    """

    # Any stands for MuJoCo's types, here and below: they have no static ones.
    def __init__(self, robot: RobotModel, model: Any, data: Any, physics: PhysicsStepper) -> None:
        self._robot, self._m, self._d, self._physics = robot, model, data, physics
        # A memory view is faster to read than numpy's array.
        self._numbers = memoryview(data.warning.number)
        names = {model.body(thing.name).id: thing.name for thing in robot.things}
        # Name of the object of each degree of freedom; empty for the robot.
        roots = model.body_rootid[model.dof_bodyid].tolist()
        self._owners = [names.get(root, "") for root in roots]
        self._kept: Array | None = None
        if any(self._owners):
            self._kept = np.zeros(mujoco.mj_stateSize(model, _ALL))

    @property
    def broken(self) -> bool:
        """Whether the robot's physics has become unstable since the last reset of states."""
        numbers = self._numbers
        position, velocity, acceleration = _BROKEN
        return bool(numbers[position] or numbers[velocity] or numbers[acceleration])

    def step(self, count: int) -> list[str]:
        """Advance by physics steps; return the names of objects that were reset meanwhile.

        Returns:
            Names of the objects that diverged, and have made these steps from their start.
        """
        if self._kept is None:
            self._physics.step(self._d, count)
            return []
        mujoco.mj_getState(self._m, self._d, self._kept, _ALL)
        slid = self._physics.save() if self._physics.slides else None
        self._physics.step(self._d, count)
        found: list[str] = []
        while self.broken and (thing := self._diverged_object()) and thing not in found:
            found.append(thing)
            mujoco.mj_setState(self._m, self._d, self._kept, _ALL)
            if slid is not None:
                self._physics.restore(slid)
            for number in _BROKEN:
                self._numbers[number] = 0
            self._put_back(found)
            self._physics.step(self._d, count)
        return [] if self.broken else found

    def _diverged_object(self) -> str:
        """Return the object of the first number that diverged; empty for the robot."""
        for kind in _BROKEN:
            if self._numbers[kind]:
                number = int(self._d.warning[kind].lastinfo)
                if kind == _BAD_POSITION:
                    joint = int(np.searchsorted(self._m.jnt_qposadr, number, "right")) - 1
                    number = int(self._m.jnt_dofadr[joint])
                return self._owners[number]
        return ""

    def _put_back(self, things: list[str]) -> None:
        m, d = self._m, self._d
        start = mujoco.MjData(m)
        self._robot.put_at_start(m, start)
        dofs = np.flatnonzero([owner in things for owner in self._owners])
        for field in ("qvel", "qacc_warmstart", "qfrc_applied"):
            getattr(d, field)[dofs] = 0.0
        bodies = m.dof_bodyid[dofs]
        d.xfrc_applied[bodies] = 0.0
        for joint in np.flatnonzero(np.isin(m.jnt_bodyid, bodies)):
            first = int(m.jnt_qposadr[joint])
            last = int(m.jnt_qposadr[joint + 1]) if joint + 1 < m.njnt else m.nq
            d.qpos[first:last] = start.qpos[first:last]
