"""Comparison of the messages of a replayed run with the recorded ones, field by field."""

from __future__ import annotations

import itertools
import math
import struct
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, NamedTuple, TypeAlias

from teleopctl.bag.export.plots import Curve
from teleopctl.errors import InvalidFileError, InvalidMessageError
from teleopctl.interfaces import Message, deserialize, get_message, to_seconds

Value: TypeAlias = float | int | bool | str | None
"""Value of a message field; None if the field does not exist."""

MOST_LISTED = 20
"""Number of differences of a topic that are stored; further ones are only counted."""

# Fields that name the elements of a message; element paths use these names instead of indices.
_NAMES = ("name", "joint_names", "child_frame_id", "ns")
# Largest difference between the ends of topics: a recorder unsubscribes from one after the other.
_LONGEST_END_NS = 1_000_000_000


class DifferenceKind(StrEnum):
    """Kind of a `Difference`: field value, missing in recording, extra in recording, time order."""

    VALUE = "value"
    MISSING = "missing"
    EXTRA = "extra"
    ORDER = "order"


class Difference(NamedTuple):
    """Difference between a recorded message and the replayed one of the same simulated time.

    Attributes:
        topic: Name of the topic.
        time_ns: Simulated time of the message, in nanoseconds.
        field: Path of the field, such as ``position[joint_4]``; empty for the whole message.
        recorded: Value in the bag; None if the field is missing there.
        replayed: Value in the replay; None if the field is missing there.
        kind: Kind of the difference.
    """

    topic: str
    time_ns: int
    field: str = ""
    recorded: Value = None
    replayed: Value = None
    kind: DifferenceKind = DifferenceKind.VALUE

    @property
    def size(self) -> float:
        """Absolute difference of recorded and replayed number; infinite for other values."""
        if not (_is_number(self.recorded) and _is_number(self.replayed)):
            return math.inf
        distance = abs(float(self.recorded or 0) - float(self.replayed or 0))
        return math.inf if math.isnan(distance) else distance

    def __str__(self) -> str:
        """Return the difference as a line of text."""
        where = f"{self.topic} {to_seconds(self.time_ns):.3f} s"
        match self.kind:
            case DifferenceKind.MISSING:
                return f"{where}: the recording lacks the message"
            case DifferenceKind.EXTRA:
                return f"{where}: the recording has a message that the run does not publish"
            case DifferenceKind.ORDER:
                return f"{where}: recorded after a message of a later time"
        apart = f" ({self.size:.3g} apart)" if math.isfinite(self.size) else ""
        return f"{where}: {self.field} was {self.recorded!r} and is {self.replayed!r}{apart}"


class RecordedMessage(NamedTuple):
    """Recorded message with its simulated time.

    Attributes:
        time_ns: Stamp of the message, in nanoseconds of simulated time.
        data: CDR bytes.
        sequence: Number that the recorder gave to the message, see `BagMessage`.
        log_time_ns: Time of receipt, in nanoseconds since the epoch.
        publish_time_ns: Time of publication, in nanoseconds since the epoch.
    """

    time_ns: int
    data: bytes
    sequence: int = 0
    log_time_ns: int = 0
    publish_time_ns: int = 0


