"""Services of gazebo_ros: entities, links, forces, pause and reset, over the running simulation."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.errors import InvalidMessageError, NotFoundError, RefusedError
from teleopctl.interfaces import get_service, set_stamp, to_nanoseconds
from teleopctl.robot import read_world_text
from teleopctl.sim.entities.entity import SimulatedEntity, entities, move
from teleopctl.sim.entities.poses import (
    fill_pose,
    fill_twist,
    pose_in_world,
    twist_in_world,
)
from teleopctl.sim.entities.pushes import Push
from teleopctl.sim.entities.service_base import NO_ROBOT, FindRunning, Refusal, failure_text
from teleopctl.sim.entities.spawn_services import choose_name
from teleopctl.sim.request_numbers import invalid_number_reason
from teleopctl.wire import EntityKind

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.sim.entities.running_simulation import RunningSimulation
    from teleopctl.sim.free_bodies import LinkPose
    from teleopctl.sim.simulation import Simulation

Array = npt.NDArray[np.float64]

# Names of the world's frame in Gazebo's services.
_WORLD = ("", "world", "map", "/map")


def link_of(simulation: Simulation, name: str) -> str:
    """Return the link name that a Gazebo name means: a link, an entity, or ``entity::link``.

    Returns:
        Name of the link; empty for a robot that is fixed at the world's origin.

    Raises:
        NotFoundError: There is no such entity or link.
    """
    known = entities(simulation)
    if name in known:
        return known[name].body
    if simulation.has_link(name):
        return name
    first, _, rest = name.partition("::")
    if first in known and rest:
        inner = rest.replace("::", "/")
        if simulation.has_link(f"{first}/{inner}"):
            return f"{first}/{inner}"
        if known[first].is_robot and simulation.has_link(inner):
            return inner
        if not known[first].is_robot and "/" not in inner and _is_alone(simulation, first):
            # The only link of an object has the object's name; its name in the file is not kept.
            return first
    raise NotFoundError(f"There is no entity and no link '{name}'; there is {', '.join(known)}")


def entity_of(simulation: Simulation, name: str) -> SimulatedEntity:
    """Return the entity that has a name, or whose topmost link has the name.

    Raises:
        NotFoundError: There is no such entity.
    """
    link = link_of(simulation, name)
    for entity in entities(simulation).values():
        if name == entity.name or (link and link == entity.body):
            return entity
    raise NotFoundError(f"'{name}' is a link: move its entity instead")


def motion_of_link(simulation: Simulation, link: str) -> tuple[Array, Array]:
    """Return the pose, (7,), and velocity, (6,), of a link's frame in the world.

    Args:
        simulation: Simulation of the link.
        link: Name of the link, as `link_of` returns it.

    Returns:
        Position (m) and rotation (w x y z), (7,); velocity (m/s) and angular velocity (rad/s),
        (6,).
    """
    if not link:
        return np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), np.zeros(6)
    model, data = simulation.observe()
    number, velocity = model.body(link).id, np.zeros(6)
    kind = mujoco.mjtObj.mjOBJ_XBODY
    mujoco.mj_objectVelocity(model, data, kind, number, velocity, 0)
    pose = np.concatenate([data.xpos[number], data.xquat[number]])
    # MuJoCo has the angular part first.
    return pose, np.concatenate([velocity[3:], velocity[:3]])


def frame_link(simulation: Simulation, name: str) -> str:
    """Return the name of the link that a reference frame names; empty for the world.

    Raises:
        NotFoundError: There is no such entity or link.
    """
    return "" if name in _WORLD else link_of(simulation, name)


def _is_alone(simulation: Simulation, thing: str) -> bool:
    """Whether an object has only one link."""
    m = simulation.present_model.mj_model
    return not any(m.body(number).name.startswith(f"{thing}/") for number in range(m.nbody))


# Any, here and below: messages, whose classes are made at run time.
def get_model_list(
    running: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Handle Gazebo classic's ``get_model_list``: list all entities' names in the response."""
    del request, warn

    def look() -> None:
        set_stamp(response.header.stamp, running.simulation.time_ns)
        response.model_names = list(entities(running.simulation))

    running.call(look)


