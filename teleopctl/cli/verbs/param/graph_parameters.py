"""Which nodes a verb asks about their parameters, and for how long."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeAlias

from teleopctl.cli.command_node import brief_node
from teleopctl.cli.live import absolute_name
from teleopctl.errors import NotFoundError, TeleopctlError, UnavailableError, what_there_is
from teleopctl.wire import query_graph

if TYPE_CHECKING:
    from rcl_interfaces.msg import Parameter as ParameterMessage, SetParametersResult

    from teleopctl.interfaces import ResponseT
    from teleopctl.node import AsyncParameterClient, BareNode, Parameter, ResponseFuture

    Question: TypeAlias = Callable[[AsyncParameterClient], ResponseFuture[ResponseT]]

LONGEST_WAIT_S = 5.0


class Parameters:
    """The parameters of the graph's nodes, as a verb asks for them.

    Args:
        node: The node that asks.
    """

    def __init__(self, node: BareNode) -> None:
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
            NotFoundError: There is no such node, or it offers none.
        """
        name = absolute_name(node_name)
        if self._graph.find_node(name) is None:
            there_is = what_there_is(
                "nodes", [name], self._graph.node_names(), self._graph.node_names(True)
            )
            raise NotFoundError(f"Node not found: '{name}'", hint=there_is)
        if not self._graph.servers(f"{name}/list_parameters"):
            raise NotFoundError(f"Node '{name}' offers no parameters")
        return name

    def ask(self, node_name: str, question: Question[ResponseT]) -> ResponseT:
        """Send a request to one node and return its response, whatever the question was.

        Raises:
            UnavailableError: The node does not answer.
        """
        answer = self.ask_all([node_name], question)[node_name]
        if isinstance(answer, TeleopctlError):
            raise answer
        return answer

    def ask_all(
        self, node_names: Iterable[str], question: Question[ResponseT]
    ) -> Mapping[str, ResponseT | UnavailableError]:
        """Ask many nodes at once; the response of each, or the error where it did not answer."""
        from teleopctl.node import ask_nodes

        return ask_nodes(self._node, node_names, question, LONGEST_WAIT_S)

    def names(self, node_name: str) -> list[str]:
        """Names of all parameters of a node, sorted.

        Raises:
            UnavailableError: The node does not answer.
        """
        return sorted(self.ask(node_name, lambda remote: remote.list_parameters()).result.names)

    def set(
        self, node_name: str, parameters: Sequence[Parameter | ParameterMessage]
    ) -> Mapping[str, SetParametersResult]:
        """Set parameters, each for itself; a ``SetParametersResult`` for each name.

        Args:
            node_name: Full name of the node.
            parameters: Each is a `Parameter` or its message.

        Raises:
            UnavailableError: The node does not answer.
        """
        results = self.ask(node_name, lambda remote: remote.set_parameters(parameters)).results
        return dict(zip((each.name for each in parameters), results, strict=False))


@contextmanager
def open_parameters() -> Iterator[Parameters]:
    """The parameters of the graph, through a session of its own.

    Raises:
        RouterNotRunning: No router answers.
    """
    with brief_node() as node:
        yield Parameters(node)
