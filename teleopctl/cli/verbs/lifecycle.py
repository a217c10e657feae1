"""``teleopctl lifecycle``: states and transitions of managed nodes, as ``ros2 lifecycle``."""

from teleopctl.base.typed import (
    TYPE_CHECKING,
    Annotated,
    Any,
    Iterable,
    Iterator,
    Mapping,
    Sequence,
    contextmanager,
)
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import absolute_name, live_graph
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option, Verb, VerbGroup
from teleopctl.errors import (
    NotFoundError,
    RefusedError,
    TeleopctlError,
    UnavailableError,
    existing_names_hint,
)
from teleopctl.wire import query_graph

if TYPE_CHECKING:
    from teleopctl.cli.completion.completing import TypedWords
    from teleopctl.node import Node
    from teleopctl.wire import Graph


GROUP = VerbGroup(
    "Manage the states of managed nodes.",
    {
        "nodes": Verb(f"{__name__}:list_nodes", "List the managed nodes."),
        "get": Verb(f"{__name__}:get_state", "Print the state of one node, or of all."),
        "list": Verb(f"{__name__}:list_transitions", "List the transitions that are possible."),
        "set": Verb(
            f"{__name__}:set_state",
            "Trigger a transition of a node.",
            examples=("teleopctl lifecycle set /camera configure",),
        ),
    },
)


ManagedNodeName = Annotated[str, Argument(help="The node.", complete="managed_nodes")]
HiddenNodes = Annotated[
    bool, Option("--include-hidden-nodes", help="Include nodes whose name starts with _.")
]
Timeout = Annotated[
    float | None, Option("--timeout", help="Give up after this many seconds.", metavar="SECONDS")
]
# Longest wait for responses to queries, in seconds, which nodes send at once.
_LONGEST_WAIT_S = 5.0
# A node appears in the graph before its services, one by one; on a busy machine, a command may find
# it between. Longest wait for the first of them, and for the rest, in seconds.
_FIRST_SERVICE_WITHIN_S = 0.5
_SERVICES_WITHIN_S = 2.0
_SERVICES = (
    *("change_state", "get_state", "get_available_states"),
    *("get_available_transitions", "get_transition_graph"),
)


class LifecycleClient:
    """Client of the lifecycle services of managed nodes in the graph.

    Args:
        node: Node that calls the services.
        timeout_s: Longest wait for responses, in seconds; None for 5 s.
    """

    def __init__(self, node: "Node", timeout_s: float | None) -> None:
        self._node = node
        self._graph = query_graph(node.context.session)
        self._timeout_s = _LONGEST_WAIT_S if timeout_s is None else timeout_s

    def node_names(self, *, include_hidden: bool = False) -> list[str]:
        """Return the full names of the managed nodes in the graph, sorted."""
        return managed_nodes(self._graph, include_hidden=include_hidden)

    def find_node(self, node_name: str, *, include_hidden: bool = False) -> str:
        """Return the full name of a managed node; raise an error if there is none.

        Raises:
            NotFoundError: The node does not exist, or is not a managed node.
        """
        name = absolute_name(node_name)
        exists = name in self._graph.node_names(include_hidden)
        if exists and not _has_all_services(self._graph, name):
            self._graph = self._graph_with_services(name)
        managed = self.node_names(include_hidden=include_hidden)
        if name not in managed:
            hint = existing_names_hint("managed nodes", [name], managed)
            if exists:
                hint = f"'{name}' is not a managed node. {hint}"
            raise NotFoundError(f"Node not found: '{name}'", hint=hint)
        return name

    def _graph_with_services(self, name: str) -> "Graph":
        """Return the graph when a node has lifecycle services, or after the time they may take."""
        wait = self._node.context.wait_for_graph
        first = f"{name}/{_SERVICES[0]}"
        if wait(lambda graph: bool(graph.servers(first)), _FIRST_SERVICE_WITHIN_S):
            wait(lambda graph: _has_all_services(graph, name), _SERVICES_WITHIN_S)
        return self._node.graph()

    # Any, here and below: requests and responses of lifecycle_msgs, whose classes are created at
    # run time.
    def call(self, node_name: str, type_: str, service: str, **fields: object) -> Any:
        """Call a lifecycle service of a node, and return the response.

        Raises:
            UnavailableError: The node does not respond.
        """
        answer = self.call_all([node_name], type_, service, **fields)[node_name]
        if isinstance(answer, TeleopctlError):
            raise answer
        return answer

    def call_all(
        self, node_names: Iterable[str], type_: str, service: str, **fields: object
    ) -> Mapping[str, Any]:
        """Call a lifecycle service of nodes; return each response or error by node name."""
        from teleopctl.cli.command_node import call_all
        from teleopctl.interfaces import get_service

        class_ = get_service(f"lifecycle_msgs/srv/{type_}")
        request = class_.Request(**fields)
        return call_all(self._node, class_, service, node_names, request, self._timeout_s)

    def change_state(self, node_name: str, transition: Any, timeout_s: float | None) -> bool:
        """Request a transition of a node, wait, and return whether it succeeded.

        The transition's callback may take long, so only ``timeout_s`` limits the wait; None waits
        without limit.

        Raises:
            UnavailableError: The node does not respond.
        """
        from teleopctl.cli.waiting import wait_with_notice
        from teleopctl.interfaces import get_service

        class_ = get_service("lifecycle_msgs/srv/ChangeState")
        client = self._node.create_client(class_, f"{node_name}/change_state")
        future = client.call_async(class_.Request(transition=transition))
        wait_with_notice(
            future.wait_until_settled,
            timeout_s,
            lambda: f"waiting for {node_name} to make the transition '{transition.label}'...",
        )
        response = future.wait_for_response(0.0)
        if response is None:
            raise UnavailableError(f"Node '{node_name}' did not answer within {timeout_s:g} s")
        return bool(response.success)


