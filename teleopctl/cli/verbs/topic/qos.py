"""QoS options of the verbs that publish, subscribe and call services."""

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli.verb import Option, OptionSet
from teleopctl.errors import UsageError

if TYPE_CHECKING:
    from teleopctl.node import QoSProfile


class QosOptions(OptionSet):
    """QoS preset and policies given on a command line; None for those not given."""

    qos_profile: Annotated[
        str | None,
        Option(
            "--qos-profile",
            help="QoS preset to start from.",
            choices=(
                *("default", "system_default", "sensor_data", "services_default", "parameters"),
                *("parameter_events", "action_status_default", "best_available"),
            ),
        ),
    ] = None
    qos_reliability: Annotated[
        str | None,
        Option(
            "--qos-reliability",
            help="Reliability policy.",
            choices=("system_default", "reliable", "best_effort", "best_available"),
        ),
    ] = None
    qos_durability: Annotated[
        str | None,
        Option(
            "--qos-durability",
            help="Durability policy.",
            choices=("system_default", "transient_local", "volatile", "best_available"),
        ),
    ] = None
    qos_history: Annotated[
        str | None,
        Option(
            "--qos-history",
            help="History policy.",
            choices=("system_default", "keep_last", "keep_all"),
        ),
    ] = None
    qos_depth: Annotated[int | None, Option("--qos-depth", help="Depth of keep_last.")] = None
    qos_liveliness: Annotated[
        str | None,
        Option(
            "--qos-liveliness",
            help="Liveliness policy.",
            choices=("system_default", "automatic", "manual_by_topic", "best_available"),
        ),
    ] = None
    qos_liveliness_lease_duration_seconds: Annotated[
        float | None,
        Option(
            "--qos-liveliness-lease-duration-seconds",
            help="Liveliness lease duration, in seconds.",
            metavar="SECONDS",
        ),
    ] = None

    def check(self) -> None:
        """Raise a UsageError if the depth or the lease duration is negative."""
        for flag, value in (
            ("--qos-depth", self.qos_depth),
            ("--qos-liveliness-lease-duration-seconds", self.qos_liveliness_lease_duration_seconds),
        ):
            if value is not None and value < 0:
                raise UsageError(f"{flag} must not be negative, got {value:g}")

    def for_subscription(self, compatible: "QoSProfile") -> "QoSProfile":
        """Return the QoS of a subscription: the given options applied to a compatible profile.

        As in ROS 2, reliability and durability of a preset alone are replaced by those that the
        publishers offer; with single policies given, the preset is used as it is.

        Args:
            compatible: QoS profile that is compatible with the publishers of the topic.
        """
        qos = self.applied_to(compatible)
        if self.qos_profile and not self._has_policies():
            qos.reliability, qos.durability = compatible.reliability, compatible.durability
        return qos

    def applied_to(self, base: "QoSProfile") -> "QoSProfile":
        """Return the QoS profile of the command line: a preset or ``base``, with given policies."""
        if not self.are_given:
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

        preset = self.qos_profile
        qos = copy(QoSPresetProfiles.get_from_short_key(preset) if preset else base)
        if self.qos_reliability:
            qos.reliability = ReliabilityPolicy.get_from_short_key(self.qos_reliability)
        if self.qos_durability:
            qos.durability = DurabilityPolicy.get_from_short_key(self.qos_durability)
        if self.qos_history:
            qos.history = HistoryPolicy.get_from_short_key(self.qos_history)
        if self.qos_depth is not None:
            qos.depth = self.qos_depth
        if self.qos_liveliness:
            qos.liveliness = LivelinessPolicy.get_from_short_key(self.qos_liveliness)
        lease_s = self.qos_liveliness_lease_duration_seconds
        if lease_s is not None:
            qos.liveliness_lease_duration = Duration(nanoseconds=round(lease_s * 1e9))
        return qos

    @property
    def are_given(self) -> bool:
        """Whether a preset or a policy is given on the command line."""
        return bool(self.qos_profile) or self._has_policies()

    def _has_policies(self) -> bool:
        single = (name for name in type(self).__annotations__ if name != "qos_profile")
        return any(getattr(self, name) is not None for name in single)
