"""Services of simulation_interfaces that spawn and delete entities, and load and unload worlds."""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.base.printable import shortened
from teleopctl.errors import (
    InvalidDescriptionError,
    InvalidMessageError,
    NotFoundError,
    UnknownFormatError,
)
from teleopctl.interfaces import get_message, get_service
from teleopctl.packages import package_share
from teleopctl.robot import World, gazebo_models, read_world, read_world_text
from teleopctl.sim.entities.poses import frame_of, pose_in_world
from teleopctl.sim.entities.service_base import (
    Refusal,
    Result,
    SimulationServices,
    description_at,
    files_at,
)

if TYPE_CHECKING:
    from pathlib import Path

    from teleopctl.mujoco_model import NewObject
    from teleopctl.sim.entities.running_simulation import RunningSimulation

_Answer = get_service("simulation_interfaces/srv/SpawnEntity").Response
_Many = get_service("simulation_interfaces/srv/SpawnEntities").Response
_SpawnResult = get_message("simulation_interfaces/msg/SpawnResult")
_Spawnable = get_message("simulation_interfaces/msg/Spawnable")

_TEXT = "resource_string"
_NAME = re.compile(r"[A-Za-z0-9_][\w.:/ -]{0,127}")
_NAMESPACE = re.compile(r"(/?[A-Za-z_]\w*)(/[A-Za-z_]\w*)*/?")


class SpawnServices:
    """Services that spawn and delete entities, and list the files that can be spawned.

    Args:
        services: Services of the node, on which these are created.
    """

    def __init__(self, services: SimulationServices) -> None:
        self._services = services
        self._logger = services.node.get_logger()
        services.offer("SpawnEntity", "spawn_entity", self._spawn)
        services.offer("SpawnEntities", "spawn_entities", self._spawn_many)
        services.offer("DeleteEntity", "delete_entity", self._delete)
        services.offer("GetSpawnables", "get_spawnables", self._list)

    # Any, here and below: messages, whose classes are made at run time.
    async def _spawn(self, running: RunningSimulation, request: Any, response: Any) -> None:
        await self._begin(running, request)(response)

    async def _spawn_many(self, running: RunningSimulation, request: Any, response: Any) -> None:
        begun = []
        for each in request.spawn_requests:
            answer = _SpawnResult()
            response.results.append(answer)
            with self._services.answering(answer.result):
                begun.append((answer, self._begin(running, each)))
        for answer, finish in begun:
            with self._services.answering(answer.result):
                await finish(answer)
        failed = [r for r in response.results if r.result.result != Result.RESULT_OK]
        if failed:
            raise Refusal(
                _Many.ENTITIES_SPAWN_FAILED, f"{len(failed)} of {len(response.results)} failed"
            )

    def _begin(self, running: RunningSimulation, request: Any) -> Callable[[Any], Awaitable[None]]:
        """Start to spawn an entity; return a function that waits for it and fills the response."""
        # simulation_interfaces 2 has URI and text in a message of their own.
        resource = getattr(request, "entity_resource", request)
        world = _read_resource(resource, _Answer, "what to spawn")
        name = choose_name(running, world, request.name, renames=request.allow_renaming)
        try:
            pose = running.call(
                lambda: pose_in_world(
                    request.initial_pose.pose,
                    frame_of(running.simulation, request.initial_pose.header.frame_id),
                )
            )
        except (InvalidMessageError, NotFoundError) as error:
            raise Refusal(_Answer.INVALID_POSE, error.message) from error
        remarks = []
        if request.entity_namespace:
            if not _NAMESPACE.fullmatch(request.entity_namespace):
                raise Refusal(
                    _Answer.NAMESPACE_INVALID, f"'{request.entity_namespace}' is no namespace"
                )
            remarks.append(
                f"the namespace {request.entity_namespace} is without effect: '{name}' has no "
                "interfaces of its own"
            )
        spawned = running.spawn(
            world, name, pose[:3], pose[3:], check_warnings=_refuse_missing_meshes
        )

        async def finish(answer: Any) -> None:
            try:
                thing = await spawned
            except InvalidDescriptionError as error:
                raise Refusal(_Answer.RESOURCE_PARSE_ERROR, error.message) from error
            assert thing is not None  # only a cancelled future has no result
            remarks.extend(thing.warnings)
            for remark in remarks:
                self._logger.warning(f"Spawning '{name}': {remark}")
            self._logger.info(f"Spawned {' and '.join(repr(each) for each in thing.names)}")
            answer.entity_name = name
            answer.result.error_message = "; ".join((*remarks, *_renamed_parts_remark(thing)))

        return finish

    def _delete(self, running: RunningSimulation, request: Any, response: Any) -> None:
        del response
        running.delete(request.entity)
        self._logger.info(f"Deleted '{request.entity}'")

    def _list(self, running: RunningSimulation, request: Any, response: Any) -> None:
        del running
        own = files_at(str(package_share("teleopctl") / "worlds"))
        # Gazebo's models are not read: there may be hundreds.
        found = dict.fromkeys([*filter(_is_world, own), *gazebo_models()])
        unknown = []
        for source in request.sources:
            inside = [*files_at(source), *gazebo_models(source)]
            worlds = [file.absolute() for file in inside if _is_world(file)]
            if not worlds:
                unknown.append(source)
            found |= dict.fromkeys(worlds)
        response.spawnables = [_spawnable(file.as_uri()) for file in found]
        if unknown:
            response.result.error_message = f"Nothing to spawn in {', '.join(unknown)}"


