"""What a display asks of its topic, so that something arrives.

RViz asks for what its file says, and shows nothing where publishers offer less. Here the file's
wish is met as far as the publishers do: a robot's map or a sensor's cloud appears.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from teleopctl.node import DurabilityPolicy, QoSProfile, ReliabilityPolicy

if TYPE_CHECKING:
    from teleopctl.node import Node

_DEPTH = 5
_MOST = 100


# Any: what YAML holds.
def topic_qos(
    node: Node, topic: str, given: Mapping[str, Any], *, latched: bool = False
) -> QoSProfile:
    """Return the QoS profile with which a display subscribes to a topic.

    Args:
        node: Who asks.
        topic: The topic.
        given: What a file says of the display.
        latched: Whether to ask for the last message of those who keep it, whatever the file says.
    """
    said = given.get("Topic")
    said = said if isinstance(said, Mapping) else {}
    offered = [one.qos_profile for one in node.get_publishers_info_by_topic(topic)]
    reliable = said.get("Reliability Policy", "Reliable") != "Best Effort" and all(
        profile.reliability == ReliabilityPolicy.RELIABLE for profile in offered
    )
    keeps = any(profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for profile in offered)
    depth = said.get("Depth", _DEPTH)
    depth = depth if isinstance(depth, int) and 0 < depth <= _MOST else _DEPTH
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL
        if latched or keeps
        else DurabilityPolicy.VOLATILE,
    )
