"""QoS profiles in the liveliness tokens of endpoints, as rmw_zenoh writes them.

The text is ``reliability:durability:history,depth:deadline:lifespan:liveliness,lease`` where a
duration is ``seconds,nanoseconds`` and every number that equals rmw_zenoh's default is left out.
Policies are the plain integers of ``rmw/types.h``; names for them belong to the client library.
"""

from __future__ import annotations

from teleopctl.base.typed import NamedTuple
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, split

INFINITE_NS = 9_223_372_036_854_775_807
"""A duration that never ends, in nanoseconds: the largest that the ROS middleware can express."""

DEFAULT_DEPTH = 42
"""Depth of a token whose depth is left out."""

RELIABILITY_RELIABLE = 1
RELIABILITY_BEST_EFFORT = 2
DURABILITY_TRANSIENT_LOCAL = 1
DURABILITY_VOLATILE = 2
HISTORY_KEEP_LAST = 1
LIVELINESS_AUTOMATIC = 1

_INFINITE_S, _INFINITE_REST_NS = split(INFINITE_NS)
_HIGHEST_RELIABILITY = 4
_HIGHEST_DURABILITY = 4
_HIGHEST_HISTORY = 3
_HIGHEST_LIVELINESS = 5
_LONGEST_NUMBER = 20


# Texts come from other processes, so that there may be any number.
_MOST_PARSED = 1000
_parsed: dict[str, EndpointQos | None] = {}


class EndpointQos(NamedTuple):
    """Offered or requested QoS of an endpoint; durations in nanoseconds."""

    reliability: int = RELIABILITY_RELIABLE
    durability: int = DURABILITY_VOLATILE
    history: int = HISTORY_KEEP_LAST
    depth: int = DEFAULT_DEPTH
    deadline_ns: int = INFINITE_NS
    lifespan_ns: int = INFINITE_NS
    liveliness: int = LIVELINESS_AUTOMATIC
    lease_ns: int = INFINITE_NS

    @property
    def is_reliable(self) -> bool:
        """Whether the reliability is RELIABLE or left at the system default."""
        return self.reliability in (0, RELIABILITY_RELIABLE)

    @property
    def is_transient_local(self) -> bool:
        """Whether the durability is TRANSIENT_LOCAL."""
        return self.durability == DURABILITY_TRANSIENT_LOCAL


def format_qos(qos: EndpointQos) -> str:
    """Return a QoS profile as text in the form that liveliness tokens contain.

    A system default policy (0), a depth of 0 and a duration of 0 become rmw_zenoh's defaults. The
    depth is always written, since implementations interpret an empty depth differently.
    """
    return ":".join(
        (
            _unless(qos.reliability or RELIABILITY_RELIABLE, RELIABILITY_RELIABLE),
            _unless(qos.durability or DURABILITY_VOLATILE, DURABILITY_VOLATILE),
            f"{_unless(qos.history or HISTORY_KEEP_LAST, HISTORY_KEEP_LAST)},"
            f"{qos.depth or DEFAULT_DEPTH}",
            _format_duration(qos.deadline_ns),
            _format_duration(qos.lifespan_ns),
            f"{_unless(qos.liveliness or LIVELINESS_AUTOMATIC, LIVELINESS_AUTOMATIC)},"
            f"{_format_duration(qos.lease_ns)}",
        )
    )


def parse_qos(text: str) -> EndpointQos | None:
    """Parse the QoS part of a liveliness token to an `EndpointQos`; return None if malformed."""
    # A graph has thousands of endpoints, and few texts of QoS.
    if text not in _parsed:
        if len(_parsed) >= _MOST_PARSED:
            _parsed.clear()
        _parsed[text] = _parse(text)
    return _parsed[text]


def _parse(text: str) -> EndpointQos | None:
    parts = text.split(":")
    if len(parts) != 6:
        return None
    history = parts[2].split(",")
    deadline = parts[3].split(",")
    lifespan = parts[4].split(",")
    liveliness = parts[5].split(",")
    if (len(history), len(deadline), len(lifespan), len(liveliness)) != (2, 2, 2, 3):
        return None
    try:
        qos = EndpointQos(
            _number(parts[0], RELIABILITY_RELIABLE),
            _number(parts[1], DURABILITY_VOLATILE),
            _number(history[0], HISTORY_KEEP_LAST),
            _number(history[1], DEFAULT_DEPTH),
            _duration_ns(deadline[0], deadline[1]),
            _duration_ns(lifespan[0], lifespan[1]),
            _number(liveliness[0], LIVELINESS_AUTOMATIC),
            _duration_ns(liveliness[1], liveliness[2]),
        )
    except ValueError:
        return None
    known = (
        qos.reliability <= _HIGHEST_RELIABILITY
        and qos.durability <= _HIGHEST_DURABILITY
        and qos.history <= _HIGHEST_HISTORY
        and qos.liveliness <= _HIGHEST_LIVELINESS
    )
    return qos if known else None


def _unless(value: int, default: int) -> str:
    return "" if value == default else str(value)


def _format_duration(duration_ns: int) -> str:
    seconds, rest_ns = split(duration_ns or INFINITE_NS)
    return f"{_unless(seconds, _INFINITE_S)},{_unless(rest_ns, _INFINITE_REST_NS)}"


def _number(text: str, default: int) -> int:
    if not text:
        return default
    # int() would also take signs, blanks, underscores and the digits of every script.
    if len(text) > _LONGEST_NUMBER or not (text.isascii() and text.isdigit()):
        raise ValueError(text)
    return int(text)


def _duration_ns(seconds: str, nanoseconds: str) -> int:
    rest_ns = _number(nanoseconds, _INFINITE_REST_NS)
    return _number(seconds, _INFINITE_S) * NANOSECONDS_PER_SECOND + rest_ns
