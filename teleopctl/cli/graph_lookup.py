"""The live graph of nodes, and names and types that are looked up in it."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING, Iterable, Sequence
from teleopctl.errors import NotFoundError
from teleopctl.wire import RouterNotRunning, open_session, query_graph

if TYPE_CHECKING:
    from teleopctl.wire import Graph


def live_graph() -> Graph:
    """Return the ROS graph of this domain (nodes and endpoints), queried from the router.

    Raises:
        RouterNotRunning: No router runs.
    """
    with open_session("client") as session:
        return query_graph(session)


def absolute_name(name: str) -> str:
    """Return a name with a leading slash, which is added if it is missing."""
    return name if name.startswith("/") else f"/{name}"


def is_pattern(name: str) -> bool:
    """Return whether a name is a pattern with ``*``."""
    return "*" in name


def matching_names(pattern: str, names: Iterable[str], *, kind: str) -> list[str]:
    """Return the names that match a pattern, in their order; raise an error if none does.

    Args:
        pattern: Pattern such as ``/arm/*``; ``*`` matches within one part of a name, ``**`` any.
        names: Full names to match.
        kind: Kind of the names, such as ``topic``, for the error message.

    Raises:
        NotFoundError: No name matches.
    """
    import re

    parts = re.split(r"(\*\*|\*)", absolute_name(pattern))
    meant = {"**": ".*", "*": "[^/]*"}
    expression = re.compile("".join(meant.get(part) or re.escape(part) for part in parts))
    found = [name for name in names if expression.fullmatch(name)]
    if not found:
        raise NotFoundError(f"No {kind} fits '{pattern}'")
    return found


def expand_patterns(names: Sequence[str], known: Iterable[str], *, kind: str) -> list[str]:
    """Return absolute names, each pattern replaced by matching known names; no duplicates.

    Raises:
        NotFoundError: No known name matches a pattern.
    """
    live = list(known)
    found: dict[str, None] = {}
    for name in names:
        fits = matching_names(name, live, kind=kind) if is_pattern(name) else [absolute_name(name)]
        found.update(dict.fromkeys(fits))
    return list(found)


def learn_type(type_name: str, graph: Graph | None = None) -> None:
    """Request the definition of an unknown type from a node that uses it, and register it.

    Args:
        type_name: Full name of a message or service type.
        graph: ROS graph; None to query it.

    Raises:
        InvalidMessageError: A node's type description is invalid, or contradicts a known type.
    """
    from teleopctl.interfaces import known_types

    if known_types().find(type_name) is not None:
        return
    if graph is None:
        try:
            graph = live_graph()
        except RouterNotRunning:
            return
    if any(e.type_name == type_name for e in graph.endpoints):
        from teleopctl.cli.command_node import command_node
        from teleopctl.node import add_type_from_graph

        with command_node(session_mode="client") as node:
            add_type_from_graph(node, type_name, graph)
