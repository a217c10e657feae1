"""The QoS flags that ``topic echo`` and ``topic pub`` share."""

from typing import TYPE_CHECKING, Annotated

from teleopctl.cli.verb import Option

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


class QosWishes:
    """What a person asked for; None where nothing was said."""

    __slots__ = ("depth", "durability", "history", "profile", "reliability")

    def __init__(
        self,
        profile: str | None,
        reliability: str | None,
        durability: str | None,
        history: str | None,
        depth: int | None,
    ) -> None:
        self.profile = profile
        self.reliability = reliability
        self.durability = durability
        self.history = history
        self.depth = depth

    def applied_to(self, base: "QoSProfile") -> "QoSProfile":
        """A new profile: the preset, or else ``base``, with the single policies on top."""
        from copy import copy

        from teleopctl.node import (
            DurabilityPolicy,
            HistoryPolicy,
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
        return qos
