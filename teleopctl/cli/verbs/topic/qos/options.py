"""The QoS flags of the verbs that publish, subscribe and call."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli.verb import Option
from teleopctl.errors import UsageError

if TYPE_CHECKING:
    from teleopctl.node import QoSProfile

ProfileName = Annotated[
    str | None,
    Option(
        "--qos-profile",
        help="A preset to start from.",
        choices=(
            *("default", "system_default", "sensor_data", "services_default", "parameters"),
            *("parameter_events", "action_status_default", "best_available"),
        ),
    ),
]
ReliabilityName = Annotated[
    str | None,
    Option(
        "--qos-reliability",
        help="Whether lost messages are sent again.",
        choices=("system_default", "reliable", "best_effort", "best_available"),
    ),
]
DurabilityName = Annotated[
    str | None,
    Option(
        "--qos-durability",
        help="Whether late subscribers get earlier messages.",
        choices=("system_default", "transient_local", "volatile", "best_available"),
    ),
]
HistoryName = Annotated[
    str | None,
    Option(
        "--qos-history",
        help="How many messages are kept.",
        choices=("system_default", "keep_last", "keep_all"),
    ),
]
Depth = Annotated[int | None, Option("--qos-depth", help="Messages kept with keep_last.")]
LivelinessName = Annotated[
    str | None,
    Option(
        "--qos-liveliness",
        help="How a publisher shows that it is alive.",
        choices=("system_default", "automatic", "manual_by_topic", "best_available"),
    ),
]
LeaseDuration = Annotated[
    float | None,
    Option(
        "--qos-liveliness-lease-duration-seconds",
        help="How long it may be silent.",
        metavar="SECONDS",
    ),
]


class QosWishes:
    """The QoS options of a command line; None for those not given."""

    __slots__ = (
        "depth",
        "durability",
        "history",
        "lease_s",
        "liveliness",
        "profile",
        "reliability",
    )

    def __init__(
        self,
        profile: str | None,
        reliability: str | None,
        durability: str | None,
        history: str | None,
        depth: int | None,
        liveliness: str | None = None,
        lease_s: float | None = None,
    ) -> None:
        for flag, value in (
            ("--qos-depth", depth),
            ("--qos-liveliness-lease-duration-seconds", lease_s),
        ):
            if value is not None and value < 0:
                raise UsageError(f"{flag} must not be negative, got {value:g}")
        self.profile = profile
        self.reliability = reliability
        self.durability = durability
        self.history = history
        self.depth = depth
        self.liveliness = liveliness
        self.lease_s = lease_s

    def suited(self, base: "QoSProfile") -> "QoSProfile":
        """Return the QoS of a subscription: the given options, else a base that fits publishers.

        As in ROS 2 a preset alone gives way to what they offer; beside single policies it is
        meant as it is. Policies that nobody names are those of ``base``.
        """
        qos = self.applied_to(base)
        if self.profile and not self._names_policies():
            qos.reliability, qos.durability = base.reliability, base.durability
        return qos

    def _names_policies(self) -> bool:
        named = (self.reliability, self.durability, self.history, self.depth, self.liveliness)
        return any(policy is not None for policy in (*named, self.lease_s))

    def applied_to(self, base: "QoSProfile") -> "QoSProfile":
        """Return the preset or ``base``, with the given policies applied."""
        if not self.profile and not self._names_policies():
            return base
        from copy import copy

        from teleopctl.node import (
            DurabilityPolicy,
            Duration,
            HistoryPolicy,
            LivelinessPolicy,
            QoSPresetProfiles,
            ReliabilityPolicy,
        )

        start = QoSPresetProfiles.get_from_short_key(self.profile) if self.profile else base
        qos = copy(start)
        if self.reliability:
            qos.reliability = ReliabilityPolicy.get_from_short_key(self.reliability)
        if self.durability:
            qos.durability = DurabilityPolicy.get_from_short_key(self.durability)
        if self.history:
            qos.history = HistoryPolicy.get_from_short_key(self.history)
        if self.depth is not None:
            qos.depth = self.depth
        if self.liveliness:
            qos.liveliness = LivelinessPolicy.get_from_short_key(self.liveliness)
        if self.lease_s is not None:
            qos.liveliness_lease_duration = Duration(nanoseconds=round(self.lease_s * 1e9))
        return qos
