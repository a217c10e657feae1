"""Asking nodes about their parameters: all that are asked at once, none is waited for in turn."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from teleopctl.cli.command_node import command_node
from teleopctl.cli.live import absolute_name
from teleopctl.errors import NotFoundError, TeleopctlError, UnavailableError, did_you_mean
from teleopctl.interfaces.store import get_message, get_service
from teleopctl.wire.graph import query_graph

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.node.values.future import Future

LONGEST_WAIT_S = 5.0


class ParameterClient:
    """The parameters of every node of the graph, through the node's parameter services.

    Args:
        node: The node that asks.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._graph = query_graph(node.context.session)

    def nodes(self, *, include_hidden: bool = False) -> list[str]:
        """Full names of the nodes that offer parameters, sorted."""
        return [
            name
            for name in dict.fromkeys(self._graph.node_names(include_hidden))
            if self._graph.servers(f"{name}/list_parameters")
        ]

    def find(self, node_name: str) -> str:
        """The full name of a node that offers parameters.

        Raises:
            TeleopctlError: There is no such node, or it offers none.
        """
        name = absolute_name(node_name)
        if self._graph.find_node(name) is None:
            known = self._graph.node_names(include_hidden=True)
            raise NotFoundError("Node not found", hint=did_you_mean(name, known))
        if not self._graph.servers(f"{name}/list_parameters"):
            raise NotFoundError(f"Node '{name}' offers no parameters")
        return name

    def ask(self, node_name: str, service: str, **fields: Any) -> Any:
        """Call one parameter service of one node.

        Args:
            node_name: Its full name.
            service: Such as ``GetParameters``.
            fields: The fields of the request.

        Raises:
            TeleopctlError: The node does not answer.
        """
        answer = self.ask_all([node_name], service, **fields)[node_name]
        if isinstance(answer, TeleopctlError):
            raise answer
        return answer

    def ask_all(
        self, node_names: Sequence[str], service: str, **fields: Any
    ) -> Mapping[str, Any | TeleopctlError]:
        """Call a parameter service of many nodes at once.

        Returns:
            The response of each node, or the error where it did not answer.
        """
        service_class = get_service(f"rcl_interfaces/srv/{service}")
        request = service_class.Request(**fields)
        futures = {
            name: self._node.create_client(
                service_class, f"{name}/{_snake_case(service)}"
            ).call_async(request)
            for name in node_names
        }
        deadline = time.monotonic() + LONGEST_WAIT_S
        return {name: _outcome(name, future, deadline) for name, future in futures.items()}

    def names(self, node_name: str) -> list[str]:
        """Names of all parameters of a node, sorted."""
        return sorted(self.ask(node_name, "ListParameters").result.names)

    def set(self, node_name: str, values: Mapping[str, Any]) -> Mapping[str, Any]:
        """Set parameters, each for itself.

        Args:
            node_name: Full name of the node.
            values: ``ParameterValue`` messages by name.

        Returns:
            A ``SetParametersResult`` for each name.
        """
        parameter = get_message("rcl_interfaces/msg/Parameter")
        wanted = [parameter(name=name, value=value) for name, value in values.items()]
        results = self.ask(node_name, "SetParameters", parameters=wanted).results
        return dict(zip(values, results, strict=False))


@contextmanager
def parameter_client() -> Iterator[ParameterClient]:
    """A client in a session of its own.

    Raises:
        RouterNotRunning: No router answers.
    """
    with command_node(session_mode="client") as node:
        yield ParameterClient(node)


def _outcome(node_name: str, future: Future, deadline: float) -> Any | TeleopctlError:
    if not future.wait(max(0.0, deadline - time.monotonic())):
        return UnavailableError(f"Node '{node_name}' did not answer within {LONGEST_WAIT_S:g} s")
    try:
        return future.result()
    except TeleopctlError as error:
        return UnavailableError(f"Node '{node_name}' did not answer: {error.message}")


def _snake_case(name: str) -> str:
    words = "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in name)
    return words.strip().replace(" ", "_")
