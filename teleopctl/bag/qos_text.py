"""Quality of service as bags write it: ``offered_qos_profiles``, a YAML list.

Version 8 of rosbag2's metadata has it as a text in which policies are the integers of
``rmw/types.h`` (versions 4 to 8 alike), version 9 as a list in which they are names. Both are read;
version 8 is written, since every rosbag2 reads that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import yaml

from teleopctl.base import ros_yaml
from teleopctl.errors import InvalidFileError
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, split
from teleopctl.node import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, ReliabilityPolicy
from teleopctl.wire import INFINITE_NS, EndpointQos

_SAFE_DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)

# Older versions of rosbag2 wrote what the middleware calls infinite in other ways; none is longer.
_LONGEST_S = INFINITE_NS // NANOSECONDS_PER_SECOND


def format_offers(profiles: Sequence[EndpointQos]) -> str:
    """Return the text of offered QoS profiles, as metadata.yaml has it; empty for none."""
    if not profiles:
        return ""
    listed = [
        {
            "history": profile.history,
            "depth": profile.depth,
            "reliability": profile.reliability,
            "durability": profile.durability,
            "deadline": _format_duration(profile.deadline_ns),
            "lifespan": _format_duration(profile.lifespan_ns),
            "liveliness": profile.liveliness,
            "liveliness_lease_duration": _format_duration(profile.lease_ns),
            "avoid_ros_namespace_conventions": False,
        }
        for profile in profiles
    ]
    text: str = yaml.dump(listed, Dumper=_SAFE_DUMPER, sort_keys=False)
    return text.rstrip("\n")


# Any: YAML's values, from a file that nobody here wrote.
def parse_offers(value: Any) -> tuple[EndpointQos, ...]:
    """Parse offered QoS profiles: the text of version 8 or the list of version 9.

    Policies and durations that are missing or unknown are those of the default profile.

    Raises:
        InvalidFileError: It is neither.
    """
    if not value:
        return ()
    try:
        listed = ros_yaml.load(value) if isinstance(value, str) else value
        return tuple(dict.fromkeys(_profile(item) for item in listed or ()))
    except (
        *(yaml.YAMLError, ArithmeticError, AttributeError),
        *(LookupError, TypeError, ValueError),
    ) as error:
        raise InvalidFileError(f"offered_qos_profiles is no list of profiles: {error}") from error


def _profile(item: Mapping[str, Any]) -> EndpointQos:
    default = EndpointQos()
    return EndpointQos(
        _policy(item.get("reliability"), ReliabilityPolicy, default.reliability),
        _policy(item.get("durability"), DurabilityPolicy, default.durability),
        _policy(item.get("history"), HistoryPolicy, default.history),
        max(0, int(item.get("depth", default.depth))),
        _duration_ns(item.get("deadline")),
        _duration_ns(item.get("lifespan")),
        _policy(item.get("liveliness"), LivelinessPolicy, default.liveliness),
        _duration_ns(item.get("liveliness_lease_duration")),
    )


def _policy(value: object, policies: Any, default: int) -> int:
    if isinstance(value, str):
        return int(policies[value.upper()]) if value.upper() in policies.__members__ else default
    return int(value) if isinstance(value, int) and value in set(policies) else default


def _format_duration(duration_ns: int) -> dict[str, int]:
    seconds, rest_ns = split(duration_ns or INFINITE_NS)
    return {"sec": seconds, "nsec": rest_ns}


def _duration_ns(value: Mapping[str, Any] | str | None) -> int:
    # Version 9 may write the word instead of the number.
    if not isinstance(value, Mapping):
        return INFINITE_NS
    seconds, rest_ns = int(value["sec"]), int(value["nsec"])
    if seconds >= _LONGEST_S or seconds < 0 or not (seconds or rest_ns):
        return INFINITE_NS
    return seconds * NANOSECONDS_PER_SECOND + rest_ns
