"""``teleopctl param dump``, ``load``, ``save`` and ``restore``."""

from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.param.graph_parameters import (
    LONGEST_WAIT_S,
    PATIENCE_S,
    Parameters,
    with_each,
)
from teleopctl.cli.verbs.param.loading import load_values
from teleopctl.cli.verbs.param.options import HiddenNodes, Nodes, ServiceTimeout, Timeout
from teleopctl.cli.verbs.param.results import Results
from teleopctl.cli.words.patterns import is_pattern
from teleopctl.errors import NotFoundError

if TYPE_CHECKING:
    from collections.abc import Callable

    from teleopctl.node import ParameterFile

NodesOrAll = Annotated[
    list[str] | None,
    Argument(
        help="The nodes, or patterns such as '/arm/*'; otherwise all.",
        metavar="NODE_NAME...",
        complete="nodes",
    ),
]


def dump_parameters(
    node_name: Nodes,
    include_hidden: HiddenNodes = False,
    timeout: Timeout = PATIENCE_S,
    service_timeout: ServiceTimeout = LONGEST_WAIT_S,
    as_json: AsJson = False,
) -> int:
    """Print a node's parameters as a file.

    It is what --params-file and `teleopctl param load` read.
    """
    document: dict[str, Any] = {}
    with Parameters(timeout, service_timeout) as parameters:

        def add(node: str) -> bool:
            document.update(_document(parameters, node, as_json=as_json))
            return True

        nodes = parameters.meant(node_name, include_hidden=include_hidden)
        all_well = with_each(nodes, add, is_one=not is_pattern(node_name))
    if as_json:
        console.out_json(document)
        return int(not all_well)
    from teleopctl.base import ros_yaml

    # It ends in an empty line, as ROS 2's does.
    console.out_text(ros_yaml.dump(document))
    return int(not all_well)


def save_parameters(
    parameter_file: Annotated[str, Argument(help="The file that is written.", metavar="FILE")],
    node_names: NodesOrAll = None,
    include_hidden: HiddenNodes = False,
    timeout: Timeout = PATIENCE_S,
    service_timeout: ServiceTimeout = LONGEST_WAIT_S,
    as_json: AsJson = False,
) -> int:
    """Write the parameters of nodes to one file.

    `teleopctl param restore` sets them again, and --params-file starts a node with them.
    """
    from teleopctl.base import ros_yaml

    document: dict[str, Any] = {}
    with Parameters(timeout, service_timeout) as parameters:

        def add(node: str) -> bool:
            document.update(_document(parameters, node))
            return True

        all_well = _with_each_of(parameters, node_names, add, include_hidden=include_hidden)
    if document:
        Path(parameter_file).write_text(ros_yaml.dump(document), encoding="utf-8")
    if as_json:
        console.out_json({"file": parameter_file, "nodes": list(document)})
    else:
        console.out_lines(f"Saved the parameters of {node}" for node in document)
    return int(not all_well)


def load_parameters(
    node_name: Nodes,
    parameter_file: Annotated[str, Argument(help="A parameter file.")],
    no_use_wildcard: Annotated[
        bool,
        Option("--no-use-wildcard", help="Leave out what is meant for several nodes (/**)."),
    ] = False,
    include_hidden: HiddenNodes = False,
    timeout: Timeout = PATIENCE_S,
    service_timeout: ServiceTimeout = LONGEST_WAIT_S,
    as_json: AsJson = False,
) -> int:
    """Set parameters from a file.

    Of the file's sections, those count whose name fits the node.
    """
    from teleopctl.node import read_parameter_file

    wanted = read_parameter_file(Path(parameter_file))
    told = Results(as_json=as_json)
    with Parameters(timeout, service_timeout) as parameters:

        def load(node: str) -> bool:
            values = wanted.for_node(node, use_wildcard=not no_use_wildcard)
            if not values:
                raise NotFoundError(
                    "Param file does not contain selected parameters: "
                    f"{parameter_file} has none for '{node}'"
                )
            return load_values(parameters, node, values, told)

        nodes = parameters.meant(node_name, include_hidden=include_hidden)
        all_well = with_each(nodes, load, is_one=not is_pattern(node_name))
    told.finish()
    return int(not all_well)


def restore_parameters(
    parameter_file: Annotated[
        str, Argument(help="What `teleopctl param save` has written.", metavar="FILE")
    ],
    node_names: NodesOrAll = None,
    include_hidden: HiddenNodes = False,
    timeout: Timeout = PATIENCE_S,
    service_timeout: ServiceTimeout = LONGEST_WAIT_S,
    as_json: AsJson = False,
) -> int:
    """Set the parameters of nodes from one file.

    Without names, those of all nodes that the file has a section for.
    """
    from teleopctl.node import read_parameter_file

    wanted = read_parameter_file(Path(parameter_file))
    told = Results(as_json=as_json)
    with Parameters(timeout, service_timeout) as parameters:

        def restore(node: str) -> bool:
            values = wanted.for_node(node)
            if not values:
                raise NotFoundError(
                    "Param file does not contain selected parameters: "
                    f"{parameter_file} has none for '{node}'"
                )
            told.say(f"{node}:")
            return load_values(parameters, node, values, told, indent="  ")

        names = node_names or _sections(wanted)
        all_well = _with_each_of(parameters, names, restore, include_hidden=include_hidden)
    told.finish()
    return int(not all_well)


def _sections(wanted: "ParameterFile") -> list[str]:
    return list(dict.fromkeys(name for name, _ in wanted.sections))


def _with_each_of(
    parameters: Parameters,
    names: list[str] | None,
    do: "Callable[[str], bool]",
    *,
    include_hidden: bool,
) -> bool:
    """Do it with each node that is meant, all where none is named; whether all went well."""
    if not names:
        return with_each(parameters.nodes(include_hidden=include_hidden), do, is_one=False)
    is_one = len(names) == 1
    nodes: dict[str, None] = {}

    def find(name: str) -> bool:
        nodes.update(dict.fromkeys(parameters.meant(name, include_hidden=include_hidden)))
        return True

    all_found = with_each(names, find, is_one=is_one)
    return with_each(nodes, do, is_one=is_one and not is_pattern(names[0])) and all_found


# Any: YAML's values.
def _document(parameters: Parameters, node: str, *, as_json: bool = False) -> dict[str, Any]:
    from teleopctl.node import parameter_document

    values = parameters.values(node, parameters.names(node))
    return parameter_document(node, values.items(), plain=as_json)