@dataclass
class ComparedStream:
    """Comparison of one publisher's recorded and replayed messages by simulated time.

    Attributes:
        topic: Name of the topic.
        type_name: Type of the messages.
        recorded: Recorded messages, in the order of recording.
        publisher: Name of the publisher if the topic has several; else empty.
        tolerance: Largest difference of two numbers that counts as equal.
        may_skip: Whether the publisher may skip messages for reasons that the bag does not show,
            such as an inactive controller.
        numbers: Sequence numbers of the topic's messages of all publishers; empty if the recorder
            did not number them.
        may_repeat: Whether the publisher publishes several messages of one time: the same one for
            each new subscriber while the simulation is paused, and another one after a change.
        compared: Number of compared messages.
        skipped_ns: Simulated times of messages that the publisher skipped, as the sequence numbers
            show, in nanoseconds.
        differences: First differences, at most `MOST_LISTED`.
        difference_count: Number of all differences.
        largest: Largest difference of each field that differs.
    """

    topic: str
    type_name: str
    recorded: Sequence[RecordedMessage]
    publisher: str = ""
    tolerance: float = 0.0
    may_skip: bool = False
    numbers: frozenset[int] = frozenset()
    may_repeat: bool = False
    compared: int = 0
    skipped_ns: list[int] = field(default_factory=list)
    differences: list[Difference] = field(default_factory=list)
    difference_count: int = 0
    largest: dict[str, Difference] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Index the recorded messages by time; add a difference for repeated or unordered ones."""
        # Several of a time, in their order: published while the simulation was paused.
        self._left: dict[int, list[RecordedMessage]] = {}
        latest_ns = -1
        for message in self.recorded:
            if others := self._left.get(message.time_ns):
                if self.may_repeat and _is_published_again(others[-1], message):
                    continue
                if not self.may_repeat or others[-1].sequence == message.sequence:
                    self.add(Difference(self.topic, message.time_ns, kind=DifferenceKind.EXTRA))
                    continue
            if message.time_ns < latest_ns:
                self.add(Difference(self.topic, message.time_ns, kind=DifferenceKind.ORDER))
            self._left.setdefault(message.time_ns, []).append(message)
            latest_ns = max(latest_ns, message.time_ns)
        times_ns = sorted(self._left)
        self.begin_ns, self.end_ns = (times_ns[0], times_ns[-1]) if times_ns else (0, -1)
        self._later = dict(itertools.pairwise(times_ns))
        self._by_time = {time_ns: each[0] for time_ns, each in self._left.items()}
        self._after_ns: int | None = None
        self._type = get_message(self.type_name)

    @property
    def name(self) -> str:
        """Topic of the stream, with the publisher's name if the topic has several."""
        return f"{self.topic} of {self.publisher}" if self.publisher else self.topic

    @property
    def is_same(self) -> bool:
        """Whether the stream has no differences."""
        return not self.difference_count

    def at(self, time_ns: int) -> RecordedMessage | None:
        """Return the recorded message of a simulated time; None if none or already compared."""
        return next(iter(self._left.get(time_ns, ())), None)

    def take(self, time_ns: int, data: bytes) -> RecordedMessage | None:
        """Compare a replayed message with the recorded one of its time; return that one or None.

        Messages before the first recorded one are ignored, since the recorder or the publisher
        started later. The first message after the last recorded one is handled by `close`.
        """
        left = self._left.get(time_ns)
        recorded = left.pop(0) if left else None
        if recorded is not None:
            self.compared += 1
            self.compare(time_ns, recorded.data, data)
        elif self.begin_ns < time_ns < self.end_ns and time_ns not in self._by_time:
            self.add_missing(time_ns)
        elif time_ns > self.end_ns and self._after_ns is None:
            self._after_ns = time_ns
        return recorded

    def add_missing(self, time_ns: int) -> None:
        """Count a replayed message that the bag lacks: skipped if plausible, else a difference."""
        if self.may_skip and self._is_whole_around(time_ns):
            self.skipped_ns.append(time_ns)
        else:
            self.add(Difference(self.topic, time_ns, kind=DifferenceKind.MISSING))

    def compare(self, time_ns: int, recorded: bytes, replayed: bytes) -> None:
        """Compare two messages' CDR bytes; add a difference for each field beyond the tolerance."""
        if recorded == replayed:
            return
        try:
            before = deserialize(recorded, self._type)
        except InvalidMessageError as error:
            raise InvalidFileError(
                f"{self.topic}, {to_seconds(time_ns):.3f} s: {error.message}"
            ) from error
        for found in differences(self.topic, time_ns, before, deserialize(replayed, self._type)):
            # Without a tolerance all bits are compared, and 0.0 differs from -0.0.
            if not (self.tolerance and found.size <= self.tolerance):
                self.add(found)

    def add(self, difference: Difference) -> None:
        """Count a difference; store it if among the first, or the largest of its field."""
        self.difference_count += 1
        if len(self.differences) < MOST_LISTED:
            self.differences.append(difference)
        largest = self.largest.get(difference.field)
        if difference.kind is DifferenceKind.VALUE and (
            largest is None or difference.size > largest.size
        ):
            self.largest[difference.field] = difference

    def close(self, reference: ComparedStream | None = None) -> None:
        """Finish the comparison: add differences for recorded messages that were not replayed.

        Args:
            reference: Stream that ends at the same time as this one, or None.
        """
        for time_ns, left in self._left.items():
            for _ in left:
                self.add(Difference(self.topic, time_ns, kind=DifferenceKind.EXTRA))
        self._left.clear()
        if self._after_ns is None:
            return
        if not self.recorded:
            if not self.may_skip:
                self.add(Difference(self.topic, self._after_ns, kind=DifferenceKind.MISSING))
            return
        if reference is None:
            return
        later = [m.log_time_ns for m in reference.recorded if m.time_ns > self._after_ns]
        if later and max(later) - min(later) > _LONGEST_END_NS:
            self.add(Difference(self.topic, self._after_ns, kind=DifferenceKind.MISSING))

    def _is_whole_around(self, time_ns: int) -> bool:
        """Return whether the recorder lost no message around a time, by its sequence numbers."""
        before_ns = max(each for each in self._by_time if each < time_ns)
        first = self._by_time[before_ns].sequence
        last = self._by_time[self._later[before_ns]].sequence
        return 0 < first < last and all(each in self.numbers for each in range(first, last))


