"""``teleopctl tf echo``."""

import contextlib

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.verb import Argument, Option
from teleopctl.errors import UsageError
from teleopctl.interfaces import from_seconds, split
from teleopctl.tf import ECHO_DIGITS, Transform, echo_text, echo_transforms, rpy_from_quaternion

_MOST_DIGITS = 17  # a double has no more


def echo_transform(
    source_frame: Annotated[
        str,
        Argument(
            help="The frame in which the other is expressed.", metavar="SOURCE", complete="frames"
        ),
    ],
    target_frame: Annotated[
        str, Argument(help="The frame that is looked for.", metavar="TARGET", complete="frames")
    ],
    rate: Annotated[float, Argument(help="How often to print, in Hz; as -r.")] = 1.0,
    rate_option: Annotated[
        float | None, Option("-r", "--rate", help="How often to print, in Hz.", metavar="HZ")
    ] = None,
    at: Annotated[
        float | None,
        Option("-t", "--time", help="At which ROS time; otherwise the newest.", metavar="SECONDS"),
    ] = None,
    precision: Annotated[
        int, Option("-p", "--precision", help="How many decimals to print.", metavar="DIGITS")
    ] = ECHO_DIGITS,
    once: Annotated[bool, Option("--once", help="Print the first transform and end.")] = False,
    as_json: Annotated[bool, Option("--json", help="Print one JSON object a line.")] = False,
) -> None:
    """Print where one frame stands in another."""
    if rate_option is not None:
        rate = rate_option
    if not 0.0 < rate < float("inf"):
        raise UsageError(f"The rate must be positive, got {rate:g}")
    if not 0 <= precision <= _MOST_DIGITS:
        raise UsageError(f"The precision is 0 to {_MOST_DIGITS} digits, not {precision}")

    def show(stamp: int, transform: Transform) -> None:
        if as_json:
            console.out_json(_document(source_frame, target_frame, stamp, transform), compact=True)
        else:
            console.out_text(echo_text(stamp, transform, precision))
        console.flush()

    # Ctrl-C is the ordinary end of a stream
    with contextlib.suppress(KeyboardInterrupt), command_node() as node:
        echo_transforms(
            node,
            source_frame,
            target_frame,
            period_s=1.0 / rate,
            once=once,
            stamp=from_seconds(at or 0.0),
            show=show,
            fail=console.note,
            wait=console.note,
        )


def _document(source: str, target: str, stamp: int, transform: Transform) -> console.Json:
    """Return a ``geometry_msgs/msg/TransformStamped`` as JSON, with the angles besides."""
    seconds, nanoseconds = split(stamp)
    return {
        "header": {"stamp": {"sec": seconds, "nanosec": nanoseconds}, "frame_id": source},
        "child_frame_id": target,
        "transform": {
            "translation": dict(zip("xyz", transform.translation, strict=True)),
            "rotation": dict(zip("xyzw", transform.rotation, strict=True)),
        },
        "rpy": list(rpy_from_quaternion(transform.rotation)),
    }
