"""Files that say with which quality of service topics are recorded or played."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from teleopctl.base import ros_yaml
from teleopctl.base.files import read_text
from teleopctl.errors import InvalidFileError, TeleopctlError
from teleopctl.node import (
    DurabilityPolicy,
    Duration,
    HistoryPolicy,
    InvalidQoSProfileException,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)

_POLICIES = {
    "history": HistoryPolicy,
    "reliability": ReliabilityPolicy,
    "durability": DurabilityPolicy,
    "liveliness": LivelinessPolicy,
}
_DURATIONS = ("deadline", "lifespan", "liveliness_lease_duration")
_VALUES = ("depth", "avoid_ros_namespace_conventions")


def read_qos_overrides(file: Path) -> dict[str, QoSProfile]:
    """Read the file of ``--qos-profile-overrides-path``: QoS profiles by topic.

    Policies have the names of the command line, such as ``best_effort``; a duration is a mapping
    of ``sec`` and ``nsec``.

    Raises:
        InvalidFileError: It cannot be read, or says something that is no profile.
    """
    with ros_yaml.faults_of(file):
        document = ros_yaml.load(read_text(file)) or {}
    if not isinstance(document, dict):
        raise InvalidFileError(f"{file} does not map topics to profiles")
    return {str(topic): _profile(file, str(topic), values) for topic, values in document.items()}


# Any, here and below: YAML's values, from a file that nobody here wrote.
def _profile(file: Path, topic: str, values: Any) -> QoSProfile:
    where = f"{file}: {topic}"
    if not isinstance(values, dict):
        raise InvalidFileError(f"{where} is no profile")
    try:
        return QoSProfile(**{key: _value(key, value) for key, value in values.items()})
    except TeleopctlError as error:
        raise InvalidFileError(f"{where}: {error.message}", hint=error.hint) from error
    except (InvalidQoSProfileException, KeyError, TypeError, ValueError) as error:
        raise InvalidFileError(f"{where}: {error}") from error


def _value(key: str, value: Any) -> Any:
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
