"""Whether a publisher and a subscription fit each other by their quality of service.

The rules are those of DDS, which rmw_zenoh's check has as well. On Zenoh itself everything meets
everything; but what does not fit here loses messages, or never meets under another middleware.
"""

from __future__ import annotations

import enum
from collections.abc import Iterator

from teleopctl.node.values.qos import (
    DurabilityPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from teleopctl.node.values.time import Duration, Infinite


class QoSCompatibility(enum.IntEnum):
    """Compatibility of two QoS profiles: ok, warning or error."""

    OK = 0
    WARNING = 1
    ERROR = 2


_Policy = ReliabilityPolicy | DurabilityPolicy | LivelinessPolicy

# What a subscription asks for, and what a publisher offers that is less.
_LESS_THAN_ASKED: tuple[tuple[str, _Policy, _Policy], ...] = (
    ("reliability", ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT),
    ("durability", DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE),
    ("liveliness", LivelinessPolicy.MANUAL_BY_TOPIC, LivelinessPolicy.AUTOMATIC),
)
_UNDECIDED = frozenset({"SYSTEM_DEFAULT", "UNKNOWN"})


def qos_check_compatible(
    publisher_qos: QoSProfile, subscription_qos: QoSProfile
) -> tuple[QoSCompatibility, str]:
    """Return the compatibility of two QoS profiles, and the reason.

    Where a policy is left to the system or unknown, and it could matter, that is a warning.
    """
    errors = "; ".join(_errors(publisher_qos, subscription_qos))
    if errors:
        return QoSCompatibility.ERROR, f"ERROR: {errors}"
    warnings = "; ".join(_warnings(publisher_qos, subscription_qos))
    if warnings:
        return QoSCompatibility.WARNING, f"WARNING: {warnings}"
    return QoSCompatibility.OK, ""


def _errors(publisher: QoSProfile, subscription: QoSProfile) -> Iterator[str]:
    for name, asked, less in _LESS_THAN_ASKED:
        if getattr(subscription, name) == asked and getattr(publisher, name) == less:
            yield f"{name}: {less.name} publisher and {asked.name} subscription"
    for name in ("deadline", "liveliness_lease_duration"):
        offered, wanted = _bound(getattr(publisher, name)), _bound(getattr(subscription, name))
        if offered > wanted:
            yield f"{name}: {offered} of the publisher exceed {wanted} of the subscription"


def _warnings(publisher: QoSProfile, subscription: QoSProfile) -> Iterator[str]:
    for name, asked, less in _LESS_THAN_ASKED:
        offered, wanted = getattr(publisher, name), getattr(subscription, name)
        if (offered.name in _UNDECIDED and (wanted == asked or wanted.name in _UNDECIDED)) or (
            wanted.name in _UNDECIDED and offered == less
        ):
            yield f"{name}: {offered.name} publisher and {wanted.name} subscription"


def _bound(duration: Duration) -> Duration:
    """Return a duration with zero, which stands for no bound, as infinite."""
    return duration if duration.nanoseconds else Infinite
