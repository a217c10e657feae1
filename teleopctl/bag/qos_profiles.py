"""QoS profiles in bags, ``offered_qos_profiles``, and in files of QoS overrides.

Versions 4 to 8 of rosbag2's metadata hold the profiles as a text in which policies are the integers
of ``rmw/types.h``; version 9 holds a list in which policies are names. Both are read; version 8 is
written, since every rosbag2 since Iron reads it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from teleopctl.base import ros_yaml
from teleopctl.base.files import read_text
from teleopctl.errors import InvalidFileError, TeleopctlError
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, split
from teleopctl.node import (
    DurabilityPolicy,
    Duration,
    HistoryPolicy,
    InvalidQoSProfileException,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from teleopctl.wire import INFINITE_NS, EndpointQos

_SAFE_DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)

# Infinite durations as rosbag2 has written them: now as the largest number of nanoseconds, with
# Foxy's Fast DDS and Connext as the largest 32-bit number of seconds (and some nanoseconds).
_INFINITE_S = INFINITE_NS // NANOSECONDS_PER_SECOND
_FOXY_INFINITE_S = 2**31 - 1


def format_offered_profiles(profiles: Sequence[EndpointQos]) -> str:
    """Return QoS profiles as text for ``offered_qos_profiles``; empty text for none."""
    if not profiles:
        return ""
    listed = [
        {
            "history": int(profile.history),
            "depth": int(profile.depth),
            "reliability": int(profile.reliability),
            "durability": int(profile.durability),
            "deadline": _format_duration(profile.deadline_ns),
            "lifespan": _format_duration(profile.lifespan_ns),
            "liveliness": int(profile.liveliness),
            "liveliness_lease_duration": _format_duration(profile.lease_ns),
            "avoid_ros_namespace_conventions": False,
        }
        for profile in profiles
    ]
    text: str = yaml.dump(listed, Dumper=_SAFE_DUMPER, sort_keys=False)
    return text.rstrip("\n")


# Any: YAML values of a bag's metadata.
def parse_offered_profiles(value: Any) -> tuple[EndpointQos, ...]:
    """Return the distinct QoS profiles in ``offered_qos_profiles``: a YAML text, or a list (v9).

    Missing or unknown policies and durations get the values of the default profile.

    Raises:
        InvalidFileError: The value is no list of profiles.
    """
    if not value:
        return ()
    try:
        listed = ros_yaml.load(value) if isinstance(value, str) else value
        return tuple(dict.fromkeys(_parse_profile(item) for item in listed or ()))
    except (
        *(yaml.YAMLError, ArithmeticError, AttributeError),
        *(LookupError, TypeError, ValueError),
    ) as error:
        raise InvalidFileError(f"offered_qos_profiles is no list of profiles: {error}") from error


def _parse_profile(item: Mapping[str, Any]) -> EndpointQos:
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
    # Version 9 may write the word "infinite" instead of a number.
    if not isinstance(value, Mapping):
        return INFINITE_NS
    seconds, rest_ns = int(value["sec"]), int(value["nsec"])
    if seconds in range(_INFINITE_S) and seconds != _FOXY_INFINITE_S and (seconds or rest_ns):
        return seconds * NANOSECONDS_PER_SECOND + rest_ns
    return INFINITE_NS


_POLICIES = {
    "history": HistoryPolicy,
    "reliability": ReliabilityPolicy,
    "durability": DurabilityPolicy,
    "liveliness": LivelinessPolicy,
}
_DURATIONS = ("deadline", "lifespan", "liveliness_lease_duration")
_VALUES = ("depth", "avoid_ros_namespace_conventions")


def read_qos_overrides(file: Path) -> dict[str, QoSProfile]:
    """Read a ``--qos-profile-overrides-path`` file; return QoS profiles by topic.

    Policies have the names of the command line, such as ``best_effort``; a duration is a mapping
    of ``sec`` and ``nsec``.

    Raises:
        InvalidFileError: The file cannot be read, or contains an invalid profile.
    """
    with ros_yaml.faults_of(file):
        document = ros_yaml.load(read_text(file)) or {}
    if not isinstance(document, dict):
        raise InvalidFileError(f"{file} does not map topics to profiles")
    return {
        str(topic): _parse_override(file, str(topic), values) for topic, values in document.items()
    }


# Any, here and below: YAML values of a user's file.
def _parse_override(file: Path, topic: str, values: Any) -> QoSProfile:
    where = f"{file}: {topic}"
    if not isinstance(values, dict):
        raise InvalidFileError(f"{where} is no profile")
    try:
        return QoSProfile(**{key: _parse_policy_value(key, value) for key, value in values.items()})
    except TeleopctlError as error:
        raise InvalidFileError(f"{where}: {error.message}", hint=error.hint) from error
    except (InvalidQoSProfileException, KeyError, TypeError, ValueError) as error:
        raise InvalidFileError(f"{where}: {error}") from error


def _parse_policy_value(key: str, value: Any) -> Any:
    if key in _POLICIES:
        return _POLICIES[key].get_from_short_key(str(value))
    if key in _DURATIONS:
        if not isinstance(value, dict) or not {"sec", "nsec"} <= value.keys():
            raise ValueError(
                "Time overrides must include both seconds (sec) and nanoseconds (nsec)."
            )
        if value["sec"] < 0 or value["nsec"] < 0:
            raise ValueError("Time duration may not be a negative value.")
        return Duration(seconds=value["sec"], nanoseconds=value["nsec"])
    if key in _VALUES:
        if value < 0:
            raise ValueError(f"`{key}` may not be a negative value.")
        return value
    raise ValueError(f"Unexpected key `{key}` for QoS profile.")
