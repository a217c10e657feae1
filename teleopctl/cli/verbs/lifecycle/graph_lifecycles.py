"""Which managed nodes a verb asks, and for how long."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli.command_node import ask_all, command_node
from teleopctl.cli.live import absolute_name
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.lifecycle.nodes import managed_nodes
from teleopctl.cli.waiting import wait_aloud
from teleopctl.errors import NotFoundError, TeleopctlError, UnavailableError, what_there_is
from teleopctl.interfaces import get_service
from teleopctl.wire import query_graph

if TYPE_CHECKING:
    from teleopctl.node import Node

ManagedNodeName = Annotated[str, Argument(help="The node.", complete="managed_nodes")]
HiddenNodes = Annotated[
    bool, Option("--include-hidden-nodes", help="Ask nodes whose name starts with _, too.")
]
Timeout = Annotated[
    float | None, Option("--timeout", help="Give up after this many seconds.", metavar="SECONDS")
]
# What is only asked for is answered at once.
_LONGEST_WAIT_S = 5.0


class Lifecycles:
    """Client of the managed nodes of the graph.

    Args:
        node: The node that asks.
        timeout_s: Longest wait for answers, in seconds; a short while if None.
    """

    def __init__(self, node: "Node", timeout_s: float | None) -> None:
        self._node = node
        self._graph = query_graph(node.context.session)
        self._timeout_s = _LONGEST_WAIT_S if timeout_s is None else timeout_s

    def nodes(self, *, include_hidden: bool = False) -> list[str]:
        """Return the full names of managed nodes, sorted."""
        return managed_nodes(self._graph, include_hidden=include_hidden)

    def find(self, node_name: str, *, include_hidden: bool = False) -> str:
        """Return the full name of a managed node.

        Raises:
            NotFoundError: There is no such node, or it has no life cycle.
        """
        name = absolute_name(node_name)
        managed = self.nodes(include_hidden=include_hidden)
        if name not in managed:
            there_is = what_there_is("managed nodes", [name], managed)
            if name in self._graph.node_names(include_hidden):
                there_is = f"'{name}' has no life cycle. {there_is}"
            raise NotFoundError(f"Node not found: '{name}'", hint=there_is)
        return name

    # Any, here and below: requests and responses of lifecycle_msgs, whose classes are made when
    # they are asked for.
    def ask(self, node_name: str, type_: str, service: str, **fields: object) -> Any:
        """Call a service of a node, and return the response.

        Raises:
            UnavailableError: The node does not answer.
        """
        answer = self.ask_all([node_name], type_, service, **fields)[node_name]
        if isinstance(answer, TeleopctlError):
            raise answer
        return answer

    def ask_all(
        self, node_names: Iterable[str], type_: str, service: str, **fields: object
    ) -> Mapping[str, Any]:
        """Call a service of several nodes; return the response or error of each."""
        class_ = get_service(f"lifecycle_msgs/srv/{type_}")
        request = class_.Request(**fields)
        return ask_all(self._node, class_, service, node_names, request, self._timeout_s)

    def change(self, node_name: str, transition: Any, timeout_s: float | None) -> bool:
        """Request a transition of a node; return False if it is rejected.

        Its callback may do what takes long: only ``timeout_s`` bounds the wait, None waits for
        ever.

        Raises:
            UnavailableError: The node does not answer.
        """
        class_ = get_service("lifecycle_msgs/srv/ChangeState")
        client = self._node.create_client(class_, f"{node_name}/change_state")
        future = client.call_async(class_.Request(transition=transition))
        wait_aloud(
            future.wait_until_settled,
            timeout_s,
            lambda: f"waiting for {node_name} to make the transition '{transition.label}'...",
        )
        response = future.wait_for_response(0.0)
        if response is None:
            raise UnavailableError(f"Node '{node_name}' did not answer within {timeout_s:g} s")
        return bool(response.success)


@contextmanager
def open_lifecycles(timeout_s: float | None) -> Iterator[Lifecycles]:
    """Open a client of the managed nodes, in a session of its own.

    Raises:
        RouterNotRunning: No router answers.
    """
    with command_node(session_mode="client") as node:
        yield Lifecycles(node, timeout_s)
