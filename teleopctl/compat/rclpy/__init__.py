"""``rclpy``: the module functions."""

from collections.abc import Sequence
from typing import Any

from teleopctl.node import lifetime
from teleopctl.node.context import Context
from teleopctl.node.lifetime import (
    create_node,
    get_default_context,
    get_global_executor,
    ok,
    shutdown,
    spin,
    spin_once,
    spin_until_future_complete,
    try_shutdown,
)

__all__ = [
    "create_node",
    "get_default_context",
    "get_global_executor",
    "init",
    "ok",
    "shutdown",
    "spin",
    "spin_once",
    "spin_until_future_complete",
    "try_shutdown",
]


def init(args: Sequence[str] | None = None, **options: Any) -> Context:
    """Start the default context; ``args`` may be given by position, as nodes do."""
    return lifetime.init(args=args, **options)
