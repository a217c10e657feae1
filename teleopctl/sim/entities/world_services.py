"""simulation_interfaces: the world around the robot, and others that it can be put into."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.errors import InvalidDescriptionError, UnknownFormatError
from teleopctl.interfaces import get_message, get_service
from teleopctl.packages import package_share
from teleopctl.robot import World, read_world, read_world_text
from teleopctl.sim.entities.answers import (
    Refusal,
    Result,
    SimulationServices,
    description_at,
    files_at,
)
from teleopctl.sim.entities.spawn_services import meshes_left_out

if TYPE_CHECKING:
    from teleopctl.sim.entities.stage import RunningSimulation

_Load = get_service("simulation_interfaces/srv/LoadWorld").Response
_Current = get_service("simulation_interfaces/srv/GetCurrentWorld").Response
_Unload = get_service("simulation_interfaces/srv/UnloadWorld").Response
_WorldResource = get_message("simulation_interfaces/msg/WorldResource")

_TEXT = "resource_string"


class WorldServices:
    """Offers the services that list, load and unload worlds.

    Args:
        desk: Where they are offered.
    """

    def __init__(self, desk: SimulationServices) -> None:
        self._logger = desk.node.get_logger()
        desk.offer("LoadWorld", "load_world", self._load)
        desk.offer("UnloadWorld", "unload_world", self._unload)
        desk.offer("GetCurrentWorld", "get_current_world", self._tell)
        desk.offer("GetAvailableWorlds", "get_available_worlds", self._list)

    # Any, here and below: messages, whose classes are made at run time.
    def _load(self, stage: RunningSimulation, request: Any, response: Any) -> None:
        resource = getattr(request, "world_resource", request)
        world = _read(resource)
        try:
            warnings = stage.load(
                world,
                str(resource.uri or _TEXT),
                lambda warnings: _judge(request, warnings),
            )
        except InvalidDescriptionError as error:
            raise Refusal(_Load.RESOURCE_PARSE_ERROR, error.message) from error
        for warning in warnings:
            self._logger.warning(warning)
        response.result.error_message = "; ".join(warnings)
        response.world = _resource(world, str(resource.uri), str(resource.resource_string))
        self._logger.info(f"World '{response.world.name}' is loaded; the simulation is stopped")

    def _unload(self, stage: RunningSimulation, request: Any, response: Any) -> None:
        del request, response
        if stage.world is None:
            raise Refusal(_Unload.NO_WORLD_LOADED, "There is nothing around the robot")
        stage.load(None)
        self._logger.info("The world is unloaded: there is only the robot")

    def _tell(self, stage: RunningSimulation, request: Any, response: Any) -> None:
        del request
        if stage.world is None:
            raise Refusal(_Current.NO_WORLD_LOADED, "There is nothing around the robot")
        uri = "" if stage.world_source == _TEXT else stage.world_source
        response.world = _resource(stage.world, uri, stage.world.text)

    def _list(self, stage: RunningSimulation, request: Any, response: Any) -> None:
        del stage
        unknown = []
        own = package_share("teleopctl") / "worlds"
        for source in (str(own), *request.additional_sources):
            found = list(_worlds_in(source))
            if not found:
                unknown.append(source)
            response.worlds += found
        if request.filter.tags:
            response.worlds = []  # none of them has any
        if unknown:
            response.result.error_message = f"No worlds in {', '.join(unknown)}"
            if not request.continue_on_error:
                raise Refusal(Result.RESULT_NOT_FOUND, response.result.error_message)


def _judge(request: Any, warnings: tuple[str, ...]) -> None:
    """Refuse a world of which something is missing, where that is asked for."""
    meshes = meshes_left_out(warnings)
    others = [warning for warning in warnings if warning not in meshes]
    if meshes and not request.ignore_missing_or_unsupported_assets:
        raise Refusal(_Load.MISSING_ASSETS, "; ".join(meshes))
    if others and request.fail_on_unsupported_element:
        raise Refusal(_Load.UNSUPPORTED_ELEMENTS, "; ".join(others))


def _read(resource: Any) -> World:
    try:
        if resource.uri:
            return read_world(description_at(resource.uri))
        if resource.resource_string:
            return read_world_text(resource.resource_string, _TEXT)
    except UnknownFormatError as error:
        raise Refusal(_Load.UNSUPPORTED_FORMAT, error.message) from error
    except InvalidDescriptionError as error:
        raise Refusal(_Load.RESOURCE_PARSE_ERROR, error.message) from error
    raise Refusal(_Load.NO_RESOURCE, "There is neither a URI nor a text of a world")


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