@contextmanager
def open_lifecycle_client(timeout_s: float | None) -> Iterator[LifecycleClient]:
    """Yield a client of the services of managed nodes, in a session of its own.

    Raises:
        RouterNotRunning: No router runs.
    """
    from teleopctl.cli.command_node import command_node

    with command_node(session_mode="client") as node:
        yield LifecycleClient(node, timeout_s)


def list_nodes(
    include_all: Annotated[
        bool, Option("-a", "--all", help="Include nodes whose name starts with _.")
    ] = False,
    count_nodes: Annotated[
        bool, Option("-c", "--count-nodes", help="Print only the number.")
    ] = False,
    timeout: Annotated[
        float | None,
        Option(
            "--timeout", help="Accepted for compatibility with ROS 2: the graph is known at once."
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the managed nodes."""
    del timeout
    names = managed_nodes(live_graph(), include_hidden=include_all)
    if as_json:
        console.out_json(names)
    elif count_nodes:
        console.out(str(len(names)))
    else:
        console.out_lines(names)


def _has_all_services(graph: "Graph", node_name: str) -> bool:
    return all(graph.servers(f"{node_name}/{service}") for service in _SERVICES)


def managed_nodes(graph: "Graph", *, include_hidden: bool = False) -> list[str]:
    """Return the full names of the managed nodes in the graph, sorted."""
    return [
        name
        for name in dict.fromkeys(graph.node_names(include_hidden))
        if graph.servers(f"{name}/get_state", "lifecycle_msgs/srv/GetState")
    ]


def get_state(
    node_name: Annotated[
        str | None, Argument(help="Node; by default all nodes.", complete="managed_nodes")
    ] = None,
    include_hidden: HiddenNodes = False,
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """Print the state of one node, or of all managed nodes."""
    with open_lifecycle_client(timeout) as client:
        if node_name:
            names = [client.find_node(node_name, include_hidden=include_hidden)]
        else:
            names = client.node_names(include_hidden=include_hidden)
        answers = client.call_all(names, "GetState", "get_state")
    failures = [answer for answer in answers.values() if isinstance(answer, TeleopctlError)]
    if node_name and failures:
        raise failures[0]
    states = {
        name: answer.current_state
        for name, answer in answers.items()
        if not isinstance(answer, TeleopctlError)
    }
    if as_json:
        console.out_json([{"node": n, "state": s.label, "id": s.id} for n, s in states.items()])
    else:
        console.out_lines(
            f"{'' if node_name else f'{name}: '}{state.label} [{state.id}]"
            for name, state in states.items()
        )
    console.flush()
    for failure in failures:
        console.warn(failure.message)


def list_transitions(
    node_name: ManagedNodeName,
    include_hidden: HiddenNodes = False,
    include_all: Annotated[
        bool, Option("-a", "--all", help="List all transitions, not only those possible now.")
    ] = False,
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """Print the transitions of a node that are possible in its present state, or all."""
    with open_lifecycle_client(timeout) as client:
        node = client.find_node(node_name, include_hidden=include_hidden)
        transitions = _transitions(
            client, node, "get_transition_graph" if include_all else "get_available_transitions"
        )
    if as_json:
        console.out_json([_document(transition) for transition in transitions])
        return
    for transition in transitions:
        console.out(f"- {transition.transition.label} [{transition.transition.id}]")
        console.out(f"\tStart: {transition.start_state.label}")
        console.out(f"\tGoal: {transition.goal_state.label}")


def set_state(
    node_name: ManagedNodeName,
    transition: Annotated[
        str, Argument(help="The transition, by label or number.", complete="transitions")
    ],
    include_hidden: HiddenNodes = False,
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """Request a transition of a managed node, and wait for its end."""
    with open_lifecycle_client(timeout) as client:
        node = client.find_node(node_name, include_hidden=include_hidden)
        available = [
            each.transition for each in _transitions(client, node, "get_available_transitions")
        ]
        wanted = _chosen(available, transition)
        success = client.change_state(node, wanted, timeout)
        state = client.call(node, "GetState", "get_state").current_state if as_json else None
    if not success:
        raise RefusedError(
            "Transitioning failed", hint=f"`teleopctl lifecycle get {node}` prints where it is now."
        )
    if state is not None:
        console.out_json(
            {"node": node, "transition": wanted.label, "state": state.label, "id": state.id}
        )
    else:
        console.out("Transitioning successful")


# Any, here and below: messages of lifecycle_msgs.
def _transitions(client: LifecycleClient, node: str, service: str) -> Sequence[Any]:
    answer = client.call(node, "GetAvailableTransitions", service)
    transitions: Sequence[Any] = answer.available_transitions
    return transitions


def _chosen(available: Sequence[Any], wanted: str) -> Any:
    """Return the available transition of a label, else of a number.

    Raises:
        NotFoundError: No available transition has this label or number.
    """
    for transition in available:
        if transition.label == wanted:
            return transition
    for transition in available:
        if str(transition.id) == wanted:
            return transition
    lines = [f"- {each.label} [{each.id}]" for each in available]
    raise NotFoundError("\n".join(["Unknown transition requested, available ones are:", *lines]))


def _document(transition: Any) -> dict[str, Any]:
    return {
        "transition": transition.transition.label,
        "id": transition.transition.id,
        "start": transition.start_state.label,
        "goal": transition.goal_state.label,
    }


# Longest wait for completion candidates, in seconds.
_LONGEST_COMPLETION_S = 1.0


def complete_managed_nodes(incomplete: str) -> list[str]:
    """Return completion candidates: the full names of managed nodes."""
    from teleopctl.cli.graph_lookup import live_graph

    try:
        return [name for name in managed_nodes(live_graph()) if name.startswith(incomplete)]
    except TeleopctlError:
        return []


def complete_transitions(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return completion candidates: labels of the transitions possible for the node on the line."""
    try:
        with open_lifecycle_client(_LONGEST_COMPLETION_S) as client:
            node = client.find_node(ctx.params.get("node_name") or "")
            answer = client.call(node, "GetAvailableTransitions", "get_available_transitions")
    except TeleopctlError:
        return []
    labels = [each.transition.label for each in answer.available_transitions]
    return [label for label in labels if label.startswith(incomplete)]
