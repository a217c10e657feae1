"""The quality of service with which the topics of a bag are played."""

from __future__ import annotations

from collections.abc import Sequence

from teleopctl.bag.records import BagTopic
from teleopctl.node import HistoryPolicy, QoSProfile, ReliabilityPolicy
from teleopctl.wire import EndpointQos

# Of a topic of which nothing was recorded, as in rosbag2.
_DEPTH = 10

STATIC_TRANSFORMS = "tf2_msgs/msg/TFMessage"
STATIC_TRANSFORMS_KEPT = 100
"""Each broadcaster has a message of its own on the latched topic: the last is not enough."""


def offer_for(topic: BagTopic) -> QoSProfile | None:
    """Return the recorded QoS profile; None if the publishers offered different ones.

    Only what decides who can understand whom has to be the same: not history, depth and lifespan.
    """
    if not topic.qos:
        return QoSProfile(depth=_DEPTH)
    if len({_decisive(profile) for profile in topic.qos}) > 1:
        return None
    profile = QoSProfile.from_wire(topic.qos[0])
    return QoSProfile(
        depth=max(latched_messages(topic), _depth(topic.qos)),
        reliability=profile.reliability,
        durability=profile.durability,
        deadline=profile.deadline,
        lifespan=profile.lifespan,
        liveliness=profile.liveliness,
        liveliness_lease_duration=profile.liveliness_lease_duration,
    )


def default_offer() -> QoSProfile:
    """Return the QoS profile for a topic whose publishers offered different ones."""
    return QoSProfile(depth=_DEPTH)


def keeping_all(offer: QoSProfile) -> QoSProfile:
    """Return the profile of a publisher that waits for slow subscribers, if reliable.

    A latched one stays as well: its late subscribers are to have its last messages, not all.
    """
    if offer.reliability == ReliabilityPolicy.BEST_EFFORT or offer.is_latched:
        return offer
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL,
        reliability=offer.reliability,
        durability=offer.durability,
        deadline=offer.deadline,
        lifespan=offer.lifespan,
        liveliness=offer.liveliness,
        liveliness_lease_duration=offer.liveliness_lease_duration,
    )


def latched_messages(topic: BagTopic) -> int:
    """Return how many last messages a late subscriber must receive; 0 for volatile topics."""
    if not topic.is_latched:
        return 0
    return STATIC_TRANSFORMS_KEPT if topic.type_name == STATIC_TRANSFORMS else 1


def _depth(profiles: Sequence[EndpointQos]) -> int:
    return max(profile.depth for profile in profiles) or _DEPTH


def _decisive(profile: EndpointQos) -> tuple[object, ...]:
    return (
        *(profile.reliability, profile.durability, profile.deadline_ns),
        *(profile.liveliness, profile.lease_ns),
    )
