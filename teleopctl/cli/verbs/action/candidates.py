"""What Tab offers for actions and their types."""

from __future__ import annotations

from teleopctl.cli.completion.completing import TypedWords
from teleopctl.errors import TeleopctlError


def actions(incomplete: str) -> list[str]:
    """Return the names of actions."""
    return [name for name in _live() if name.startswith(incomplete)]


def action_types(ctx: TypedWords, incomplete: str) -> list[str]:
    """Return the types of the action on the line, else all known types."""
    from teleopctl.cli.live import absolute_name
    from teleopctl.interfaces import list_types

    name = ctx.params.get("action_name")
    live = _live().get(absolute_name(name)) if name else None
    return [type_ for type_ in live or list_types("action") if type_.startswith(incomplete)]


def _live() -> dict[str, list[str]]:
    from teleopctl.cli.live import live_graph

    try:
        return dict(live_graph().action_names_and_types())
    except TeleopctlError:
        return {}
