"""Physics simulation of a robot, without ROS: commands in, time forward, joint states out.

Time is counted in control periods and physics steps, both integers, so a run is the same each
time: the same commands at the same ticks give the same bits.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.mujoco_model import RobotModel, copy_state, set_timestep
from teleopctl.sim.drives import Drives
from teleopctl.sim.entities.pushes import Push, Pushes, read_pushes
from teleopctl.sim.free_bodies import FreeBodies, LinkPose
from teleopctl.sim.gazebo_plugins import PlanarMove
from teleopctl.sim.initial_overlaps import InitialOverlaps
from teleopctl.sim.mjcf import FileActuators
from teleopctl.sim.state.divergence_recovery import DivergenceRecovery
from teleopctl.sim.state.friction_directions import FrictionDirections
from teleopctl.sim.state.joint_states import JointStates
from teleopctl.sim.state.physics import physics_state, put_physics_state, scale_model, wake
from teleopctl.sim.state.slip_correction import PhysicsStepper, drives_by_sliding
from teleopctl.sim.state.state_observer import StateObserver

Array = npt.NDArray[np.float64]

# Interval of the checks for links that have come apart: each may cost as much as a physics step.
_PARTING_NS = 10_000_000


class Simulation:
    """Physics simulation of a robot and its world, without ROS topics.

    Args:
        model: Model of the robot and its world.
        control_period_ns: Time between two control ticks, in nanoseconds.
        timestep_ns: Longest physics step, in nanoseconds, by default that of the model; the step
            used divides the control period evenly.
        mass_scale: Factor of all masses and inertias.
        friction_scale: Factor of all coefficients of friction.

    Attributes:
        joint_names: Names of the joints in all arrays below, in the order of the model.
        positions: Joint positions (rad or m) as of the last `read`.
        velocities: Joint velocities (rad/s or m/s) as of the last `read`.
        efforts: Efforts of the drives (N m or N) as of the last `read`.
        free_bodies: Poses and velocities of the freely moving bodies.
        movers: Planar-move plug-ins, which move the robot by commands from topics.
        control_period_ns: Time between two control ticks, in nanoseconds.
        steps_per_period: Number of physics steps in one control period.
        static_moves: Number of changes of static objects' poses.
        resets: Number of resets of the state.
        put_back: Objects whose physics diverged, and which alone were reset; for the log.
    """

    def __init__(
        self,
        model: RobotModel,
        *,
        control_period_ns: int,
        timestep_ns: int | None = None,
        mass_scale: float = 1.0,
        friction_scale: float = 1.0,
    ) -> None:
        self._scales = mass_scale, friction_scale
        self.control_period_ns = control_period_ns
        self.steps_per_period = -(-control_period_ns // (timestep_ns or model.timestep_ns))
        joints = model.joints
        self._states = states = JointStates(joints, model.weightless)
        self.joint_names = states.names
        self.positions, self.velocities, self.efforts = states.values
        self._bind(model)
        self._steps = self.resets = self.static_moves = 0
        self.put_back: list[str] = []
        self._pushes = Pushes()
        self._drives = Drives(self._m, self._d, joints, control_period_ns * 1e-9, self._others)
        self._drives.remove_gravity(model.weightless)
        self._file_actuators = FileActuators(self._m, self._d, joints, model.transmissions)
        self.movers: list[PlanarMove] = []
        self._parting = InitialOverlaps(self._m, self._d, model.excluded)
        self._parting_steps = -(-_PARTING_NS // control_period_ns) * self.steps_per_period
        self.reset_state()

    def _bind(self, model: RobotModel) -> None:
        """Set up MuJoCo's model and data from a model, in its initial state."""
        self.model = model
        # A copy: gains, gravity compensation and excluded contacts change at run time.
        self._m: Any = copy.copy(model.mj_model)
        set_timestep(self._m, self.control_period_ns * 1e-9 / self.steps_per_period)
        scale_model(self._m, *self._scales)
        self._d: Any = mujoco.MjData(self._m)
        directions = FrictionDirections(self._m, model.directed, self._scales[1])
        self._physics = PhysicsStepper(
            self._m, slides=drives_by_sliding(model), directions=directions
        )
        self._observer = StateObserver(self._m, self._physics)
        self._breakdowns = DivergenceRecovery(model, self._m, self._d, self._physics)
        self._states.bind(self._m, self._d)
        self.free_bodies = FreeBodies(self._m, self._d, model.free_bodies)
        self._others = [thing.name for thing in model.things]

    def replace_model(self, model: RobotModel) -> None:
        """Replace the MuJoCo model; all parts that both models have keep their state.

        Args:
            model: Model of the same robot, with other objects around it.
        """
        m, d, physics = self._m, self._d, self._physics
        self._bind(model)
        copy_state(m, d, self._m, self._d)
        self._physics.restore(physics.save())
        self._drives = self._drives.transferred_to(self._m, self._d, self._others)
        self._file_actuators = FileActuators(self._m, self._d, model.joints, model.transmissions)
        self._parting = self._parting.transferred_to(self._m, self._d)
        self.refresh()

    # --- time -----------------------------------------------------------------------------

    @property
    def time_ns(self) -> int:
        """Simulated time since the last reset of time, in nanoseconds."""
        return self._steps * self.control_period_ns // self.steps_per_period

    @property
    def timestep_s(self) -> float:
        """Length of a physics step, in seconds."""
        return float(self._m.opt.timestep)

    @property
    def at_tick(self) -> bool:
        """Whether a control period begins at the present time."""
        return self._steps % self.steps_per_period == 0

    @property
    def steps_to_tick(self) -> int:
        """Number of physics steps until the next control period begins, at least one."""
        return self.steps_per_period - self._steps % self.steps_per_period

    def steps_until(self, time_ns: int) -> int:
        """Return the number of physics steps until a simulated time; 0 if it has passed."""
        tick, rest = divmod(time_ns, self.control_period_ns)
        within = -(-rest * self.steps_per_period // self.control_period_ns)
        wanted = tick * self.steps_per_period + within
        return max(0, wanted - self._steps)

    def step(self, count: int) -> None:
        """Advance the simulation by a number of physics steps."""
        while count > 0:
            to_tick = self.steps_per_period - self._steps % self.steps_per_period
            if to_tick == self.steps_per_period:
                self._begin_period()
            block = min(count, to_tick)
            if self._pushes:
                block = 1
                self._pushes.begin_step(self._m, self._d)
                self._advance(1)
                self._pushes.end_step(self._d)
            else:
                self._advance(block)
            count -= block
            self._steps += block

    def coast(self, count: int) -> None:
        """Advance by at most ``count`` steps, without stopping at ticks while drives stand still.

        The result is that of `step`, bit for bit. The simulation stops early at a control tick
        where the drives have something to do, or that would have detected diverged physics.
        """
        if self._pushes:
            self.step(min(count, self.steps_to_tick))
            return
        if self.at_tick:
            self._begin_period()
        to_tick = self.steps_to_tick
        if self.movers or not self._drives.settled:
            count = min(count, to_tick)
        elif self._parting.waits:
            count = min(count, self._parting_steps - self._steps % self._parting_steps)
        self._advance(count)
        self._steps += count
        if count > to_tick and self.diverged:
            # MuJoCo reset its own time in the step that failed.
            failed = self._steps - round(self._d.time / self.timestep_s) + 1
            noticed = -(-failed // self.steps_per_period) * self.steps_per_period
            self._steps = min(self._steps, noticed)

    def _advance(self, count: int) -> None:
        for thing in self._breakdowns.step(count):
            self._pushes.end(thing, self._d)
            self.put_back.append(thing)

    def _begin_period(self) -> None:
        if self._parting.waits and self._steps % self._parting_steps == 0:
            self._parting.check()
        changing = bool(self.movers)
        if not self._drives.settled:
            self._drives.plan_period()
            changing |= self._drives.changing
        for mover in self.movers:
            mover.plan_period(self._m, self._d)
        self._physics.begin_period(changing=changing)

    def step_to(self, time_ns: int) -> None:
        """Advance to the first physics step at or after a simulated time; nothing if it is past."""
        self.step(self.steps_until(time_ns))

    def reset(self) -> None:
        """Reset time to zero and all states to the initial ones, without commands."""
        self.reset_state()
        self.reset_time()

    def reset_time(self) -> None:
        """Set the simulated time to zero; all states stay."""
        self._steps = 0

    def reset_state(
        self,
        positions: Mapping[str, float] | None = None,
        velocities: Mapping[str, float] | None = None,
        keyframe: str = "",
    ) -> None:
        """Reset all states, to given joint values or a keyframe if any; drop commands; time stays.

        Args:
            positions: Positions of joints (rad or m), by name, instead of the initial ones.
            velocities: Velocities of joints (rad/s or m/s), by name, instead of the initial ones.
            keyframe: Keyframe of the model to start from, instead of its initial state.
        """
        self.resets += 1
        mujoco.mj_resetData(self._m, self._d)
        self._restore_standing()
        self.model.put_at_start(self._m, self._d, keyframe)
        self._states.put_balls(self._d, positions or {})
        for joint in self.model.joints:
            if joint.ball:
                continue
            if positions and joint.name in positions:
                self._d.joint(joint.name).qpos[0] = positions[joint.name]
            if velocities and joint.name in velocities:
                self._d.joint(joint.name).qvel[0] = velocities[joint.name]
        self._pushes.clear(self._d)
        self._physics.begin_period(changing=True)
        self._drives.reset()
        for mover in self.movers:
            mover.stop()
        start = self.model.keyframes.get(keyframe, self.model.start)
        if positions or (start is not None and not start.controls):
            self._file_actuators.hold_present()
        self._parting.reset()
        self.refresh()

    def save(self) -> dict[str, Array]:
        """Return the complete state, except simulated time, as arrays by name, for `restore`."""
        return {
            **physics_state(self._m, self._d),
            **self._drives.save(),
            "pushes": self._pushes.save(self._m),
            "waiting": self._parting.save(),
            "sliding": self._physics.save(),
            "step": np.array([self._steps % self.steps_per_period, self.steps_per_period], float),
        }

    def restore(self, saved: Mapping[str, Array], time_ns: int | None = None) -> None:
        """Set the state to what `save` returned for a model with the same parts.

        Args:
            saved: The state.
            time_ns: Simulated time from which it continues, in nanoseconds; None restarts time, at
                the same step of a control period.

        Raises:
            RefusedError: A saved push is invalid; nothing is changed.
        """
        pushes = read_pushes(self._m, saved["pushes"])
        self.reset_state()
        self._drives.restore(saved)
        for push in pushes:
            self._pushes.add(push)
        self._parting.restore(saved["waiting"])
        self._physics.restore(saved["sliding"])
        put_physics_state(self._m, self._d, saved)
        self.static_moves += 1
        wake(self._m, self._d)
        # `wake` has changed the solver's warm start.
        put_physics_state(self._m, self._d, saved)
        step, period = saved["step"]
        self._steps = int(step) % self.steps_per_period if period == self.steps_per_period else 0
        if time_ns is not None:
            self._steps = 0
            self._steps = self.steps_until(time_ns)
            self._d.time = self._steps * self.timestep_s
        self.read()

    def refresh(self) -> None:
        """Recompute all quantities that depend on changed positions and velocities."""
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
        """Set joint commands for the control period that begins now."""
        self._drives.apply(names, position, velocity, effort)
        if self._file_actuators:
            self._file_actuators.apply(names, position, velocity, effort)

    def take_cut_commands(self) -> list[str]:
        """Return and clear the sentences on each joint's first command beyond its limits."""
        cut, self._drives.cut = self._drives.cut, []
        return cut

    def hold(self) -> None:
        """Hold all joints at their present or last commanded positions, without commands."""
        self._drives.hold()
        self._file_actuators.hold()

    def commandable(self, name: str) -> bool:
        """Return whether a joint accepts commands."""
        return self._drives.commandable(name) or name in self._file_actuators

    # --- state ----------------------------------------------------------------------------

    def read(self) -> None:
        """Copy the present joint states into `positions`, `velocities` and `efforts`."""
        self._states.read(moving=not self._drives.settled)

    def observe(self) -> tuple[mujoco.MjModel, mujoco.MjData]:
        """Return MuJoCo's model and a copy of its data with present sensor values.

        Model and data are valid until the next step.
        """
        moving = not self._drives.settled
        return self._m, self._observer.observe(self._d, self.time_ns * 1e-9, moving=moving)

    def has_link(self, name: str) -> bool:
        """Return whether the robot or the world has a link of this name."""
        return bool(mujoco.mj_name2id(self._m, mujoco.mjtObj.mjOBJ_BODY, name) >= 0)

    @property
    def present_model(self) -> RobotModel:
        """The model of robot and world, with static objects at their present poses."""
        return replace(self.model, mj_model=self._m)

    def set_static_pose(self, body: str, pose: Array) -> None:
        """Set the pose of a static object, until the next reset of states.

        Args:
            body: Topmost body of the object.
            pose: Position (m) and rotation (w x y z, of any length) in the world, (7,).
        """
        number, turn = self._m.body(body).id, np.array(pose[3:])
        mujoco.mju_normalize4(turn)
        self._m.body_pos[number], self._m.body_quat[number] = pose[:3], turn
        self.static_moves += 1
        wake(self._m, self._d)

    def _restore_standing(self) -> None:
        """Set all static objects back to their initial poses."""
        start = self.model.mj_model
        if not np.array_equal(self._m.body_pos, start.body_pos) or not np.array_equal(
            self._m.body_quat, start.body_quat
        ):
            self._m.body_pos[:], self._m.body_quat[:] = start.body_pos, start.body_quat
            self.static_moves += 1
            wake(self._m, self._d)

    def push(self, push: Push) -> None:
        """Apply an external force and torque to a body for a number of steps."""
        self._pushes.add(push)
        wake(self._m, self._d)

    def end_pushes(self, body: str) -> bool:
        """End the external wrenches on a body; return whether there were any."""
        return self._pushes.end(body, self._d)

    @property
    def gravity(self) -> list[float]:
        """Gravity vector in the world, (3,), in m/s²."""
        return [float(part) for part in self._m.opt.gravity]

    def set_gravity(self, gravity: Array | Sequence[float]) -> None:
        """Set the gravity vector in the world, (3,), in m/s²."""
        self._m.opt.gravity[:] = gravity
        wake(self._m, self._d)

    def reset_world_state(self) -> None:
        """Reset all states, and set the gravity of the model; called for a new world."""
        self.set_gravity(self.model.mj_model.opt.gravity)
        self.reset_state()

    def link_pose(self, link: str) -> LinkPose:
        """Return the present pose of a link's frame in the world."""
        mujoco.mj_kinematics(self._m, self._d)
        body = self._d.body(link)
        return LinkPose(np.array(body.xpos), np.array(body.xquat), body.xmat.reshape(3, 3).copy())

    @property
    def diverged(self) -> bool:
        """Whether the robot's physics has become unstable since the last reset of states."""
        return self._breakdowns.broken
