"""Services of mujoco_ros2_control: pause, step, reset and save the world, set free bodies.

A request is checked as a whole before any part of it is applied.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from teleopctl.errors import NotFoundError, RefusedError
from teleopctl.packages import resolve_uri
from teleopctl.sim.entities.service_base import FindRunning, offer_message_service
from teleopctl.sim.request_numbers import invalid_number_reason
from teleopctl.sim.state.saved_state import SavedState

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.sim.entities.running_simulation import RunningSimulation
    from teleopctl.sim.free_bodies import LinkPose
    from teleopctl.sim.simulation import Simulation

# Any stands for messages: their classes are made at run time, from definitions.


def joints_refusal_reason(simulation: Simulation, state: Any) -> str:
    """Return why a JointState message cannot be applied to a simulation; empty if it can.

    Args:
        simulation: Simulation to apply the message to.
        state: JointState with positions and velocities, each one per name or empty; no efforts.
    """
    unknown = [name for name in state.name if name not in simulation.joint_names]
    if unknown:
        return f"There is no joint '{unknown[0]}'; there is {', '.join(simulation.joint_names)}"
    if len(state.effort):
        return "The effort of joints cannot be set"
    for word, values in (("position", state.position), ("velocity", state.velocity)):
        if len(values) not in (0, len(state.name)):
            return f"There are {len(state.name)} names and {len(values)} values of '{word}'"
        if reason := invalid_number_reason(values):
            return f"A value of '{word}' {reason}"
    return ""


def bodies_refusal_reason(simulation: Simulation, states: Sequence[Any]) -> str:
    """Return why FreeJointState messages cannot be applied to a simulation; empty if they can."""
    bodies = simulation.free_bodies
    for state in states:
        if bodies.index(state.name) is None:
            known = ", ".join(body.link for body in bodies.bodies) or "nothing"
            return f"'{state.name}' does not move freely; {known} does"
        for header in (state.pose.header, state.twist.header):
            if _is_turned(simulation, header) and not simulation.has_link(header.frame_id):
                return f"There is no link '{header.frame_id}'"
        if reason := invalid_number_reason([*_pose_values(state), *_twist_values(state)]):
            return f"A value of '{state.name}' {reason}"
    return ""


def reset_to(simulation: Simulation, overrides: Any, keyframe: str = "") -> None:
    """Reset a simulation, to a keyframe if named, with the values of a SimulationState message."""
    joints = overrides.joint_states
    simulation.reset_state(
        dict(zip(joints.name, joints.position, strict=False)),
        dict(zip(joints.name, joints.velocity, strict=False)),
        keyframe,
    )
    put_bodies(simulation, overrides.free_joints)


def put_bodies(simulation: Simulation, states: Sequence[Any]) -> None:
    """Set the poses and velocities of free bodies from FreeJointState messages."""
    frames = {
        header.frame_id: simulation.link_pose(header.frame_id)
        for state in states
        for header in (state.pose.header, state.twist.header)
        if _is_turned(simulation, header)
    }
    bodies = simulation.free_bodies
    for state in states:
        index = bodies.index(state.name)
        assert index is not None
        pose, twist = np.array(_pose_values(state)), np.array(_twist_values(state))
        if not pose[3:].any():
            pose[3] = 1.0
        frame = frames.get(state.pose.header.frame_id)
        if frame is not None:
            pose = _in_world(frame, pose)
        frame = frames.get(state.twist.header.frame_id)
        if frame is not None:
            twist = np.concatenate([frame.rotation @ twist[:3], frame.rotation @ twist[3:]])
        bodies.put(index, pose, twist)
    simulation.refresh()


def _is_turned(simulation: Simulation, header: Any) -> bool:
    """Whether a header names another frame than the world's, in which states are published."""
    return header.frame_id not in ("", simulation.model.world_frame)


def _in_world(frame: LinkPose, pose: Any) -> Any:
    rotation = np.zeros(4)
    mujoco.mju_mulQuat(rotation, frame.quaternion, pose[3:])
    return np.concatenate([frame.position + frame.rotation @ pose[:3], rotation])


def _pose_values(state: Any) -> list[float]:
    p, q = state.pose.pose.position, state.pose.pose.orientation
    return [p.x, p.y, p.z, q.w, q.x, q.y, q.z]


