"""The graph as it is now, for verbs that look once and end."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.wire import open_session, query_graph

if TYPE_CHECKING:
    from teleopctl.wire import Graph


def live_graph() -> Graph:
    """Return the nodes and endpoints of this domain.

    Raises:
        RouterNotRunning: No router answers.
    """
    with open_session("client") as session:
        return query_graph(session)


def absolute_name(name: str) -> str:
    """Return a name with a leading slash."""
    return name if name.startswith("/") else f"/{name}"
