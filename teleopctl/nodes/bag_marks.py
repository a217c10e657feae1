"""Marks on a bag's time line: warnings of the log, contacts, episodes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.bag import open_bag, register_types
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import deserialize, get_message

if TYPE_CHECKING:
    from pathlib import Path

    from teleopctl.bag import BagTopic

MOST_MARKS = 500
"""Largest number of marks of a bag; the first ones of each kind are kept."""

_WARN = 30
_ERROR = 40
_LONGEST_TEXT = 200
_STATUS = "diagnostic_msgs/msg/DiagnosticStatus"

# Any: messages, whose classes are created from definitions at run time.


class BagMark(NamedTuple):
    """Mark on the time line of a bag.

    Attributes:
        time_ns: Log time, in nanoseconds since the epoch.
        kind: ``warning``, ``error``, ``contact`` or ``episode``.
        text: What happened, in one line.
    """

    time_ns: int
    kind: str
    text: str


def bag_marks(path: Path) -> list[BagMark]:
    """Read the marks of a bag, in the order of their times.

    Args:
        path: Path of the bag.

    Raises:
        TeleopctlError: The bag cannot be read.
    """
    with open_bag(path) as bag:
        finders = dict(_finders(topic for topic, count in bag.metadata.topics if count))
        if not finders:
            return []
        classes = {}
        for topic, _ in bag.metadata.topics:
            if topic.name in finders:
                register_types(topic)
                classes[topic.name] = get_message(topic.type_name)
        found: list[BagMark] = []
        for message in bag.messages(list(finders), on_left_out=lambda _text: None):
            try:
                decoded = deserialize(message.data, classes[message.topic])
            except TeleopctlError:
                continue
            mark = finders[message.topic](decoded)
            if mark is not None:
                found.append(BagMark(message.log_time_ns, mark[0], mark[1][:_LONGEST_TEXT]))
    kept: list[BagMark] = []
    for kind in ("episode", "error", "warning", "contact"):
        kept += [mark for mark in found if mark.kind == kind][: MOST_MARKS - len(kept)]
    return sorted(kept)


_Finder = Callable[[Any], tuple[str, str] | None]


def _finders(topics: Iterator[BagTopic]) -> Iterator[tuple[str, _Finder]]:
    """Yield for each topic with marks the function that finds one in a message."""
    for topic in topics:
        if topic.type_name == "rcl_interfaces/msg/Log":
            yield topic.name, _of_log
        elif topic.type_name.rpartition("/")[2] in ("Contacts", "ContactsState"):
            yield topic.name, _Contacts()
        elif topic.type_name == _STATUS and topic.name.endswith("episode_recorder/state"):
            yield topic.name, _Episodes()


def _of_log(message: Any) -> tuple[str, str] | None:
    if message.level < _WARN:
        return None
    kind = "error" if message.level >= _ERROR else "warning"
    return kind, f"{message.name}: {message.msg}"


class _Contacts:
    """Finder of the moments at which two bodies begin to touch."""

    def __init__(self) -> None:
        self._touching: set[tuple[str, str]] = set()

    def __call__(self, message: Any) -> tuple[str, str] | None:
        contacts = message.contacts if hasattr(message, "contacts") else message.states
        pairs = set(map(_pair_of, contacts))
        new, self._touching = pairs - self._touching, pairs
        return ("contact", ", ".join(" and ".join(pair) for pair in sorted(new))) if new else None


def _pair_of(contact: Any) -> tuple[str, str]:
    names = [getattr(contact, f"collision{number}", None) for number in (1, 2)]
    if names[0] is None:
        names = [contact.collision1_name, contact.collision2_name]
    first, second = sorted(str(getattr(name, "name", name)) for name in names)
    return first, second


class _Episodes:
    """Finder of the starts and ends of episodes in the states of an episode recorder."""

    def __init__(self) -> None:
        self._last = ""

    def __call__(self, message: Any) -> tuple[str, str] | None:
        values = {one.key: one.value for one in message.values}
        text = f"{message.message} {values.get('episode', '')}".strip()
        is_new, self._last = text != self._last, text
        return ("episode", text) if is_new else None
