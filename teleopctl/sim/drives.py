"""Joint drives of a simulated robot: commands to set-points and gains of MuJoCo's actuators.

How a drive works is described in `teleopctl.mujoco_model.drives`, which builds the actuators. This
module switches them between positions, velocities and efforts, and plans their set-points for each
control period.

The work of each period loops over lists of drives: for less than a few dozen drives, calls of numpy
take several times as long.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from teleopctl.mujoco_model import DRIVE_RAD_S, compensated_bodies, drive_name, motor_name
from teleopctl.robot import clamped_command_text
from teleopctl.sim.state.set_points import (
    feedforward_speed,
    goes_on_from_joint,
    lag_distance,
    limited_lead,
    position_speed,
    speed_within_limits,
)
from teleopctl.sim.state.tuning import MovedInertia, drive_rates

if TYPE_CHECKING:
    import mujoco

    from teleopctl.mujoco_model import JointSpec

Array = npt.NDArray[np.float64]

_POSITION, _VELOCITY, _EFFORT = range(3)
_INTERFACES = "position", "velocity", "effort"
_NONE = float("nan")

# On a velocity command the spring is weak, and the damper is the same: the joint reaches a new
# speed as a first-order system with the fast one of the two poles; the slow pole (rad/s) removes
# the error that a load leaves. With equal poles, joints that disturb one another would overshoot by
# 4 %.
_SLOW_POLE_RAD_S = 5.0

# State of the drives from one period to the next.
_STATE = (
    *("_mode", "_target", "_wanted_speed", "_setpoint", "_setpoint_speed", "_speed_before"),
    *("_fed_forward", "_planned_target", "_stiffness", "_inertia", "_tuned_at"),
)

# Drives are tuned again when a joint has moved by more than this (rad or m): within it, a joint's
# inertia differs by a few percent at most.
_TUNED_WITHIN = 0.05

# Least effort (N m or N) for accelerations, so that a joint with an effort limit of 0 has one too.
_LEAST_EFFORT = 1e-6

# Distance of a command outside the limits (rad or m, N m or N) below which it is not reported: a
# joint that is held where it was measured at its stop is this little beyond it.
_ROUNDING = 1e-5

# Closer than this (rad or m) a set-point has arrived.
_ARRIVED = 1e-9


class Drives:
    """Drives of a robot's joints: MuJoCo actuators for position, velocity and effort commands.

    Args:
        model: The ``mujoco.MjModel``, whose gains change at run time.
        data: Its ``mujoco.MjData``.
        joints: The robot's movable joints.
        period_s: Time between two commands, in seconds.
        others: Topmost bodies that are not of the robot, whose weight no drive carries.

    Attributes:
        settled: Whether `plan_period` would change nothing: set-points stand still, and nothing
            was commanded since.
        cut: A sentence for each joint's first command beyond its limits.
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
        # Memory views: numpy takes several times as long to read or write one number.
        self._act, self._ctrl = data.act.data, data.ctrl.data
        self._positions, self._speeds = data.qpos.data, data.qvel.data
        self._period_s = period_s
        driven = [joint for joint in joints if joint.has_drive]
        self._drive_of = {joint.name: row for row, joint in enumerate(driven)}
        self._drive = np.array([m.actuator(drive_name(j.name)).id for j in driven], dtype=int)
        named = [m.joint(joint.name) for joint in driven]
        self._qpos = np.array([joint.qposadr[0] for joint in named], dtype=int)
        self._dof = np.array([joint.dofadr[0] for joint in named], dtype=int)
        places = (self._drive, m.actuator_actadr[self._drive], self._qpos, self._dof)
        self._places = list(zip(*(column.tolist() for column in places), strict=True))
        self._joint_names = [joint.name for joint in driven]
        self._accepts = [[name in j.command_interfaces for name in _INTERFACES] for j in driven]
        self._motor = [
            int(m.actuator(motor_name(joint.name)).id) if accepts[_EFFORT] else -1
            for joint, accepts in zip(driven, self._accepts, strict=True)
        ]
        # Mechanical limits: controllers enforce those of control. A drive limits the speed on the
        # way to a position; controllers limit a commanded speed.
        self._limits = [joint.limits.mechanical for joint in driven]
        self._lower = [limits.lower for limits in self._limits]
        self._upper = [limits.upper for limits in self._limits]
        self._max_speed: list[float] = [limits.velocity for limits in self._limits]
        self._gain = np.array(m.actuator_gainprm[self._drive])
        self._bias = np.array(m.actuator_biasprm[self._drive])
        self._limited = np.array(m.actuator_actlimited[self._drive], dtype=bool)
        takes_position = np.array([accepts[_POSITION] for accepts in self._accepts], dtype=bool)
        self._rate = rate = drive_rates(takes_position, period_s, m.opt.timestep)
        fast_pole = 2.0 * rate - _SLOW_POLE_RAD_S
        # Stiffness of the spring on a velocity command, as a fraction of that on other commands.
        self._speed_stiffness = _SLOW_POLE_RAD_S * fast_pole / rate**2
        self._speed_lag_s = (1.0 / fast_pole).tolist()
        # A joint without limits is a wheel: its angle does not change the inertia.
        posed = np.isfinite(self._lower) & np.isfinite(self._upper)
        self._posed = [(row, self._places[row][2]) for row in np.flatnonzero(posed).tolist()]
        self._moved = MovedInertia(
            m, joints, list(self._drive_of), self._gain[:, 0] / DRIVE_RAD_S**2
        )
        # Damping of the joint itself, which the feedforward has to overcome.
        self._drag: Array = np.array(m.dof_damping[self._dof])
        self._effort = [joint.limits.effort for joint in driven]
        roots = [m.body(name).id for name in others]
        self._own = ~np.isin(m.body_rootid, roots)
        self._weightless = np.zeros(0, dtype=int)
        # `settled`, but for repeated commands.
        self.settled = self._at_rest = False
        self.cut: list[str] = []
        self._reported: set[str] = set()
        self._command_names: list[str] = []
        # The last command, while modes and targets are those that it has set.
        self._last_command: tuple[list[str], list[float], list[float], list[float]] | None = None
        # For each drive in such a command: its row, its column, and the interfaces it accepts.
        self._commanded: list[tuple[int, int, list[bool]]] = []
        # Degrees of freedom of driven joints' mimic joints, which are held with their leaders.
        self._followers = np.array(
            [
                m.joint(joint.name).dofadr[0]
                for joint in joints
                if joint.mimic is not None and joint.mimic.joint in self._drive_of
            ],
            dtype=int,
        )

    def reset(self) -> None:
        """Make all drives hold the joints at their present positions, without commands."""
        self.settled = self._at_rest = False
        self._last_command = None
        nothing = [0.0] * len(self._drive)
        actual = self._d.qpos[self._qpos]
        self._mode = [_POSITION] * len(self._drive)
        self._target: list[float] = np.clip(actual, self._lower, self._upper).tolist()
        self._wanted_speed, self._setpoint_speed = list(nothing), list(nothing)
        self._speed_before, self._fed_forward = list(nothing), list(nothing)
        self._setpoint, self._planned_target = list(self._target), list(self._target)
        self._d.act[self._m.actuator_actadr[self._drive]] = self._setpoint
        self._tuned_at: list[float] = actual.tolist()
        self._inertia: list[float] = self._moved.at(self._d).tolist()
        self._tune()
        self._stiffness: list[float] = self._gain[:, 0].tolist()
        self._apply_modes()

    def transferred_to(
        self, model: mujoco.MjModel, data: mujoco.MjData, others: Iterable[str]
    ) -> Drives:
        """Return new drives, with the state of these, for another compiled model of the same robot.

        Args:
            model: The other ``mujoco.MjModel``, whose gains change at run time.
            data: Its ``mujoco.MjData``, in the present state.
            others: See `Drives`.
        """
        moved = Drives(model, data, self._joints, self._period_s, others)
        moved.remove_gravity(self._m.body(body).name for body in self._weightless)
        for name in _STATE:
            setattr(moved, name, getattr(self, name))
        moved.cut, moved._reported = self.cut, self._reported
        moved._tune()
        moved._apply_modes()
        return moved

    def save(self) -> dict[str, Array]:
        """Return the internal state of all drives, as arrays by name."""
        values = {f"drives{name}": np.array(getattr(self, name), float) for name in _STATE}
        return {**values, "drives_still": np.array([self.settled, self._at_rest], float)}

    def restore(self, saved: Mapping[str, Array]) -> None:
        """Set the internal state of all drives to what `save` returned."""
        for name in _STATE:
            setattr(self, name, saved[f"drives{name}"].tolist())
        self._mode = [int(mode) for mode in self._mode]
        self._last_command = None
        self._tune()
        self._apply_modes()
        self.settled, self._at_rest = (bool(still) for still in saved["drives_still"])

    def apply(
        self,
        names: Sequence[str],
        position: Sequence[float] = (),
        velocity: Sequence[float] = (),
        effort: Sequence[float] = (),
    ) -> None:
        """Set joint commands for the period that begins, positions and efforts clamped; rest holds.

        Of several commands for a joint, position has priority over velocity, and velocity over
        effort. A joint without a finite command holds its position. Positions and efforts are
        clamped to the joint's limits; a speed is not, but the joint brakes at its position limits.
        Names of joints that are not `commandable` are ignored.

        Args:
            names: Joint names.
            position: Positions (rad or m), one per name, NaN for none; or empty.
            velocity: Velocities (rad/s or m/s) in the same way.
            effort: Efforts (N m or N) in the same way.
        """
        self.settled = False
        command = list(names), list(position), list(velocity), list(effort)
        if command == self._last_command:
            # A controller that holds repeats its command.
            self._follow_pose()
            return
        self._last_command, self._at_rest = command, False
        if command[0] != self._command_names:
            self._index_command(command[0])
        fields = enumerate((position, velocity, effort))
        given = [(interface, values) for interface, values in fields if len(values) == len(names)]
        modes, wanted = [_POSITION] * len(self._mode), [_NONE] * len(self._mode)
        for row, column, accepts in self._commanded:
            for interface, values in given:
                if accepts[interface] and isfinite(value := values[column]):
                    modes[row], wanted[row] = interface, float(value)
                    break
        self._follow_pose()
        self._set_modes(modes)
        for row, (mode, value) in enumerate(zip(modes, wanted, strict=True)):
            if value != value:  # NaN: the drive keeps its target
                continue
            possible = value
            if mode == _POSITION:
                possible = min(max(value, self._lower[row]), self._upper[row])
                self._target[row] = possible
            elif mode == _VELOCITY:
                self._wanted_speed[row] = value
            else:
                possible = min(max(value, -self._effort[row]), self._effort[row])
                self._ctrl[self._motor[row]] = possible
            if abs(value - possible) > _ROUNDING:
                self._record_clamped(row, mode, value, possible)

    def _record_clamped(self, row: int, mode: int, commanded: float, possible: float) -> None:
        joint, interface = self._joint_names[row], _INTERFACES[mode]
        if joint not in self._reported:
            self._reported.add(joint)
            limits = self._limits[row]
            self.cut.append(
                clamped_command_text(joint, interface, commanded, possible, limits, interface)
            )

    def hold(self) -> None:
        """Switch all drives to position mode at the present or last commanded position."""
        self.settled = self._at_rest = False
        self._last_command = None
        self._set_modes([_POSITION] * len(self._mode))

    def commandable(self, name: str) -> bool:
        """Return whether a joint has a drive that accepts commands."""
        return name in self._drive_of

    def _apply_gains(self) -> None:
        by_effort = (np.array(self._mode, dtype=int) == _EFFORT)[:, None]
        gain, bias = np.array(self._gain), np.array(self._bias)
        gain[:, 0], bias[:, 1] = self._stiffness, np.negative(self._stiffness)
        self._m.actuator_gainprm[self._drive] = np.where(by_effort, 0.0, gain)
        self._m.actuator_biasprm[self._drive] = np.where(by_effort, 0.0, bias)

    @property
    def changing(self) -> bool:
        """Whether any set-point's speed differs from that in the period before."""
        return self._setpoint_speed != self._speed_before

    def _index_command(self, names: list[str]) -> None:
        column = {name: number for number, name in enumerate(names)}
        self._command_names = names
        known = [(row, name) for name, row in self._drive_of.items() if name in column]
        self._commanded = [(row, column[name], self._accepts[row]) for row, name in known]

    def _follow_pose(self) -> None:
        """Tune the drives to the inertia that they move in the present pose, if it has changed."""
        here, before = self._positions, self._tuned_at
        for row, place in self._posed:
            if abs(here[place] - before[row]) > _TUNED_WITHIN:
                break
        else:
            return
        self._at_rest = False
        actual = self._d.qpos[self._qpos]
        self._tuned_at, self._inertia = actual.tolist(), self._moved.at(self._d).tolist()
        self._tune()
        self._stretch(np.array(self._mode), actual)
        self._apply_gains()

    def _tune(self) -> None:
        """Compute springs, dampers and accelerations for the inertia that is moved."""
        inertia = np.array(self._inertia)
        self._gain[:, 0] = inertia * self._rate**2
        self._bias[:, 1] = -self._gain[:, 0]
        damping = 2.0 * inertia * self._rate
        self._bias[:, 2] = -damping
        acceleration = np.maximum(self._effort, _LEAST_EFFORT) / inertia
        # Time in which the full effort makes the change of speed that the damper alone answers with
        # it, or a quarter of a period that is not long.
        at_once = np.maximum(0.5 / self._rate, min(0.25 * self._period_s, 0.5 / DRIVE_RAD_S))
        self._damping: list[float] = damping.tolist()
        self._drawn: list[float] = (damping + self._drag).tolist()
        self._acceleration: list[float] = acceleration.tolist()
        self._speed_step: list[float] = (acceleration * at_once).tolist()

    def _stretch(self, mode: npt.NDArray[np.intp], actual: Array) -> None:
        """Change the stiffness of the springs, stretched so that they carry the same load."""
        before, setpoint = np.array(self._stiffness), np.array(self._setpoint)
        stiffness = self._gain[:, 0] * np.where(mode == _VELOCITY, self._speed_stiffness, 1.0)
        lead = (setpoint - actual) * before / stiffness
        self._setpoint = np.where(stiffness == before, setpoint, actual + lead).tolist()
        self._stiffness = stiffness.tolist()

    def _set_modes(self, modes: list[int]) -> None:
        if modes == self._mode:
            return
        # A drive that takes over starts from the joint's position, not from an old set-point.
        actual = self._d.qpos[self._qpos]
        now = np.clip(actual, self._lower, self._upper).tolist()
        for row, (mode, before) in enumerate(zip(modes, self._mode, strict=True)):
            if before == _EFFORT != mode:
                self._setpoint[row] = now[row]
            if before != _POSITION == mode:
                self._target[row] = now[row]
        self._stretch(np.array(modes), actual)
        self._mode = modes
        self._apply_modes()

    def _apply_modes(self) -> None:
        """Switch between drives and motors, and set which links' weight the drives carry."""
        self._apply_gains()
        mode = np.array(self._mode, dtype=int)
        by_effort = mode == _EFFORT
        # The range keeps set-points of positions within the stops; a speed is limited instead.
        self._m.actuator_actlimited[self._drive] = self._limited & (mode != _VELOCITY)
        motors = np.array(self._motor, dtype=int)
        self._d.ctrl[motors[(motors >= 0) & ~by_effort]] = 0.0
        if not len(self._drive):
            return  # the gravity compensation of an MJCF file stays
        unsupported = np.ones(self._m.nv, dtype=bool)
        unsupported[self._dof[~by_effort]] = False
        unsupported[self._followers] = False
        carried = compensated_bodies(self._m, unsupported)
        carried[self._weightless] = 1.0
        self._m.body_gravcomp[self._own] = carried[self._own]

    def remove_gravity(self, links: Iterable[str]) -> None:
        """Compensate gravity on links, so that they have no weight; to be called before `reset`.

        A joint that moves only such links carries no weight. For a joint that moves others too, the
        effort that lifts these links counts towards its limit.
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
        """Compute all set-points for the control period that begins, into MuJoCo's data."""
        if self._at_rest:
            self.settled = True
            return
        period_s, settled = self._period_s, True
        setpoints, drawn, stiffness = self._setpoint, self._drawn, self._stiffness
        fed_forward, speeds, speeds_before = (
            self._fed_forward,
            self._setpoint_speed,
            self._speed_before,
        )
        rows = enumerate(zip(self._mode, self._target, self._planned_target, speeds, strict=True))
        for row, (mode, target, planned, before) in rows:
            setpoint, speed, fed = setpoints[row], 0.0, 0.0
            if mode == _POSITION:
                away, fresh = target - setpoint, target != planned
                if fresh and not fed_forward[row]:
                    # On the way to a distant position the set-point is ahead of the joint.
                    _, _, place, dof = self._places[row]
                    actual, joint_speed = self._positions[place], self._speeds[dof]
                    if goes_on_from_joint(
                        target - actual, joint_speed, away, before, self._max_speed[row], period_s
                    ):
                        setpoint, before = actual, joint_speed
                        away = target - setpoint
                        speeds_before[row] = fed_forward[row] = before
                if not (away or fresh or before or speeds_before[row] or fed_forward[row]):
                    # The set-point stands still, as in the previous period.
                    settled &= self._lower[row] <= setpoint <= self._upper[row]
                    continue
                if abs(away) < _ARRIVED:
                    setpoint, away = target, 0.0
                most, more = self._max_speed[row], self._acceleration[row]
                speed = position_speed(away, before, fresh, most, more, period_s)
                if fresh and abs(away - speed * period_s) <= 1e-6 * abs(away):
                    expected, more = 2.0 * before - speeds_before[row], self._speed_step[row]
                    fed = feedforward_speed(speed, fed_forward[row], expected, more)
            elif mode == _VELOCITY:
                speed = fed = self._wanted_within_stops(row)
                setpoint = self._led(row, setpoint, speed - before)
            drive, act, _, _ = self._places[row]
            # The damper acts on the joint's absolute speed: stretching the spring by
            # damping * speed / stiffness makes it act on the difference from the set-point's speed.
            self._act[act] = setpoint + fed * drawn[row] / stiffness[row]
            self._ctrl[drive] = speed
            speeds_before[row], speeds[row], fed_forward[row] = before, speed, fed
            setpoints[row] = setpoint + speed * period_s
            # MuJoCo keeps a set-point that does not move, unless it lies outside of its range.
            settled &= mode != _VELOCITY and not (speed or fed or before)
            settled &= self._lower[row] <= setpoint <= self._upper[row]
        self._planned_target[:] = self._target
        self.settled = self._at_rest = settled

    def _led(self, row: int, setpoint: float, change: float) -> float:
        """Return the start of a speed's set-point, with the spring's present stretch."""
        _, _, place, dof = self._places[row]
        pull = self._damping[row] * (self._setpoint_speed[row] - self._speeds[dof])
        actual: float = self._positions[place]
        lead = limited_lead(setpoint - actual, pull, self._effort[row], self._stiffness[row])
        # A change of speed must not leave a distance to make up.
        lead -= lag_distance(change, self._speed_lag_s[row], self._acceleration[row])
        return actual + lead

    def _wanted_within_stops(self, row: int) -> float:
        _, _, place, dof = self._places[row]
        rest = self._positions[place] + self._speeds[dof] * self._speed_lag_s[row]
        stops = self._lower[row] - rest, self._upper[row] - rest
        speed: float = speed_within_limits(self._wanted_speed[row], *stops, self._period_s)
        return speed
