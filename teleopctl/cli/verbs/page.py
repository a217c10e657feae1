"""``teleopctl view``, also as ``rviz``, ``rviz2`` and ``gui``: where the page is."""

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option, Verb
from teleopctl.errors import NotFoundError

VERB = Verb(
    f"{__name__}:view",
    "Print the address of the page in the browser, or how to start it.",
    examples=("teleopctl view --open",),
)

_START = "teleopctl run -d rviz2 rviz2"


def view(
    open_it: Annotated[bool, Option("--open", help="Open the page in the browser.")] = False,
    as_json: AsJson = False,
) -> int:
    """Print the address of the page that runs, which is RViz and rqt here; status 1 without one.

    The page shows the robot, joint sliders, cameras, plots, topics, the graph, parameters and the
    log. Launch files that name rviz2 start it.
    """
    from teleopctl.base import progress
    from teleopctl.base.token_file import Address
    from teleopctl.launch import running

    found = []
    for entry in running():
        said = progress.read(entry.record.log_file)
        if said is not None and said.state == progress.READY and said.detail.startswith("http"):
            found.append((entry.qualified_name, Address.parse(said.detail)))
    if as_json:
        console.out_json({name: address.with_token for name, address in found})
        return 0 if found else 1
    if not found:
        nodes = _pages_elsewhere()
        if nodes:
            raise NotFoundError(
                f"{', '.join(nodes)} serves a page, started in a terminal or on another machine",
                hint="Its first lines there have the address.",
            )
        raise NotFoundError(
            "No page runs in the background",
            hint=f"Start it: `{_START}`, or with a robot: `teleopctl launch -d display.yaml`.",
        )
    for name, address in found:
        console.out(f"{name}: {address.with_token}")
    if open_it:
        from teleopctl.nodes.rviz2 import open_in_browser

        open_in_browser(found[0][1])
    return 0


def _pages_elsewhere() -> list[str]:
    """Return the nodes of the graph that have the names of the page."""
    from teleopctl.cli.graph_lookup import live_graph
    from teleopctl.wire import RouterNotRunning

    try:
        graph = live_graph()
    except RouterNotRunning:
        return []
    return [node.full_name for node in graph.nodes if node.name in ("rviz", "rviz2")]
