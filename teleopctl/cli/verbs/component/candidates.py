"""What Tab offers for containers and components."""

from __future__ import annotations

from teleopctl.cli.completion.completing import TypedWords
from teleopctl.errors import TeleopctlError

# Who presses Tab waits for no longer.
_LONGEST_WAIT_S = 1.0


def containers(incomplete: str) -> list[str]:
    """Return the full names of component containers."""
    from teleopctl.cli.live import live_graph
    from teleopctl.cli.verbs.component.containers import containers

    try:
        return [name for name in containers(live_graph()) if name.startswith(incomplete)]
    except TeleopctlError:
        return []


def component_packages(incomplete: str) -> list[str]:
    """Return packages with components."""
    from teleopctl.packages import list_components

    return [name for name in list_components() if name.startswith(incomplete)]


def component_types(ctx: TypedWords, incomplete: str) -> list[str]:
    """Return the components of the package on the line."""
    from teleopctl.packages import list_components

    components = list_components().get(ctx.params.get("package_name") or "", ())
    return [each.type_name for each in components if each.type_name.startswith(incomplete)]


def component_ids(ctx: TypedWords, incomplete: str) -> list[str]:
    """Return the numbers of the components in the container on the line."""
    from teleopctl.cli.command_node import command_node
    from teleopctl.cli.verbs.component.containers import find_container, loaded

    try:
        with command_node(session_mode="client") as node:
            name = find_container(node, ctx.params.get("container_name") or "")
            answer = loaded(node, [name], _LONGEST_WAIT_S)[name]
    except TeleopctlError:
        return []
    numbers = [] if isinstance(answer, TeleopctlError) else map(str, answer.unique_ids)
    return [number for number in numbers if number.startswith(incomplete)]
