"""Node of the test's process through which tests wait for messages and nodes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection

from teleopctl.interfaces import MessageT
from teleopctl.node import Context, Node, QoSProfile, SignalHandlerOptions, SingleThreadedExecutor
from teleopctl.testing.process import LONGEST_WAIT_S


class Observer:
    """Node of the test's process, spun on a thread, to wait for nodes and messages.

    Attributes:
        node: The node, for publishers, clients and other needs of a test. An exception of a
            callback is raised again by the next wait for a message, or by `close`.
    """

    def __init__(self) -> None:
        self._context = Context()
        # pytest handles Ctrl-C.
        self._context.init([], signal_handler_options=SignalHandlerOptions.NO)
        self.node = Node("test", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._failure: Exception | None = None
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._spin, name="ros_graph", daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        try:
            self._executor.spin()
        except Exception as error:  # noqa: BLE001 (any exception of the test's callback)
            with self._changed:
                self._failure = error
                self._changed.notify_all()

    def wait_for_nodes(self, names: Collection[str], timeout_s: float = LONGEST_WAIT_S) -> None:
        """Wait until nodes with these full names are in the graph; AssertionError on timeout.

        Args:
            names: Full names of the nodes, ``/ns/node``.
            timeout_s: Longest wait in seconds.

        Raises:
            AssertionError: The timeout has passed; the message lists the nodes of the graph.
        """
        if not self._context.wait_for_graph(
            lambda graph: all(graph.find_node(name) for name in names), timeout_s
        ):
            present = self.node.graph().node_names(include_hidden=True)
            missing = ", ".join(sorted(set(names) - set(present)))
            raise AssertionError(
                f"no node {missing} within {timeout_s:g} s; there are {', '.join(present)}"
            )

    def wait_for_message(
        self,
        message_type: type[MessageT],
        topic: str,
        matching: Callable[[MessageT], object] | None = None,
        *,
        qos: QoSProfile | int = 10,
        timeout_s: float = LONGEST_WAIT_S,
    ) -> MessageT:
        """Wait for and return a topic's next message, or the next that satisfies ``matching``."""
        found: list[MessageT] = []
        last: list[MessageT] = []

        def receive(message: MessageT) -> None:
            last[:] = [message]
            if not found and (matching is None or matching(message)):
                with self._changed:
                    found.append(message)
                    self._changed.notify_all()

        subscription = self.node.create_subscription(message_type, topic, receive, qos)
        try:
            with self._changed:
                self._changed.wait_for(lambda: found or self._failure, timeout_s)
        finally:
            self.node.destroy_subscription(subscription)
        self._raise_failure()
        if not found:
            received = f"the last one was {last[0]}" if last else "none came"
            raise AssertionError(f"no message on {topic} within {timeout_s:g} s: {received}")
        return found[0]

    def close(self) -> None:
        """Shut down the node and its thread; raise a callback's exception that no wait has raised.

        Raises:
            Exception: A callback raised the exception, and no wait has raised it again.
        """
        self._executor.shutdown()
        self._context.try_shutdown()
        self._thread.join()
        self._raise_failure()

    def _raise_failure(self) -> None:
        failure, self._failure = self._failure, None
        if failure is not None:
            raise failure
