"""QoS profiles and policies of rclpy, their form in liveliness tokens, their compatibility."""

from __future__ import annotations

import enum
from collections.abc import Iterator

from teleopctl.base.typed import TYPE_CHECKING, Any, Self
from teleopctl.errors import UsageError
from teleopctl.node.values.time import Duration, Infinite
from teleopctl.wire import INFINITE_NS, EndpointQos

RMW_DEFAULT_DEPTH = 42
# rmw's "best available" deadline or lease; as in rmw_zenoh it is infinite.
BEST_AVAILABLE_NS = INFINITE_NS - 1


class _PolicyType(enum.EnumMeta):
    """Metaclass by which members also have their names in rmw, which older programs use."""

    if not TYPE_CHECKING:  # type checkers only accept the members

        def __getattr__(cls, name: str) -> object:
            member = name.removeprefix(f"RMW_QOS_{cls._rmw_name()}_")
            if member == name or member not in cls.__members__:
                raise AttributeError(f"{cls.__name__} has no attribute {name!r}")
            import warnings

            said = f"{cls.__name__}.{name} is deprecated. Use {cls.__name__}.{member} instead."
            warnings.warn(said, stacklevel=2)
            return cls[member]


class QoSPolicyEnum(enum.IntEnum, metaclass=_PolicyType):
    """Base of policies whose members have short names, as on the command line (``best_effort``)."""

    @classmethod
    def _rmw_name(cls) -> str:
        """Return the name of the policy in rmw, such as ``POLICY_HISTORY``."""
        return f"POLICY_{cls.__name__.removesuffix('Policy').upper()}"

    @property
    def short_key(self) -> str:
        """Name of the policy value in lower case, as on the command line."""
        return self.name.lower()

    @classmethod
    def short_keys(cls) -> list[str]:
        """Return the lower-case names of all values of the policy."""
        return [member.short_key for member in cls]

    @classmethod
    def get_from_short_key(cls, name: str) -> Self:
        """Return the policy value of a lower-case name.

        Raises:
            UsageError: The name is unknown.
        """
        try:
            return cls[name.upper()]
        except KeyError:
            known = ", ".join(key for key in cls.short_keys() if key != "unknown")
            raise UsageError(
                f"'{name}' is no {cls.__name__}", hint=f"choose one of {known}"
            ) from None


class ReliabilityPolicy(QoSPolicyEnum):
    """QoS policy: reliable or best effort."""

    SYSTEM_DEFAULT = 0
    RELIABLE = 1
    BEST_EFFORT = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class DurabilityPolicy(QoSPolicyEnum):
    """QoS policy: whether late subscriptions receive earlier messages."""

    SYSTEM_DEFAULT = 0
    TRANSIENT_LOCAL = 1
    VOLATILE = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class HistoryPolicy(QoSPolicyEnum):
    """QoS policy: number of messages kept, the last ones or all."""

    SYSTEM_DEFAULT = 0
    KEEP_LAST = 1
    KEEP_ALL = 2
    UNKNOWN = 3


class LivelinessPolicy(QoSPolicyEnum):
    """QoS policy: way in which a publisher asserts its liveliness."""

    SYSTEM_DEFAULT = 0
    AUTOMATIC = 1
    MANUAL_BY_TOPIC = 3
    UNKNOWN = 4
    BEST_AVAILABLE = 5


class InvalidQoSProfileException(Exception):
    """A QoS profile has neither history nor depth, or KEEP_LAST without a depth."""


