"""What Tab offers for parameters."""

from __future__ import annotations

from teleopctl.cli.completion.completing import Line
from teleopctl.errors import TeleopctlError


def parameter_names(ctx: Line, incomplete: str) -> list[str]:
    """Names of the parameters of the node that stands on the line."""
    from teleopctl.cli.verbs.param.graph_parameters import open_parameters

    try:
        with open_parameters() as client:
            names = client.names(client.find(ctx.params.get("node_name") or ""))
    except TeleopctlError:
        return []
    return [name for name in names if name.startswith(incomplete)]
