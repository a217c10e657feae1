"""Which containers there are, and ``teleopctl component list``."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.command_node import ask_all, command_node
from teleopctl.cli.live import absolute_name
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.errors import NotFoundError, TeleopctlError, what_there_is
from teleopctl.interfaces import get_service
from teleopctl.wire import query_graph

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.wire import Graph

ContainerName = Annotated[str, Argument(help="The container.", complete="containers")]
Timeout = Annotated[
    float | None, Option("--timeout", help="Give up after this many seconds.", metavar="SECONDS")
]

# What is only asked for is answered at once.
_LONGEST_WAIT_S = 5.0
_SERVICES = {"load_node": "LoadNode", "unload_node": "UnloadNode", "list_nodes": "ListNodes"}


def list_containers(
    container_name: Annotated[
        str | None, Argument(help="The container; otherwise all.", complete="containers")
    ] = None,
    containers_only: Annotated[
        bool, Option("--containers-only", help="Print the names of the containers alone.")
    ] = False,
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """List the loaded components."""
    with command_node(session_mode="client") as node:
        if container_name:
            names = [find_container(node, container_name)]
        else:
            names = containers(query_graph(node.context.session))
        answers = {} if containers_only else loaded(node, names, timeout)
    failures = [answer for answer in answers.values() if isinstance(answer, TeleopctlError)]
    if container_name and failures:
        raise failures[0]
    found = {name: list(_components(answers.get(name))) for name in names}
    if as_json:
        console.out_json(
            names
            if containers_only
            else [
                {"container": name, "components": [{"id": i, "node": n} for i, n in components]}
                for name, components in found.items()
            ]
        )
    elif container_name:
        console.out_lines(f"{number}  {node}" for number, node in found[names[0]])
    else:
        for name, components in found.items():
            console.out(name)
            console.out_lines(f"  {number}  {node}" for number, node in components)
    console.flush()
    for failure in failures:
        console.warn(failure.message)


def containers(graph: "Graph") -> list[str]:
    """Return the full names of component containers, sorted."""
    return [
        name
        for name in dict.fromkeys(graph.node_names(include_hidden=True))
        if all(
            graph.servers(f"{name}/_container/{service}", f"composition_interfaces/srv/{type_}")
            for service, type_ in _SERVICES.items()
        )
    ]


def find_container(node: "Node", name: str) -> str:
    """Return the full name of a container.

    Raises:
        NotFoundError: There is none of that name.
    """
    full_name = absolute_name(name)
    known = containers(query_graph(node.context.session))
    if full_name not in known:
        raise NotFoundError(
            f"Unable to find container node '{full_name}'",
            hint=what_there_is("containers", [full_name], known),
        )
    return full_name


# Any: responses of composition_interfaces, or errors.
def loaded(node: "Node", names: list[str], timeout_s: float | None) -> dict[str, Any]:
    """Return the loaded components of containers."""
    class_ = get_service("composition_interfaces/srv/ListNodes")
    longest_s = _LONGEST_WAIT_S if timeout_s is None else timeout_s
    return ask_all(node, class_, "_container/list_nodes", names, class_.Request(), longest_s)


def _components(answer: Any) -> list[tuple[int, str]]:
    if answer is None or isinstance(answer, TeleopctlError):
        return []
    return list(zip(map(int, answer.unique_ids), answer.full_node_names, strict=True))