class QoSProfile:
    """QoS profile of a publisher, subscription, service or client.

    Args:
        history: Number of messages kept; KEEP_LAST by default.
        depth: Number of messages kept with KEEP_LAST; required unless a history is given.
        reliability: Reliability; RELIABLE by default.
        durability: Durability; VOLATILE by default.
        lifespan: Age from which a message is dropped; infinite by default.
        deadline: Longest time between two messages; infinite by default.
        liveliness: Way in which publishers assert their liveliness; AUTOMATIC by default.
        liveliness_lease_duration: Longest time between two assertions; infinite by default.
        avoid_ros_namespace_conventions: Accepted for rclpy programs; without effect on Zenoh.

    Raises:
        InvalidQoSProfileException: Neither history nor depth was given, or KEEP_LAST without
            depth.
    """

    # The attributes that ros2cli's daemon serializes; in rclpy's order, which is that of the repr.
    __slots__ = (  # noqa: RUF023
        "history",
        "_depth",
        "reliability",
        "durability",
        "lifespan",
        "deadline",
        "liveliness",
        "liveliness_lease_duration",
        "avoid_ros_namespace_conventions",
    )

    def __init__(
        self,
        *,
        history: HistoryPolicy | None = None,
        depth: int | None = None,
        reliability: ReliabilityPolicy = ReliabilityPolicy.RELIABLE,
        durability: DurabilityPolicy = DurabilityPolicy.VOLATILE,
        lifespan: Duration | None = None,
        deadline: Duration | None = None,
        liveliness: LivelinessPolicy = LivelinessPolicy.AUTOMATIC,
        liveliness_lease_duration: Duration | None = None,
        avoid_ros_namespace_conventions: bool = False,
    ) -> None:
        if history is None and depth is None:
            raise InvalidQoSProfileException("History and/or depth settings are required.")
        if history == HistoryPolicy.KEEP_LAST and depth is None:
            raise InvalidQoSProfileException("History set to KEEP_LAST without a depth setting.")
        self.history = HistoryPolicy.KEEP_LAST if history is None else HistoryPolicy(history)
        self._depth = 0
        if depth is not None:
            self.depth = depth
        self.reliability = ReliabilityPolicy(reliability)
        self.durability = DurabilityPolicy(durability)
        self.lifespan = Infinite if lifespan is None else lifespan
        self.deadline = Infinite if deadline is None else deadline
        self.liveliness = LivelinessPolicy(liveliness)
        self.liveliness_lease_duration = (
            Infinite if liveliness_lease_duration is None else liveliness_lease_duration
        )
        self.avoid_ros_namespace_conventions = avoid_ros_namespace_conventions

    @property
    def depth(self) -> int:
        """History depth with KEEP_LAST; 0 is the middleware's default.

        Raises:
            ValueError: The depth is set to a negative number.
        """
        return self._depth

    @depth.setter
    def depth(self, value: int) -> None:
        if value < 0:
            raise ValueError(f"QoS depth must be greater than or equal to zero, got {value}")
        if value == 0 and self.history == HistoryPolicy.KEEP_LAST:
            import warnings

            warnings.warn(
                "A zero depth with KEEP_LAST doesn't make sense: nothing could be kept. "
                "The system default is used.",
                stacklevel=2,
            )
        self._depth = value

    @property
    def is_latched(self) -> bool:
        """Whether the durability is transient local."""
        return self.durability == DurabilityPolicy.TRANSIENT_LOCAL

    @property
    def queue_depth(self) -> int | None:
        """Depth of a receive queue by this profile, 42 if unset; None (unlimited) with KEEP_ALL."""
        if self.history == HistoryPolicy.KEEP_ALL:
            return None
        return self.depth or RMW_DEFAULT_DEPTH

    def to_wire(self) -> EndpointQos:
        """Return the profile as liveliness tokens hold it, with rmw_zenoh's defaults."""
        return EndpointQos(
            reliability=self.reliability or ReliabilityPolicy.RELIABLE,
            durability=self.durability or DurabilityPolicy.VOLATILE,
            history=self.history or HistoryPolicy.KEEP_LAST,
            depth=self.depth or RMW_DEFAULT_DEPTH,
            deadline_ns=_wire_duration(self.deadline),
            lifespan_ns=_wire_duration(self.lifespan),
            liveliness=self.liveliness or LivelinessPolicy.AUTOMATIC,
            lease_ns=_wire_duration(self.liveliness_lease_duration),
        )

    @classmethod
    def from_wire(cls, qos: EndpointQos) -> QoSProfile:
        """Return the profile that a liveliness token holds."""
        return cls(
            history=HistoryPolicy(qos.history),
            depth=qos.depth,
            reliability=ReliabilityPolicy(qos.reliability),
            durability=DurabilityPolicy(qos.durability),
            lifespan=_rclpy_duration(qos.lifespan_ns),
            deadline=_rclpy_duration(qos.deadline_ns),
            liveliness=LivelinessPolicy(qos.liveliness),
            liveliness_lease_duration=_rclpy_duration(qos.lease_ns),
        )

    def get_c_qos_profile(self) -> QoSProfile:
        """Return this profile; rclpy returns the one of its C library."""
        return self

    # Any: policies have different types.
    def to_dict(self) -> dict[str, Any]:
        """Return the policies of the profile, by the constructor's argument names."""
        return {name.lstrip("_"): getattr(self, name) for name in self.__slots__}

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, QoSProfile):
            return NotImplemented
        return all(getattr(self, name) == getattr(other, name) for name in self.__slots__)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        fields = ", ".join(f"{name}={value!r}" for name, value in self.to_dict().items())
        return f"QoSProfile({fields})"


