"""``rclpy.utilities``. Command-line arguments, domain id and middleware."""

import sys
from collections.abc import Sequence

from rclpy import get_rmw_implementation_identifier
from teleopctl.interfaces import from_seconds
from teleopctl.node import (
    Context,
    get_default_context,
    ok,
    parse_ros_arguments,
    shutdown,
    try_shutdown,
)

__all__ = [
    "get_available_rmw_implementations",
    "get_default_context",
    "get_domain_id",
    "get_rmw_implementation_identifier",
    "ok",
    "remove_ros_args",
    "shutdown",
    "timeout_sec_to_nsec",
    "try_shutdown",
]


def remove_ros_args(args: Sequence[str] | None = None) -> list[str]:
    """Return a command line without its ``--ros-args`` groups; ``sys.argv`` if None."""
    return list(parse_ros_arguments(sys.argv if args is None else args).program)


def get_available_rmw_implementations() -> set[str]:
    """Return the names of the ROS middlewares that there are: one."""
    return {get_rmw_implementation_identifier()}


def timeout_sec_to_nsec(timeout_sec: float | None) -> int:
    """Return a timeout in nanoseconds; -1, which waits for ever, for None and negative ones."""
    return -1 if timeout_sec is None or timeout_sec < 0 else from_seconds(timeout_sec)


def get_domain_id(context: Context | None = None) -> int:
    """Return the ROS domain of a context."""
    return (context or get_default_context()).domain_id
