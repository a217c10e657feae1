"""Module functions of rclpy, ``init``, ``spin`` and so on, and a node that runs in a block."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator, Sequence

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.node.context import Context
from teleopctl.node.executors import Executor, SingleThreadedExecutor
from teleopctl.node.values.exceptions import ExternalShutdownException
from teleopctl.node.values.signals import SignalHandlerOptions

if TYPE_CHECKING:
    from teleopctl.node.context import SessionMode
    from teleopctl.node.node import Node
    from teleopctl.node.values.future import AnyFuture

_executor: Executor | None = None
_executor_lock = threading.RLock()


def init(
    *,
    args: Sequence[str] | None = None,
    context: Context | None = None,
    domain_id: int | None = None,
    signal_handler_options: SignalHandlerOptions | None = None,
    session_mode: SessionMode = "peer",
    publishes_after_signal: bool = False,
) -> Context:
    """Initialize a context from command-line arguments, and return it; see `Context.init`.

    Raises:
        RuntimeError: The context is running already.
        TeleopctlError: A ROS argument is malformed.
    """
    chosen = context or Context.default()
    chosen.init(
        args,
        domain_id=domain_id,
        session_mode=session_mode,
        signal_handler_options=signal_handler_options,
        publishes_after_signal=publishes_after_signal,
    )
    return chosen


def ok(*, context: Context | None = None) -> bool:
    """Return whether a context, the default one if None, is initialized and has not ended."""
    return (context or Context.default()).ok()


def shutdown(*, context: Context | None = None, uninstall_handlers: bool | None = None) -> None:  # noqa: ARG001
    """Shut down a context, the default one if None; raise RuntimeError if not initialized.

    Raises:
        RuntimeError: The context is not initialized.
    """
    (context or Context.default()).shutdown()


def try_shutdown(*, context: Context | None = None, uninstall_handlers: bool | None = None) -> None:  # noqa: ARG001
    """Shut down a context, the default one if None, if it is initialized."""
    (context or Context.default()).try_shutdown()


def get_default_context(*, shutting_down: bool = False) -> Context:
    """Return the default context of the process.

    Args:
        shutting_down: Whether the context is to be shut down by the caller; the next call then
            returns a new one.
    """
    return Context.release_default() if shutting_down else Context.default()


def get_global_executor() -> Executor:
    """Return the process's executor for the module-level spin functions, made on first use."""
    global _executor
    with _executor_lock:
        if _executor is None:
            _executor = SingleThreadedExecutor()
            # After a new init() of the context, another executor is created.
            _executor.context.on_shutdown(_drop_global_executor)
        return _executor


def _drop_global_executor() -> None:
    global _executor
    with _executor_lock:
        _executor = None


@contextlib.contextmanager
def _served(node: Node, executor: Executor | None) -> Iterator[Executor]:
    """Add a node to an executor during the block, unless the executor has the node already."""
    chosen = executor or get_global_executor()
    before = node.executor
    added = chosen.add_node(node)
    try:
        yield chosen
    finally:
        if added:
            chosen.remove_node(node)
            if before is not None and before is not chosen and not before.is_shutdown:
                before.add_node(node)


def create_node(node_name: str, **options: Any) -> Node:  # Any: Node checks its arguments
    """Create and return a node; the options are those of `Node`."""
    from teleopctl.node.node import Node

    return Node(node_name, **options)


def spin(node: Node, executor: Executor | None = None) -> None:
    """Run a node's callbacks, in the global executor if None, until the context is shut down.

    Raises:
        ExternalShutdownException: A signal shut the context down.
    """
    with _served(node, executor) as chosen:
        chosen.spin()


def spin_in_thread(executor: Executor, name: str | None = None) -> threading.Thread:
    """Start and return a daemon thread that spins an executor until its shutdown (ours).

    The thread also ends when a signal shuts the context down, without printing an exception: the
    main thread receives the same one where it waits.

    Args:
        executor: Executor of the nodes; `Executor.shutdown` ends the thread.
        name: Name of the thread.
    """

    def run() -> None:
        with contextlib.suppress(ExternalShutdownException):
            executor.spin()

    thread = threading.Thread(target=run, name=name, daemon=True)
    thread.start()
    return thread


def spin_once(
    node: Node, *, executor: Executor | None = None, timeout_sec: float | None = None
) -> None:
    """Wait for one callback of a node or its executor's other nodes, and run it; or time out."""
    with _served(node, executor) as chosen:
        chosen.spin_once(timeout_sec)


def spin_until_future_complete(
    node: Node,
    future: AnyFuture,
    executor: Executor | None = None,
    timeout_sec: float | None = None,
) -> None:
    """Run a node's callbacks until a future ends, the timeout expires or the context shuts down.

    Args:
        node: Node whose callbacks run.
        future: Future of rclpy, asyncio or ``concurrent.futures``.
        executor: Executor of the callbacks; the global executor if None.
        timeout_sec: Longest wait in seconds of wall time; None or negative waits forever.
    """
    with _served(node, executor) as chosen:
        chosen.spin_until_future_complete(future, timeout_sec)


@contextlib.contextmanager
def open_node(name: str, *, namespace: str = "") -> Iterator[Node]:
    """Yield a node that runs until the end of the ``with`` block; a thread runs its callbacks.

    The node has rclpy's methods: ``create_publisher``, ``create_subscription``, ``create_client``,
    ``declare_parameter`` and so on. An exception in a callback stops the callbacks and is raised at
    the end of the block.

    Args:
        name: Name of the node.
        namespace: Namespace of the node, such as ``/left``.

    Raises:
        UsageError: A name is malformed.
        RouterNotRunning: No router answers, and the configuration needs one.

    Example:
        >>> with open_node("watcher", namespace="/left") as node:
        ...     node.get_fully_qualified_name()
        '/left/watcher'
    """
    from teleopctl.node.node import Node

    context = Context()
    context.init([], signal_handler_options=SignalHandlerOptions.NO)
    failures: list[BaseException] = []
    executor = SingleThreadedExecutor(context=context)

    def spin() -> None:
        try:
            executor.spin()
        except ExternalShutdownException:
            pass
        except Exception as error:  # noqa: BLE001 -- any exception of a callback
            failures.append(error)

    thread = threading.Thread(target=spin, name=name, daemon=True)
    try:
        node = Node(name, context=context, namespace=namespace)
        executor.add_node(node)
        thread.start()
        yield node
    finally:
        context.try_shutdown()
        if thread.is_alive():
            thread.join()
    if failures:
        raise failures[0]