class ReplayComparison:
    """Result of comparing a whole recorded run with its replay.

    Args:
        tolerance: Largest difference of two numbers that counts as equal; 0 requires equal bits.

    Attributes:
        tolerance: Largest difference of two numbers that counts as equal.
        streams: Compared streams.
        played_back: Number of messages sent to the replay, by topic.
        not_compared: Reason for each topic of the bag or replay that was not compared, by name.
    """

    def __init__(self, tolerance: float = 0.0) -> None:
        self.tolerance = tolerance
        self.streams: list[ComparedStream] = []
        self.played_back: dict[str, int] = {}
        self.not_compared: dict[str, str] = {}

    @property
    def is_same(self) -> bool:
        """Whether no stream has differences."""
        return all(stream.is_same for stream in self.streams)

    @property
    def messages(self) -> int:
        """Number of compared messages in all streams."""
        return sum(stream.compared for stream in self.streams)

    @property
    def end_ns(self) -> int:
        """Latest recorded simulated time in ns among streams with compared messages; 0 if none."""
        return max((stream.end_ns for stream in self.streams if stream.compared), default=0)

    @property
    def first_differences(self) -> list[Difference]:
        """Differences at the earliest simulated time that has any; empty if there are none."""
        listed = [each for stream in self.streams for each in stream.differences]
        first_ns = min((each.time_ns for each in listed), default=0)
        return [each for each in listed if each.time_ns == first_ns]

    @property
    def largest_differences(self) -> list[Difference]:
        """Largest difference of each message field that differs, of all streams."""
        return [each for stream in self.streams for each in stream.largest.values()]


def _is_published_again(earlier: RecordedMessage, later: RecordedMessage) -> bool:
    """Return whether a publisher sent a message twice, as for a new subscriber while paused.

    The recorder numbers both; one that a bag holds twice has the same number.
    """
    return 0 < earlier.sequence < later.sequence and earlier.data == later.data


