"""Endpoints of topics and services as ``info`` prints them, and pairs with incompatible QoS."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING, Iterable, Iterator, NamedTuple, Sequence
from teleopctl.cli import console
from teleopctl.wire import INFINITE_NS

if TYPE_CHECKING:
    from teleopctl.node import QoSCompatibility
    from teleopctl.wire import EndpointQos, EndpointToken


def endpoint_lines(endpoint: EndpointToken, kind: str, role: str) -> list[str]:
    """Return the lines about an endpoint that ``info --verbose`` prints.

    Args:
        endpoint: Endpoint to describe.
        kind: ``Topic`` or ``Service``, to which the endpoint belongs.
        role: Role of the endpoint, such as ``PUBLISHER``.
    """
    return [
        f"Node name: {endpoint.node}",
        f"Node namespace: {endpoint.namespace}",
        f"{kind} type: {endpoint.type_name}",
        f"{kind} type hash: {endpoint.type_hash}",
        f"Endpoint type: {role}",
        f"GID: {endpoint.gid.hex('.')}",
        *qos_lines(endpoint.qos),
        "",
    ]


def endpoint_record(endpoint: EndpointToken) -> dict[str, console.Json]:
    """Return the properties of an endpoint as the JSON object that ``info --json`` prints."""
    return {
        "node": endpoint.node,
        "namespace": endpoint.namespace,
        "type": endpoint.type_name,
        "type_hash": endpoint.type_hash,
        "gid": endpoint.gid.hex(),
        "qos": qos_record(endpoint.qos),
    }


def warn_of_type_mismatch(topic: str, endpoints: Sequence[EndpointToken]) -> None:
    """Warn of endpoints with different types or type hashes, which exchange no messages."""
    types = {endpoint.type_name for endpoint in endpoints}
    if len(types) > 1:
        console.warn(
            f"{topic} has more than one type ({', '.join(sorted(types))}); "
            "endpoints of different types are not connected"
        )
    for type_name in sorted(types):
        nodes_by_hash: dict[str, list[str]] = {}
        for endpoint in endpoints:
            if endpoint.type_name == type_name:
                nodes_by_hash.setdefault(endpoint.type_hash, []).append(endpoint.full_name)
        if len(nodes_by_hash) > 1:
            groups = " and ".join(", ".join(sorted(set(nodes))) for nodes in nodes_by_hash.values())
            console.warn(
                f"{topic}: {groups} mean different versions of {type_name} (their type hashes "
                "differ), so they are not connected"
            )


_RELIABILITY = ("SYSTEM_DEFAULT", "RELIABLE", "BEST_EFFORT", "UNKNOWN", "BEST_AVAILABLE")
_DURABILITY = ("SYSTEM_DEFAULT", "TRANSIENT_LOCAL", "VOLATILE", "UNKNOWN", "BEST_AVAILABLE")
_HISTORY = ("SYSTEM_DEFAULT", "KEEP_LAST", "KEEP_ALL", "UNKNOWN")
_LIVELINESS = {
    0: "SYSTEM_DEFAULT",
    1: "AUTOMATIC",
    3: "MANUAL_BY_TOPIC",
    5: "BEST_AVAILABLE",
}
_KEEP_LAST = 1


def qos_lines(qos: EndpointQos) -> list[str]:
    """Return the lines about a QoS profile that ``topic info --verbose`` prints."""
    history = _name(_HISTORY, qos.history)
    depth = f" ({qos.depth})" if qos.history == _KEEP_LAST else ""
    return [
        "QoS profile:",
        f"  Reliability: {_name(_RELIABILITY, qos.reliability)}",
        f"  History (Depth): {history}{depth}",
        f"  Durability: {_name(_DURABILITY, qos.durability)}",
        f"  Lifespan: {_duration(qos.lifespan_ns)}",
        f"  Deadline: {_duration(qos.deadline_ns)}",
        f"  Liveliness: {_LIVELINESS.get(qos.liveliness, 'UNKNOWN')}",
        f"  Liveliness lease duration: {_duration(qos.lease_ns)}",
    ]


def qos_record(qos: EndpointQos) -> dict[str, str | int | None]:
    """Return a QoS profile for ``--json``; infinite durations are null, others nanoseconds."""
    return {
        "reliability": _name(_RELIABILITY, qos.reliability).lower(),
        "durability": _name(_DURABILITY, qos.durability).lower(),
        "history": _name(_HISTORY, qos.history).lower(),
        "depth": qos.depth,
        "lifespan_ns": _finite(qos.lifespan_ns),
        "deadline_ns": _finite(qos.deadline_ns),
        "liveliness": _LIVELINESS.get(qos.liveliness, "UNKNOWN").lower(),
        "liveliness_lease_ns": _finite(qos.lease_ns),
    }


def _name(names: tuple[str, ...], number: int) -> str:
    return names[number] if 0 <= number < len(names) else "UNKNOWN"


def _finite(duration_ns: int) -> int | None:
    return None if duration_ns >= INFINITE_NS else duration_ns


def _duration(duration_ns: int) -> str:
    return "Infinite" if duration_ns >= INFINITE_NS else f"{duration_ns} nanoseconds"


ON_ZENOH = (
    "They communicate over Zenoh, with the QoS that the publisher offers; over DDS they do not."
)


class QosPair(NamedTuple):
    """A publisher, a subscription and their QoS compatibility.

    Attributes:
        publisher: Publisher of the pair.
        subscription: Subscription of the pair.
        verdict: QoS compatibility of the two.
        reason: Reason of an incompatibility; empty if compatible.
    """

    publisher: EndpointToken
    subscription: EndpointToken
    verdict: QoSCompatibility
    reason: str


def qos_pairs(
    publishers: Iterable[EndpointToken], subscriptions: Iterable[EndpointToken]
) -> Iterator[QosPair]:
    """Yield the QoS compatibility of each publisher with each subscription."""
    from teleopctl.node import QoSProfile, qos_check_compatible

    for publisher in publishers:
        for subscription in subscriptions:
            verdict, reason = qos_check_compatible(
                QoSProfile.from_wire(publisher.qos), QoSProfile.from_wire(subscription.qos)
            )
            yield QosPair(publisher, subscription, verdict, reason.partition(": ")[2])


def warn_of_incompatible_qos(
    topic: str, publishers: Iterable[EndpointToken], subscriptions: Iterable[EndpointToken]
) -> None:
    """Warn of each pair of publisher and subscription whose QoS is incompatible."""
    publishers, subscriptions = list(publishers), list(subscriptions)
    # Usually all QoS profiles are equal, and nothing has to be imported.
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
