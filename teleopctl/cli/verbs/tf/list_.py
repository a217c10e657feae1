"""``teleopctl tf list``."""

import time

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option
from teleopctl.errors import UsageError
from teleopctl.tf import Buffer, TransformListener

# A robot sends its moving frames at least this often.
_WAIT_S = 1.0


def list_frames(
    show_parents: Annotated[
        bool, Option("-p", "--show-parents", help="Show in which frame each one stands.")
    ] = False,
    count_frames: Annotated[
        bool, Option("-c", "--count-frames", help="Print only how many there are.")
    ] = False,
    wait_time: Annotated[
        float, Option("-t", "--wait-time", help="How long to listen.", metavar="SECONDS")
    ] = _WAIT_S,
    as_json: AsJson = False,
) -> None:
    """List the frames.

    Those that are broadcast while it listens, and those that stand still.
    """
    if not 0.0 < wait_time < float("inf"):
        raise UsageError(f"The time to listen must be positive, got {wait_time:g}")
    buffer = Buffer()
    with command_node() as node:
        TransformListener(buffer, node)
        time.sleep(wait_time)
    known = {frame.name: frame for frame in buffer.known_frames()}
    names = sorted(buffer.frame_names())
    if as_json:
        console.out_json(
            [
                {
                    "name": name,
                    "parent": known[name].parent if name in known else None,
                    "is_static": known[name].is_static if name in known else None,
                }
                for name in names
            ]
        )
    elif count_frames:
        console.out(str(len(names)))
    elif show_parents:
        console.out_lines(
            f"{name} [{known[name].parent}]" if name in known else name for name in names
        )
    else:
        console.out_lines(names)
