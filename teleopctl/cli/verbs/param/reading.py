"""``teleopctl param list``, ``get`` and ``describe``."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any, Sequence
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import is_pattern
from teleopctl.cli.options import AsJson, NodeName
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.param.client import (
    SERVICE_TIMEOUT_S,
    GraphParameters,
    ParameterServiceOptions,
    ServiceTimeout,
    Timeout,
    not_set_error,
)
from teleopctl.errors import NotFoundError, TeleopctlError, UsageError

if TYPE_CHECKING:
    import re

    from rcl_interfaces.msg import ParameterValue


def list_parameters(
    node_name: Annotated[
        str | None,
        Argument(help="Node, or a pattern; by default all nodes.", complete="nodes"),
    ] = None,
    show_types: Annotated[
        bool, Option("--param-type", help="Show the type of each parameter.")
    ] = False,
    include_hidden: Annotated[
        bool, Option("--include-hidden-nodes", help="Include nodes whose name starts with _.")
    ] = False,
    name_filter: Annotated[
        str | None,
        Option("--filter", help="List only names whose start matches this regular expression."),
    ] = None,
    prefixes: Annotated[
        list[str] | None,
        Option(
            "--param-prefixes",
            help="List only parameters with these prefixes.",
            metavar="PREFIX...",
        ),
    ] = None,
    timeout: Timeout = 0.0,
    service_timeout: ServiceTimeout = SERVICE_TIMEOUT_S,
    as_json: AsJson = False,
) -> int:
    """Print the parameter names of one node, of matching nodes, or of all nodes."""
    wanted = _pattern(name_filter)
    is_one = node_name is not None and not is_pattern(node_name)
    with GraphParameters(timeout, service_timeout) as parameters:
        nodes = (
            parameters.matching_nodes(node_name, include_hidden=include_hidden)
            if node_name
            else parameters.nodes(include_hidden=include_hidden)
        )
        answers = parameters.call_all(nodes, "ListParameters", prefixes=prefixes or [])
        names = {
            node: sorted(name for name in answer.result.names if wanted.match(name))
            for node, answer in answers.items()
            if not isinstance(answer, TeleopctlError)
        }
        types = (
            {node: _types(parameters, node, names[node]) for node in names} if show_types else {}
        )
    if as_json:
        console.out_json({node: types.get(node) or names[node] for node in names})
    else:
        for node, its_names in names.items():
            if its_names and not is_one:
                console.out(f"{node}:")
            console.out_lines(_name_lines(its_names, types.get(node, {})))
    console.flush()
    failures = [answer for answer in answers.values() if isinstance(answer, TeleopctlError)]
    if is_one and failures:
        raise failures[0]
    for failure in failures:
        console.warn(failure.message)
    return 0


def _name_lines(names: Sequence[str], types: dict[str, str]) -> list[str]:
    return [f"  {name} (type: {types[name]})" if name in types else f"  {name}" for name in names]


def _types(parameters: GraphParameters, node: str, names: list[str]) -> dict[str, str]:
    response = parameters.call(node, "GetParameterTypes", names=names)
    return dict(zip(names, map(type_name, response.types), strict=False))


def _pattern(text: str | None) -> "re.Pattern[str]":
    import re

    try:
        return re.compile(text or "")
    except re.error as error:
        raise UsageError(f"'{text}' is not a regular expression: {error}") from error


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
    *,
    options: ParameterServiceOptions,
    as_json: AsJson = False,
) -> int:
    """Print the values of parameters of one or more nodes; return 1 if any is missing, else 0.

    With several nodes or parameters, prints the name before each value.
    """
    if not parameter_names and "/" in node_name:
        raise UsageError("Missing argument 'PARAMETER_NAME'.", hint="See `teleopctl param get -h`.")
    with options.client() as parameters:
        if parameter_names:
            names = parameter_names
            nodes = parameters.matching_nodes(node_name, include_hidden=options.include_hidden)
        else:
            names = [node_name]
            nodes = parameters.nodes(include_hidden=options.include_hidden)
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
            raise not_set_error(parameters, nodes[0], missing[0])
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
        _print_values(found[nodes[0]], hide_type=hide_type)
    elif len(names) == 1:
        values = {node: values[names[0]] for node, values in found.items() if values}
        _print_values(values, hide_type=hide_type)
    else:
        _print_by_node(found, hide_type=hide_type)
    console.flush()
    for name in missing:
        console.warn(f"Parameter not set: {name}")
    return int(bool(missing or failures))


def _print_values(values: "dict[str, ParameterValue]", *, hide_type: bool) -> None:
    """Print values below the names of their parameters or nodes, in the format of Lyrical."""
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


def describe_parameters(
    node_name: NodeName,
    parameter_names: Annotated[
        list[str],
        Argument(help="The parameters.", metavar="PARAMETER_NAME...", complete="parameter_names"),
    ],
    *,
    options: ParameterServiceOptions,
    as_json: AsJson = False,
) -> int:
    """Print type, description and constraints of a node's parameters; return 1 if one is missing.

    The exit status is 1 if a parameter is not declared.
    """
    with options.client() as parameters:
        node = parameters.find_node(node_name)
        descriptors = _descriptors(parameters, node, parameter_names)
        described = {descriptor.name for descriptor in descriptors}
        missing = [name for name in parameter_names if name not in described]
        if not descriptors:
            raise not_set_error(parameters, node, missing[0])
    if as_json:
        from teleopctl.interfaces import message_to_dict

        console.out_json([message_to_dict(descriptor) for descriptor in descriptors])
    else:
        for descriptor in descriptors:
            console.out_lines(_description(descriptor))
    console.flush()
    for name in missing:
        console.warn(f"Parameter not set: {name}")
    return int(bool(missing))


# Any: messages of rcl_interfaces.
def _descriptors(parameters: GraphParameters, node: str, names: list[str]) -> list[Any]:
    """Return the descriptors of the declared ones of a node's parameters."""
    found = parameters.call(node, "DescribeParameters", names=names).descriptors
    if len(found) == len(names):
        return list(found)
    if len(names) == 1:
        return []
    # A node that lacks one of several parameters returns none of them.
    return [each for name in names for each in _descriptors(parameters, node, [name])]


