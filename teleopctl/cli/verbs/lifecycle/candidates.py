"""What Tab offers for managed nodes and their transitions."""

from __future__ import annotations

from teleopctl.cli.completion.completing import TypedWords
from teleopctl.errors import TeleopctlError

# Who presses Tab waits for no longer.
_LONGEST_WAIT_S = 1.0


def managed_nodes(incomplete: str) -> list[str]:
    """Return the full names of managed nodes."""
    from teleopctl.cli.live import live_graph
    from teleopctl.cli.verbs.lifecycle.nodes import managed_nodes

    try:
        return [name for name in managed_nodes(live_graph()) if name.startswith(incomplete)]
    except TeleopctlError:
        return []


def transitions(ctx: TypedWords, incomplete: str) -> list[str]:
    """Return the labels of the possible transitions."""
    from teleopctl.cli.verbs.lifecycle.graph_lifecycles import open_lifecycles

    try:
        with open_lifecycles(_LONGEST_WAIT_S) as lifecycles:
            node = lifecycles.find(ctx.params.get("node_name") or "")
            answer = lifecycles.ask(node, "GetAvailableTransitions", "get_available_transitions")
    except TeleopctlError:
        return []
    labels = [each.transition.label for each in answer.available_transitions]
    return [label for label in labels if label.startswith(incomplete)]