async def spawn_entity(
    running: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Handle Gazebo classic's ``spawn_entity``: add an entity from URDF, SDF or MJCF text."""
    world = read_world_text(request.xml, "xml")
    # Without a requested name, the entity is renamed if its own name is taken.
    name = choose_name(running, world, request.name, renames=not request.name)
    pose = running.call(
        lambda: pose_in_world(
            request.initial_pose, _frame(running.simulation, request.reference_frame)
        )
    )
    if request.robot_namespace:
        warn(
            f"the namespace {request.robot_namespace} is without effect: '{name}' has no "
            "interfaces of its own"
        )
    thing = await running.spawn(world, name, pose[:3], pose[3:], own_pose=True)
    assert thing is not None  # only a cancelled future has no result
    for remark in thing.warnings:
        warn(f"'{name}': {remark}")
    response.status_message = f"SpawnEntity: Successfully spawned entity [{', '.join(thing.names)}]"


def delete_entity(
    running: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Handle Gazebo classic's ``delete_entity``: remove an entity."""
    del warn
    running.delete(request.name)
    response.status_message = f"Successfully deleted entity [{request.name}]"


def get_entity_state(
    running: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Handle Gazebo classic's ``get_entity_state``: respond with an entity's or link's state."""
    del warn

    def look() -> None:
        simulation = running.simulation
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

    running.call(look)


def set_entity_state(
    running: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Handle Gazebo classic's ``set_entity_state``: set the pose and twist of an entity."""
    del response, warn
    state = request.state

    def change() -> None:
        simulation = running.simulation
        entity = entity_of(simulation, state.name)
        frame = _frame(simulation, state.reference_frame)
        pose, twist = pose_in_world(state.pose, frame), twist_in_world(state.twist, frame)
        move(simulation, entity, pose, twist)

    running.call_and_publish(change)


def _frame(simulation: Simulation, name: str) -> LinkPose | None:
    link = frame_link(simulation, name)
    return simulation.link_pose(link) if link else None


def _seen_from(frame: LinkPose, pose: Any) -> Any:
    """Return a pose in the world as a pose relative to a frame, (7,)."""
    import mujoco

    inverse, turn = np.zeros(4), np.zeros(4)
    mujoco.mju_negQuat(inverse, frame.quaternion)
    mujoco.mju_mulQuat(turn, inverse, pose[3:])
    return np.concatenate([frame.rotation.T @ (pose[:3] - frame.position), turn])


# Number of steps for a negative duration, which means without end.
_ENDLESS = 1 << 62


# Any, here and below: messages, whose classes are made at run time.
def apply_link_wrench(
    running: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Handle Gazebo classic's ``apply_link_wrench``: apply a wrench to a link for a duration."""
    del warn

    def apply() -> bool:
        push = _push(running.simulation, request)
        if push is not None:
            running.simulation.push(push)
        return push is not None

    if not running.call(apply):
        response.status_message = "The duration is 0: no wrench is applied"


def clear_link_wrenches(
    running: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Handle Gazebo classic's ``clear_link_wrenches``: end all external wrenches on a link."""
    del response

    def clear() -> bool:
        return running.simulation.end_pushes(link_of(running.simulation, request.link_name))

    if not running.call(clear):
        warn(f"No applied wrenches on [{request.link_name}]")


def _push(simulation: Simulation, request: Any) -> Push | None:
    link = link_of(simulation, request.link_name)
    if not link:
        raise NotFoundError(f"'{request.link_name}' is fixed to the world: name one of its links")
    parts = request.wrench.force, request.wrench.torque, request.reference_point
    force, torque, point = (np.array([part.x, part.y, part.z]) for part in parts)
    if reason := invalid_number_reason([force, torque, point]):
        raise InvalidMessageError(f"A number of the wrench on '{link}' {reason}")
    if to_nanoseconds(request.start_time) > simulation.time_ns:
        raise RefusedError("start_time is in the future: the wrench starts now")
    pushed = simulation.link_pose(link)
    if reference := frame_link(simulation, request.reference_frame):
        frame = simulation.link_pose(reference)
        force, torque = frame.rotation @ force, frame.rotation @ torque
        lever = frame.position + frame.rotation @ point - pushed.position
    else:
        # Along the world's axes, from the link's origin.
        lever = point
    duration = to_nanoseconds(request.duration)
    if duration == 0:
        return None
    step_ns = simulation.timestep_s * 1e9
    steps = _ENDLESS if duration < 0 else max(1, round(duration / step_ns))
    return Push(link, force, torque, pushed.rotation.T @ lever, steps)


# Any, here and below: messages, whose classes are made at run time.
def pause_physics(
    running: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Handle Gazebo classic's ``pause_physics``: pause the simulation."""
    del request, response, warn
    running.pause()


def unpause_physics(
    running: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Handle Gazebo classic's ``unpause_physics``: resume the simulation."""
    del request, response, warn
    running.play()


def reset_simulation(
    running: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Handle Gazebo classic's ``reset_simulation``: reset time and states; entities stay."""
    del request, response, warn
    running.reset(time=True, state=True, spawned=False)


def reset_world(
    running: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Handle Gazebo classic's ``reset_world``: reset the states of all entities; time continues."""
    del request, response, warn
    running.reset(time=False, state=True, spawned=False)


# Any, here and below: messages, whose classes are made at run time. The last argument receives
# warnings. Handlers that take long are coroutines.
Handler = Callable[["RunningSimulation", Any, Any, Callable[[str], None]], "Awaitable[None] | None"]

_EMPTY = "std_srvs/srv/Empty"
_ALWAYS: dict[str, tuple[str, Handler]] = {
    "get_model_list": ("gazebo_msgs/srv/GetModelList", get_model_list),
    "apply_link_wrench": ("gazebo_msgs/srv/ApplyLinkWrench", apply_link_wrench),
    "clear_link_wrenches": ("gazebo_msgs/srv/LinkRequest", clear_link_wrenches),
    "pause_physics": (_EMPTY, pause_physics),
    "unpause_physics": (_EMPTY, unpause_physics),
    "reset_world": (_EMPTY, reset_world),
    # Most worlds give the namespace /gazebo to the plug-in with these services.
    "gazebo/get_entity_state": ("gazebo_msgs/srv/GetEntityState", get_entity_state),
    "gazebo/set_entity_state": ("gazebo_msgs/srv/SetEntityState", set_entity_state),
}
# simulation_interfaces has services of the same names.
_WHEN_ASKED_FOR: dict[str, tuple[str, Handler]] = {
    "spawn_entity": ("gazebo_msgs/srv/SpawnEntity", spawn_entity),
    "delete_entity": ("gazebo_msgs/srv/DeleteEntity", delete_entity),
    "get_entity_state": ("gazebo_msgs/srv/GetEntityState", get_entity_state),
    "set_entity_state": ("gazebo_msgs/srv/SetEntityState", set_entity_state),
    "reset_simulation": (_EMPTY, reset_simulation),
}


class GazeboServices:
    """Services of Gazebo classic's gazebo_ros on the simulator's node.

    Services with the name of a service of simulation_interfaces are created once there is a client
    of Gazebo's type without a server: most tools support one type per name, and for them the
    service of simulation_interfaces stays the only one.

    Args:
        node: Node of the services.
        find_running: See `FindRunning`.
    """

    def __init__(self, node: Node, find_running: FindRunning) -> None:
        self._node, self._find_running = node, find_running
        self._waiting = dict(_WHEN_ASKED_FOR)
        for name, (type_name, handler) in _ALWAYS.items():
            self._offer(name, type_name, handler)
        node.add_graph_callback(self._offer_requested)
        self._offer_requested()

    def _offer_requested(self) -> None:
        """Offer the services that have clients; called by other threads when the graph changes."""
        for name, (type_name, handler) in list(self._waiting.items()):
            full = self._node.resolve_service_name(name)
            if not self._node.matched(EntityKind.SC, full, type_name):
                continue
            if self._node.matched(EntityKind.SS, full, type_name):
                continue
            # Two threads may get here: a new service changes the graph itself.
            if self._waiting.pop(name, None) is not None:
                self._offer(name, type_name, handler)

    def _offer(self, name: str, type_name: str, handler: Handler) -> None:
        logger = self._node.get_logger()

        def warn(words: str) -> None:
            logger.warning(f"{name}: {words}")

        async def answer(request: Any, response: Any) -> Any:
            text, done = "", False
            try:
                running = self._find_running()
                if running is None:
                    raise RefusedError(NO_ROBOT)
                if (outcome := handler(running, request, response, warn)) is not None:
                    await outcome
                done = True
            except Refusal as refusal:
                text = str(refusal)
            except Exception as error:  # noqa: BLE001 - no request ends the simulation
                text = failure_text(self._node, error)
            if not done:
                logger.error(f"{name}: {text}")
            if hasattr(response, "success"):
                response.success = done
            if text and hasattr(response, "status_message"):
                response.status_message = text
            return response

        self._node.create_service(get_service(type_name), name, answer)
