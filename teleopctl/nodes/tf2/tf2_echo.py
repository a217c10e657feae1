"""Executable ``tf2_echo``: prints the transform between two frames repeatedly."""

import argparse
import contextlib
import sys

from teleopctl.base.printable import printable_text
from teleopctl.interfaces import from_seconds
from teleopctl.node import Node, init, parse_ros_arguments
from teleopctl.tf import ECHO_DIGITS, Transform, echo_text, echo_transforms


def main(args: list[str] | None = None) -> int:
    """Run ``tf2_echo``: print a transform repeatedly until Ctrl-C; return the exit status.

    Args:
        args: Command line: frame in which the transform is expressed, frame whose pose is printed,
            and rate in Hz (1); None takes ``sys.argv``.

    Raises:
        SystemExit: The arguments are wrong.
    """
    words = sys.argv[1:] if args is None else args
    options = _parser().parse_args(parse_ros_arguments(words).program)

    def show(stamp: int, transform: Transform) -> None:
        _print(echo_text(stamp, transform, options.precision))

    with (
        contextlib.suppress(KeyboardInterrupt),
        init(args=words),
        Node("tf2_echo", start_parameter_services=False) as node,
    ):
        echo_transforms(
            node,
            options.source_frame,
            options.target_frame,
            period_s=1.0 / (options.rate or options.rate_by_position),
            once=False,
            stamp=from_seconds(options.time),
            show=show,
            fail=_print,
            wait=node.get_logger().info,
        )
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="tf2_echo", description="Print the transform between two frames repeatedly."
    )
    parser.add_argument("source_frame", help="frame in which the transform is expressed")
    parser.add_argument("target_frame", help="frame whose pose is printed")
    parser.add_argument(
        "rate_by_position", nargs="?", type=_rate, default=1.0, metavar="rate", help="as --rate"
    )
    parser.add_argument("-r", "--rate", type=_rate, metavar="HZ", help="how often to print (1)")
    parser.add_argument(
        "-t",
        "--time",
        type=float,
        default=0.0,
        metavar="SECONDS",
        help="ROS time of the transform (the newest)",
    )
    parser.add_argument(
        "-p",
        "--precision",
        type=int,
        choices=range(18),
        default=ECHO_DIGITS,
        metavar="DIGITS",
        help="number of decimals (%(default)s)",
    )
    return parser


def _rate(text: str) -> float:
    rate = float(text)
    if not 0.0 < rate < float("inf"):
        raise argparse.ArgumentTypeError(f"the rate must be positive, got '{text}'")
    return rate


def _print(text: str) -> None:
    sys.stdout.write(f"{printable_text(text)}\n")
    sys.stdout.flush()
