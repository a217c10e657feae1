"""Executables ``component_container``, ``…_mt`` and ``…_isolated``, which load components.

The executables of ``rclcpp_components`` are the same programs. They load components in Python,
including teleopctl's replacements for a few well-known components in C++.
"""

import contextlib
import os
import sys
from collections.abc import Iterator

from rclpy_components.component_manager import ComponentManager

from teleopctl.base import progress
from teleopctl.node import (
    Executor,
    ExternalShutdownException,
    MultiThreadedExecutor,
    SingleThreadedExecutor,
    init,
    parse_ros_arguments,
)

_NAME = "ComponentManager"
_POOLS = "--use_multi_threaded_executor"


def single() -> int:
    """Run ``component_container``: one thread executes all components; return the exit status."""
    with _init_until_interrupt():
        executor = SingleThreadedExecutor()
        _serve(executor, ComponentManager(executor, _NAME))
    return 0


def multi() -> int:
    """Run ``component_container_mt``: a thread pool executes components; return the exit status."""
    with _init_until_interrupt():
        node = ComponentManager(None, _NAME)
        size = node.declare_parameter("thread_num", os.cpu_count() or 1).value
        executor = MultiThreadedExecutor(size)
        node.set_executor(executor)
        _serve(executor, node)
    return 0


def isolated() -> int:
    """Run ``component_container_isolated``: an executor per component; return the exit status."""
    has_pools = _POOLS in parse_ros_arguments(sys.argv[1:]).program
    make_executor = MultiThreadedExecutor if has_pools else SingleThreadedExecutor
    with _init_until_interrupt():
        executor = SingleThreadedExecutor()
        _serve(executor, ComponentManager(executor, _NAME, make_executor=make_executor))
    return 0


@contextlib.contextmanager
def _init_until_interrupt() -> Iterator[None]:
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException), init():
        yield


def _serve(executor: Executor, node: ComponentManager) -> None:
    executor.add_node(node)
    progress.report(progress.READY)
    try:
        executor.spin()
    finally:
        executor.shutdown()
        node.destroy_node()
