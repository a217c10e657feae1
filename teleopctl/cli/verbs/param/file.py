"""``teleopctl param dump`` and ``load``."""

from pathlib import Path
from typing import Annotated

from teleopctl.cli import console
from teleopctl.cli.options import AsJson, NodeName
from teleopctl.cli.verb import Argument
from teleopctl.cli.verbs.param.graph_parameters import open_parameters
from teleopctl.errors import NotFoundError
from teleopctl.node import Parameter, parameter_document, read_parameter_file


def dump_parameters(
    node_name: NodeName,
    as_json: AsJson = False,
) -> None:
    """Print a node's parameters as a file.

    It is what --params-file and `teleopctl param load` read.
    """
    with open_parameters() as parameters:
        node = parameters.find(node_name)
        names = parameters.names(node)
        values = parameters.ask(node, lambda remote: remote.get_parameters(names)).values
    document = parameter_document(node, zip(names, values, strict=False))
    if as_json:
        console.out_json(document)
        return
    import yaml

    # It ends in an empty line, as ROS 2's does.
    console.out_text(yaml.safe_dump(document, allow_unicode=True))


def load_parameters(
    node_name: NodeName,
    parameter_file: Annotated[str, Argument(help="A parameter file.")],
) -> int:
    """Set parameters from a file.

    Of the file's sections, those count whose name fits the node.
    """
    wanted = read_parameter_file(Path(parameter_file))
    with open_parameters() as parameters:
        node = parameters.find(node_name)
        values = [Parameter(name, value=value) for name, value in wanted.for_node(node).items()]
        if not values:
            raise NotFoundError(f"{parameter_file} has no parameters for '{node}'")
        results = parameters.set(node, values)
    failed = False
    for name, result in results.items():
        reason = f": {result.reason}" if result.reason else ""
        if result.successful:
            console.out(f"Set parameter {name} successful{reason}")
        else:
            failed = True
            console.note(f"Set parameter {name} failed{reason}")
    return int(failed)
