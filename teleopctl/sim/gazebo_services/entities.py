"""What is there, what comes and goes, where it is: ``gazebo_ros_factory``, ``gazebo_ros_state``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl.interfaces import set_stamp
from teleopctl.robot import read_world_text
from teleopctl.sim.entities.entity import entities, move
from teleopctl.sim.entities.poses import fill_pose, fill_twist, pose_in_world, twist_in_world
from teleopctl.sim.entities.spawn_services import name_for
from teleopctl.sim.gazebo_services.links import (
    entity_of,
    frame_link,
    link_of,
    motion_of_link,
)

if TYPE_CHECKING:
    from teleopctl.sim.entities.stage import RunningSimulation
    from teleopctl.sim.free_bodies import LinkPose
    from teleopctl.sim.simulation import Simulation


# Any, here and below: messages, whose classes are made at run time.
def get_model_list(
    stage: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """List the entities."""
    del request, warn

    def look() -> None:
        set_stamp(response.header.stamp, stage.simulation.time_ns)
        response.model_names = list(entities(stage.simulation))

    stage.ask(look)


async def spawn_entity(
    stage: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Spawn a model from URDF or SDF text."""
    world = read_world_text(request.xml, "xml")
    # Without a name it gets another one where its own is taken.
    name = name_for(stage, world, request.name, renames=not request.name)
    pose = stage.ask(
        lambda: pose_in_world(
            request.initial_pose, _frame(stage.simulation, request.reference_frame)
        )
    )
    if request.robot_namespace:
        warn(
            f"the namespace {request.robot_namespace} is without effect: '{name}' has no "
            "interfaces of its own"
        )
    thing = await stage.spawn(world, name, pose[:3], pose[3:], own_pose=True)
    assert thing is not None  # only what is cancelled has no result
    for remark in thing.warnings:
        warn(f"'{name}': {remark}")
    response.status_message = f"SpawnEntity: Successfully spawned entity [{', '.join(thing.names)}]"


def delete_entity(
    stage: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Remove an entity."""
    del warn
    stage.delete(request.name)
    response.status_message = f"Successfully deleted entity [{request.name}]"


def get_entity_state(
    stage: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Return the pose and twist of an entity or link, relative to a frame."""
    del warn

    def look() -> None:
        simulation = stage.simulation
        pose, twist = motion_of_link(simulation, link_of(simulation, request.name))
        if link := frame_link(simulation, request.reference_frame):
            frame = simulation.link_pose(link)
            _, carried = motion_of_link(simulation, link)
            back = frame.rotation.T
            relative = twist - carried
            twist = np.concatenate([back @ relative[:3], back @ relative[3:]])
            pose = _seen_from(frame, pose)
        set_stamp(response.header.stamp, simulation.time_ns)
        response.header.frame_id = response.state.reference_frame = request.reference_frame
        response.state.name = request.name
        fill_pose(response.state.pose, pose)
        fill_twist(response.state.twist, twist)

    stage.ask(look)


def set_entity_state(
    stage: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Set the pose and twist of an entity."""
    del response, warn
    state = request.state

    def change() -> None:
        simulation = stage.simulation
        entity = entity_of(simulation, state.name)
        frame = _frame(simulation, state.reference_frame)
        pose, twist = pose_in_world(state.pose, frame), twist_in_world(state.twist, frame)
        move(simulation, entity, pose, twist)

    stage.change(change)


def _frame(simulation: Simulation, name: str) -> LinkPose | None:
    link = frame_link(simulation, name)
    return simulation.link_pose(link) if link else None


def _seen_from(frame: LinkPose, pose: Any) -> Any:
    """A pose of the world as seen from a frame, (7,)."""
    import mujoco

    inverse, turn = np.zeros(4), np.zeros(4)
    mujoco.mju_negQuat(inverse, frame.quaternion)
    mujoco.mju_mulQuat(turn, inverse, pose[3:])
    return np.concatenate([frame.rotation.T @ (pose[:3] - frame.position), turn])