def _wire_duration(duration: Duration) -> int:
    unbounded = duration == Duration() or duration.nanoseconds >= BEST_AVAILABLE_NS
    return INFINITE_NS if unbounded else duration.nanoseconds


def bound_ns(duration: Duration) -> int | None:
    """Return a QoS duration in nanoseconds; None if it is unspecified or infinite."""
    nanoseconds = duration.nanoseconds
    return nanoseconds if 0 < nanoseconds < INFINITE_NS else None


def _rclpy_duration(nanoseconds: int) -> Duration:
    return Infinite if nanoseconds >= INFINITE_NS else Duration(nanoseconds=nanoseconds)


def as_qos_profile(profile_or_depth: QoSProfile | int) -> QoSProfile:
    """Return a QoS profile as it is, or the default profile with an integer as depth.

    Raises:
        TypeError: The value is neither.
    """
    if isinstance(profile_or_depth, QoSProfile):
        return profile_or_depth
    if isinstance(profile_or_depth, int) and not isinstance(profile_or_depth, bool):
        return QoSProfile(depth=profile_or_depth)
    raise TypeError(f"Expected QoSProfile or int, but received {type(profile_or_depth).__name__}")


qos_profile_default = QoSProfile(depth=10)
qos_profile_system_default = QoSProfile(
    history=HistoryPolicy.SYSTEM_DEFAULT,
    depth=0,
    reliability=ReliabilityPolicy.SYSTEM_DEFAULT,
    durability=DurabilityPolicy.SYSTEM_DEFAULT,
    liveliness=LivelinessPolicy.SYSTEM_DEFAULT,
)
qos_profile_sensor_data = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
qos_profile_services_default = QoSProfile(depth=10)
qos_profile_parameters = QoSProfile(depth=1000)
qos_profile_parameter_events = QoSProfile(depth=1000)
qos_profile_action_status_default = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
qos_profile_best_available = QoSProfile(
    depth=10,
    reliability=ReliabilityPolicy.BEST_AVAILABLE,
    durability=DurabilityPolicy.BEST_AVAILABLE,
    liveliness=LivelinessPolicy.BEST_AVAILABLE,
)
qos_profile_rosout_default = QoSProfile(
    depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL, lifespan=Duration(seconds=10)
)
qos_profile_latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
qos_profile_unknown = QoSProfile(
    history=HistoryPolicy.UNKNOWN,
    depth=0,
    reliability=ReliabilityPolicy.UNKNOWN,
    durability=DurabilityPolicy.UNKNOWN,
    lifespan=Duration(),
    deadline=Duration(),
    liveliness=LivelinessPolicy.UNKNOWN,
    liveliness_lease_duration=Duration(),
)
qos_profile_clock = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class QoSPresetProfiles(enum.Enum):
    """Preset QoS profiles, by rclpy's names."""

    UNKNOWN = qos_profile_unknown
    DEFAULT = qos_profile_default
    SYSTEM_DEFAULT = qos_profile_system_default
    SENSOR_DATA = qos_profile_sensor_data
    SERVICES_DEFAULT = qos_profile_services_default
    PARAMETERS = qos_profile_parameters
    PARAMETER_EVENTS = qos_profile_parameter_events
    ACTION_STATUS_DEFAULT = qos_profile_action_status_default
    BEST_AVAILABLE = qos_profile_best_available

    @classmethod
    def short_keys(cls) -> list[str]:
        """Return the lower-case names of the presets except UNKNOWN, as on the command line."""
        return [preset.name.lower() for preset in cls if preset is not cls.UNKNOWN]

    @classmethod
    def get_from_short_key(cls, name: str) -> QoSProfile:
        """Return the preset profile of a lower-case name.

        Raises:
            UsageError: The name is unknown.
        """
        preset = cls.__members__.get(name.upper())
        if preset is None or preset is cls.UNKNOWN:
            raise UsageError(
                f"'{name}' is not a QoS profile",
                hint=f"choose one of {', '.join(cls.short_keys())}",
            )
        profile = preset.value
        assert isinstance(profile, QoSProfile)
        return profile


