"""``launch_ros.utilities.lifecycle_event_manager``."""

from __future__ import annotations

from launch.launch_context import LaunchContext

from .._lifecycle import LifecycleLink, NamedNode


class LifecycleEventManager:
    """Connects to launch events a lifecycle node that the launch does not start.

    Its transitions are emitted as `StateTransition`; `ChangeState` requests transitions.

    Args:
        lifecycle_node: Action of the node, with a ``node_name``.
    """

    def __init__(self, lifecycle_node: NamedNode) -> None:
        self._node = lifecycle_node

    @property
    def node_name(self) -> str:
        """The node's full name."""
        return self._node.node_name

    def setup_lifecycle_manager(self, context: LaunchContext) -> None:
        """Subscribe to the node's transitions, and handle requests for transitions."""
        link = LifecycleLink(self._node, None, context.launch)
        context.launch.register(link)
        link.begin()
