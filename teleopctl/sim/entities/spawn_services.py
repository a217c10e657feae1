"""simulation_interfaces: what comes into the simulation while it runs, and what leaves it."""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable, Iterator, Sequence
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
from teleopctl.sim.entities.answers import (
    Refusal,
    Result,
    SimulationServices,
    description_at,
    files_at,
)
from teleopctl.sim.entities.poses import frame_of, pose_in_world

if TYPE_CHECKING:
    from pathlib import Path

    from teleopctl.mujoco_model import Coming
    from teleopctl.sim.entities.stage import RunningSimulation

_Answer = get_service("simulation_interfaces/srv/SpawnEntity").Response
_Many = get_service("simulation_interfaces/srv/SpawnEntities").Response
_SpawnResult = get_message("simulation_interfaces/msg/SpawnResult")
_Spawnable = get_message("simulation_interfaces/msg/Spawnable")

_TEXT = "resource_string"
_NAME = re.compile(r"[A-Za-z0-9_][\w.:/ -]{0,127}")
_NAMESPACE = re.compile(r"(/?[A-Za-z_]\w*)(/[A-Za-z_]\w*)*/?")


class SpawnServices:
    """Offers the services that spawn and delete entities.

    Args:
        desk: Where they are offered.
    """

    def __init__(self, desk: SimulationServices) -> None:
        self._desk = desk
        self._logger = desk.node.get_logger()
        desk.offer("SpawnEntity", "spawn_entity", self._spawn)
        desk.offer("SpawnEntities", "spawn_entities", self._spawn_many)
        desk.offer("DeleteEntity", "delete_entity", self._delete)
        desk.offer("GetSpawnables", "get_spawnables", self._list)

    # Any, here and below: messages, whose classes are made at run time.
    async def _spawn(self, stage: RunningSimulation, request: Any, response: Any) -> None:
        await self._begin(stage, request)(response)

    async def _spawn_many(self, stage: RunningSimulation, request: Any, response: Any) -> None:
        begun = []
        for each in request.spawn_requests:
            answer = _SpawnResult()
            response.results.append(answer)
            with self._desk.answering(answer.result):
                begun.append((answer, self._begin(stage, each)))
        for answer, finish in begun:
            with self._desk.answering(answer.result):
                await finish(answer)
        failed = [r for r in response.results if r.result.result != Result.RESULT_OK]
        if failed:
            raise Refusal(
                _Many.ENTITIES_SPAWN_FAILED, f"{len(failed)} of {len(response.results)} failed"
            )

    def _begin(self, stage: RunningSimulation, request: Any) -> Callable[[Any], Awaitable[None]]:
        """Have a thing come; returns what answers when it is there."""
        world = _read(request)
        name = name_for(stage, world, request.name, renames=request.allow_renaming)
        try:
            pose = stage.ask(
                lambda: pose_in_world(
                    request.initial_pose.pose,
                    frame_of(stage.simulation, request.initial_pose.header.frame_id),
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
        spawned = stage.spawn(world, name, pose[:3], pose[3:], judge=_judge)

        async def finish(answer: Any) -> None:
            try:
                thing = await spawned
            except InvalidDescriptionError as error:
                raise Refusal(_Answer.RESOURCE_PARSE_ERROR, error.message) from error
            assert thing is not None  # only what is cancelled has no result
            remarks.extend(thing.warnings)
            for remark in remarks:
                self._logger.warning(f"Spawning '{name}': {remark}")
            self._logger.info(f"Spawned {' and '.join(repr(each) for each in thing.names)}")
            answer.entity_name = name
            answer.result.error_message = "; ".join((*remarks, *_told_of_parts(thing)))

        return finish

    def _delete(self, stage: RunningSimulation, request: Any, response: Any) -> None:
        del response
        stage.delete(request.entity)
        self._logger.info(f"Deleted '{request.entity}'")

    def _list(self, stage: RunningSimulation, request: Any, response: Any) -> None:
        del stage
        own = files_at(str(package_share("teleopctl") / "worlds"))
        # Gazebo's are not read: there may be hundreds.
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


def _read(request: Any) -> World:
    """Read what a request brings: by a URI, else as a text."""
    # simulation_interfaces 2 has both in a message of their own.
    resource = getattr(request, "entity_resource", request)
    try:
        if resource.uri:
            return read_world(description_at(resource.uri))
        if resource.resource_string:
            return read_world_text(resource.resource_string, _TEXT)
    except UnknownFormatError as error:
        raise Refusal(_Answer.UNSUPPORTED_FORMAT, error.message) from error
    except InvalidDescriptionError as error:
        raise Refusal(_Answer.RESOURCE_PARSE_ERROR, error.message) from error
    raise Refusal(_Answer.NO_RESOURCE, "There is neither a URI nor a text of what to spawn")


def meshes_left_out(warnings: Sequence[str]) -> list[str]:
    """Return the warnings about meshes that were left out of a model."""
    return [warning for warning in warnings if re.search(r"Mesh '.*' is left out: ", warning)]


def _told_of_parts(thing: Coming) -> Iterator[str]:
    """What to know of a name that is none of an entity."""
    if thing.names != (thing.name,):
        yield (
            f"there is no entity '{thing.name}' but {' and '.join(thing.names)}, which are deleted "
            "together by that name"
        )


def _judge(warnings: Sequence[str]) -> None:
    if meshes := meshes_left_out(warnings):
        raise Refusal(_Answer.MISSING_ASSETS, "; ".join(meshes))


def name_for(stage: RunningSimulation, world: World, wanted: str, *, renames: bool) -> str:
    """Return a name for a new entity: the requested one, or a free one if allowed.

    Args:
        stage: Where it comes.
        world: What it is.
        wanted: What it is to be called; empty for its own name.
        renames: Whether it may be called otherwise where that is taken.

    Raises:
        Refusal: It cannot be called so.
    """
    name = str(wanted or world.name or ("entity" if renames else ""))
    if not _NAME.fullmatch(name) or name == "world":
        raise Refusal(
            _Answer.NAME_INVALID,
            f"'{shortened(name)}' is no name: letters, digits and _ . : / - are"
            if name
            else "It has no name",
        )
    if stage.ask(lambda: stage.is_free(name)):
        return name
    if not renames:
        raise Refusal(_Answer.NAME_NOT_UNIQUE, f"There is '{name}' already")
    return stage.ask(lambda: stage.unused_name(name))


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
