"""Joint positions, velocities and efforts, copied out of MuJoCo's data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl.mujoco_model import drive_name, gravity_efforts
from teleopctl.sim.mjcf import BallJoints

if TYPE_CHECKING:
    from teleopctl.mujoco_model import JointSpec


class JointStates:
    """Positions, velocities and efforts of a robot's joints.

    Args:
        joints: The robot's movable joints.
        weightless: Links on which gravity does not act.

    Attributes:
        names: Names of the joints.
        values: Positions, velocities and efforts, (3, n).
        positions: Positions in rad or m, as of the last `read`, (n,).
        velocities: Velocities in rad/s or m/s, as of the last `read`, (n,).
        efforts: Efforts of the drives in N m or N, as of the last `read`, (n,).
    """

    def __init__(self, joints: Sequence[JointSpec], weightless: Sequence[str] = ()) -> None:
        self.names = tuple(joint.name for joint in joints)
        self.values = np.zeros((3, len(joints)))
        self.positions, self.velocities, self.efforts = self.values
        self._weightless = weightless
        self._joints = joints
        self._balls = BallJoints(joints)

    # Any stands for MuJoCo's types, which have no static ones.
    def bind(self, model: Any, data: Any) -> None:
        """Set the MuJoCo model and data that `read` copies from."""
        named = [model.joint(joint.ball or joint.name) for joint in self._joints]
        qpos = [int(joint.qposadr[0]) for joint in named]
        dof = [int(joint.dofadr[0]) for joint in named]
        self._m, self._d, self._dofs = model, data, dof
        self._lifted = np.array([model.body(name).id for name in self._weightless], dtype=int)
        self._driven = [
            (row, dof[row], int(model.actuator(drive_name(joint.name)).id), joint.limits.effort)
            for row, joint in enumerate(self._joints)
            if joint.has_drive
        ]
        self._effort_values: memoryview[float] = self.efforts.data.cast("B").cast("d")
        self._speeds: memoryview[float] = data.qvel.data
        self._speeds_before: memoryview[float] = data.actuator_velocity.data
        self._bias: memoryview[float] = model.actuator_biasprm.data
        # Memory views: numpy takes four times as long to copy a few numbers.
        self._copied = [
            (target.data[first:end], source.data[at : at + end - first])
            for source, places, target in (
                (data.qpos, qpos, self.positions),
                (data.qvel, dof, self.velocities),
                (data.qfrc_actuator, dof, self.efforts),
            )
            for first, end, at in _runs(places)
        ]

    def read(self, *, moving: bool = True) -> None:
        """Copy the joints' present positions, velocities and efforts into the arrays.

        Args:
            moving: Whether drives may accelerate anything.
        """
        for target, source in self._copied:
            target[:] = source
        if moving:
            self._correct_efforts()
        if self._weightless:
            # MuJoCo lifts weightless links by a force, which it counts as the joints' own effort.
            lifting = gravity_efforts(self._m, self._d, self._lifted)
            lifting[self._m.jnt_actgravcomp[self._m.dof_jntid] == 0] = 0.0
            self.efforts -= lifting[self._dofs]
        if self._balls:
            self._balls.read(self._d, self.positions, self.velocities)

    def _correct_efforts(self) -> None:
        """Correct the efforts for the integrator's implicit treatment of dampers.

        MuJoCo computes a damper's force with the speed at the beginning of a step, but applies it
        with the speed at the end of the step, except where a joint is at its effort limit.
        """
        for row, dof, drive, limit in self._driven:
            effort = self._effort_values[row]
            if abs(effort) < limit:
                gained = self._speeds[dof] - self._speeds_before[drive]
                # An impact on the joint may raise the value above the limit for one step.
                true = effort + self._bias[drive, 2] * gained
                self._effort_values[row] = min(max(true, -limit), limit)

    def put_balls(self, data: Any, given: Mapping[str, float]) -> None:
        """Set the rotation of each ball joint that has a given angle; its missing angles are 0."""
        self._balls.put(data, given)


def _runs(places: Sequence[int]) -> Iterator[tuple[int, int, int]]:
    """Yield each run of consecutive places: its first joint, end joint (exclusive) and place."""
    first = 0
    for end in range(1, len(places) + 1):
        if end == len(places) or places[end] != places[end - 1] + 1:
            yield first, end, places[first]
            first = end
