"""Setting what a parameter file holds, so that what was dumped is taken back."""

from __future__ import annotations

from collections.abc import Mapping

from teleopctl.base.typed import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rcl_interfaces.msg import Parameter as ParameterMessage

    from teleopctl.cli.verbs.param.graph_parameters import Parameters
    from teleopctl.cli.verbs.param.results import Results


def load_values(
    parameters: Parameters,
    node: str,
    values: Mapping[str, Any],  # Any: YAML's values
    told: Results,
    indent: str = "",
) -> bool:
    """Set parameters of a node one by one, and print the results.

    Values that are null stay as they are. One that may not be changed and has the value already
    counts as set.

    Args:
        parameters: How to reach the node.
        node: Its full name.
        values: The values by name.
        told: Who says what became of it.
        indent: What each line begins with.

    Returns:
        Whether all are as the values say.

    Raises:
        UnavailableError: The node does not answer.
        TypeError: A value is none that parameters can have.
    """
    wanted = {message.name: message for message in _messages(parameters, node, values)}
    results = parameters.set(node, list(wanted.values()))
    refused = [name for name, result in results.items() if not result.successful]
    present = parameters.values(node, refused) if refused else {}
    all_well = True
    for name, result in results.items():
        reason = f": {result.reason}" if result.reason else ""
        if result.successful:
            line = f"{indent}Set parameter {name} successful{reason}"
            told.tell(line, node, [name], result.reason)
        elif name in present and present[name] == wanted[name].value:
            reason = "it has this value already"
            line = f"{indent}Set parameter {name} successful: {reason}"
            told.tell(line, node, [name], reason)
        else:
            all_well = False
            line = f"{indent}Set parameter {name} failed{reason}"
            told.tell(line, node, [name], result.reason, successful=False)
    return all_well


def _messages(
    parameters: Parameters, node: str, values: Mapping[str, Any]
) -> list[ParameterMessage]:
    from teleopctl.node import Parameter, ParameterType

    # An empty list of a file says nothing of its type; the parameter that is there does.
    empty = [name for name, value in values.items() if isinstance(value, list) and not value]
    present = parameters.values(node, empty) if empty else {}
    types = {name: ParameterType(value.type) for name, value in present.items()}
    return [
        Parameter(name, _list_type(types.get(name)), value).to_parameter_msg()
        for name, value in values.items()
        if value is not None
    ]


def _list_type(present: Any) -> Any:
    from teleopctl.node import ParameterType

    is_list = present is not None and present >= ParameterType.BYTE_ARRAY
    return present if is_list else None
