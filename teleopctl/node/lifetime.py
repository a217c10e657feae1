"""``init``, ``spin``, ``shutdown``: rclpy's module functions."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from teleopctl.node.context import Context, SessionMode
from teleopctl.node.executor import Executor, SingleThreadedExecutor

if TYPE_CHECKING:
    from teleopctl.node.future import Future
    from teleopctl.node.node import Node

_executor: Executor | None = None
_executor_lock = threading.Lock()


def init(
    *,
    args: Sequence[str] | None = None,
    context: Context | None = None,
    domain_id: int | None = None,
    signal_handler_options: Any = None,  # noqa: ARG001 (SIGTERM shuts down, Ctrl-C interrupts)
    session_mode: SessionMode = "peer",
) -> Context:
    """Start a context; see :meth:`Context.init`. It may be used as a context manager.

    Raises:
        RuntimeError: It runs already.
        TeleopctlError: A ROS argument is malformed.
    """
    chosen = context or Context.default()
    chosen.init(args, domain_id=domain_id, session_mode=session_mode)
    return chosen


def ok(*, context: Context | None = None) -> bool:
    """Tell whether a context runs."""
    return (context or Context.default()).ok()


def shutdown(*, context: Context | None = None, uninstall_handlers: bool | None = None) -> None:  # noqa: ARG001
    """End a context.

    Raises:
        RuntimeError: It does not run.
    """
    _drop_global_executor()
    (context or Context.default()).shutdown()


def try_shutdown(*, context: Context | None = None, uninstall_handlers: bool | None = None) -> None:  # noqa: ARG001
    """End a context if it runs."""
    _drop_global_executor()
    (context or Context.default()).try_shutdown()


def get_default_context() -> Context:
    """Return the context that is used where none is given."""
    return Context.default()


def get_global_executor() -> Executor:
    """Return the executor that spins where none is given."""
    global _executor
    with _executor_lock:
        if _executor is None or not _executor.context.ok():
            _executor = SingleThreadedExecutor()
        return _executor


def _drop_global_executor() -> None:
    global _executor
    with _executor_lock:
        executor, _executor = _executor, None
    if executor is not None:
        executor.shutdown()


def create_node(node_name: str, **options: Any) -> Node:
    """Make a node; the options are those of :class:`Node`."""
    from teleopctl.node.node import Node

    return Node(node_name, **options)


def spin(node: Node, executor: Executor | None = None) -> None:
    """Run a node's callbacks until its context is shut down.

    Raises:
        ExternalShutdownException: A signal shut it down.
    """
    chosen = executor or get_global_executor()
    chosen.add_node(node)
    try:
        chosen.spin()
    finally:
        chosen.remove_node(node)


def spin_once(
    node: Node, *, executor: Executor | None = None, timeout_sec: float | None = None
) -> None:
    """Wait for one callback of a node and run it; see :meth:`Executor.spin_once`."""
    chosen = executor or get_global_executor()
    chosen.add_node(node)
    try:
        chosen.spin_once(timeout_sec)
    finally:
        chosen.remove_node(node)


def spin_until_future_complete(
    node: Node,
    future: Future,
    executor: Executor | None = None,
    timeout_sec: float | None = None,
) -> None:
    """Run a node's callbacks until a future has ended or the time is over."""
    chosen = executor or get_global_executor()
    chosen.add_node(node)
    try:
        chosen.spin_until_future_complete(future, timeout_sec)
    finally:
        chosen.remove_node(node)
