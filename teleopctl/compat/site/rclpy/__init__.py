"""``rclpy``: the module functions; its submodules load when they are first used."""

import importlib
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
from teleopctl.node.values.future import Future
from teleopctl.node.values.parameter import Parameter
from teleopctl.node.values.signals import SignalHandlerOptions

__all__ = [
    "Context",
    "Future",
    "Parameter",
    "SignalHandlerOptions",
    "create_node",
    "get_default_context",
    "get_global_executor",
    "get_rmw_implementation_identifier",
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


def get_rmw_implementation_identifier() -> str:
    """Return the middleware whose wire format is spoken."""
    return "rmw_zenoh_cpp"


def __getattr__(name: str) -> Any:
    # Programs write ``rclpy.qos.QoSProfile`` after a bare ``import rclpy``.
    target = f"{__name__}.{name}"
    try:
        return importlib.import_module(target)
    except ModuleNotFoundError as error:
        if error.name != target:
            raise
    raise AttributeError(f"module 'rclpy' has no attribute {name!r}")
