"""``launch_ros.ros_adapters``: the node that a launch has of its own."""

from __future__ import annotations

import os
from threading import Lock, Thread
from weakref import WeakKeyDictionary

import rclpy
from launch.event_handlers import OnShutdown
from launch.launch_context import LaunchContext
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node


class ROSAdapter:
    """A node of the launch itself, ``launch_ros_PID``, which works in a thread.

    Args:
        argv: Arguments of ROS, such as remappings.
        autostart: Whether it comes up at once.
    """

    def __init__(self, *, argv: list[str] | None = None, autostart: bool = True) -> None:
        self._argv = argv or []
        self._context: Context | None = None
        self._node: Node | None = None
        self._executor: SingleThreadedExecutor | None = None
        self._thread: Thread | None = None
        if autostart:
            self.start()

    def start(self) -> None:
        """Make the node.

        Raises:
            RuntimeError: It is there.
        """
        if self._thread is not None:
            raise RuntimeError("Cannot start a ROS adapter that is already running")
        self._context = Context()
        rclpy.init(args=self._argv, context=self._context)
        self._node = rclpy.create_node(f"launch_ros_{os.getpid()}", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = Thread(target=self._executor.spin, name="launch_ros", daemon=True)
        self._thread.start()

    def shutdown(self) -> None:
        """End the node.

        Raises:
            RuntimeError: There is none.
        """
        if self._thread is None or self._node is None or self._executor is None:
            raise RuntimeError("Cannot shutdown a ROS adapter that is not running")
        self._executor.shutdown()
        self._thread.join()
        self._thread = None
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)

    @property
    def argv(self) -> list[str]:
        """Arguments of ROS."""
        return self._argv

    @property
    def ros_context(self) -> Context | None:
        """The node's context, or None."""
        return self._context

    @property
    def ros_node(self) -> Node | None:
        """The node, or None."""
        return self._node

    @property
    def ros_executor(self) -> SingleThreadedExecutor | None:
        """What it works in, or None."""
        return self._executor


class _Shared:
    """The adapter of a launch, made when it is first asked for, by any thread."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._adapter: ROSAdapter | None = None
        self._has_ended = False

    def adapter(self) -> ROSAdapter:
        """Return it.

        Raises:
            RuntimeError: The launch has ended.
        """
        with self._lock:
            if self._has_ended:
                raise RuntimeError("the launch has ended")
            if self._adapter is None:
                self._adapter = ROSAdapter()
            return self._adapter

    def end(self) -> None:
        """End it; there will be none any more."""
        with self._lock:
            if self._adapter is not None and not self._has_ended:
                self._adapter.shutdown()
            self._has_ended = True

    # The event tells nothing that matters here.
    def on_shutdown(self, _event: object, _context: object) -> None:
        """End it beside everything else."""
        Thread(target=self.end, name="launch_ros_end").start()


_shared: WeakKeyDictionary[LaunchContext, _Shared] = WeakKeyDictionary()


def shared_adapter(context: LaunchContext) -> _Shared:
    """Return what makes and ends the adapter of a launch."""
    if context not in _shared:
        _shared[context] = shared = _Shared()
        context.register_event_handler(OnShutdown(on_shutdown=shared.on_shutdown))
    return _shared[context]


def get_ros_adapter(context: LaunchContext) -> ROSAdapter:
    """Return the adapter of a launch; it is made when it is first asked for."""
    return shared_adapter(context).adapter()


def get_ros_node(context: LaunchContext) -> Node:
    """Return the node of a launch; it is made when it is first asked for."""
    node = get_ros_adapter(context).ros_node
    assert node is not None
    return node