def differences(
    topic: str, time_ns: int, recorded: Message, replayed: Message
) -> Iterator[Difference]:
    """Yield a `Difference` for each field of two messages that differs in any bit."""
    before, now = dict(flatten_fields(recorded)), dict(flatten_fields(replayed))
    for path in dict.fromkeys([*before, *now]):
        was, is_now = before.get(path), now.get(path)
        if not _same(was, is_now):
            yield Difference(topic, time_ns, path, was, is_now)


# Any: a message or a field of any type.
def flatten_fields(value: Any, path: str = "") -> Iterator[tuple[str, Value]]:
    """Yield path and value of each primitive field of a message, including nested ones."""
    if isinstance(value, Message):
        names = _part_names(value)
        for field_ in type(value).get_fields_and_field_types():
            inner = getattr(value, field_)
            below = f"{path}.{field_}" if path else field_
            if _is_sequence(inner):
                yield from _elements(inner, below, names)
            else:
                yield from flatten_fields(inner, below)
    elif isinstance(value, bytes | bytearray):
        yield path, bytes(value).hex()
    else:
        yield path, value.item() if hasattr(value, "item") else value


def _elements(
    values: Sequence[Any], path: str, names: Sequence[str]
) -> Iterator[tuple[str, Value]]:
    labels: Iterable[object] = range(len(values))
    if len(values) == len(names) == len(set(names)) and list(values) != names:
        labels = names
    elif len(values) and isinstance(values[0], Message):
        own = [str(getattr(each, _name_field(each), "")) for each in values]
        if all(own) and len(set(own)) == len(own):
            labels = own
    for label, each in zip(labels, values, strict=True):
        yield from flatten_fields(each, f"{path}[{label}]")


def _part_names(message: Message) -> Sequence[str]:
    """Return a message's names of its sequence elements, as JointState has them."""
    for field_ in _NAMES:
        # Any: the value of a field of any type.
        names: Any = getattr(message, field_, None)
        if _is_sequence(names) and all(isinstance(name, str) for name in names):
            return list(names)
    return ()


def _name_field(message: Message) -> str:
    return next((each for each in _NAMES if isinstance(getattr(message, each, None), str)), "")


def _is_sequence(value: object) -> bool:
    return hasattr(value, "__len__") and not isinstance(value, str | bytes | bytearray | Mapping)


def _is_number(value: Value) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _same(one: Value, other: Value) -> bool:
    """Return whether two values have the same bits; 0.0 and -0.0 have not."""
    if isinstance(one, float) and isinstance(other, float):
        return struct.pack("<d", one) == struct.pack("<d", other)
    return type(one) is type(other) and one == other


class ComparedTraces:
    """Store of pairs of recorded and replayed messages, for plots of their fields."""

    def __init__(self) -> None:
        self._types: dict[str, str] = {}
        self._pairs: dict[str, list[tuple[int, bytes, bytes]]] = defaultdict(list)

    def add(
        self, topic: str, type_name: str, time_ns: int, recorded: bytes, replayed: bytes
    ) -> None:
        """Store the CDR bytes of a recorded and a replayed message of the same time."""
        self._types[topic] = type_name
        self._pairs[topic].append((time_ns, recorded, replayed))

    def curves(self, difference: Difference) -> list[Curve]:
        """Return two curves, recorded and replayed, of the field that a difference names.

        A curve has gaps where the field is no number.
        """
        name = f"{difference.topic} {difference.field}"
        message_class = get_message(self._types[difference.topic])
        curves = []
        pairs = self._pairs[difference.topic]
        for title, messages in (
            (f"{name}, recorded", [recorded for _, recorded, _ in pairs]),
            (f"{name}, now", [now for _, _, now in pairs]),
        ):
            values = [
                dict(flatten_fields(deserialize(data, message_class))).get(difference.field)
                for data in messages
            ]
            curves.append(
                Curve(
                    title,
                    [to_seconds(pair[0]) for pair in pairs],
                    [float(v) if isinstance(v, int | float) else math.nan for v in values],
                )
            )
        return curves
