"""Physics of one robot: commands in, time forward, joint states out. Knows nothing of ROS.

Time is counted in control periods and physics steps, both integers, so a run is the same each
time: the same commands at the same ticks give the same bits.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.mujoco_model import (
    RobotModel,
    compensated_bodies,
    drive_name,
    initial_positions,
    motor_name,
)

Array = npt.NDArray[np.float64]

_POSITION, _VELOCITY, _EFFORT = range(3)

# Closer than this (rad or m) a set-point has arrived.
_ARRIVED = 1e-9

_DIVERGED = (
    mujoco.mjtWarning.mjWARN_BADQPOS,
    mujoco.mjtWarning.mjWARN_BADQVEL,
    mujoco.mjtWarning.mjWARN_BADQACC,
)


class Simulation:
    """A robot model in motion.

    Args:
        model: The robot.
        control_period_ns: Time between two control ticks, in nanoseconds.
        timestep_ns: Longest physics step; the step used divides the control period evenly.

    Attributes:
        joint_names: The joints of all arrays below, in the order of the model.
        positions: Joint positions (rad or m) as of the last `read`.
        velocities: Joint velocities (rad/s or m/s) as of the last `read`.
        efforts: What the drives exert (N m or N) as of the last `read`.
        control_period_ns: Time between two control ticks.
        steps_per_period: Physics steps in one control period.
    """

    def __init__(
        self, model: RobotModel, *, control_period_ns: int, timestep_ns: int = 1_000_000
    ) -> None:
        self.model = model
        self.control_period_ns = control_period_ns
        self.steps_per_period = -(-control_period_ns // timestep_ns)
        # Gains and gravity compensation change while running: on a copy of its own.
        self._m: Any = copy.copy(model.mj_model)
        self._m.opt.timestep = control_period_ns * 1e-9 / self.steps_per_period
        # Sensors are computed when they are read, on a copy: who looks changes nothing.
        self._m.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_SENSOR
        self._d: Any = mujoco.MjData(self._m)
        self._observed: Any = None

        joints = model.joints
        self.joint_names = tuple(joint.name for joint in joints)
        self._qpos = np.array([self._m.joint(j.name).qposadr[0] for j in joints], dtype=int)
        self._dof = np.array([self._m.joint(j.name).dofadr[0] for j in joints], dtype=int)
        self.positions: Array = np.zeros(len(joints))
        self.velocities: Array = np.zeros(len(joints))
        self.efforts: Array = np.zeros(len(joints))
        self._tick = 0
        self._substep = 0
        self._index_drives()
        self.reset_state()

    def _index_drives(self) -> None:
        m = self._m
        driven = [
            (index, joint)
            for index, joint in enumerate(self.model.joints)
            if joint.command_interfaces
        ]
        self._drive_of = {joint.name: row for row, (_, joint) in enumerate(driven)}
        self._drive = np.array([m.actuator(drive_name(j.name)).id for _, j in driven], dtype=int)
        self._act = np.array([m.actuator_actadr[drive] for drive in self._drive], dtype=int)
        self._drive_qpos = np.array([self._qpos[index] for index, _ in driven], dtype=int)
        self._drive_dof = np.array([self._dof[index] for index, _ in driven], dtype=int)
        self._motor = np.array(
            [
                m.actuator(motor_name(j.name)).id if "effort" in j.command_interfaces else -1
                for _, j in driven
            ],
            dtype=int,
        )
        self._accepts = np.array(
            [
                [name in joint.command_interfaces for _, joint in driven]
                for name in ("position", "velocity", "effort")
            ],
            dtype=bool,
        ).reshape(3, len(driven))
        self._lower: Array = np.array([joint.limits.lower for _, joint in driven])
        self._upper: Array = np.array([joint.limits.upper for _, joint in driven])
        self._max_speed: Array = np.array([joint.limits.velocity for _, joint in driven])
        stiffness = m.actuator_gainprm[self._drive, 0]
        effort = np.array([joint.limits.effort for _, joint in driven])
        # How far a set-point may run ahead of a joint that something holds back.
        self._max_lead: Array = effort / stiffness
        self._gain = np.array(m.actuator_gainprm[self._drive])
        self._bias = np.array(m.actuator_biasprm[self._drive])
        self._command_names: tuple[str, ...] = ()
        self._command_rows = np.zeros(0, dtype=int)
        self._command_columns = np.zeros(0, dtype=int)
        # Dofs that hold themselves: the followers of driven joints.
        self._followers = np.array(
            [
                self._dof[index]
                for index, joint in enumerate(self.model.joints)
                if joint.mimic is not None and joint.mimic.joint in self._drive_of
            ],
            dtype=int,
        )

    # --- time -----------------------------------------------------------------------------

    @property
    def time_ns(self) -> int:
        """Simulated time since the last reset, in nanoseconds."""
        rest = self.control_period_ns * self._substep // self.steps_per_period
        return self._tick * self.control_period_ns + rest

    @property
    def timestep_s(self) -> float:
        """The physics step, in seconds."""
        return float(self._m.opt.timestep)

    @property
    def at_tick(self) -> bool:
        """Whether a control period begins now."""
        return self._substep == 0

    @property
    def steps_to_tick(self) -> int:
        """Physics steps from now to the next control tick, at least one."""
        return self.steps_per_period - self._substep

    def steps_until(self, time_ns: int) -> int:
        """Physics steps from now to the first one at or after a time; 0 if it has passed."""
        tick, rest = divmod(time_ns, self.control_period_ns)
        within = -(-rest * self.steps_per_period // self.control_period_ns)
        wanted = tick * self.steps_per_period + within
        return max(0, wanted - self._tick * self.steps_per_period - self._substep)

    def step(self, count: int) -> None:
        """Advance by a number of physics steps."""
        while count > 0:
            if self._substep == 0:
                self._plan_period()
            block = min(count, self.steps_per_period - self._substep)
            mujoco.mj_step(self._m, self._d, block)
            count -= block
            self._substep += block
            if self._substep == self.steps_per_period:
                self._substep = 0
                self._tick += 1

    def step_to(self, time_ns: int) -> None:
        """Advance to the first physics step at or after a time."""
        self.step(self.steps_until(time_ns))

    def reset(self) -> None:
        """Back to time zero, initial positions and no commands."""
        self.reset_state()
        self._tick = 0
        self._substep = 0

    def reset_state(self) -> None:
        """Back to the initial positions, at rest and without commands; time stays."""
        mujoco.mj_resetData(self._m, self._d)
        self._d.qpos[:] = initial_positions(self._m, self.model.joints)
        count = len(self._drive)
        self._mode = np.full(count, _POSITION)
        self._target = np.clip(self._d.qpos[self._drive_qpos], self._lower, self._upper)
        self._speed = np.zeros(count)
        self._d.act[self._act] = self._target
        self._apply_modes()
        mujoco.mj_forward(self._m, self._d)
        self.read()

    # --- commands -------------------------------------------------------------------------

    def apply(
        self,
        names: Sequence[str],
        position: Sequence[float] = (),
        velocity: Sequence[float] = (),
        effort: Sequence[float] = (),
    ) -> None:
        """Take commands for the control period that begins now.

        Position wins over velocity, velocity over effort, where a joint is commanded more than
        one. A joint without a finite command holds where it is. Positions are kept within the
        joint's limits. Names that are not commandable are passed over; `commandable` tells.

        Args:
            names: Joint names.
            position: Positions (rad or m), one per name, NaN for none; or empty.
            velocity: Velocities (rad/s or m/s) in the same way.
            effort: Efforts (N m or N) in the same way.
        """
        if tuple(names) != self._command_names:
            self._index_command(tuple(names))
        wanted_position = self._by_drive(position, _POSITION)
        wanted_velocity = self._by_drive(velocity, _VELOCITY)
        wanted_effort = self._by_drive(effort, _EFFORT)
        by_position = np.isfinite(wanted_position)
        by_velocity = np.isfinite(wanted_velocity) & ~by_position
        by_effort = np.isfinite(wanted_effort) & ~by_position & ~by_velocity
        self._set_modes(by_velocity, by_effort)
        self._target[by_position] = np.clip(wanted_position, self._lower, self._upper)[by_position]
        self._speed[by_velocity] = wanted_velocity[by_velocity]
        self._d.ctrl[self._motor[by_effort]] = wanted_effort[by_effort]

    def hold(self) -> None:
        """Nobody commands any more: every joint stays where it is or was last sent."""
        nothing = np.zeros(len(self._drive), dtype=bool)
        self._set_modes(nothing, nothing)

    def commandable(self, name: str) -> bool:
        """Whether a joint takes commands."""
        return name in self._drive_of

    def _index_command(self, names: tuple[str, ...]) -> None:
        known = [
            (self._drive_of[name], column)
            for column, name in enumerate(names)
            if name in self._drive_of
        ]
        self._command_names = names
        self._command_rows = np.array([row for row, _ in known], dtype=int)
        self._command_columns = np.array([column for _, column in known], dtype=int)

    def _by_drive(self, values: Sequence[float], interface: int) -> Array:
        """Values ordered by drive; NaN where there is none or the joint does not take it."""
        ordered = np.full(len(self._drive), np.nan)
        if len(values) == len(self._command_names) and len(values) > 0:
            ordered[self._command_rows] = np.asarray(values, dtype=float)[self._command_columns]
            ordered[~self._accepts[interface]] = np.nan
        return ordered

    def _set_modes(
        self, by_velocity: npt.NDArray[np.bool_], by_effort: npt.NDArray[np.bool_]
    ) -> None:
        mode = np.full(len(self._drive), _POSITION)
        mode[by_velocity] = _VELOCITY
        mode[by_effort] = _EFFORT
        if np.array_equal(mode, self._mode):
            return
        # A drive that takes over starts from where the joint is, not from an old set-point.
        now = np.clip(self._d.qpos[self._drive_qpos], self._lower, self._upper)
        from_effort = (self._mode == _EFFORT) & (mode != _EFFORT)
        self._d.act[self._act[from_effort]] = now[from_effort]
        released = (mode == _POSITION) & (self._mode != _POSITION)
        self._target[released] = now[released]
        self._mode = mode
        self._apply_modes()

    def _apply_modes(self) -> None:
        """Switch between drives and motors, and what of the robot's weight the drives carry."""
        by_effort = self._mode == _EFFORT
        self._m.actuator_gainprm[self._drive] = np.where(by_effort[:, None], 0.0, self._gain)
        self._m.actuator_biasprm[self._drive] = np.where(by_effort[:, None], 0.0, self._bias)
        motors = self._motor[(self._motor >= 0) & ~by_effort]
        self._d.ctrl[motors] = 0.0
        unsupported = np.ones(self._m.nv, dtype=bool)
        unsupported[self._drive_dof[~by_effort]] = False
        unsupported[self._followers] = False
        self._m.body_gravcomp[:] = compensated_bodies(self._m, unsupported)

    def _plan_period(self) -> None:
        """Set the velocity of every set-point for the control period that begins."""
        setpoint = self._d.act[self._act]
        seconds = self.control_period_ns * 1e-9
        away = self._target - setpoint
        arrived = (self._mode == _POSITION) & (np.abs(away) < _ARRIVED)
        setpoint[arrived] = self._target[arrived]
        away[arrived] = 0.0
        speed = np.where(self._mode == _VELOCITY, self._speed, away / seconds)
        np.clip(speed, -self._max_speed, self._max_speed, out=speed)
        speed[self._mode == _EFFORT] = 0.0
        moving = self._mode == _VELOCITY
        if moving.any():
            actual = self._d.qpos[self._drive_qpos]
            lead = np.clip(setpoint - actual, -self._max_lead, self._max_lead)
            setpoint[moving] = (actual + lead)[moving]
        self._d.act[self._act] = setpoint
        self._d.ctrl[self._drive] = speed

    # --- state ----------------------------------------------------------------------------

    def read(self) -> None:
        """Copy the present joint states into `positions`, `velocities` and `efforts`."""
        np.take(self._d.qpos, self._qpos, out=self.positions)
        np.take(self._d.qvel, self._dof, out=self.velocities)
        np.take(self._d.qfrc_actuator, self._dof, out=self.efforts)

    def observe(self) -> tuple[Any, Any]:
        """MuJoCo's model, and a copy of its data with what its sensors measure at this time.

        Both are of MuJoCo's own types, which have no static ones. They are good until the next
        step.
        """
        if self._observed is None:
            self._observed = mujoco.MjData(self._m)
        mujoco.mj_copyData(self._observed, self._m, self._d)
        self._m.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
        mujoco.mj_forward(self._m, self._observed)
        self._m.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_SENSOR
        return self._m, self._observed

    def link_position(self, link: str) -> Array:
        """Where a link's frame is in the world, in metres."""
        mujoco.mj_kinematics(self._m, self._d)
        return np.array(self._d.body(link).xpos)

    @property
    def diverged(self) -> bool:
        """Whether physics has broken down since the last reset; MuJoCo then starts it anew."""
        return any(self._d.warning[kind].number > 0 for kind in _DIVERGED)
