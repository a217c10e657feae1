"""simulation_interfaces: places with names, which a world's file has for spawning and for goals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl.errors import NotFoundError
from teleopctl.interfaces import get_message
from teleopctl.mujoco_model import WORLD_PREFIX
from teleopctl.robot import ScenePose
from teleopctl.sim.entities.answers import SimulationServices, has_tags
from teleopctl.sim.entities.poses import fill_pose
from teleopctl.tf import Transform

if TYPE_CHECKING:
    from teleopctl.sim.entities.stage import RunningSimulation

_Bounds = get_message("simulation_interfaces/msg/Bounds")
_NamedPose = get_message("simulation_interfaces/msg/NamedPose")
_Vector3 = get_message("geometry_msgs/msg/Vector3")


class PoseServices:
    """Offers the services for named poses.

    Args:
        desk: Where they are offered.
    """

    def __init__(self, desk: SimulationServices) -> None:
        desk.offer("GetNamedPoses", "get_named_poses", self._list)
        desk.offer("GetNamedPoseBounds", "get_named_pose_bounds", self._get_bounds)

    # Any, here and below: messages, whose classes are made at run time.
    def _list(self, stage: RunningSimulation, request: Any, response: Any) -> None:
        for place in named_poses(stage):
            if has_tags(list(place.tags), request.tags):
                found = _NamedPose(
                    name=place.name, description=place.description, tags=list(place.tags)
                )
                x, y, z, w = place.pose.rotation
                fill_pose(found.pose, np.array([*place.pose.translation, w, x, y, z]))
                response.poses.append(found)

    def _get_bounds(self, stage: RunningSimulation, request: Any, response: Any) -> None:
        known = {place.name: place for place in named_poses(stage)}
        if request.name not in known:
            there_is = f"; there is {', '.join(known)}" if known else ""
            raise NotFoundError(f"There is no named pose '{request.name}'{there_is}")
        size = known[request.name].size
        if size is not None:
            x, y, z = (edge / 2.0 for edge in size)
            response.bounds.type = _Bounds.TYPE_BOX
            # The upper right corner comes first.
            response.bounds.points = [_Vector3(x=x, y=y, z=z), _Vector3(x=-x, y=-y, z=-z)]


def named_poses(stage: RunningSimulation) -> list[ScenePose]:
    """Return the named poses of the world: ``poses`` of YAML, frames of SDF, sites of MJCF."""
    if stage.world is None:
        return []
    if stage.world.scene is not None:
        return list(stage.world.scene.poses)
    m = stage.simulation.model.mj_model
    found = []
    for number in np.flatnonzero(m.site_bodyid == 0):
        name = m.site(int(number)).name
        inner = name.removeprefix(WORLD_PREFIX)
        # What was spawned has a number behind the prefix.
        if inner and inner != name and not inner.split("/")[0].isdigit():
            w, x, y, z = map(float, m.site_quat[number])
            px, py, pz = map(float, m.site_pos[number])
            found.append(ScenePose(inner, Transform((px, py, pz), (x, y, z, w))))
    return found
