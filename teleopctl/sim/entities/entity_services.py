"""Services of simulation_interfaces for entities, their states, and named poses."""

from __future__ import annotations

from collections.abc import Container
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl.errors import InvalidMessageError, NotFoundError
from teleopctl.interfaces import get_message, get_service, set_stamp
from teleopctl.mujoco_model import WORLD_PREFIX
from teleopctl.robot import ScenePose
from teleopctl.sim.entities.entity import (
    BoundingBox,
    Observed,
    SimulatedEntity,
    bounds_of,
    entities,
    find,
    motion_of,
    move,
)
from teleopctl.sim.entities.name_filter import matching_names
from teleopctl.sim.entities.poses import (
    fill_pose,
    fill_twist,
    frame_of,
    pose_in_world,
    twist_in_world,
)
from teleopctl.sim.entities.service_base import Refusal, Result, SimulationServices, has_tags
from teleopctl.tf import Transform

if TYPE_CHECKING:
    from teleopctl.sim.entities.running_simulation import RunningSimulation

_Bounds = get_message("simulation_interfaces/msg/Bounds")
_Category = get_message("simulation_interfaces/msg/EntityCategory")
_EntityInfo = get_message("simulation_interfaces/msg/EntityInfo")
_EntityState = get_message("simulation_interfaces/msg/EntityState")
_Vector3 = get_message("geometry_msgs/msg/Vector3")
_INVALID_POSE = get_service("simulation_interfaces/srv/SetEntityState").Response.INVALID_POSE


def offer_entity_services(services: SimulationServices) -> None:
    """Create the services that list entities, get or set states and infos, and get bounds.

    Args:
        services: Services of the node, on which these are created.
    """
    services.offer("GetEntities", "get_entities", _list)
    services.offer("GetEntitiesStates", "get_entities_states", _list_states)
    services.offer("GetEntityState", "get_entity_state", _get_state)
    services.offer("SetEntityState", "set_entity_state", _set_state)
    services.offer("GetEntityInfo", "get_entity_info", _get_info)
    services.offer("SetEntityInfo", "set_entity_info", _set_info)
    services.offer("GetEntityBounds", "get_entity_bounds", _get_bounds)


# Any, here and below: messages, whose classes are made at run time.
async def _list(running: RunningSimulation, request: Any, response: Any) -> None:
    names = await _named(running, request.filters)
    chosen = running.call(lambda: _chosen(running, names, request.filters))
    response.entities = [entity.name for entity in chosen]


async def _list_states(running: RunningSimulation, request: Any, response: Any) -> None:
    names = await _named(running, request.filters)

    def look() -> None:
        seen = running.simulation.observe()
        for entity in _chosen(running, names, request.filters):
            response.entities.append(entity.name)
            state = _EntityState()
            _fill_state(state, running, entity, seen)
            response.states.append(state)

    running.call(look)


def _get_state(running: RunningSimulation, request: Any, response: Any) -> None:
    def look() -> None:
        _fill_state(response.state, running, find(running.simulation, request.entity))

    running.call(look)


def _set_state(running: RunningSimulation, request: Any, response: Any) -> None:
    del response
    # Before simulation_interfaces 2.1 there was no choice: all of the state is set.
    with_pose = getattr(request, "set_pose", True)
    with_twist = getattr(request, "set_twist", True)
    if getattr(request, "set_acceleration", False):
        raise Refusal(
            Result.RESULT_FEATURE_UNSUPPORTED,
            "Accelerations cannot be set: they follow from forces",
        )

    def change() -> None:
        simulation, state = running.simulation, request.state
        entity = find(simulation, request.entity)
        frame = frame_of(simulation, state.header.frame_id)
        twist = twist_in_world(state.twist, frame) if with_twist else None
        try:
            pose = pose_in_world(state.pose, frame) if with_pose else None
        except InvalidMessageError as error:
            raise Refusal(_INVALID_POSE, error.message) from error
        move(simulation, entity, pose, twist)

    running.call_and_publish(change)


def _get_info(running: RunningSimulation, request: Any, response: Any) -> None:
    response.info = _info(running, running.call(lambda: find(running.simulation, request.entity)))


def _set_info(running: RunningSimulation, request: Any, response: Any) -> None:
    del response
    entity = running.call(lambda: find(running.simulation, request.entity))
    running.infos[entity.name] = request.info


def _get_bounds(running: RunningSimulation, request: Any, response: Any) -> None:
    box = running.call(
        lambda: bounds_of(running.simulation, find(running.simulation, request.entity))
    )
    if box is not None:
        response.bounds.type = _Bounds.TYPE_BOX
        # The upper right corner comes first.
        response.bounds.points = [_point(box.high), _point(box.low)]


def _info(running: RunningSimulation, entity: SimulatedEntity) -> Any:
    if entity.name in running.infos:
        return running.infos[entity.name]
    category = _Category.CATEGORY_STATIC_OBJECT
    if entity.is_robot:
        category = _Category.CATEGORY_ROBOT
    elif entity.index is not None:
        category = _Category.CATEGORY_DYNAMIC_OBJECT
    return _EntityInfo(category=_Category(category=category))


