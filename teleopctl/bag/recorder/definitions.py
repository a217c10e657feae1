"""Type definitions of recorded topics, in exactly the version that their publishers use."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from teleopctl.bag.records import ROS2MSG, TypeText
from teleopctl.bag.type_definitions import known_definition
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import described_definition_text
from teleopctl.node import request_type_description

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.wire import EndpointToken, Graph

_EVENT = "_Event"


class DefinitionFinder:
    """Finder of type definitions, in this process or by requests to nodes of the graph.

    Args:
        node: Node that sends requests to other nodes; needs no executor.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._found: dict[tuple[str, str], TypeText] = {}

    def find_local(self, type_name: str, version: str) -> TypeText | None:
        """Return a type's definition if this process has the type with this hash, else None."""
        key = (type_name, version)
        if key not in self._found:
            found = known_definition(type_name, version)
            if found is None:
                return None
            self._found[key] = found
        return self._found[key]

    def request(self, type_name: str, version: str, graph: Graph) -> TypeText:
        """Return a type's definition, requested from nodes that use it; empty without response.

        Blocks until a node responds, at most some seconds.
        """
        key = (type_name, version)
        if key not in self._found:
            self._found[key] = self._request_from_nodes(type_name, version, graph)
        return self._found[key]

    def _request_from_nodes(self, type_name: str, version: str, graph: Graph) -> TypeText:
        for node_name, its_type, its_version in self._nodes_with_type(type_name, version, graph):
            try:
                description = request_type_description(self._node, node_name, its_type, its_version)
                if description is not None:
                    return TypeText(ROS2MSG, described_definition_text(description, type_name))
            except TeleopctlError as error:
                self._node.get_logger().debug(f"{node_name} on {type_name}: {error.message}")
        return TypeText()

    def _nodes_with_type(
        self, type_name: str, version: str, graph: Graph
    ) -> Iterator[tuple[str, str, str]]:
        """Yield nodes that may have a type's definition, with the type and type hash to request."""
        users = (e for e in graph.endpoints if (e.type_name, e.type_hash) == (type_name, version))
        yield from self._reachable(users, graph)
        if type_name.endswith(_EVENT):
            # The description of a service includes that of its events.
            service = type_name.removesuffix(_EVENT)
            yield from self._reachable(
                (e for e in graph.endpoints if e.type_name == service), graph
            )

    def _reachable(
        self, endpoints: Iterator[EndpointToken], graph: Graph
    ) -> Iterator[tuple[str, str, str]]:
        own_name = self._node.get_fully_qualified_name()
        nodes = {(e.full_name, e.type_name, e.type_hash) for e in endpoints}
        for each in sorted(nodes):
            if each[0] != own_name and graph.servers(f"{each[0]}/get_type_description"):
                yield each
