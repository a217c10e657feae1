"""``teleopctl sim`` for the simulator that runs: words for its standard services."""

from pathlib import Path

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.command_node import brief_node
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.errors import NotFoundError, RefusedError, UnavailableError, UsageError
from teleopctl.wire import query_graph

# What is asked for is done at once, but for many steps and for what has to be compiled.
_LONGEST_WAIT_S = 60.0
_STANDARD, _MUJOCO = "simulation_interfaces/srv", "mujoco_ros2_control_msgs/srv"
_PLAYING, _PAUSED = 1, 2
_OK, _ALREADY = 1, 101

EntityName = Annotated[str, Argument(help="The entity, as `sim list` has it.")]
StateName = Annotated[
    str, Argument(metavar="NAME", help="A name for the simulator to keep it by, or a .json file.")
]


def pause(as_json: AsJson = False) -> None:
    """Pause the simulation."""
    _set_state(_PAUSED)
    _say("The simulation is paused", as_json)


def play(as_json: AsJson = False) -> None:
    """Resume the simulation."""
    _set_state(_PLAYING)
    _say("The simulation is running", as_json)


def step(
    steps: Annotated[int, Argument(metavar="N", help="How many steps of physics.")] = 1,
    as_json: AsJson = False,
) -> None:
    """Advance a paused simulation by steps of physics."""
    if steps < 1:
        raise UsageError(f"N is {steps}, expected at least 1")
    try:
        _standard("StepSimulation", steps=steps)
    except UnavailableError as error:
        error.hint = "The steps go on; `teleopctl sim pause` ends them."
        raise
    _say(f"Advanced by {steps} step{'s' if steps > 1 else ''}", as_json)


def reset(as_json: AsJson = False) -> None:
    """Reset time and states; spawned entities are removed, deleted ones restored."""
    _standard("ResetSimulation")
    _say("The simulation is back at its start", as_json)


def list_entities(as_json: AsJson = False) -> None:
    """List the entities of the simulation: robots and objects."""
    names = list(_standard("GetEntities").entities)
    if as_json:
        console.out_json(names)
        return
    for name in names:
        console.out(name)


def spawn(
    file: Annotated[
        str, Argument(metavar="FILE", help="A URDF, SDF, MJCF or YAML file, or a URI of one.")
    ],
    name: Annotated[
        str | None, Option("--name", help="Name of the entity; by default that in the file.")
    ] = None,
    at: Annotated[
        str | None, Option("--at", metavar="X,Y,Z", help="Where it is to be, in metres.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Add an object to the simulation; if its name is taken, a number is appended."""
    from teleopctl.interfaces import get_message, get_service

    request = get_service(f"{_STANDARD}/SpawnEntity").Request(name=name or "", allow_renaming=True)
    uri = file if "://" in file else str(Path(file).absolute())
    if hasattr(request, "uri"):
        request.uri = uri
    else:
        request.entity_resource = get_message("simulation_interfaces/msg/Resource")(uri=uri)
    if at is not None:
        position = request.initial_pose.pose.position
        position.x, position.y, position.z = _place(at)
    response = _checked(_send("SpawnEntity", _STANDARD, request))
    entity = str(response.entity_name)
    if response.result.error_message:
        console.note(f"'{entity}': {response.result.error_message}")
    if as_json:
        console.out_json({"entity": entity})
    else:
        console.out(f"Spawned {', '.join(_parts_of(entity))}")


def delete(entity: EntityName, as_json: AsJson = False) -> None:
    """Remove an entity from the simulation."""
    _standard("DeleteEntity", entity=entity)
    if as_json:
        console.out_json({"entity": entity})
    else:
        console.out(f"Deleted {entity}")


def save(name: StateName, as_json: AsJson = False) -> None:
    """Save the state of the simulation, to go back to it with `sim load`."""
    _say(_world("save_world", name), as_json)


def load(name: StateName, as_json: AsJson = False) -> None:
    """Load a saved state, or a keyframe of an MJCF file."""
    _say(_world("reset_world", name), as_json)


def _say(message: str, as_json: bool) -> None:
    if as_json:
        console.out_json({"message": message})
    else:
        console.out(message)


def _parts_of(entity: str) -> list[str]:
    """What is there by a name: the entity, or several that a file has brought."""
    names = _standard("GetEntities").entities
    return [entity] if entity in names else [n for n in names if n.startswith(f"{entity}/")]


def _place(text: str) -> list[float]:
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 3:
        raise UsageError(f"--at is '{text}', expected three numbers: --at=1,-0.5,0.3")
    return numbers


def _set_state(wanted: int) -> None:
    from teleopctl.interfaces import get_message, get_service

    state = get_message("simulation_interfaces/msg/SimulationState")(state=wanted)
    request = get_service(f"{_STANDARD}/SetSimulationState").Request(state=state)
    response = _send("SetSimulationState", _STANDARD, request)
    if response.result.result != _ALREADY:
        _checked(response)


# Any, here and below: requests and responses, whose classes are made when they are asked for.
def _standard(type_: str, **fields: object) -> Any:
    from teleopctl.interfaces import get_service

    return _checked(_send(type_, _STANDARD, get_service(f"{_STANDARD}/{type_}").Request(**fields)))


def _checked(response: Any) -> Any:
    if response.result.result != _OK:
        raise RefusedError(response.result.error_message or "The simulator refused it")
    return response


def _world(service: str, name: str) -> str:
    from teleopctl.interfaces import get_service

    keyframe = str(Path(name).absolute()) if "/" in name or name.endswith(".json") else name
    request = get_service(f"{_MUJOCO}/ResetWorld").Request(keyframe=keyframe)
    response = _send("ResetWorld", _MUJOCO, request, service)
    if not response.success:
        raise RefusedError(response.message)
    return str(response.message)


def _send(type_: str, package: str, request: Any, service: str = "") -> Any:
    """Ask the simulator, wherever in the graph its service of a type is."""
    from teleopctl.interfaces import get_service

    type_name = f"{package}/{type_}"
    with brief_node() as node:
        graph = query_graph(node.context.session)
        names = [
            name
            for name, types in graph.service_names_and_types()
            if type_name in types
            and (not service or name.endswith(f"/{service}"))
            and graph.servers(name, type_name)
        ]
        if not names:
            raise NotFoundError(
                "No simulator runs that can be asked for this",
                hint="Start one: teleopctl launch sim.yaml",
            )
        client = node.create_client(get_service(type_name), min(names))
        response = client.call_async(request).wait_for_response(_LONGEST_WAIT_S)
    if response is None:
        raise UnavailableError(f"'{min(names)}' did not answer within {_LONGEST_WAIT_S:g} s")
    return response
