"""The drives of a simulated robot: commands in, set-points and gains of MuJoCo's actuators out.

How a drive works is told in `teleopctl.mujoco_model.drives`, which builds the actuators; here
they are switched between positions, velocities and efforts, and led from period to period.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from teleopctl.mujoco_model import (
    DRIVE_RAD_S,
    compensated_bodies,
    drive_name,
    motor_name,
)
from teleopctl.sim.state.set_points import fed_speed, lost_distance, way_there
from teleopctl.sim.state.tuning import MovedInertia, drive_rates

if TYPE_CHECKING:
    import mujoco

    from teleopctl.mujoco_model import JointSpec

Array = npt.NDArray[np.float64]

_POSITION, _VELOCITY, _EFFORT = range(3)

# On a velocity command the spring is weak, its damper the same: the joint takes up a new speed as
# a first-order system with the fast one of the two poles; the slow one (rad/s) removes what a load
# leaves. At equal poles, joints that shake one another would overshoot by 4 %.
_SLOW_POLE_RAD_S = 5.0

# The shortest time in which a joint on a velocity command brakes before its limits, in seconds:
# two time constants of its drive.
_BRAKING_S = 0.01

# What a drive remembers from one period to the next.
_STATE = (
    *("_mode", "_target", "_wanted_speed", "_setpoint", "_setpoint_speed", "_speed_before"),
    *("_fed_forward", "_planned_target", "_stiffness", "_inertia", "_tuned_at"),
)

# A drive is tuned anew when joints have moved so far (rad or m): a joint's inertia then differs by
# a few percent at most.
_TUNED_WITHIN = 0.05

# So that a joint of no effort has a way to go (N m or N).
_LEAST_EFFORT = 1e-6

# Closer than this (rad or m) a set-point has arrived.
_ARRIVED = 1e-9


class Drives:
    """The drives of a robot's joints.

    Args:
        model: The ``mujoco.MjModel``, whose gains change while running.
        data: Its ``mujoco.MjData``.
        joints: The robot's movable joints.
        period_s: Time between two commands, in seconds.
        others: The topmost bodies of what is not the robot, whose weight is their own matter.

    Attributes:
        settled: Whether `plan_period` would change nothing: set-points stand still, and nothing
            was commanded since.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        joints: Sequence[JointSpec],
        period_s: float,
        others: Iterable[str] = (),
    ) -> None:
        self._m = m = model
        self._d = data
        self._joints = joints
        self._period_s = period_s
        driven = [joint for joint in joints if joint.has_drive]
        self._drive_of = {joint.name: row for row, joint in enumerate(driven)}
        self._drive = np.array([m.actuator(drive_name(j.name)).id for j in driven], dtype=int)
        self._act = np.array([m.actuator_actadr[drive] for drive in self._drive], dtype=int)
        self._qpos = np.array([m.joint(j.name).qposadr[0] for j in driven], dtype=int)
        self._dof = np.array([m.joint(j.name).dofadr[0] for j in driven], dtype=int)
        self._motor = np.array(
            [
                m.actuator(motor_name(j.name)).id if "effort" in j.command_interfaces else -1
                for j in driven
            ],
            dtype=int,
        )
        self._accepts = np.array(
            [
                [name in joint.command_interfaces for joint in driven]
                for name in ("position", "velocity", "effort")
            ],
            dtype=bool,
        ).reshape(3, len(driven))
        self._lower: Array = np.array([joint.limits.lower for joint in driven])
        self._upper: Array = np.array([joint.limits.upper for joint in driven])
        self._max_speed: Array = np.array([joint.limits.velocity for joint in driven])
        self._gain = np.array(m.actuator_gainprm[self._drive])
        self._bias = np.array(m.actuator_biasprm[self._drive])
        self._limited = np.array(m.actuator_actlimited[self._drive], dtype=bool)
        self._rate = rate = drive_rates(self._accepts[_POSITION], period_s, m.opt.timestep)
        fast_pole = 2.0 * rate - _SLOW_POLE_RAD_S
        # Of the spring on a velocity command, as a part of the other one.
        self._speed_stiffness = _SLOW_POLE_RAD_S * fast_pole / rate**2
        self._speed_lag_s = 1.0 / fast_pole
        # What turns without end is a wheel: its pose changes nothing.
        self._posed = np.isfinite(self._lower) & np.isfinite(self._upper)
        self._moved = MovedInertia(
            m, joints, list(self._drive_of), self._gain[:, 0] / DRIVE_RAD_S**2
        )
        # What the joint itself loses to its bearings at 1 rad/s, which a drive is tuned to.
        self._drag: Array = np.array(m.dof_damping[self._dof])
        self._effort: Array = np.array([joint.limits.effort for joint in driven])
        roots = [m.body(name).id for name in others]
        self._own = ~np.isin(m.body_rootid, roots)
        self._weightless = np.zeros(0, dtype=int)
        self.settled = False
        self._command_names: tuple[str, ...] = ()
        self._command_rows = np.zeros(0, dtype=int)
        self._command_columns = np.zeros(0, dtype=int)
        # Dofs that hold themselves: the followers of driven joints.
        self._followers = np.array(
            [
                m.joint(joint.name).dofadr[0]
                for joint in joints
                if joint.mimic is not None and joint.mimic.joint in self._drive_of
            ],
            dtype=int,
        )

    def reset(self) -> None:
        """Stand still where the joints are, without commands."""
        self.settled = False
        count = len(self._drive)
        self._mode = np.full(count, _POSITION)
        self._target = np.clip(self._d.qpos[self._qpos], self._lower, self._upper)
        self._wanted_speed = np.zeros(count)
        self._setpoint: Array = np.array(self._target)
        self._setpoint_speed: Array = np.zeros(count)
        self._speed_before: Array = np.zeros(count)
        self._fed_forward: Array = np.zeros(count)
        self._planned_target: Array = np.array(self._target)
        self._d.act[self._act] = self._setpoint
        self._tuned_at: Array = np.array(self._d.qpos[self._qpos])
        self._inertia = self._moved.at(self._d)
        self._tune()
        self._stiffness: Array = np.array(self._gain[:, 0])
        self._apply_modes()

    def moved_to(self, model: mujoco.MjModel, data: mujoco.MjData, others: Iterable[str]) -> Drives:
        """Return the same drives, with all that they were told, in another model of the robot.

        Args:
            model: The other ``mujoco.MjModel``, whose gains change while running.
            data: Its ``mujoco.MjData``, in the state of the one so far.
            others: See `Drives`.
        """
        moved = Drives(model, data, self._joints, self._period_s, others)
        moved.leave_alone(self._m.body(body).name for body in self._weightless)
        for name in _STATE:
            setattr(moved, name, getattr(self, name))
        moved._tune()
        moved._apply_modes()
        return moved

    def save(self) -> dict[str, Array]:
        """What the drives remember, by name."""
        return {f"drives{name}": np.array(getattr(self, name), float) for name in _STATE}

    def restore(self, saved: Mapping[str, Array]) -> None:
        """Remember what `save` returned."""
        for name in _STATE:
            setattr(self, name, np.array(saved[f"drives{name}"]))
        self._mode = self._mode.astype(int)
        self.settled = False
        self._tune()
        self._apply_modes()

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
        self.settled = False
        if tuple(names) != self._command_names:
            self._index_command(tuple(names))
        wanted_position = self._by_drive(position, _POSITION)
        wanted_velocity = self._by_drive(velocity, _VELOCITY)
        wanted_effort = self._by_drive(effort, _EFFORT)
        by_position = np.isfinite(wanted_position)
        by_velocity = np.isfinite(wanted_velocity) & ~by_position
        by_effort = np.isfinite(wanted_effort) & ~by_position & ~by_velocity
        self._follow_pose()
        self._set_modes(by_velocity, by_effort)
        self._target[by_position] = np.clip(wanted_position, self._lower, self._upper)[by_position]
        self._wanted_speed[by_velocity] = wanted_velocity[by_velocity]
        self._d.ctrl[self._motor[by_effort]] = wanted_effort[by_effort]

    def hold(self) -> None:
        """Nobody commands any more: every joint stays where it is or was last sent."""
        self.settled = False
        nothing = np.zeros(len(self._drive), dtype=bool)
        self._set_modes(nothing, nothing)

    def commandable(self, name: str) -> bool:
        """Whether a joint takes commands."""
        return name in self._drive_of

    def _apply_gains(self) -> None:
        by_effort = (self._mode == _EFFORT)[:, None]
        gain, bias = np.array(self._gain), np.array(self._bias)
        gain[:, 0], bias[:, 1] = self._stiffness, -self._stiffness
        self._m.actuator_gainprm[self._drive] = np.where(by_effort, 0.0, gain)
        self._m.actuator_biasprm[self._drive] = np.where(by_effort, 0.0, bias)

    @property
    def moving(self) -> bool:
        """Whether any set-point moves in this control period."""
        return bool(self._setpoint_speed.any())

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

    def _follow_pose(self) -> None:
        """Tune the drives to what they move in the pose of now, where it has changed."""
        actual = self._d.qpos[self._qpos]
        if not (np.abs(actual - self._tuned_at) > _TUNED_WITHIN)[self._posed].any():
            return
        self._tuned_at, self._inertia = actual, self._moved.at(self._d)
        self._tune()
        self._stretch(self._mode, actual)
        self._apply_gains()

    def _tune(self) -> None:
        """Work out springs, dampers and accelerations for the inertia that is moved."""
        self._gain[:, 0] = self._inertia * self._rate**2
        self._bias[:, 1] = -self._gain[:, 0]
        self._damping: Array = 2.0 * self._inertia * self._rate
        self._bias[:, 2] = -self._damping
        self._acceleration: Array = np.maximum(self._effort, _LEAST_EFFORT) / self._inertia
        # The change of speed that the damper alone answers with all the joint's effort, or what
        # that does in a quarter of a period that is not long.
        at_once = np.maximum(0.5 / self._rate, min(0.25 * self._period_s, 0.5 / DRIVE_RAD_S))
        self._speed_step: Array = self._acceleration * at_once

    def _stretch(self, mode: npt.NDArray[np.intp], actual: Array) -> None:
        """Take other springs, stretched so that they carry the same load."""
        stiffness = self._gain[:, 0] * np.where(mode == _VELOCITY, self._speed_stiffness, 1.0)
        lead = (self._setpoint - actual) * self._stiffness / stiffness
        self._setpoint = np.where(stiffness == self._stiffness, self._setpoint, actual + lead)
        self._stiffness = stiffness

    def _set_modes(
        self, by_velocity: npt.NDArray[np.bool_], by_effort: npt.NDArray[np.bool_]
    ) -> None:
        mode = np.full(len(self._drive), _POSITION)
        mode[by_velocity] = _VELOCITY
        mode[by_effort] = _EFFORT
        if np.array_equal(mode, self._mode):
            return
        # A drive that takes over starts from where the joint is, not from an old set-point.
        actual = self._d.qpos[self._qpos]
        now = np.clip(actual, self._lower, self._upper)
        from_effort = (self._mode == _EFFORT) & (mode != _EFFORT)
        self._setpoint[from_effort] = now[from_effort]
        released = (mode == _POSITION) & (self._mode != _POSITION)
        self._target[released] = now[released]
        self._stretch(mode, actual)
        self._mode = mode
        self._apply_modes()

    def _apply_modes(self) -> None:
        """Switch between drives and motors, and what of the robot's weight the drives carry."""
        self._apply_gains()
        by_effort = self._mode == _EFFORT
        # The range keeps a position's set-point off the stops; speeds are kept within them instead.
        self._m.actuator_actlimited[self._drive] = self._limited & (self._mode != _VELOCITY)
        motors = self._motor[(self._motor >= 0) & ~by_effort]
        self._d.ctrl[motors] = 0.0
        if not len(self._drive):
            return  # what an MJCF file says of its weight holds
        unsupported = np.ones(self._m.nv, dtype=bool)
        unsupported[self._dof[~by_effort]] = False
        unsupported[self._followers] = False
        carried = compensated_bodies(self._m, unsupported)
        carried[self._weightless] = 1.0
        self._m.body_gravcomp[self._own] = carried[self._own]

    def leave_alone(self, links: Iterable[str]) -> None:
        """Name the links on which gravity does not act, before the first reset.

        A joint that moves nothing else carries nothing. One that moves others too counts what lifts
        these links among the effort that it can exert.
        """
        m = self._m
        self._weightless = np.array([m.body(name).id for name in links], dtype=int)
        loaded = set(range(m.nbody)) - set(map(int, self._weightless))
        for body in sorted(loaded, reverse=True):
            loaded.add(int(m.body_parentid[body]))
        for joint in range(m.njnt) if len(self._weightless) else ():
            if int(m.jnt_bodyid[joint]) not in loaded:
                m.jnt_actgravcomp[joint] = 0

    def plan_period(self) -> None:
        """Set the path of every set-point for the control period that begins."""
        setpoint = self._setpoint
        away = self._target - setpoint
        arrived = (self._mode == _POSITION) & (np.abs(away) < _ARRIVED)
        setpoint[arrived] = self._target[arrived]
        away[arrived] = 0.0
        moving = self._mode == _VELOCITY
        fresh = self._target != self._planned_target
        before = self._setpoint_speed, self._speed_before
        speed = way_there(
            away, before[0], fresh, self._max_speed, self._acceleration, self._period_s
        )
        if moving.any():
            wanted = self._within_stops(self._wanted_speed)
            np.copyto(speed, np.clip(wanted, -self._max_speed, self._max_speed), where=moving)
        speed[self._mode == _EFFORT] = 0.0
        if moving.any():
            actual = self._d.qpos[self._qpos]
            # The spring is stretched no further than for the effort that the damper leaves it: what
            # holds the joint back does not wind it up.
            pull = self._damping * (self._setpoint_speed - self._d.qvel[self._dof])
            most = np.clip(self._effort - pull, 0.0, self._effort) / self._stiffness
            least = -np.clip(self._effort + pull, 0.0, self._effort) / self._stiffness
            lead = np.clip(setpoint - actual, least, most)
            # A change of speed asks for no distance to be made up.
            change = speed - self._setpoint_speed
            lead -= lost_distance(change, self._speed_lag_s, self._acceleration)
            setpoint[moving] = (actual + lead)[moving]
        arrives = fresh & (np.abs(away - speed * self._period_s) <= 1e-6 * np.abs(away))
        fed = fed_speed(speed, arrives, self._fed_forward, before, self._speed_step)
        fed[moving] = speed[moving]
        # The damper pulls at the joint's absolute speed: stretching the spring by
        # damping * speed / stiffness makes that the difference from the set-point's speed.
        stretch = fed * (self._damping + self._drag) / self._stiffness
        self._d.act[self._act] = setpoint + stretch
        self._d.ctrl[self._drive] = speed
        self._speed_before, self._setpoint_speed = self._setpoint_speed, speed
        self._fed_forward = fed
        self._planned_target[:] = self._target
        self._setpoint = setpoint + speed * self._period_s
        # MuJoCo keeps a set-point that does not move, unless it lies outside of its range.
        self.settled = not (moving.any() or speed.any() or fed.any()) and bool(
            ((setpoint >= self._lower) & (setpoint <= self._upper)).all()
        )

    def _within_stops(self, speed: Array) -> Array:
        """Speeds that end at the joints' limits, not beyond them."""
        rest = self._d.qpos[self._qpos] + self._d.qvel[self._dof] * self._speed_lag_s
        braking = max(self._period_s, _BRAKING_S)
        lowest = np.minimum(self._lower - rest, 0.0) / braking
        highest = np.maximum(self._upper - rest, 0.0) / braking
        return np.clip(speed, lowest, highest)
