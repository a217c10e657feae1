"""``teleopctl graph``: a drawing of nodes and topics."""

from pathlib import Path

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import live_graph
from teleopctl.cli.verb import Option, Verb
from teleopctl.diagram import SHOWN, format_dot, ros_graph, to_svg
from teleopctl.errors import SystemFailureError, UsageError

VERB = Verb(
    f"{__name__}:graph",
    "Draw the graph of nodes and topics.",
    examples=(
        "teleopctl graph --svg graph.svg",
        "teleopctl graph --show nodes | dot -Tpdf -o graph.pdf",
    ),
)


def graph(
    show: Annotated[
        str,
        Option(
            "--show",
            help="Nodes with the topics between them, nodes only, or nodes with all topics.",
            choices=SHOWN,
        ),
    ] = "active",
    include_hidden: Annotated[
        bool,
        Option(
            "--include-hidden", help="Include /rosout, /clock, names with _, RViz and the like."
        ),
    ] = False,
    svg: Annotated[
        str | None, Option("--svg", help="Write a picture to this file.", metavar="FILE")
    ] = None,
    dot: Annotated[bool, Option("--dot", help="Print it for Graphviz; the default.")] = False,
    as_json: Annotated[bool, Option("--json", help="Print boxes and arrows as JSON.")] = False,
) -> None:
    """Print the graph of nodes and topics as DOT or JSON, or write a picture of it as SVG.

    Data flows from left to right. Actions, the transports of a camera and tf are drawn as one box
    each.
    """
    if (svg is not None) + dot + as_json > 1:
        raise UsageError("Choose one of --svg, --dot and --json")
    diagram = ros_graph(live_graph(), show, include_hidden=include_hidden)
    if svg is not None:
        path = Path(svg)
        try:
            path.write_text(to_svg(diagram), encoding="utf-8")
        except OSError as error:
            raise SystemFailureError(f"Cannot write {path}: {error.strerror or error}") from error
        console.out(f"{path}: {len(diagram.boxes)} boxes, {len(diagram.edges)} arrows")
    elif as_json:
        console.out_json(
            {
                "boxes": [box._asdict() for box in diagram.boxes],
                "edges": [edge._asdict() for edge in diagram.edges],
            }
        )
    else:
        console.out_text(format_dot(diagram).removesuffix("\n"))
