"""``teleopctl node``."""

from collections import Counter

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Iterable
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import absolute_name, live_graph
from teleopctl.cli.options import AsJson, NodeName
from teleopctl.cli.verb import Argument, Option, Verb, VerbGroup
from teleopctl.errors import NotFoundError, did_you_mean
from teleopctl.wire import EntityKind, actions_of, is_hidden_name

if TYPE_CHECKING:
    from teleopctl.wire import EndpointToken, NodeEntry

GROUP = VerbGroup(
    "List nodes and their endpoints.",
    {
        "list": Verb(f"{__name__}:list_nodes", "List the nodes."),
        "info": Verb(f"{__name__}:node_info", "Show the topics, services and actions of a node."),
        "kill": Verb(
            f"{__name__}:kill_nodes",
            "End the processes of nodes of this machine, wherever they were started.",
            examples=("teleopctl node kill /talker",),
        ),
    },
    leaves_nothing=True,
)

NamesAndTypes = dict[str, list[str]]


def list_nodes(
    include_all: Annotated[
        bool, Option("-a", "--all", help="Include nodes whose name starts with _.")
    ] = False,
    count_nodes: Annotated[
        bool, Option("-c", "--count-nodes", help="Print only the number.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """List the nodes."""
    names = live_graph().node_names(include_all)
    if as_json:
        console.out_json(names)
    elif count_nodes:
        console.out(str(len(names)))
    else:
        console.out_lines(names)
    console.flush()
    repeated = [name for name, times in Counter(names).items() if times > 1]
    if repeated:
        console.warn(
            "Be aware that there are nodes in the graph that share an exact name, which can have "
            "unintended side effects."
        )
        console.note(f"  More than one is called {', '.join(repeated)}.")


def node_info(
    node_name: NodeName,
    include_hidden: Annotated[
        bool, Option("--include-hidden", help="Include hidden topics and services.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print the topics, services and actions of a node."""
    graph = live_graph()
    name = absolute_name(node_name)
    node = graph.find_node(name)
    if node is None:
        hint = did_you_mean(name, graph.node_names(include_hidden=True))
        raise NotFoundError(f"Unable to find node '{name}'", hint=hint)
    if (twins := graph.node_names(include_hidden=True).count(name)) > 1:
        console.note(
            f'There are {twins} nodes in the graph with the exact name "{name}". You are seeing '
            "information about only one of them."
        )
    sections = _sections(node, include_hidden=include_hidden)
    if as_json:
        document = {_key(title): dict(entries) for title, entries in sections.items()}
        console.out_json({"name": name, **document})
        return
    console.out(name)
    for title, entries in sections.items():
        console.out(f"  {title}:")
        lines = [f"    {entry}: {', '.join(types)}" for entry, types in entries.items()]
        console.out_lines(lines or [""])


def kill_nodes(
    node_names: Annotated[list[str], Argument(metavar="NODE", help="The nodes.", complete="nodes")],
    as_json: AsJson = False,
) -> int:
    """End the processes of nodes: SIGINT, after 5 s SIGTERM, after 5 s more SIGKILL.

    The nodes may run in a terminal, in a launch, in the background, or be of ROS 2 itself, on this
    machine and of this user. Other nodes of the same process end with it.
    """
    from teleopctl.cli.verbs.stop import stop

    return stop([absolute_name(name) for name in node_names], as_json=as_json)


def _sections(node: "NodeEntry", *, include_hidden: bool) -> dict[str, NamesAndTypes]:
    subscriptions, publishers = node.of_kind(EntityKind.MS), node.of_kind(EntityKind.MP)

    def shown(entries: NamesAndTypes) -> NamesAndTypes:
        return {
            name: types
            for name, types in entries.items()
            if include_hidden or not is_hidden_name(name)
        }

    return {
        "Subscribers": shown(_names_and_types(subscriptions)),
        "Publishers": shown(_names_and_types(publishers)),
        "Service Servers": shown(_names_and_types(node.of_kind(EntityKind.SS))),
        "Service Clients": shown(_names_and_types(node.of_kind(EntityKind.SC))),
        "Action Servers": dict(actions_of(publishers)),
        "Action Clients": dict(actions_of(subscriptions)),
    }


def _names_and_types(endpoints: Iterable["EndpointToken"]) -> NamesAndTypes:
    entries: dict[str, set[str]] = {}
    for endpoint in endpoints:
        entries.setdefault(endpoint.name, set()).add(endpoint.type_name)
    return {name: sorted(types) for name, types in entries.items()}


def _key(title: str) -> str:
    return title.lower().replace(" ", "_")
