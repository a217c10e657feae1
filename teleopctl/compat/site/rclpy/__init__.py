"""``rclpy``: the module functions; its submodules load when they are first used."""

import importlib
import sys
from collections.abc import Sequence
from types import ModuleType
from typing import TYPE_CHECKING

from teleopctl.node import (
    Context,
    Future,
    Parameter,
    SignalHandlerOptions,
    create_node,
    get_default_context,
    get_global_executor,
    init as _init,
    ok,
    shutdown,
    spin,
    spin_once,
    spin_until_future_complete,
    try_shutdown,
)

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
    "install_signal_handlers",
    "ok",
    "shutdown",
    "spin",
    "spin_once",
    "spin_until_future_complete",
    "try_shutdown",
    "uninstall_signal_handlers",
]


def init(
    args: Sequence[str] | None = None,
    *,
    context: Context | None = None,
    domain_id: int | None = None,
    signal_handler_options: SignalHandlerOptions | None = None,
) -> Context:
    """Start a context; ``args`` may be given by position, as nodes do.

    Raises:
        UnicodeEncodeError: An argument is no UTF-8, so that no message could hold it.
    """
    for argument in sys.argv if args is None else args:
        argument.encode()
    return _init(
        args=args,
        context=context,
        domain_id=domain_id,
        signal_handler_options=signal_handler_options,
    )


def install_signal_handlers(options: SignalHandlerOptions = SignalHandlerOptions.ALL) -> None:
    """Install signal handlers that end all contexts of the process that are initialized."""
    from teleopctl.node import install_for_all_contexts

    install_for_all_contexts(options)


def uninstall_signal_handlers() -> None:
    """Stop ending contexts on signals, and restore the handlers from before."""
    from teleopctl.node import uninstall_for_all_contexts

    uninstall_for_all_contexts()


def get_rmw_implementation_identifier() -> str:
    """Return the name of the middleware whose wire format is used."""
    return "rmw_zenoh_cpp"


# Programs write ``rclpy.qos.QoSProfile`` after a bare ``import rclpy``. Type checkers get
# which modules there are, so that a name that is none is an error for them too.
if TYPE_CHECKING:
    from rclpy import (
        callback_groups as callback_groups,
        clock as clock,
        duration as duration,
        exceptions as exceptions,
        executors as executors,
        logging as logging,
        node as node,
        parameter as parameter,
        qos as qos,
        task as task,
        time as time,
        utilities as utilities,
    )
else:

    def __getattr__(name: str) -> ModuleType:
        target = f"{__name__}.{name}"
        try:
            return importlib.import_module(target)
        except ModuleNotFoundError as error:
            if error.name != target:
                raise
        raise AttributeError(f"module 'rclpy' has no attribute {name!r}")
