"""``teleopctl param get``, ``set`` and ``delete``."""

from typing import Annotated, Any

from teleopctl.cli import console
from teleopctl.cli.options import AsJson, NodeName
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.param.graph_parameters import Parameters, open_parameters
from teleopctl.cli.verbs.param.text import type_name, value_label
from teleopctl.errors import NotFoundError, RefusedError, did_you_mean

ParameterName = Annotated[str, Argument(help="The parameter.", complete="parameter_names")]


def get_parameter(
    node_name: NodeName,
    parameter_name: ParameterName,
    hide_type: Annotated[bool, Option("--hide-type", help="Print only the value.")] = False,
    as_json: AsJson = False,
) -> None:
    """Print the value of a parameter."""
    with open_parameters() as parameters:
        node = parameters.find(node_name)
        value = _value(parameters, node, parameter_name)
    from teleopctl.node import parameter_value_to_python, plain_parameter_value

    if as_json:
        console.out_json(
            {
                "name": parameter_name,
                "type": type_name(value.type),
                "value": plain_parameter_value(value),
            }
        )
        return
    shown = str(parameter_value_to_python(value))
    console.out_text(shown if hide_type else f"{value_label(value.type)} {shown}")


def set_parameter(
    node_name: NodeName,
    parameter_name: ParameterName,
    value: Annotated[str, Argument(help="The new value, as YAML.", complete="parameter_values")],
) -> None:
    """Change a parameter.

    The value is YAML: 1 is an integer, 1.0 a double, true a boolean, "1" a string, [1, 2] an
    array.
    """
    from teleopctl.interfaces import get_message
    from teleopctl.node import parameter_value_from_yaml

    with open_parameters() as parameters:
        node = parameters.find(node_name)
        wanted = get_message("rcl_interfaces/msg/Parameter")(
            name=parameter_name, value=parameter_value_from_yaml(value)
        )
        result = parameters.set(node, [wanted])[parameter_name]
    if not result.successful:
        raise RefusedError(_with_reason("Setting parameter failed", result.reason))
    console.out(_with_reason("Set parameter successful", result.reason))


def delete_parameter(node_name: NodeName, parameter_name: ParameterName) -> None:
    """Delete a parameter."""
    from teleopctl.node import Parameter

    with open_parameters() as parameters:
        node = parameters.find(node_name)
        result = parameters.set(node, [Parameter(parameter_name)])[parameter_name]
    if not result.successful:
        raise RefusedError(_with_reason("Deleting parameter failed", result.reason))
    console.out(_with_reason("Deleted parameter successfully", result.reason))


def _value(parameters: Parameters, node: str, name: str) -> Any:
    from teleopctl.node import ParameterType

    values = parameters.ask(node, lambda remote: remote.get_parameters([name])).values
    if not values or values[0].type == ParameterType.NOT_SET:
        hint = did_you_mean(name, parameters.names(node))
        raise NotFoundError(
            "Parameter not set", hint=hint or f"`teleopctl param list {node}` lists what there is."
        )
    return values[0]


def _with_reason(text: str, reason: str) -> str:
    return f"{text}: {reason}" if reason else text