def _read_resource(resource: Any, codes: Any, noun: str) -> World:
    """Read the world of a request: from its URI, else from its text.

    Args:
        resource: Message with ``uri`` and ``resource_string``.
        codes: Class of the response, with the result codes of the service.
        noun: Name of the resource in the error message.

    Raises:
        Refusal: There is neither URI nor text, or the resource cannot be read.
        NotFoundError: There is no file at the URI.
    """
    try:
        if resource.uri:
            return read_world(description_at(resource.uri))
        if resource.resource_string:
            return read_world_text(resource.resource_string, _TEXT)
    except UnknownFormatError as error:
        raise Refusal(codes.UNSUPPORTED_FORMAT, error.message) from error
    except InvalidDescriptionError as error:
        raise Refusal(codes.RESOURCE_PARSE_ERROR, error.message) from error
    raise Refusal(codes.NO_RESOURCE, f"There is neither a URI nor a string of {noun}")


def meshes_left_out(warnings: Sequence[str]) -> list[str]:
    """Return the warnings of a model that report a missing mesh."""
    return [warning for warning in warnings if re.search(r"Mesh '.*' is left out: ", warning)]


def _renamed_parts_remark(thing: NewObject) -> Iterator[str]:
    """Yield a remark if no entity has the requested name."""
    if thing.names != (thing.name,):
        yield (
            f"there is no entity '{thing.name}' but {' and '.join(thing.names)}, which are deleted "
            "together by that name"
        )


def _refuse_missing_meshes(warnings: Sequence[str]) -> None:
    if meshes := meshes_left_out(warnings):
        raise Refusal(_Answer.MISSING_ASSETS, "; ".join(meshes))


def choose_name(running: RunningSimulation, world: World, wanted: str, *, renames: bool) -> str:
    """Return the name for an entity to spawn: requested, its own, or numbered; raise if taken.

    Args:
        running: The running simulation.
        world: Entity to spawn, as a world of its own.
        wanted: Requested name; empty for the entity's own name.
        renames: Whether a number may be appended to a name that is taken.

    Raises:
        Refusal: The name is invalid or taken.
    """
    name = str(wanted or world.name or ("entity" if renames else ""))
    if not _NAME.fullmatch(name) or name == "world":
        raise Refusal(
            _Answer.NAME_INVALID,
            f"'{shortened(name)}' is not a valid name: use letters, digits and _ . : / -"
            if name
            else "It has no name",
        )
    if running.call(lambda: running.is_free(name)):
        return name
    if not renames:
        raise Refusal(_Answer.NAME_NOT_UNIQUE, f"There is '{name}' already")
    return running.call(lambda: running.unused_name(name))


def _is_world(file: Path) -> bool:
    try:
        read_world(file)
    except InvalidDescriptionError:
        return False
    return True


