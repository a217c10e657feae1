"""View of a bag to be played over another one: times shifted, names and frames with a prefix."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import replace
from typing import Any

from teleopctl.bag.base import Bag, BagView
from teleopctl.bag.records import NO_TIME_NS, BagMessage, BagTopic
from teleopctl.bag.type_definitions import register_types
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import (
    Shape,
    deserialize,
    get_message,
    serialize,
    set_stamp,
    to_nanoseconds,
)

_TRANSFORMS = ("/tf", "/tf_static")
_TF = "tf2_msgs/msg/TFMessage"
_HEADER = "std_msgs/msg/Header"
# Transforms of this many messages show which frames are roots, those without a parent.
_LOOKED_AT = 2000

# Any: messages, whose classes are created from definitions at run time.


class OverlaidBag(BagView):
    """View of a bag that starts at the time of another one and has names of its own.

    Topics get a prefix, except for those of transforms, whose frames get it instead; frames without
    a parent, such as ``world``, stay, so that both robots stand in the same place. Stamps and
    frames are changed in transforms and in messages that start with a header; other messages stay
    as they were recorded.

    Args:
        bag: Open bag, which this view closes.
        below: Open bag at whose time this view starts.
        prefix: Prefix of topics and frames, without slashes.
    """

    def __init__(self, bag: Bag, below: Bag, prefix: str) -> None:
        super().__init__(bag)
        self._prefix = prefix
        has_messages = bag.metadata.message_count and below.metadata.message_count
        self._shift_ns = below.metadata.start_ns - bag.metadata.start_ns if has_messages else 0
        topics = [(topic._replace(name=self._named(topic)), n) for topic, n in bag.metadata.topics]
        files = tuple(
            replace(file, start_ns=file.start_ns + self._shift_ns) for file in bag.metadata.files
        )
        self.metadata = replace(bag.metadata, topics=tuple(topics), files=files)
        self._inner = {self._named(topic): topic.name for topic, _ in bag.metadata.topics}
        self._classes = _stamped_types(bag)
        self._roots = self._find_roots()
        # Stamps may be of another clock than the times of receipt: that of a simulation.
        self._stamp_shift_ns = self._shift_ns + _stamp_lead_ns(below) - _stamp_lead_ns(bag)

    def _named(self, topic: BagTopic) -> str:
        is_tf = topic.name in _TRANSFORMS and topic.type_name == _TF
        return topic.name if is_tf else f"/{self._prefix}{topic.name}"

    def _find_roots(self) -> frozenset[str]:
        parents, children = set(), set()
        names = [name for name in _TRANSFORMS if name in self._classes]
        for message in itertools.islice(self._bag.messages(names), _LOOKED_AT) if names else ():
            for one in deserialize(message.data, self._classes[message.topic]).transforms:
                parents.add(one.header.frame_id.lstrip("/"))
                children.add(one.child_frame_id.lstrip("/"))
        return frozenset(parents - children)

    def _frame(self, name: str) -> str:
        plain = name.lstrip("/")
        return plain if not plain or plain in self._roots else f"{self._prefix}/{plain}"

    def _changed(self, message: BagMessage) -> BagMessage:
        data, name = message.data, message.topic
        message_class = self._classes.get(name)
        if message_class is not None:
            decoded = deserialize(data, message_class)
            for one in _stamped_parts(decoded):
                stamp_ns = to_nanoseconds(one.header.stamp)
                # A stamp of 0 has a meaning of its own: none.
                if stamp_ns:
                    set_stamp(one.header.stamp, max(0, stamp_ns + self._stamp_shift_ns))
                one.header.frame_id = self._frame(one.header.frame_id)
                if hasattr(one, "child_frame_id"):
                    one.child_frame_id = self._frame(one.child_frame_id)
            data = bytes(serialize(decoded))
        is_tf = name in _TRANSFORMS and name in self._classes
        return message._replace(
            topic=name if is_tf else f"/{self._prefix}{name}",
            log_time_ns=message.log_time_ns + self._shift_ns,
            publish_time_ns=message.publish_time_ns + self._shift_ns,
            data=data,
        )

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int = 0,
        end_ns: int = NO_TIME_NS,
        on_left_out: Callable[[str], object] | None = None,
    ) -> Iterator[BagMessage]:
        """Yield messages by shifted log time; report broken parts, or raise."""
        wanted = None
        if topics is not None:
            wanted = [self._inner[name] for name in topics if name in self._inner]
        last_ns = end_ns if end_ns == NO_TIME_NS else end_ns - self._shift_ns
        first_ns = max(0, start_ns - self._shift_ns)
        return map(self._changed, self._bag.messages(wanted, first_ns, last_ns, on_left_out))

    def latest(self, topic: str, end_ns: int, most: int = 1) -> list[BagMessage]:
        """Return up to `most` last messages of a topic before a shifted log time, oldest first."""
        if topic not in self._inner:
            return []
        last_ns = end_ns if end_ns == NO_TIME_NS else end_ns - self._shift_ns
        return [*map(self._changed, self._bag.latest(self._inner[topic], last_ns, most))]


def _stamped_types(bag: Bag) -> dict[str, Any]:
    """Return the message classes of the topics whose messages have stamps and frames to change."""
    found = {}
    for topic, _ in bag.metadata.topics:
        try:
            register_types(topic)
            message_class = get_message(topic.type_name)
        except TeleopctlError:
            continue
        fields = message_class.__definition__.fields
        first = fields[0].type if fields else None
        has_header = first and first.shape is Shape.SINGLE and str(first.base) == _HEADER
        if has_header or (topic.type_name == _TF and topic.name in _TRANSFORMS):
            found[topic.name] = message_class
    return found


def _stamped_parts(message: Any) -> Iterable[Any]:
    """Return the parts of a message that have a header: itself, or its transforms."""
    parts: Iterable[Any] = (message,) if hasattr(message, "header") else message.transforms
    return parts


def _stamp_lead_ns(bag: Bag) -> int:
    """Return how far the stamps of a bag are ahead of its times of receipt, in nanoseconds."""
    classes = _stamped_types(bag)
    for message in itertools.islice(bag.messages(list(classes)), _LOOKED_AT) if classes else ():
        for part in _stamped_parts(deserialize(message.data, classes[message.topic])):
            stamp_ns = to_nanoseconds(part.header.stamp)
            if stamp_ns:
                return stamp_ns - message.log_time_ns
    return 0
