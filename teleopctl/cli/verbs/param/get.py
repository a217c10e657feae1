"""``teleopctl param get``."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.param.graph_parameters import (
    LONGEST_WAIT_S,
    PATIENCE_S,
    Parameters,
    not_set,
)
from teleopctl.cli.verbs.param.options import HiddenNodes, ServiceTimeout, Timeout
from teleopctl.cli.verbs.param.text import is_set, type_name, value_text
from teleopctl.cli.words.patterns import is_pattern
from teleopctl.errors import NotFoundError, TeleopctlError, UsageError

if TYPE_CHECKING:
    from rcl_interfaces.msg import ParameterValue


def get_parameter(
    node_name: Annotated[
        str,
        Argument(
            help="The node, or a pattern such as '/arm/*'; a parameter alone is that of all nodes.",
            complete="nodes",
        ),
    ],
    parameter_names: Annotated[
        list[str] | None,
        Argument(help="The parameters.", metavar="PARAMETER_NAME...", complete="parameter_names"),
    ] = None,
    hide_type: Annotated[bool, Option("--hide-type", help="Print only the value.")] = False,
    include_hidden: HiddenNodes = False,
    timeout: Timeout = PATIENCE_S,
    service_timeout: ServiceTimeout = LONGEST_WAIT_S,
    as_json: AsJson = False,
) -> int:
    """Print the values of parameters.

    Of several nodes or parameters, each value has its name before it.
    """
    if not parameter_names and "/" in node_name:
        raise UsageError("Missing argument 'PARAMETER_NAME'.", hint="See `teleopctl param get -h`.")
    with Parameters(timeout, service_timeout) as parameters:
        if parameter_names:
            names = parameter_names
            nodes = parameters.meant(node_name, include_hidden=include_hidden)
        else:
            names = [node_name]
            nodes = parameters.nodes(include_hidden=include_hidden)
        is_one_node = bool(parameter_names) and not is_pattern(node_name)
        is_one = is_one_node and len(names) == 1
        answers = parameters.values_of_all(nodes, names)
        failures = [each for each in answers.values() if isinstance(each, TeleopctlError)]
        if failures and is_one_node:
            raise failures[0]
        found = {
            node: values
            for node, values in answers.items()
            if not isinstance(values, TeleopctlError)
        }
        for failure in failures:
            console.warn(failure.message)
        missing = [name for name in names if not any(name in values for values in found.values())]
        if missing and (is_one or len(missing) == len(names)):
            if not is_one_node:
                raise NotFoundError(f"Parameter '{missing[0]}' not set on any node")
            raise not_set(parameters, nodes[0], missing[0])
    if as_json:
        records = [
            {"node": node, **_record(name, value)}
            for node, values in found.items()
            for name, value in values.items()
        ]
        console.out_json(_record(names[0], found[nodes[0]][names[0]]) if is_one else records)
    elif is_one:
        console.out_text(value_text(found[nodes[0]][names[0]], hide_type=hide_type))
    elif is_one_node:
        _print(found[nodes[0]], hide_type=hide_type)
    elif len(names) == 1:
        values = {node: values[names[0]] for node, values in found.items() if values}
        _print(values, hide_type=hide_type)
    else:
        _print_by_node(found, hide_type=hide_type)
    console.flush()
    for name in missing:
        console.warn(f"Parameter not set: {name}")
    return int(bool(missing or failures))


def _print(values: "dict[str, ParameterValue]", *, hide_type: bool) -> None:
    """Values below the names of their parameters, or of their nodes, as Lyrical prints them."""
    for name, value in values.items():
        text = value_text(value, hide_type=hide_type)
        console.out_text(f"{name}: {text}" if hide_type else f"{name}:\n  {text}")


def _print_by_node(found: "dict[str, dict[str, ParameterValue]]", *, hide_type: bool) -> None:
    for node, values in found.items():
        if values:
            console.out(f"{node}:")
        for name, value in values.items():
            console.out_text(f"  {name}: {value_text(value, hide_type=hide_type)}")


def _record(name: str, value: "ParameterValue") -> "dict[str, console.Json]":
    from teleopctl.node import plain_parameter_value

    return {
        "name": name,
        "type": type_name(value.type),
        "value": plain_parameter_value(value) if is_set(value) else None,
    }
