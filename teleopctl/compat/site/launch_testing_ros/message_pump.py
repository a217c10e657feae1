"""``launch_testing_ros.message_pump``."""

from __future__ import annotations

import threading

from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

_STOPS_WITHIN_S = 5.0


class MessagePump:
    """Spins a node in a thread of its own.

    Args:
        node: The node.
        context: Its context; None for the default one.
    """

    def __init__(self, node: Node, context: Context | None = None) -> None:
        self._node = node
        self._context = context
        self._executor: SingleThreadedExecutor | None = None
        self._is_stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, name="msg_pump_thread")

    def start(self) -> None:
        """Start to spin."""
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread.start()

    def stop(self) -> None:
        """Stop spinning, and join the thread.

        Raises:
            TimeoutError: A callback does not return.
        """
        self._is_stopped.set()
        if self._executor is not None:
            self._executor.wake()
        self._thread.join(_STOPS_WITHIN_S)
        if self._thread.is_alive():
            raise TimeoutError("Timed out waiting for message pump to stop")

    def _run(self) -> None:
        assert self._executor is not None
        while not self._is_stopped.is_set():
            self._executor.spin_once(timeout_sec=1.0)
