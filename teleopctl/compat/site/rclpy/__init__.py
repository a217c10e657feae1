"""``rclpy``: the module functions; its submodules load when they are first used."""

import importlib
from collections.abc import Sequence
from types import ModuleType
from typing import TYPE_CHECKING

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


def init(
    args: Sequence[str] | None = None,
    *,
    context: Context | None = None,
    domain_id: int | None = None,
    signal_handler_options: SignalHandlerOptions | None = None,
) -> Context:
    """Start a context; ``args`` may be given by position, as nodes do."""
    return lifetime.init(
        args=args,
        context=context,
        domain_id=domain_id,
        signal_handler_options=signal_handler_options,
    )


def get_rmw_implementation_identifier() -> str:
    """Return the middleware whose wire format is spoken."""
    return "rmw_zenoh_cpp"


# Programs write ``rclpy.qos.QoSProfile`` after a bare ``import rclpy``. Type checkers are told
# which modules there are, so that a name that is none is an error for them too.
if TYPE_CHECKING:
    from rclpy import callback_groups as callback_groups
    from rclpy import clock as clock
    from rclpy import duration as duration
    from rclpy import exceptions as exceptions
    from rclpy import executors as executors
    from rclpy import logging as logging
    from rclpy import node as node
    from rclpy import parameter as parameter
    from rclpy import qos as qos
    from rclpy import task as task
    from rclpy import time as time
    from rclpy import utilities as utilities
else:

    def __getattr__(name: str) -> ModuleType:
        target = f"{__name__}.{name}"
        try:
            return importlib.import_module(target)
        except ModuleNotFoundError as error:
            if error.name != target:
                raise
        raise AttributeError(f"module 'rclpy' has no attribute {name!r}")
