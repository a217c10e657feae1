"""``launch_ros.ros_adapters``: node of a launch for its own subscriptions and service calls."""

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
    """Node ``launch_ros_PID`` of a launch, spun in a thread.

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
        """Create the node, and start to spin it.

        Raises:
            RuntimeError: The adapter has been started before.
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
        """Destroy the node, and end its thread.

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
        """ROS arguments of the node."""
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
        """Executor of the node, or None."""
        return self._executor


class _Shared:
    """Adapter of a launch, created at its first use. Thread-safe."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._adapter: ROSAdapter | None = None
        self._has_ended = False

    def adapter(self) -> ROSAdapter:
        """Return the adapter, created if necessary.

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
        """Shut the adapter down; later calls of `adapter` raise."""
        with self._lock:
            if self._adapter is not None and not self._has_ended:
                self._adapter.shutdown()
            self._has_ended = True

    # The event is not used.
    def on_shutdown(self, _event: object, _context: object) -> None:
        """Shut the adapter down in a thread, without blocking the launch."""
        Thread(target=self.end, name="launch_ros_end").start()


_shared: WeakKeyDictionary[LaunchContext, _Shared] = WeakKeyDictionary()


def shared_adapter(context: LaunchContext) -> _Shared:
    """Return the holder of a launch's adapter, created if necessary."""
    if context not in _shared:
        _shared[context] = shared = _Shared()
        context.register_event_handler(OnShutdown(on_shutdown=shared.on_shutdown))
    return _shared[context]


def get_ros_adapter(context: LaunchContext) -> ROSAdapter:
    """Return the adapter of a launch, created if necessary."""
    return shared_adapter(context).adapter()


def get_ros_node(context: LaunchContext) -> Node:
    """Return the node of a launch, created if necessary."""
    node = get_ros_adapter(context).ros_node
    assert node is not None
    return node