async def _named(running: RunningSimulation, filters: Any) -> frozenset[str]:
    """Return the names of all entities that match a filter's regular expression."""
    names = running.call(lambda: list(entities(running.simulation)))
    return frozenset(await matching_names(filters.filter, names))


def _chosen(
    running: RunningSimulation, names: Container[str], filters: Any
) -> list[SimulatedEntity]:
    """Return the entities of some names that pass the rest of a filter."""
    categories = {category.category for category in filters.categories}
    chosen, seen = [], running.simulation.observe() if filters.bounds.type else None
    for entity in entities(running.simulation).values():
        info = _info(running, entity)
        if (
            entity.name in names
            and (not categories or info.category.category in categories)
            and has_tags(info.tags, filters.tags)
            and _is_within(running, entity, filters.bounds, seen)
        ):
            chosen.append(entity)
    return chosen


def _fill_state(
    state: Any, running: RunningSimulation, entity: SimulatedEntity, seen: Observed | None = None
) -> None:
    simulation = running.simulation
    motion = motion_of(simulation, entity, seen)
    state.header.frame_id = simulation.model.world_frame
    set_stamp(state.header.stamp, simulation.time_ns)
    fill_pose(state.pose, motion.pose)
    fill_twist(state.twist, motion.twist)
    fill_twist(state.acceleration, motion.acceleration)


def _is_within(
    running: RunningSimulation, entity: SimulatedEntity, bounds: Any, seen: Observed | None
) -> bool:
    points = [np.array([point.x, point.y, point.z]) for point in bounds.points]
    if bounds.type == _Bounds.TYPE_EMPTY:
        return True
    if bounds.type not in (_Bounds.TYPE_BOX, _Bounds.TYPE_SPHERE):
        raise Refusal(
            Result.RESULT_FEATURE_UNSUPPORTED, "Only boxes and spheres are supported as bounds"
        )
    if len(points) != 2 or not np.isfinite(points).all():
        raise Refusal(Result.RESULT_OPERATION_FAILED, "The bounds are not two finite points")
    box = bounds_of(running.simulation, entity, seen, in_world=True)
    if box is None:
        return False
    if bounds.type == _Bounds.TYPE_SPHERE:
        return box.touches(points[0], float(points[1][0]))
    return box.overlaps(BoundingBox(np.minimum(*points), np.maximum(*points)))


def _point(place: Any) -> Any:
    x, y, z = map(float, place)
    return _Vector3(x=x, y=y, z=z)


_NamedPose = get_message("simulation_interfaces/msg/NamedPose")


class PoseServices:
    """Services of simulation_interfaces that list the world's named poses and get their bounds.

    Args:
        services: Services of the node, on which these are created.
    """

    def __init__(self, services: SimulationServices) -> None:
        services.offer("GetNamedPoses", "get_named_poses", self._list)
        services.offer("GetNamedPoseBounds", "get_named_pose_bounds", self._get_bounds)

    # Any, here and below: messages, whose classes are made at run time.
    def _list(self, running: RunningSimulation, request: Any, response: Any) -> None:
        for place in named_poses(running):
            if has_tags(list(place.tags), request.tags):
                found = _NamedPose(
                    name=place.name, description=place.description, tags=list(place.tags)
                )
                x, y, z, w = place.pose.rotation
                fill_pose(found.pose, np.array([*place.pose.translation, w, x, y, z]))
                response.poses.append(found)

    def _get_bounds(self, running: RunningSimulation, request: Any, response: Any) -> None:
        known = {place.name: place for place in named_poses(running)}
        if request.name not in known:
            there_is = f"; there is {', '.join(known)}" if known else ""
            raise NotFoundError(f"There is no named pose '{request.name}'{there_is}")
        size = known[request.name].size
        if size is not None:
            x, y, z = (edge / 2.0 for edge in size)
            response.bounds.type = _Bounds.TYPE_BOX
            # The upper right corner comes first.
            response.bounds.points = [_Vector3(x=x, y=y, z=z), _Vector3(x=-x, y=-y, z=-z)]


def named_poses(running: RunningSimulation) -> list[ScenePose]:
    """Return the named poses in the loaded world's YAML, SDF or MJCF file; empty if no world."""
    if running.world is None:
        return []
    if running.world.scene is not None:
        return list(running.world.scene.poses)
    m = running.simulation.model.mj_model
    found = []
    for number in np.flatnonzero(m.site_bodyid == 0):
        name = m.site(int(number)).name
        inner = name.removeprefix(WORLD_PREFIX)
        # Sites of spawned objects have a number behind the prefix.
        if inner and inner != name and not inner.split("/")[0].isdigit():
            w, x, y, z = map(float, m.site_quat[number])
            px, py, pz = map(float, m.site_pos[number])
            found.append(ScenePose(inner, Transform((px, py, pz), (x, y, z, w))))
    return found