def _spawnable(uri: str) -> Any:
    if hasattr(_Spawnable(), "uri"):
        return _Spawnable(uri=uri)
    return _Spawnable(entity_resource=get_message("simulation_interfaces/msg/Resource")(uri=uri))


_Load = get_service("simulation_interfaces/srv/LoadWorld").Response
_Current = get_service("simulation_interfaces/srv/GetCurrentWorld").Response
_Unload = get_service("simulation_interfaces/srv/UnloadWorld").Response
_WorldResource = get_message("simulation_interfaces/msg/WorldResource")


class WorldServices:
    """Services that list, load and unload worlds, and return the loaded one.

    Args:
        services: Services of the node, on which these are created.
    """

    def __init__(self, services: SimulationServices) -> None:
        self._logger = services.node.get_logger()
        services.offer("LoadWorld", "load_world", self._load)
        services.offer("UnloadWorld", "unload_world", self._unload)
        services.offer("GetCurrentWorld", "get_current_world", self._get_current_world)
        services.offer("GetAvailableWorlds", "get_available_worlds", self._list)

    # Any, here and below: messages, whose classes are made at run time.
    def _load(self, running: RunningSimulation, request: Any, response: Any) -> None:
        resource = getattr(request, "world_resource", request)
        world = _read_resource(resource, _Load, "a world")
        try:
            warnings = running.load(
                world,
                str(resource.uri or _TEXT),
                lambda warnings: _refuse_incomplete_world(request, warnings),
            )
        except InvalidDescriptionError as error:
            raise Refusal(_Load.RESOURCE_PARSE_ERROR, error.message) from error
        for warning in warnings:
            self._logger.warning(warning)
        response.result.error_message = "; ".join(warnings)
        response.world = _resource(world, str(resource.uri), str(resource.resource_string))
        self._logger.info(f"World '{response.world.name}' is loaded; the simulation is stopped")

    def _unload(self, running: RunningSimulation, request: Any, response: Any) -> None:
        del request, response
        if running.world is None:
            raise Refusal(_Unload.NO_WORLD_LOADED, "There is nothing around the robot")
        running.load(None)
        self._logger.info("The world is unloaded: there is only the robot")

    def _get_current_world(self, running: RunningSimulation, request: Any, response: Any) -> None:
        del request
        if running.world is None:
            raise Refusal(_Current.NO_WORLD_LOADED, "There is nothing around the robot")
        uri = "" if running.world_source == _TEXT else running.world_source
        response.world = _resource(running.world, uri, running.world.text)

    def _list(self, running: RunningSimulation, request: Any, response: Any) -> None:
        del running
        unknown = []
        own = package_share("teleopctl") / "worlds"
        for source in (str(own), *request.additional_sources):
            found = list(_worlds_in(source))
            if not found:
                unknown.append(source)
            response.worlds += found
        if request.filter.tags:
            response.worlds = []  # no world has tags
        if unknown:
            response.result.error_message = f"No worlds in {', '.join(unknown)}"
            if not request.continue_on_error:
                raise Refusal(Result.RESULT_NOT_FOUND, response.result.error_message)


def _refuse_incomplete_world(request: Any, warnings: tuple[str, ...]) -> None:
    """Refuse a world with missing parts, if the request requires all."""
    meshes = meshes_left_out(warnings)
    others = [warning for warning in warnings if warning not in meshes]
    if meshes and not request.ignore_missing_or_unsupported_assets:
        raise Refusal(_Load.MISSING_ASSETS, "; ".join(meshes))
    if others and request.fail_on_unsupported_element:
        raise Refusal(_Load.UNSUPPORTED_ELEMENTS, "; ".join(others))


def _worlds_in(source: str) -> Any:
    for file in files_at(source):
        try:
            world = read_world(file)
        except InvalidDescriptionError:
            continue
        yield _resource(world, file.absolute().as_uri(), "")


def _resource(world: World, uri: str, text: str) -> Any:
    found = _WorldResource(name=world.name or Path(world.path).stem)
    found.world_resource.uri = uri
    if not uri:
        found.world_resource.resource_string = text
    return found
