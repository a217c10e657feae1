"""States that a person asks for: mujoco_ros2_control_msgs' SimulationState and FreeJointState.

All of a request is checked before any of it is done.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from teleopctl.sim.entities.poses import no_sense

if TYPE_CHECKING:
    from teleopctl.sim.free_bodies import LinkPose
    from teleopctl.sim.simulation import Simulation

# Any stands for messages: their classes are made at run time, from definitions.


def refuse_joints(simulation: Simulation, state: Any) -> str:
    """Return why a JointState cannot be applied; empty if it can.

    Args:
        simulation: What it is meant for.
        state: Positions and velocities, each one per name or none at all; no efforts.
    """
    unknown = [name for name in state.name if name not in simulation.joint_names]
    if unknown:
        return f"There is no joint '{unknown[0]}'; there is {', '.join(simulation.joint_names)}"
    if len(state.effort):
        return "The effort of joints cannot be set"
    for word, values in (("position", state.position), ("velocity", state.velocity)):
        if len(values) not in (0, len(state.name)):
            return f"There are {len(state.name)} names and {len(values)} values of '{word}'"
        if reason := no_sense(values):
            return f"A value of '{word}' {reason}"
    return ""


def refuse_bodies(simulation: Simulation, states: Sequence[Any]) -> str:
    """Return why FreeJointStates cannot be applied; empty if they can."""
    bodies = simulation.free_bodies
    for state in states:
        if bodies.index(state.name) is None:
            known = ", ".join(body.link for body in bodies.bodies) or "nothing"
            return f"'{state.name}' does not move freely; {known} does"
        for header in (state.pose.header, state.twist.header):
            if _is_turned(simulation, header) and not simulation.has_link(header.frame_id):
                return f"There is no link '{header.frame_id}'"
        if reason := no_sense([*_pose_values(state), *_twist_values(state)]):
            return f"A value of '{state.name}' {reason}"
    return ""


def reset_to(simulation: Simulation, overrides: Any, keyframe: str = "") -> None:
    """Reset a simulation, or load a keyframe, and then apply a SimulationState."""
    joints = overrides.joint_states
    simulation.reset_state(
        dict(zip(joints.name, joints.position, strict=False)),
        dict(zip(joints.name, joints.velocity, strict=False)),
        keyframe,
    )
    put_bodies(simulation, overrides.free_joints)


def put_bodies(simulation: Simulation, states: Sequence[Any]) -> None:
    """Set the poses and velocities of free bodies from FreeJointStates."""
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
