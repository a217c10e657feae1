"""``tf2_echo``: prints where one frame stands in another."""

import contextlib
import sys

from teleopctl.errors import UsageError
from teleopctl.node import Node, init, parse_ros_arguments
from teleopctl.printable import printable_text
from teleopctl.tf import Transform, echo_text, echo_transforms

_USAGE = "Usage: tf2_echo SOURCE_FRAME TARGET_FRAME [RATE]"


def main(args: list[str] | None = None) -> int:
    """Print until interrupted.

    Args:
        args: Command line: the frame in which the other is expressed, the other, and the rate in
            Hz (1); None takes the process's.

    Raises:
        TeleopctlError: When the arguments are wrong.
    """
    words = sys.argv[1:] if args is None else args
    target, source, rate = _parse(parse_ros_arguments(words).program)
    with (
        contextlib.suppress(KeyboardInterrupt),
        init(args=words),
        Node("tf2_echo", start_parameter_services=False) as node,
    ):
        echo_transforms(
            node,
            target,
            source,
            period_s=1.0 / rate,
            once=False,
            show=_show,
            fail=_print,
            wait=node.get_logger().info,
        )
    return 0


def _parse(words: tuple[str, ...]) -> tuple[str, str, float]:
    if len(words) not in (2, 3):
        raise UsageError(_USAGE)
    target, source, *rest = words
    try:
        rate = float(rest[0]) if rest else 1.0
    except ValueError:
        rate = 0.0
    if not 0.0 < rate < float("inf"):
        raise UsageError(f"Echo rate must be positive, got '{rest[0]}'", hint=_USAGE)
    return target, source, rate


def _show(stamp: int, transform: Transform) -> None:
    _print(echo_text(stamp, transform))


def _print(text: str) -> None:
    sys.stdout.write(f"{printable_text(text)}\n")
    sys.stdout.flush()
