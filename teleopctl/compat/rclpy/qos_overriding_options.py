"""``rclpy.qos_overriding_options``. Accepted by ``create_publisher`` and ``create_subscription``.

Quality of service is what the program says; parameters do not override it here.
"""

from __future__ import annotations

import dataclasses
import enum
from collections.abc import Callable, Iterable
from typing import Any

__all__ = ["QoSOverridingOptions", "QoSPolicyKind"]


class QoSPolicyKind(enum.IntEnum):
    """The policies, with the numbers of ``rmw/qos_policy_kind.h``."""

    INVALID = 1
    DURABILITY = 2
    DEADLINE = 4
    LIVELINESS = 8
    RELIABILITY = 16
    HISTORY = 32
    LIFESPAN = 64
    DEPTH = 128
    LIVELINESS_LEASE_DURATION = 256
    AVOID_ROS_NAMESPACE_CONVENTIONS = 512


@dataclasses.dataclass(frozen=True)
class QoSOverridingOptions:
    """Which policies parameters might override."""

    policy_kinds: Iterable[QoSPolicyKind]
    callback: Callable[[Any], Any] | None = None
    entity_id: str | None = None

    @classmethod
    def with_default_policies(
        cls, *, callback: Callable[[Any], Any] | None = None, entity_id: str | None = None
    ) -> QoSOverridingOptions:
        """Return options for history, depth and reliability."""
        kinds = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY)
        return cls(kinds, callback, entity_id)
