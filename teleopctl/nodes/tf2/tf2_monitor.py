"""Executable ``tf2_monitor``: prints delays and rates of transforms."""

import argparse
import contextlib
import sys

from teleopctl.base.printable import printable_text
from teleopctl.node import Node, init, parse_ros_arguments
from teleopctl.tf import GATHER_S, MonitorResults, monitor_transforms


def main(args: list[str] | None = None) -> int:
    """Run ``tf2_monitor``: print delays and rates of transforms until Ctrl-C; return the status.

    Args:
        args: Command line: two frames, or none for all frames; None takes ``sys.argv``.

    Raises:
        SystemExit: The arguments are wrong.
    """
    words = sys.argv[1:] if args is None else args
    parser = argparse.ArgumentParser(
        prog="tf2_monitor", description="Print the delay of transforms each second."
    )
    parser.add_argument("frames", nargs="*", metavar="FRAME", help="two frames; else all")
    parser.add_argument(
        "-t",
        "--wait-time",
        type=float,
        default=GATHER_S,
        metavar="SECONDS",
        help="seconds to gather data first (%(default)s)",
    )
    options = parser.parse_args(parse_ros_arguments(words).program)
    if len(options.frames) not in (0, 2):
        parser.error("give two frames, or none for all frames")
    with (
        contextlib.suppress(KeyboardInterrupt),
        init(args=words),
        Node("tf2_monitor_main", start_parameter_services=False) as node,
    ):
        monitor_transforms(
            node,
            tuple(options.frames) or None,
            gather_s=max(0.0, options.wait_time),
            once=False,
            show=_show,
            say=_print,
            wait=node.get_logger().info,
        )
    return 0


def _show(results: MonitorResults) -> None:
    _print(results.text())


def _print(text: str) -> None:
    sys.stdout.write(f"{printable_text(text)}\n")
    sys.stdout.flush()