class QoSCompatibility(enum.IntEnum):
    """Result of comparing two QoS profiles: ok, warning or error."""

    OK = 0
    WARNING = 1
    ERROR = 2


# For each policy: a value requested by the subscription, and an insufficient publisher's value.
_INSUFFICIENT_VALUES: tuple[tuple[str, QoSPolicyEnum, QoSPolicyEnum], ...] = (
    ("reliability", ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT),
    ("durability", DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE),
    ("liveliness", LivelinessPolicy.MANUAL_BY_TOPIC, LivelinessPolicy.AUTOMATIC),
)
_UNDECIDED = frozenset({"SYSTEM_DEFAULT", "UNKNOWN"})


def qos_check_compatible(
    publisher_qos: QoSProfile, subscription_qos: QoSProfile
) -> tuple[QoSCompatibility, str]:
    """Return the compatibility (OK, WARNING, ERROR) of two QoS profiles in DDS, and the reason.

    The result is a warning if a policy is unknown or the system default, and could be incompatible.
    """
    errors = "; ".join(_errors(publisher_qos, subscription_qos))
    if errors:
        return QoSCompatibility.ERROR, f"ERROR: {errors}"
    warnings = "; ".join(_warnings(publisher_qos, subscription_qos))
    if warnings:
        return QoSCompatibility.WARNING, f"WARNING: {warnings}"
    return QoSCompatibility.OK, ""


def _errors(publisher: QoSProfile, subscription: QoSProfile) -> Iterator[str]:
    for name, requested, insufficient in _INSUFFICIENT_VALUES:
        if getattr(subscription, name) == requested and getattr(publisher, name) == insufficient:
            yield f"{name}: {insufficient.name} publisher and {requested.name} subscription"
    for name in ("deadline", "liveliness_lease_duration"):
        offered, wanted = _bound(getattr(publisher, name)), _bound(getattr(subscription, name))
        if offered > wanted:
            yield f"{name}: {offered} of the publisher exceed {wanted} of the subscription"


def _warnings(publisher: QoSProfile, subscription: QoSProfile) -> Iterator[str]:
    for name, requested, insufficient in _INSUFFICIENT_VALUES:
        offered, wanted = getattr(publisher, name), getattr(subscription, name)
        if (offered.name in _UNDECIDED and (wanted == requested or wanted.name in _UNDECIDED)) or (
            wanted.name in _UNDECIDED and offered == insufficient
        ):
            yield f"{name}: {offered.name} publisher and {wanted.name} subscription"


def _bound(duration: Duration) -> Duration:
    """Return a duration with zero, which stands for no bound, as infinite."""
    return duration if duration.nanoseconds else Infinite
