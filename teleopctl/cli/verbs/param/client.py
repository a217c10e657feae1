"""Parameter services of the nodes of the graph, and the options of the verbs that call them."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any, Self
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import absolute_name, is_pattern, matching_names
from teleopctl.cli.options import check_not_negative, check_positive
from teleopctl.cli.verb import Argument, Option, OptionSet
from teleopctl.errors import (
    NotFoundError,
    TeleopctlError,
    UnavailableError,
    did_you_mean,
    existing_names_hint,
)
from teleopctl.interfaces import get_service, snake_case
from teleopctl.wire import (
    ServiceRequest,
    close_session,
    domain_id,
    open_session,
    query_endpoints,
    query_graph,
    responses_of_nodes,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from rcl_interfaces.msg import (
        Parameter as ParameterMessage,
        ParameterValue,
        SetParametersResult,
    )

    from teleopctl.wire import Graph


SERVICE_TIMEOUT_S = 5.0
"""Default wait for responses, in seconds."""
DISCOVERY_TIMEOUT_S = 1.0
"""Default wait for a node to appear in the graph, in seconds."""

# A node that has this service has those for reading and setting parameters too.
_LISTING_SERVICE = "list_parameters"


class GraphParameters:
    """Client of the parameter services of nodes in the graph, in a session of its own.

    Args:
        timeout_s: Longest wait for a node to appear in the graph, in seconds.
        service_timeout_s: Longest wait for responses, in seconds.

    Raises:
        UsageError: A time is negative, or ``ROS_DOMAIN_ID`` is malformed.
        RouterNotRunning: No router runs.
    """

    def __init__(
        self, timeout_s: float = DISCOVERY_TIMEOUT_S, service_timeout_s: float = SERVICE_TIMEOUT_S
    ) -> None:
        check_not_negative(timeout=timeout_s)
        check_positive(service_timeout=service_timeout_s)
        self._timeout_s = timeout_s
        self._service_timeout_s = service_timeout_s
        self._domain = domain_id()
        self._session = open_session("client")
        self._known: Graph | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        close_session(self._session)

    @property
    def _graph(self) -> "Graph":
        if self._known is None:
            self._known = query_graph(self._session, self._domain)
        return self._known

    def nodes(self, *, include_hidden: bool = False) -> list[str]:
        """Return the full names of nodes with parameter services, sorted."""
        return [
            name
            for name in dict.fromkeys(self._graph.node_names(include_hidden))
            if _offers_parameters(self._graph, name)
        ]

    def find_node(self, node_name: str) -> str:
        """Wait, up to the timeout, for a node's parameter services; return the full name.

        Raises:
            NotFoundError: The node does not exist, or has no parameter services.
        """
        name = absolute_name(node_name)
        service = query_endpoints(self._session, f"{name}/{_LISTING_SERVICE}")
        if _offers_parameters(service, name):
            return name
        if not _offers_parameters(self._graph, name):
            self._known = self._graph_with(name)
        if self._graph.find_node(name) is None:
            hint = existing_names_hint(
                "nodes", [name], self._graph.node_names(), self._graph.node_names(True)
            )
            raise NotFoundError(f"Node not found: '{name}'", hint=hint)
        if not _offers_parameters(self._graph, name):
            raise NotFoundError(
                f"Wait for service timed out waiting for parameter services for node {name}",
                hint="The node offers no parameters.",
            )
        return name

    def _graph_with(self, name: str) -> "Graph":
        """Return the graph when a node offers parameters, or after the timeout."""
        from teleopctl.cli.command_node import brief_node

        # Waiting needs a node, which is in the graph too.
        with brief_node() as node:
            node.context.wait_for_graph(
                lambda graph: _offers_parameters(graph, name), self._timeout_s
            )
            return node.graph()

    def matching_nodes(self, node_name: str, *, include_hidden: bool = False) -> list[str]:
        """Return the full names of nodes with parameters for a name or pattern, or raise an error.

        Raises:
            NotFoundError: No node matches, or the named node has no parameter services.
        """
        if not is_pattern(node_name):
            return [self.find_node(node_name)]
        return matching_names(node_name, self.nodes(include_hidden=include_hidden), kind="node")

    # Any, here and below: responses of rcl_interfaces, whose classes are created at run time.
    def call(self, node_name: str, type_: str, **fields: object) -> Any:
        """Call a parameter service of one node, and return the response.

        Raises:
            UnavailableError: The node does not respond.
        """
        answer = self.call_all([node_name], type_, **fields)[node_name]
        if isinstance(answer, TeleopctlError):
            raise answer
        return answer

    def call_all(
        self, node_names: "Iterable[str]", type_: str, **fields: object
    ) -> "Mapping[str, Any | UnavailableError]":
        """Call a parameter service of nodes; return each response or error by node name.

        Args:
            node_names: Full names of the nodes.
            type_: Type of the service, such as ``GetParameters``.
            fields: Fields of the request, by name.
        """
        service = get_service(f"rcl_interfaces/srv/{type_}")
        request, name = service.Request(**fields), snake_case(type_)
        return responses_of_nodes(
            {
                node: ServiceRequest(self._session, service, f"{node}/{name}", request)
                for node in node_names
            },
            self._service_timeout_s,
        )

    def names(self, node_name: str) -> list[str]:
        """Return the names of a node's parameters, sorted.

        Raises:
            UnavailableError: The node does not respond.
        """
        return sorted(self.call(node_name, "ListParameters").result.names)

    def values(self, node_name: str, names: "Sequence[str]") -> "dict[str, ParameterValue]":
        """Return a node's parameter values by name, without those that the node lacks.

        Raises:
            UnavailableError: The node does not respond.
        """
        values = self.values_of_all([node_name], names)[node_name]
        if isinstance(values, TeleopctlError):
            raise values
        return values

    def values_of_all(
        self, node_names: "Iterable[str]", names: "Sequence[str]"
    ) -> "dict[str, dict[str, ParameterValue] | UnavailableError]":
        """Return, by node name, the parameter values by name or the node's error."""
        answers = self.call_all(node_names, "GetParameters", names=list(names))
        return {
            node: answer
            if isinstance(answer, UnavailableError)
            else self._by_name(node, names, answer.values)
            for node, answer in answers.items()
        }

    def _by_name(
        self, node_name: str, names: "Sequence[str]", values: "Sequence[ParameterValue]"
    ) -> "dict[str, ParameterValue]":
        if len(values) == len(names):
            return dict(zip(names, values, strict=True))
        if len(names) <= 1:
            return {}
        # A node that lacks one of several parameters returns none of them.
        found: dict[str, ParameterValue] = {}
        for name in names:
            found |= self.values(node_name, [name])
        return found

    def set(
        self, node_name: str, parameters: "Sequence[ParameterMessage]"
    ) -> "Mapping[str, SetParametersResult]":
        """Set parameters of a node one by one; return the result of each by name.

        Args:
            node_name: Full name of the node.
            parameters: Messages with name and value of each parameter.

        Raises:
            UnavailableError: The node does not respond.
        """
        results = self.call(node_name, "SetParameters", parameters=list(parameters)).results
        return dict(zip((each.name for each in parameters), results, strict=False))