def _description(descriptor: Any) -> list[str]:
    lines = [f"Parameter name: {descriptor.name}", f"  Type: {type_name(descriptor.type)}"]
    if descriptor.description:
        lines.append(f"  Description: {descriptor.description}")
    lines.append("  Constraints:")
    if descriptor.read_only:
        lines.append("    Read only: true")
    for limits in (*descriptor.floating_point_range, *descriptor.integer_range):
        lines.append(f"    Min value: {limits.from_value}")
        lines.append(f"    Max value: {limits.to_value}")
        if limits.step:
            lines.append(f"    Step: {limits.step}")
    if descriptor.additional_constraints:
        lines.append(f"    Additional constraints: {descriptor.additional_constraints}")
    return lines


# Names of parameter types, in the order of the constants of ParameterType.
_TYPE_NAMES = (
    *("not set", "boolean", "integer", "double", "string"),
    *("byte array", "boolean array", "integer array", "double array", "string array"),
)


def type_name(number: int) -> str:
    """Return the name of a parameter type by its number in ``ParameterType``, else ``unknown``."""
    return _TYPE_NAMES[number] if 0 <= number < len(_TYPE_NAMES) else "unknown"


def value_label(number: int) -> str:
    """Return the label of a value by its type's number, such as ``Integer value is:``."""
    words = type_name(number).split()
    return f"{words[0].capitalize()} {'values are' if len(words) > 1 else 'value is'}:"


def is_set(value: "ParameterValue") -> bool:
    """Return whether the value of a parameter is set."""
    return value.type != 0


def value_text(value: "ParameterValue", *, hide_type: bool = False) -> str:
    """Return a parameter's value as ``param get`` prints it, also one that is not set."""
    if not is_set(value):
        return "None" if hide_type else "Parameter not set."
    from teleopctl.interfaces import parameter_value_to_python

    shown = str(parameter_value_to_python(value))
    return shown if hide_type else f"{value_label(value.type)} {shown}"
