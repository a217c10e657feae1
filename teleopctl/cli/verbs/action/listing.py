"""``teleopctl action list|info|type|find``."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.listing import of_type, out_names, out_types, types_of
from teleopctl.cli.live import absolute_name, live_graph
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.wire import action_type as type_of_action

if TYPE_CHECKING:
    from teleopctl.wire import EndpointToken

ActionName = Annotated[str, Argument(help="The action.", complete="actions")]
CountActions = Annotated[
    bool, Option("-c", "--count-actions", help="Print only how many there are.")
]


def list_actions(
    show_types: Annotated[
        bool, Option("-t", "--show-types", help="Show the type of each action.")
    ] = False,
    count_actions: CountActions = False,
    as_json: AsJson = False,
) -> None:
    """List the actions."""
    graph = live_graph()
    actions = graph.action_names_and_types()
    if as_json:
        console.out_json(
            [
                {"name": name, "types": types, "servers": len(graph.action_servers(name))}
                for name, types in actions
            ]
        )
    else:
        out_names(actions, only_count=count_actions, show_types=show_types)


def action_info(
    action_name: ActionName,
    show_types: Annotated[bool, Option("-t", "--show-types", help="Show the types, too.")] = False,
    only_count: Annotated[bool, Option("-c", "--count", help="Print no nodes.")] = False,
    as_json: AsJson = False,
) -> None:
    """Show who serves and who uses an action."""
    graph = live_graph()
    name = absolute_name(action_name)
    sides = {"clients": graph.action_clients(name), "servers": graph.action_servers(name)}
    if as_json:
        nodes = {
            side: [{"node": e.full_name, "type": type_of_action(e)} for e in endpoints]
            for side, endpoints in sides.items()
        }
        console.out_json({"name": name, **nodes})
        return
    console.out(f"Action: {name}")
    for side, endpoints in sides.items():
        console.out(f"Action {side}: {len(endpoints)}")
        if not only_count:
            console.out_lines(_line(endpoint, show_types=show_types) for endpoint in endpoints)


def _line(endpoint: "EndpointToken", *, show_types: bool) -> str:
    shown_type = f" [{type_of_action(endpoint)}]" if show_types else ""
    return f"    {endpoint.full_name}{shown_type}"


def action_type(action_name: ActionName, as_json: AsJson = False) -> None:
    """Print the type of an action."""
    actions = live_graph().action_names_and_types()
    out_types(types_of(absolute_name(action_name), actions, kind="action"), as_json=as_json)


def actions_of_type(
    type_name: Annotated[
        str, Argument(help="The action type.", metavar="TYPE", complete="action_types")
    ],
    count_actions: CountActions = False,
    as_json: AsJson = False,
) -> None:
    """List the actions of a type."""
    found = of_type(type_name, live_graph().action_names_and_types(), kind="action")
    out_names(found, only_count=count_actions, as_json=as_json)
