"""Zenoh key expressions of topics and services.

A topic or service has the key ``<domain>/<name>/<dds type>/<type hash>``; the slashes inside its
name are Zenoh levels. Two endpoints exchange data only if their whole keys are equal, including the
hash.
"""

from __future__ import annotations

from teleopctl.base.typed import NamedTuple
from teleopctl.interfaces import from_dds, to_dds

ANY_HASH = "*"
"""Wildcard for a type hash: matches every version of a type, including that of ROS 2 Humble."""

LIVELINESS_PREFIX = "@ros2_lv"

_ASSERTIONS = "@alive"
_BUFFER_KEY = "_buf"
_CPU_BUFFER_KEY = "_buf_cpu"


class TopicKey(NamedTuple):
    """Parsed key of a topic or service: domain, name, type and type hash."""

    domain: int
    name: str
    type_name: str
    type_hash: str


def topic_key(domain: int, name: str, type_name: str, type_hash: str) -> str:
    """Return the Zenoh key of a topic or service.

    Args:
        domain: ROS domain.
        name: Fully qualified name, ``/robot1/chatter``.
        type_name: ROS name of the type, ``std_msgs/msg/String``; for a service that of the service.
        type_hash: ``RIHS01_…``, or `ANY_HASH` to subscribe to every version of the type.
    """
    # Only one slash at either end is removed, as in rmw_zenoh.
    name = name.removeprefix("/").removesuffix("/")
    return f"{domain}/{name}/{to_dds(type_name)}/{type_hash}"


def assertion_key(key: str) -> str:
    """Return the Zenoh key on which a topic's publishers assert MANUAL_BY_TOPIC liveliness.

    Specific to teleopctl: other implementations have no such key.
    """
    # A verbatim chunk, so that no subscription to the topic with a wildcard matches it.
    return f"{key}/{_ASSERTIONS}"


def parse_topic_key(text: str) -> TopicKey | None:
    """Parse the Zenoh key of a topic or service; return None for other keys.

    The extra levels on which ROS 2 Lyrical sends messages to buffer-aware subscribers are dropped.
    """
    chunks = text.split("/")
    if chunks[-1] == _CPU_BUFFER_KEY:
        del chunks[-1]
    elif len(chunks) > 1 and chunks[-2] == _BUFFER_KEY:
        del chunks[-2:]
    if len(chunks) < 4 or not all(chunks):
        return None
    domain = parse_decimal(chunks[0])
    if domain is None:
        return None
    return TopicKey(domain, "/" + "/".join(chunks[1:-2]), from_dds(chunks[-2]), chunks[-1])


def liveliness_key(domain: int, zid: str | None = None) -> str:
    """Return the key expression of all liveliness tokens of a domain, or of one session in it."""
    # The domain is spelled out because a wildcard does not match the verbatim prefix.
    return f"{LIVELINESS_PREFIX}/{domain}/{'' if zid is None else f'{zid}/'}**"


def parse_decimal(text: str) -> int | None:
    """Parse a decimal number of at most 20 digits; return None for other texts."""
    # int() would also take signs, blanks, underscores and the digits of every script.
    if 0 < len(text) <= 20 and text.isascii() and text.isdigit():
        return int(text)
    return None
