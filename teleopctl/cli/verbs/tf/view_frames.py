"""``teleopctl tf view_frames``."""

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.listing import out_files
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.nodes.tf2.view_frames import view_frames


def view(
    wait_time: Annotated[
        float, Option("-t", "--wait-time", help="How long to listen.", metavar="SECONDS")
    ] = 5.0,
    output: Annotated[
        str | None,
        Option("-o", "--output", help="Name of the files, without their endings.", metavar="FILE"),
    ] = None,
    tf_topic: Annotated[str, Option("--tf_topic", help="The topic of moving frames.")] = "/tf",
    tf_static_topic: Annotated[
        str, Option("--tf_static_topic", help="The topic of frames that stand still.")
    ] = "/tf_static",
    as_json: AsJson = False,
) -> None:
    """Draw the tree of frames, after a few seconds of listening.

    Writes a graph for Graphviz, an SVG, and a PDF where Graphviz's program dot is installed.
    """
    with command_node() as node:
        files = view_frames(
            node,
            output,
            console.note,
            wait_s=wait_time,
            tf_topic=tf_topic,
            tf_static_topic=tf_static_topic,
        )
    out_files(files, as_json=as_json)