def _twist_values(state: Any) -> list[float]:
    v, w = state.twist.twist.linear, state.twist.twist.angular
    return [v.x, v.y, v.z, w.x, w.y, w.z]


class MujocoServices:
    """Services of mujoco_ros2_control: pause, step, reset or save the world, set free bodies.

    Args:
        node: Node of the services.
        find_running: See `FindRunning`.
    """

    def __init__(self, node: Node, find_running: FindRunning) -> None:
        self._node = node
        self._saved: dict[str, SavedState] = {}
        for type_name, name, handler in (
            ("SetPause", "set_pause", self._pause),
            ("StepSimulation", "step_simulation", _step),
            ("ResetWorld", "reset_world", self._reset),
            ("ResetWorld", "save_world", self._save),
            ("SetFreeJointState", "set_free_joint_state", _set_free),
        ):
            offer_message_service(node, find_running, type_name, f"~/{name}", handler)

    # Any, here and below: messages, whose classes are made at run time.
    def _pause(self, running: RunningSimulation, request: Any) -> str:
        word = "paused" if request.paused else "running"
        if request.paused:
            running.pause()
        else:
            running.play()
        self._node.get_logger().info(f"Simulation is {word}")
        return f"Simulation is {word}"

    def _reset(self, running: RunningSimulation, request: Any) -> str:
        keyframe, overrides = request.keyframe, request.state_overrides
        simulation, saved = running.simulation, None
        if keyframe and keyframe not in simulation.model.keyframes:
            saved = self._find(running, keyframe)
            if overrides.joint_states.name:
                raise RefusedError(
                    "The joints of a saved state are held by its drives: only free_joints of "
                    "state_overrides can be combined with it"
                )

        def change() -> None:
            _refuse(joints_refusal_reason(simulation, overrides.joint_states))
            _refuse(bodies_refusal_reason(simulation, overrides.free_joints))
            if saved is None:
                reset_to(simulation, overrides, keyframe)
                return
            saved.put(simulation)
            put_bodies(simulation, overrides.free_joints)
            running.restart_time()

        running.call_and_publish(change)
        if saved is not None:
            self._node.get_logger().info(f"World set to '{keyframe}'; time restarts")
            return f"World set to '{keyframe}'; time restarts"
        where = f"the keyframe '{keyframe}'" if keyframe else "the initial positions"
        self._node.get_logger().info(f"World reset to {where}; time continues")
        return "World reset"

    def _save(self, running: RunningSimulation, request: Any) -> str:
        name, overrides = request.keyframe, request.state_overrides
        if not name:
            raise RefusedError("A state needs a name, or the path of a file, as its keyframe")
        if overrides.joint_states.name or overrides.free_joints:
            raise RefusedError(
                "state_overrides are for reset_world only: a state is saved unchanged"
            )
        if name in running.simulation.model.keyframes:
            raise RefusedError(f"The model has a keyframe '{name}': choose another name")
        state = running.call(lambda: SavedState.of(running.simulation))
        if file := _file(name):
            state.write(file)
            return f"Saved into {file}"
        self._saved[name] = state
        return f"Saved as '{name}'"

    def _find(self, running: RunningSimulation, name: str) -> SavedState:
        if file := _file(name):
            return SavedState.read(file)
        if name in self._saved:
            return self._saved[name]
        known = [*running.simulation.model.keyframes, *self._saved]
        there_is = f"; there is {', '.join(known)}" if known else ""
        raise NotFoundError(f"There is no keyframe '{name}'{there_is}")


def _file(name: str) -> Path | None:
    """Return the path of the file that a keyframe names; None if the keyframe is a plain name."""
    if "/" not in name:
        return None
    path = resolve_uri(name)
    if not path.is_absolute():
        raise RefusedError(f"'{name}' is a relative path: give an absolute one")
    return path


def _refuse(reason: str) -> None:
    if reason:
        raise RefusedError(reason)


async def _step(running: RunningSimulation, request: Any) -> str:
    await running.step(request.steps)
    return f"Advanced by {request.steps} steps"


def _set_free(running: RunningSimulation, request: Any) -> str:
    simulation, states = running.simulation, request.free_joints

    def change() -> None:
        _refuse(bodies_refusal_reason(simulation, states))
        running.record(0, states)
        put_bodies(simulation, states)

    running.call_and_publish(change)
    return f"Set {len(states)} free bodies"
