"""Topic ``/stop``: nodes that hold the robot stopped, and nodes that stop for them.

The topic is latched (std_msgs/Bool). A node that publishes true holds the robot stopped until it
publishes false itself, like an emergency stop button, which is released where it was pressed. A
node that has gone still holds; then false from any node releases.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.interfaces import get_message, get_service
from teleopctl.node.values.qos import DurabilityPolicy, QoSProfile, qos_profile_latched

if TYPE_CHECKING:
    from teleopctl.node.endpoints.subscription import MessageInfo
    from teleopctl.node.node import Node

STOP_TOPIC = "/stop"
# Service of a node that holds the robot stopped, which ends that.
RELEASE_SERVICE = "~/release"
RELEASE_TYPE = "std_srvs/srv/Trigger"
_MOST_WAITING = 100
_UNKNOWN = "a node that is not in the graph"

# Any, here and below: message classes are generated at run time from definitions.


class StopHolders:
    """Subscription to ``/stop``: the nodes that hold the robot stopped.

    Args:
        node: Node that subscribes.
        on_change: Called with the names of the holders, on the thread that spins the node, when
            they have changed; an empty tuple when the robot is released.

    Attributes:
        names: Names of the nodes that hold the robot stopped, the first one first.
    """

    def __init__(self, node: Node, on_change: Callable[[tuple[str, ...]], object]) -> None:
        self._node = node
        self._on_change = on_change
        self._holders: dict[bytes, str] = {}
        self.names: tuple[str, ...] = ()
        self._subscription = node.create_subscription(
            get_message("std_msgs/msg/Bool"),
            STOP_TOPIC,
            self._received,
            # The value of one holder must not replace that of another before it is taken.
            QoSProfile(depth=_MOST_WAITING, durability=DurabilityPolicy.TRANSIENT_LOCAL),
        )

    def close(self) -> None:
        """Destroy the subscription."""
        self._node.destroy_subscription(self._subscription)

    def add(self, key: str, name: str) -> None:
        """Add a holder that does not publish, such as a service, under a key and a name."""
        self._holders.setdefault(key.encode(), name)
        self._update()

    def clear(self) -> None:
        """Remove all holders; those that publish true again hold again."""
        self._holders.clear()
        self._update()

    def name_all(self, timeout_s: float) -> tuple[str, ...]:
        """Return ``names`` once the graph has all holders, or after a time limit in seconds.

        A message may arrive before the news that its publisher is in the graph.
        """
        publishers: dict[bytes, str] = {}

        def has_all() -> bool:
            publishers.update(_publishers(self._node))
            return self._holders.keys() <= publishers.keys()

        if _UNKNOWN in self.names:
            self._node.context.wait_for_change(has_all, timeout_s)
            self._holders = {key: publishers.get(key, old) for key, old in self._holders.items()}
            self.names = tuple(dict.fromkeys(self._holders.values()))
        return self.names

    def _received(self, message: Any, info: MessageInfo) -> None:
        publishers = _publishers(self._node)
        gid = bytes(info["publisher_gid"])
        if message.data:
            self._holders[gid] = publishers.get(gid) or self._holders.get(gid, _UNKNOWN)
        else:
            kept = publishers.keys() - {gid}
            self._holders = {key: name for key, name in self._holders.items() if key in kept}
        self._update()

    def _update(self) -> None:
        names = tuple(dict.fromkeys(self._holders.values()))
        if names != self.names:
            self.names = names
            self._on_change(names)


def _publishers(node: Node) -> dict[bytes, str]:
    """Return the full names of the nodes that publish ``/stop``, by GID of the publisher."""
    return {
        bytes(each.endpoint_gid): f"{each.node_namespace.rstrip('/')}/{each.node_name}"
        for each in node.get_publishers_info_by_topic(STOP_TOPIC)
    }


class StopButton:
    """Publisher of ``/stop``, with a service ``~/release`` by which clients release the robot.

    Args:
        node: Node that holds the robot stopped while it is pressed.
        on_release: Called when ``~/release`` has been called.
    """

    def __init__(self, node: Node, on_release: Callable[[], object] = lambda: None) -> None:
        self._node = node
        self._on_release = on_release
        self._type: Any = get_message("std_msgs/msg/Bool")
        self._publisher = node.create_publisher(self._type, STOP_TOPIC, qos_profile_latched)
        self._service = node.create_service(
            get_service(RELEASE_TYPE), RELEASE_SERVICE, self._release
        )

    def close(self) -> None:
        """Destroy the publisher and the service."""
        self._node.destroy_service(self._service)
        self._node.destroy_publisher(self._publisher)

    def others(self) -> list[str]:
        """Return the names of the nodes of the topic's other publishers."""
        gid = self._publisher.gid
        return sorted({name for other, name in _publishers(self._node).items() if other != gid})

    def press(self) -> None:
        """Hold the robot stopped."""
        self._publisher.publish(self._type(data=True))

    def release(self) -> None:
        """Stop holding the robot; release it also for nodes that have gone."""
        self._publisher.publish(self._type(data=False))

    def _release(self, request: Any, response: Any) -> Any:
        del request
        self.release()
        response.success = True
        self._on_release()
        return response
