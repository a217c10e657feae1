"""``teleopctl tf monitor``."""

import contextlib

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.verb import Argument, Option
from teleopctl.errors import UsageError
from teleopctl.tf import GATHER_S, MonitorResults, monitor_transforms


def monitor(
    source_frame: Annotated[
        str | None,
        Argument(
            help="The frame in which the other is expressed; none for all frames.",
            complete="frames",
            metavar="SOURCE",
        ),
    ] = None,
    target_frame: Annotated[
        str | None,
        Argument(help="The frame that is looked for.", complete="frames", metavar="TARGET"),
    ] = None,
    wait_time: Annotated[
        float,
        Option("-t", "--wait-time", help="How long to gather data first.", metavar="SECONDS"),
    ] = GATHER_S,
    once: Annotated[bool, Option("--once", help="Print the first results and end.")] = False,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a line.")] = False,
) -> None:
    """Print the delays of transforms, and their broadcasters.

    After the time to gather data it prints each second. A delay is the time from a transform's
    stamp to its arrival, in seconds. Ctrl-C ends it.
    """
    if source_frame is not None and target_frame is None:
        raise UsageError("Give two frames, or none for all")
    if not 0.0 < wait_time < float("inf"):
        raise UsageError(f"The time to gather data must be positive, got {wait_time:g}")

    def show(results: MonitorResults) -> None:
        if as_json:
            console.out_json(_document(results), compact=True)
        else:
            console.out_text(results.text())
        console.flush()

    # Ctrl-C is the ordinary end of a stream
    with contextlib.suppress(KeyboardInterrupt), command_node() as node:
        monitor_transforms(
            node,
            (source_frame, target_frame) if source_frame and target_frame else None,
            gather_s=wait_time,
            once=once,
            show=show,
            say=console.note,
            wait=console.note,
        )


def _document(results: MonitorResults) -> console.Json:
    return {
        "chain": results.chain,
        "net_delay": results.net and results.net._asdict(),
        "frames": [
            {
                "name": each.name,
                "publisher": each.publisher,
                "delay": each.delay and each.delay._asdict(),
            }
            for each in results.frames
        ],
        "broadcasters": [
            {
                "node": each.node,
                "rate_hz": each.rate_hz,
                "delay": each.delay and each.delay._asdict(),
            }
            for each in results.broadcasters
        ],
    }
