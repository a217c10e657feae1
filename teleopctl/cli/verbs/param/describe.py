"""``teleopctl param describe``."""

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.options import AsJson, NodeName
from teleopctl.cli.verb import Argument
from teleopctl.cli.verbs.param.graph_parameters import (
    LONGEST_WAIT_S,
    PATIENCE_S,
    Parameters,
    not_set,
)
from teleopctl.cli.verbs.param.options import HiddenNodes, ServiceTimeout, Timeout
from teleopctl.cli.verbs.param.text import type_name


def describe_parameters(
    node_name: NodeName,
    parameter_names: Annotated[
        list[str],
        Argument(help="The parameters.", metavar="PARAMETER_NAME...", complete="parameter_names"),
    ],
    include_hidden: HiddenNodes = False,
    timeout: Timeout = PATIENCE_S,
    service_timeout: ServiceTimeout = LONGEST_WAIT_S,
    as_json: AsJson = False,
) -> int:
    """Describe parameters.

    The exit status is 1 where one of them is not declared.
    """
    del include_hidden  # one that is named is found anyway
    with Parameters(timeout, service_timeout) as parameters:
        node = parameters.find(node_name)
        descriptors = _descriptors(parameters, node, parameter_names)
        described = {descriptor.name for descriptor in descriptors}
        missing = [name for name in parameter_names if name not in described]
        if not descriptors:
            raise not_set(parameters, node, missing[0])
    if as_json:
        from teleopctl.interfaces import message_to_dict

        console.out_json([message_to_dict(descriptor) for descriptor in descriptors])
    else:
        for descriptor in descriptors:
            console.out_lines(_block(descriptor))
    console.flush()
    for name in missing:
        console.warn(f"Parameter not set: {name}")
    return int(bool(missing))


# Any: messages of rcl_interfaces.
def _descriptors(parameters: Parameters, node: str, names: list[str]) -> list[Any]:
    """Those of a node's parameters that are declared."""
    found = parameters.ask(node, "DescribeParameters", names=names).descriptors
    if len(found) == len(names):
        return list(found)
    if len(names) == 1:
        return []
    # A node that misses one of them says nothing of the others either.
    return [each for name in names for each in _descriptors(parameters, node, [name])]


def _block(descriptor: Any) -> list[str]:
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
