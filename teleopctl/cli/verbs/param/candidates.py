"""Completion candidates for names and values of parameters."""

from __future__ import annotations

from teleopctl.base.typed import Any
from teleopctl.cli.completion.completing import TypedWords
from teleopctl.errors import TeleopctlError

# Largest number of values of a range that are offered one by one.
_MOST_VALUES = 12


def parameter_names(ctx: TypedWords, incomplete: str) -> list[str]:
    """Return the parameter names of the node given on the command line."""
    from teleopctl.cli.verbs.param.client import GraphParameters

    try:
        with GraphParameters(timeout_s=0.0) as client:
            names = client.names(client.find_node(ctx.params.get("node_name") or ""))
    except TeleopctlError:
        return []
    return [name for name in names if name.startswith(incomplete)]


def parameter_values(ctx: TypedWords, incomplete: str) -> list[str]:
    """Return values for completing ``param set``: present one, booleans, range values or ends."""
    from teleopctl.cli.verbs.param.client import GraphParameters
    from teleopctl.interfaces import parameter_value_to_python

    name = ctx.params.get("parameter_name") or ""
    try:
        with GraphParameters(timeout_s=0.0) as client:
            node = client.find_node(ctx.params.get("node_name") or "")
            (value,) = client.call(node, "GetParameters", names=[name]).values
            answer = client.call(node, "DescribeParameters", names=[name])
    except (TeleopctlError, ValueError):  # no such node, or no such parameter
        return []
    present = parameter_value_to_python(value)
    if isinstance(present, bool):
        offered: list[object] = [present, not present]
    else:
        offered = [present] if present is not None else []
        for descriptor in answer.descriptors:
            offered += _range_of(descriptor)
    texts = dict.fromkeys(_yaml(each) for each in offered)
    return [text for text in texts if text.startswith(incomplete)]


# Any: a rcl_interfaces/msg/ParameterDescriptor.
def _range_of(descriptor: Any) -> list[object]:
    """Return all values of a short integer range, or the ends of any other range."""
    if descriptor.integer_range:
        found = descriptor.integer_range[0]
        values = range(found.from_value, found.to_value + 1, found.step or 1)
        return list(values) if len(values) <= _MOST_VALUES else [values[0], values[-1]]
    if descriptor.floating_point_range:
        found = descriptor.floating_point_range[0]
        return [found.from_value, found.to_value]
    return []


def _yaml(value: object) -> str:
    """Return a value as YAML text for ``param set``."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        from teleopctl.interfaces import parameter_value_to_python
        from teleopctl.node import parameter_value_from_yaml

        is_plain = parameter_value_to_python(parameter_value_from_yaml(value)) == value
        return value if value and is_plain else "'" + value.replace("'", "''") + "'"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_yaml, value))}]"
    return str(value)
