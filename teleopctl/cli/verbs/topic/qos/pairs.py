"""Publishers and subscriptions of a topic whose quality of service does not fit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from teleopctl.base.typed import TYPE_CHECKING, NamedTuple
from teleopctl.cli import console

if TYPE_CHECKING:
    from teleopctl.node import QoSCompatibility
    from teleopctl.wire import EndpointToken

ON_ZENOH = "On Zenoh they hear each other, with what the publisher offers; on DDS not at all."


class QosPair(NamedTuple):
    """A publisher, a subscription and their QoS compatibility.

    Attributes:
        publisher: The publisher.
        subscription: The subscription.
        verdict: Whether they fit.
        reason: Why not; empty where they fit.
    """

    publisher: EndpointToken
    subscription: EndpointToken
    verdict: QoSCompatibility
    reason: str


def qos_pairs(
    publishers: Iterable[EndpointToken], subscriptions: Iterable[EndpointToken]
) -> Iterator[QosPair]:
    """Yield each publisher with each subscription."""
    from teleopctl.node import QoSProfile, qos_check_compatible

    for publisher in publishers:
        for subscription in subscriptions:
            verdict, reason = qos_check_compatible(
                QoSProfile.from_wire(publisher.qos), QoSProfile.from_wire(subscription.qos)
            )
            yield QosPair(publisher, subscription, verdict, reason.partition(": ")[2])


def warn_of_qos(
    topic: str, publishers: Iterable[EndpointToken], subscriptions: Iterable[EndpointToken]
) -> None:
    """Warn of publishers whose QoS is incompatible with subscriptions."""
    publishers, subscriptions = list(publishers), list(subscriptions)
    # Where all are alike, as they mostly are, nothing has to be loaded.
    if len({endpoint.qos for endpoint in (*publishers, *subscriptions)}) < 2:
        return
    from teleopctl.node import QoSCompatibility

    refused = [
        f"{pair.publisher.full_name} and {pair.subscription.full_name}: {pair.reason}"
        for pair in qos_pairs(publishers, subscriptions)
        if pair.verdict is QoSCompatibility.ERROR
    ]
    for text in dict.fromkeys(refused):
        console.warn(f"{topic}: {text}. {ON_ZENOH}")
