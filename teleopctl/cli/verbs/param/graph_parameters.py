"""Which nodes a verb asks about their parameters, and for how long."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager

from teleopctl.cli.command_node import brief_node
from teleopctl.cli.live import absolute_name
from teleopctl.cli.words.numbers import check_not_negative, check_positive
from teleopctl.cli.words.patterns import fitting, is_pattern
from teleopctl.errors import (
    NotFoundError,
    TeleopctlError,
    UnavailableError,
    did_you_mean,
    what_there_is,
)
from teleopctl.typed import TYPE_CHECKING, TypeAlias
from teleopctl.wire import query_graph

if TYPE_CHECKING:
    from rcl_interfaces.msg import (
        Parameter as ParameterMessage,
        ParameterValue,
        SetParametersResult,
    )

    from teleopctl.interfaces import ResponseT
    from teleopctl.node import AsyncParameterClient, BareNode, Parameter, ResponseFuture
    from teleopctl.wire import Graph

    Question: TypeAlias = Callable[[AsyncParameterClient], ResponseFuture[ResponseT]]

LONGEST_WAIT_S = 5.0
"""For answers, where the command line says nothing."""
PATIENCE_S = 1.0
"""For a node to be there, likewise."""


class Parameters:
    """The parameters of the graph's nodes, as a verb asks for them.

    Args:
        node: The node that asks.
        timeout_s: How long to wait until a node that was named is there.
        service_timeout_s: How long to wait for answers.
    """

    def __init__(self, node: BareNode, timeout_s: float, service_timeout_s: float) -> None:
        self._node = node
        self._timeout_s = timeout_s
        self._service_timeout_s = service_timeout_s
        self._graph = query_graph(node.context.session)

    def nodes(self, *, include_hidden: bool = False) -> list[str]:
        """Full names of the nodes that offer parameters, sorted."""
        return [
            name
            for name in dict.fromkeys(self._graph.node_names(include_hidden))
            if _offers_parameters(self._graph, name)
        ]

    def find(self, node_name: str) -> str:
        """The full name of a node that offers parameters, once it is there.

        Raises:
            NotFoundError: There is no such node, or it offers none.
        """
        name = absolute_name(node_name)
        if not _offers_parameters(self._graph, name):
            self._node.context.wait_for_graph(
                lambda graph: _offers_parameters(graph, name), self._timeout_s
            )
            self._graph = self._node.graph()
        if self._graph.find_node(name) is None:
            there_is = what_there_is(
                "nodes", [name], self._graph.node_names(), self._graph.node_names(True)
            )
            raise NotFoundError(f"Node not found: '{name}'", hint=there_is)
        if not _offers_parameters(self._graph, name):
            raise NotFoundError(
                f"Wait for service timed out waiting for parameter services for node {name}",
                hint="The node offers no parameters.",
            )
        return name

    def meant(self, node_name: str, *, include_hidden: bool = False) -> list[str]:
        """The full names of the nodes that a name or a pattern means.

        Raises:
            NotFoundError: There is none.
        """
        if not is_pattern(node_name):
            return [self.find(node_name)]
        return fitting(node_name, self.nodes(include_hidden=include_hidden), kind="node")

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

        return ask_nodes(self._node, node_names, question, self._service_timeout_s)

    def names(self, node_name: str) -> list[str]:
        """Names of all parameters of a node, sorted.

        Raises:
            UnavailableError: The node does not answer.
        """
        return sorted(self.ask(node_name, lambda remote: remote.list_parameters()).result.names)

    def values(self, node_name: str, names: Sequence[str]) -> dict[str, ParameterValue]:
        """Values of parameters; without those that are not declared or have none.

        Raises:
            UnavailableError: The node does not answer.
        """
        values = self.ask(node_name, lambda remote: remote.get_parameters(names)).values
        if len(values) == len(names):
            return dict(zip(names, values, strict=True))
        if len(names) <= 1:
            return {}
        # A node that misses one of them says nothing of the others either.
        found: dict[str, ParameterValue] = {}
        for name in names:
            found |= self.values(node_name, [name])
        return found

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


def _offers_parameters(graph: Graph, node_name: str) -> bool:
    return bool(graph.servers(f"{node_name}/list_parameters"))


@contextmanager
def open_parameters(
    timeout_s: float = PATIENCE_S, service_timeout_s: float = LONGEST_WAIT_S
) -> Iterator[Parameters]:
    """The parameters of the graph, through a session of its own.

    Args:
        timeout_s: How long to wait until a node that was named is there.
        service_timeout_s: How long to wait for answers.

    Raises:
        RouterNotRunning: No router answers.
    """
    check_not_negative(timeout=timeout_s)
    check_positive(service_timeout=service_timeout_s)
    with brief_node() as node:
        yield Parameters(node, timeout_s, service_timeout_s)


def not_set(parameters: Parameters, nodes: list[str], name: str) -> NotFoundError:
    """The error for a parameter that none of these nodes has; of one node, with a likely name."""
    if len(nodes) != 1:
        return NotFoundError("Parameter not set", hint=f"No node has a parameter '{name}'.")
    hint = did_you_mean(name, parameters.names(nodes[0]))
    return NotFoundError(
        "Parameter not set", hint=hint or f"`teleopctl param list {nodes[0]}` lists what there is."
    )