def for_each_node(nodes: "Iterable[str]", call: "Callable[[str], bool]", *, is_one: bool) -> bool:
    """Call a function with each node's name; warn of errors; return whether all succeeded.

    Args:
        nodes: Full names of the nodes.
        call: Called with a node's name; returns whether the call succeeded.
        is_one: Whether the user named a single node, whose error is raised instead.

    Raises:
        TeleopctlError: The call failed, and ``is_one`` is true.
    """
    all_succeeded = True
    for node in nodes:
        try:
            all_succeeded &= call(node)
        except TeleopctlError as error:
            if is_one:
                raise
            console.flush()
            console.warn(error.message)
            all_succeeded = False
    return all_succeeded


def _offers_parameters(graph: "Graph", node_name: str) -> bool:
    return bool(graph.servers(f"{node_name}/{_LISTING_SERVICE}"))


def not_set_error(parameters: GraphParameters, node: str, name: str) -> NotFoundError:
    """Return the error for a parameter that a node lacks or that has no value, with a hint."""
    names = parameters.names(node)
    if name in names:
        return NotFoundError("Parameter not set", hint="It is declared, and has no value yet.")
    hint = did_you_mean(name, names)
    return NotFoundError(
        "Parameter not set", hint=hint or f"`teleopctl param list {node}` lists what there is."
    )


Nodes = Annotated[str, Argument(help="The node, or a pattern such as '/arm/*'.", complete="nodes")]
ParameterName = Annotated[str, Argument(help="The parameter.", complete="parameter_names")]
Timeout = Annotated[
    float,
    Option("--timeout", help="Seconds to wait for the node.", metavar="SECONDS"),
]
ServiceTimeout = Annotated[
    float,
    Option("--service-timeout", help="Seconds to wait for responses.", metavar="SECONDS"),
]


class ParameterServiceOptions(OptionSet):
    """Options of verbs that call parameter services: hidden nodes, and the two timeouts."""

    include_hidden: Annotated[
        bool,
        Option(
            "--include-hidden-nodes",
            help="Let patterns match nodes whose name starts with _ as well.",
        ),
    ] = False
    timeout: Timeout = DISCOVERY_TIMEOUT_S
    service_timeout: ServiceTimeout = SERVICE_TIMEOUT_S

    def client(self) -> GraphParameters:
        """Return a client of nodes' parameter services, with the timeouts of the options."""
        return GraphParameters(self.timeout, self.service_timeout)
