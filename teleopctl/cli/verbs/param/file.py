"""``teleopctl param dump``, ``load``, ``save`` and ``restore``."""

from pathlib import Path

from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.param.graph_parameters import (
    LONGEST_WAIT_S,
    PATIENCE_S,
    Parameters,
)
from teleopctl.cli.verbs.param.loading import load_values
from teleopctl.cli.verbs.param.options import HiddenNodes, Nodes, ServiceTimeout, Timeout
from teleopctl.cli.verbs.param.results import Results
from teleopctl.errors import NotFoundError, TeleopctlError
from teleopctl.typed import TYPE_CHECKING, Annotated, Any

if TYPE_CHECKING:
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
) -> None:
    """Print a node's parameters as a file.

    It is what --params-file and `teleopctl param load` read.
    """
    with Parameters(timeout, service_timeout) as parameters:
        nodes = parameters.meant(node_name, include_hidden=include_hidden)
        document: dict[str, Any] = {}
        for node in nodes:
            document |= _document(parameters, node, as_json=as_json)
    if as_json:
        console.out_json(document)
        return
    from teleopctl import ros_yaml

    # It ends in an empty line, as ROS 2's does.
    console.out_text(ros_yaml.dump(document))


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
    from teleopctl import ros_yaml

    document: dict[str, Any] = {}
    failures: list[TeleopctlError] = []
    with Parameters(timeout, service_timeout) as parameters:
        for node in _nodes(parameters, node_names, include_hidden=include_hidden):
            try:
                document |= _document(parameters, node)
            except TeleopctlError as failure:
                failures.append(failure)
    if document:
        Path(parameter_file).write_text(ros_yaml.dump(document), encoding="utf-8")
    if as_json:
        console.out_json({"file": parameter_file, "nodes": list(document)})
    else:
        console.out_lines(f"Saved the parameters of {node}" for node in document)
    console.flush()
    for each in failures:
        console.warn(each.message)
    return int(bool(failures))


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
    failed = False
    told = Results(as_json=as_json)
    with Parameters(timeout, service_timeout) as parameters:
        for node in parameters.meant(node_name, include_hidden=include_hidden):
            values = wanted.for_node(node, use_wildcard=not no_use_wildcard)
            if not values:
                raise NotFoundError(f"{parameter_file} has no parameters for '{node}'")
            failed |= not load_values(parameters, node, values, told)
    told.finish()
    return int(failed)


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
    failed = False
    told = Results(as_json=as_json)
    with Parameters(timeout, service_timeout) as parameters:
        names = node_names or _sections(wanted)
        for node in _nodes(parameters, names, include_hidden=include_hidden):
            values = wanted.for_node(node)
            if not values:
                raise NotFoundError(f"{parameter_file} has no parameters for '{node}'")
            told.say(f"{node}:")
            failed |= not load_values(parameters, node, values, told, indent="  ")
    told.finish()
    return int(failed)


def _sections(wanted: "ParameterFile") -> list[str]:
    return list(dict.fromkeys(name for name, _ in wanted.sections))


def _nodes(parameters: Parameters, names: list[str] | None, *, include_hidden: bool) -> list[str]:
    """The nodes that are meant; all where none is named."""
    if not names:
        return parameters.nodes(include_hidden=include_hidden)
    meant = [parameters.meant(name, include_hidden=include_hidden) for name in names]
    return list(dict.fromkeys(node for nodes in meant for node in nodes))


# Any: YAML's values.
def _document(parameters: Parameters, node: str, *, as_json: bool = False) -> dict[str, Any]:
    from teleopctl.node import parameter_document

    values = parameters.values(node, parameters.names(node))
    return parameter_document(node, values.items(), plain=as_json)
