"""Substitutions of launch files that ROS 2 does not have: files, nodes, controllers, worlds.

- ``$(node-exists /name)``: whether a node is in the graph.
- ``$(first-file A B …)``: the first of the files that exists.
- ``$(file-param FILE NODE NAME DEFAULT)``: a node's parameter in a parameter file.
- ``$(file-update-rate FILE NODE)``: a controller manager's update rate in it, which is checked.
- ``$(file-controllers FILE [NAMESPACE])``: the controllers that a parameter file configures.
- ``$(file-namespace FILE)``: the namespace of the controller manager in a parameter file.
- ``$(world-file FILE)``: the absolute path of a world file, which is checked.

Substitutions for robots are in `robot_substitutions`; names are registered in `teleopctl.plugins`.
"""

from __future__ import annotations

from graphlib import CycleError, TopologicalSorter

from teleopctl.base.typed import TYPE_CHECKING, Iterator, Mapping, Sequence
from teleopctl.errors import InvalidFileError, LaunchError, TeleopctlError
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.substitution import Substitution
from teleopctl.packages import resolve_uri

if TYPE_CHECKING:
    from teleopctl.node import ParameterFile

# Suffix of the controller manager's parameter NAME.type with the type of a controller.
_TYPE = ".type"
_MANAGER = "/controller_manager"
# Of ros2_control, in Hz.
_DEFAULT_UPDATE_RATE = 100
# Classes of controllers that forward received commands. They start last: where another controller
# claims the same joints, such as a trajectory controller, that one becomes active.
_FORWARDING = (
    "ForwardCommandController",
    "JointGroupEffortController",
    "JointGroupPositionController",
    "JointGroupVelocityController",
)


def _node_exists(arguments: Sequence[str], context: LaunchContext) -> str:
    name = arguments[0] if arguments[0].startswith("/") else f"/{arguments[0]}"
    return "true" if context.node_is_running(name) else "false"


def _first_file(arguments: Sequence[str], _: LaunchContext) -> str:
    for argument in arguments:
        if resolve_uri(argument).is_file():
            return argument
    raise LaunchError(f"there is no file {' nor '.join(arguments)}")


def read_parameters(file: str) -> ParameterFile:
    """Return a parsed parameter file; errors name that file instead of the launch file."""
    from teleopctl.node import read_parameter_file

    path = resolve_uri(file).absolute()
    try:
        return read_parameter_file(path)
    except InvalidFileError as error:
        error.place = str(path)  # the message names the file
        raise


def _file_parameter(arguments: Sequence[str], _: LaunchContext) -> str:
    file, node, name = arguments[:3]
    parameters = read_parameters(file).for_node(f"/{node.lstrip('/')}")
    if name in parameters:
        return str(parameters[name])
    if len(arguments) > 3:
        return arguments[3]
    raise LaunchError(f"{file} gives node '{node}' no parameter '{name}'")


def _file_update_rate(arguments: Sequence[str], _: LaunchContext) -> str:
    from teleopctl.node import find_parameter_line
    from teleopctl.robot import update_rate_problem

    file, node = arguments[0], f"/{arguments[1].lstrip('/')}"
    rate = read_parameters(file).for_node(node).get("update_rate", _DEFAULT_UPDATE_RATE)
    if problem := update_rate_problem(rate):
        error = InvalidFileError(
            f"Parameter 'update_rate' of {node} {problem}",
            hint=f"Set another one there, such as {_DEFAULT_UPDATE_RATE}.",
        )
        raise error.at(find_parameter_line([resolve_uri(file)], node, "update_rate"))
    return str(rate)


def file_controllers(arguments: Sequence[str], _: LaunchContext) -> str:
    """Evaluate ``$(file-controllers FILE [NAMESPACE])``: a parameter file's controllers.

    The type of a controller is in the controller manager's section or in the controller's own
    section; ROS 2's spawner reads both. Broadcasters start first, so that states are published
    before anything moves, and forward command controllers last, so that a trajectory controller
    claims joints before them. A controller that commands another one (chaining), as interface names
    in its parameters show, starts after the other one.
    """
    file = read_parameters(arguments[0])
    namespace = arguments[1].rstrip("/") if len(arguments) > 1 else ""
    types = {
        name.removesuffix(_TYPE): str(value)
        for name, value in file.for_node(f"{namespace}{_MANAGER}").items()
        if name.endswith(_TYPE)
    }
    for section, parameters in file.sections:
        name = section.rpartition("/")[2]
        own = file.for_node(f"{namespace}/{name}")
        if "type" in parameters and "*" not in name and "type" in own:
            types.setdefault(name, str(own["type"]))
    names = sorted(types, key=lambda name: _place_in_start_order(types[name]))
    return " ".join(_commanded_first(names, {n: file.for_node(f"{namespace}/{n}") for n in names}))


def _place_in_start_order(type_name: str) -> int:
    if type_name.endswith("Broadcaster"):
        return 0
    return 2 if type_name.endswith(_FORWARDING) else 1


def _commanded_first(
    names: Sequence[str], parameters: Mapping[str, Mapping[str, object]]
) -> Sequence[str]:
    """Return controllers in an order in which each follows those that it commands.

    A controller commands another one if its parameters name interfaces ``NAME/…`` of the other.
    """
    chains = {
        name: [other for other in dict.fromkeys(_first_words(parameters[name])) if other in names]
        for name in names
    }
    if not any(chains.values()):
        return names
    try:
        return list(TopologicalSorter(chains).static_order())
    except CycleError:
        return names  # the controller manager refuses one of them, and reports the reason


def _first_words(parameters: Mapping[str, object]) -> Iterator[str]:
    """Yield the part before the first slash of each text, also in lists of texts."""
    for value in parameters.values():
        for text in value if isinstance(value, list) else [value]:
            if isinstance(text, str) and "/" in text:
                yield text.partition("/")[0]


def defines_controllers(file: ParameterFile) -> bool:
    """Return whether a parameter file sets the type of at least one controller."""
    return any(
        name == "type" or name.endswith(_TYPE)
        for _, parameters in file.sections
        for name in parameters
    )


def namespaces_of_managers(file: ParameterFile) -> list[str]:
    """Return the namespaces of a parameter file's controller managers, without wildcard ones.

    Sections with wildcards are left out, since they apply to any namespace.
    """
    managers = (section for section, _ in file.sections if section.endswith(_MANAGER))
    return list(dict.fromkeys(m.removesuffix(_MANAGER) for m in managers if "*" not in m))


def _file_namespace(arguments: Sequence[str], _: LaunchContext) -> str:
    return next(iter(namespaces_of_managers(read_parameters(arguments[0]))), "")


def _world_file(arguments: Sequence[str], _: LaunchContext) -> str:
    """Check a world file, and return its absolute path; empty for an empty argument.

    An error is reported here, once, instead of by each node that reads the file.
    """
    if not arguments[0]:
        return ""
    from teleopctl.robot import read_world

    path = resolve_uri(arguments[0]).absolute()
    try:
        return str(read_world(path).path)
    except TeleopctlError as error:
        error.place = str(path)  # the message names the file
        raise


FILE_CONTROLLERS = Substitution(file_controllers, 1, 2)
FILE_NAMESPACE = Substitution(_file_namespace, 1, 1)
FILE_PARAM = Substitution(_file_parameter, 3, 4)
FILE_UPDATE_RATE = Substitution(_file_update_rate, 2, 2)
FIRST_FILE = Substitution(_first_file, 1, None)
NODE_EXISTS = Substitution(_node_exists, 1, 1)
WORLD_FILE = Substitution(_world_file, 1, 1)
