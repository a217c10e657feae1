"""``controller_manager.test_utils``: checks for launch tests of robots."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from launch_testing_ros import WaitForTopics
from rclpy.node import Node
from sensor_msgs.msg import JointState

from .controller_manager_services import list_controllers

_LOOKS_EVERY_S = 0.1
_JOINT_STATES_WITHIN_S = 20.0


def check_node_running(node: Node, node_name: str, timeout: float = 5.0) -> None:
    """Wait until a node of this name is in the graph.

    Args:
        node: The node to look from.
        node_name: The name, without its namespace.
        timeout: Seconds to wait.

    Raises:
        AssertionError: None is there by then.
    """
    missing = _missing([node_name], lambda: set(node.get_node_names()), timeout)
    assert not missing, f"{node_name} not found!"


def check_controllers_running(
    node: Node,
    cnames: Iterable[str],
    namespace: str = "",
    state: str = "active",
    timeout: float = 10.0,
) -> None:
    """Wait until controllers are in a state, by default active.

    Args:
        node: The node to look from.
        cnames: Their names.
        namespace: That of their controller manager.
        state: The state.
        timeout: Seconds to wait for their nodes, and once more for their states.

    Raises:
        AssertionError: A controller is missing or in another state at the timeout.
    """
    namespace = f"/{namespace.strip('/')}"
    wanted = list(cnames)

    def nodes() -> set[str]:
        found = node.get_node_names_and_namespaces()
        return {name for name, its_namespace in found if its_namespace == namespace}

    missing = _missing(wanted, nodes, timeout)
    assert not missing, (
        f"Controller node(s) not found in {namespace}: {', '.join(missing)}, but seeing "
        f"{node.get_node_names_and_namespaces()}"
    )
    manager = f"{namespace.rstrip('/')}/controller_manager"

    def in_state() -> set[str]:
        controllers = list_controllers(node, manager, 5.0).controller
        assert controllers, "No controllers found!"
        return {controller.name for controller in controllers if controller.state == state}

    missing = _missing(wanted, in_state, timeout)
    assert not missing, f"Controller(s) not found or not {state}: {', '.join(missing)}"


def check_if_js_published(topic: str, joint_names: Iterable[str]) -> None:
    """Wait for a JointState, and check its joints, in any order.

    Args:
        topic: Topic of the message.
        joint_names: The joints.

    Raises:
        AssertionError: None comes, or it has others.
    """
    topics = WaitForTopics([(topic, JointState)], timeout=_JOINT_STATES_WITHIN_S)
    try:
        assert topics.wait(), f"Topic '{topic}' not found!"
        names = topics.received_messages(topic)[0].name
    finally:
        topics.shutdown()
    assert sorted(names) == sorted(joint_names), f"Wrong joints in message: {', '.join(names)}"


def _missing(wanted: Iterable[str], found: Callable[[], set[str]], timeout: float) -> list[str]:
    """Return the items that are not found within a timeout in seconds."""
    end = time.monotonic() + timeout
    while True:
        there = found()
        missing = [name for name in wanted if name not in there]
        if not missing or time.monotonic() > end:
            return missing
        time.sleep(_LOOKS_EVERY_S)
