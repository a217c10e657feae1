"""Collision-free target positions for a robot's joints, for test commands."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

if TYPE_CHECKING:
    from teleopctl.mujoco_model import JointSpec
    from teleopctl.sim import Simulation

# Shapes closer than this (m) count as in contact: tracking errors of a drive are smaller.
_CLEARANCE_M = 1e-3
# Fractions of the step that are tried, and fractions of the path at which contacts are checked.
_PARTS = (1.0, -1.0, 0.5, -0.5, 0.25, -0.25)
_WAY = (0.25, 0.5, 0.75, 1.0)


def free_targets(
    simulation: Simulation, joints: Iterable[JointSpec], step: float
) -> dict[str, float]:
    """Return targets by joint, up to ``step`` away, without new contacts; omit joints without any.

    Joints are added one by one. A joint's target is its first position for which the straight path
    of all joints chosen so far has no contacts other than the present ones.

    Args:
        simulation: Simulation with the robot at its start; not changed.
        joints: Joints to move, in the order of the model.
        step: Largest distance in rad or m; reduced to half of the distance to the joint's limit.

    Returns:
        Target position by joint, in rad or m; a joint without such a position is left out.
    """
    ways = _Ways(simulation)
    targets: dict[str, float] = {}
    for joint in joints:
        here = ways.start[joint.name]
        up, down = joint.limits.upper - here, here - joint.limits.lower
        for part in _PARTS if up >= down else [-part for part in _PARTS]:
            room = (up if part > 0.0 else down) / 2
            target = here + float(np.sign(part)) * min(abs(part) * step, room)
            if room > 0.0 and ways.are_free({**targets, joint.name: target}):
                targets[joint.name] = target
                break
    return targets


class _Ways:
    """Straight ways from the present positions of a simulation's joints."""

    def __init__(self, simulation: Simulation) -> None:
        self._joints = simulation.model.joints
        self._m, data = simulation.observe()
        self._data = mujoco.MjData(self._m)
        self._qpos = np.array(data.qpos)
        self.start = {
            joint.name: float(data.joint(joint.name).qpos[0])
            for joint in self._joints
            if not joint.ball
        }
        self._touching = self._pairs({})

    def are_free(self, targets: Mapping[str, float]) -> bool:
        """Return whether joints move straight to ``targets`` together without new contacts."""
        return all(
            self._pairs(
                {
                    name: self.start[name] + part * (target - self.start[name])
                    for name, target in targets.items()
                }
            )
            <= self._touching
            for part in _WAY
        )

    def _pairs(self, positions: Mapping[str, float]) -> set[tuple[int, int]]:
        """Return the pairs of geoms in contact with joints, and their mimics, at ``positions``."""
        data: Any = self._data
        data.qpos[:] = self._qpos
        for joint in self._joints:
            mimic = joint.mimic
            if joint.name in positions:
                data.joint(joint.name).qpos[0] = positions[joint.name]
            elif mimic is not None and mimic.joint in positions:
                follows = mimic.multiplier * positions[mimic.joint] + mimic.offset
                data.joint(joint.name).qpos[0] = follows
        mujoco.mj_kinematics(self._m, data)
        mujoco.mj_comPos(self._m, data)
        mujoco.mj_collision(self._m, data)
        return {
            (int(contact.geom1), int(contact.geom2))
            for contact in data.contact
            if contact.dist < _CLEARANCE_M
        }
