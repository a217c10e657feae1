"""Names of QoS policies as ROS prints them."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.wire import INFINITE_NS

if TYPE_CHECKING:
    from teleopctl.wire import EndpointQos

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
    """Return the block ``QoS profile:`` of ``topic info --verbose``."""
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
