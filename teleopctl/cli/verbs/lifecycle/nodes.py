"""``teleopctl lifecycle nodes``."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.live import live_graph
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option

if TYPE_CHECKING:
    from teleopctl.wire import Graph


def list_nodes(
    include_all: Annotated[
        bool, Option("-a", "--all", help="List nodes whose name starts with _, too.")
    ] = False,
    count_nodes: Annotated[
        bool, Option("-c", "--count-nodes", help="Print only how many there are.")
    ] = False,
    timeout: Annotated[
        float | None,
        Option("--timeout", help="Accepted for ROS 2's sake: the graph is known at once."),
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


def managed_nodes(graph: "Graph", *, include_hidden: bool = False) -> list[str]:
    """Return the full names of managed nodes, sorted."""
    return [
        name
        for name in dict.fromkeys(graph.node_names(include_hidden))
        if graph.servers(f"{name}/get_state", "lifecycle_msgs/srv/GetState")
    ]
