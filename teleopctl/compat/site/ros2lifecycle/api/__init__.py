"""``ros2lifecycle.api``. Lifecycle nodes of the graph: their states and transitions."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import rclpy
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState
from ros2node.api import NodeName, get_node_names as get_all_node_names
from ros2service.api import get_service_names_and_types

__all__ = [
    "call_change_states",
    "call_get_available_transitions",
    "call_get_states",
    "call_get_transition_graph",
    "get_node_names",
]

# Any, here and below: a Node, or a node of ros2cli; states and transitions, which are messages.


def get_node_names(*, node: Any, include_hidden_nodes: bool = False) -> list[NodeName]:
    """Return the names of the lifecycle nodes of the graph."""
    services = dict(get_service_names_and_types(node=node, include_hidden_services=True))
    return [
        name
        for name in get_all_node_names(node=node, include_hidden_nodes=include_hidden_nodes)
        if "lifecycle_msgs/srv/GetState" in services.get(f"{name.full_name}/get_state", ())
    ]


def call_get_states(*, node: Any, node_names: Iterable[str]) -> dict[str, Any]:
    """Return the state of each lifecycle node, or the exception of its service."""
    requests = {name: GetState.Request() for name in node_names}
    return _call(node, GetState, "get_state", requests, lambda answer: answer.current_state)


def call_get_available_transitions(*, node: Any, states: Mapping[str, Any]) -> dict[str, Any]:
    """Return the transitions from each node's state, or the exception of its service."""
    return _transitions(node, states, "get_available_transitions")


def call_get_transition_graph(*, node: Any, states: Mapping[str, Any]) -> dict[str, Any]:
    """Return all transitions of each node, or the exception of its service."""
    return _transitions(node, states, "get_transition_graph")


def call_change_states(*, node: Any, transitions: Mapping[str, Any]) -> dict[str, Any]:
    """Start a transition at each node; return whether it succeeded, or the exception."""
    requests = {name: ChangeState.Request(transition=one) for name, one in transitions.items()}
    return _call(node, ChangeState, "change_state", requests, lambda answer: answer.success)


def _transitions(node: Any, states: Mapping[str, Any], service: str) -> dict[str, Any]:
    requests = {name: GetAvailableTransitions.Request() for name in states}
    return _call(
        node,
        GetAvailableTransitions,
        service,
        requests,
        lambda answer: answer.available_transitions,
    )


def _call(
    node: Any,
    service_type: Any,
    service: str,
    requests: Mapping[str, Any],
    result: Callable[[Any], Any],
) -> dict[str, Any]:
    """Call a service of several nodes; return the result or the exception of each by name."""
    found: dict[str, Any] = {}
    plain = getattr(node, "node", node)
    for name, request in requests.items():
        client = plain.create_client(service_type, f"{name}/{service}")
        try:
            if not client.wait_for_service(timeout_sec=5.0):
                found[name] = RuntimeError(f"service {name}/{service} is not available")
                continue
            future = client.call_async(request)
            rclpy.spin_until_future_complete(plain, future)
            found[name] = future.exception() or result(future.result())
        finally:
            plain.destroy_client(client)
    return found
