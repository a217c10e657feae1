"""Numbers of messages as vectors with names, such as the positions of the joints."""

from __future__ import annotations

from typing import Any

from teleopctl.bag.look.curves import parse_field
from teleopctl.bag.look.decoding import Decoder
from teleopctl.errors import InvalidMessageError, UsageError
from teleopctl.interfaces import field_reader

# The field that is meant where only a topic is given.
_FIELDS = {
    "sensor_msgs/msg/JointState": "position",
    "trajectory_msgs/msg/JointTrajectory": "points[-1].positions",
    "control_msgs/msg/JointTrajectoryControllerState": "reference.positions",
    "std_msgs/msg/Float64MultiArray": "data",
    "std_msgs/msg/Float32MultiArray": "data",
}
_NAMES = ("name", "joint_names")


class VectorField:
    """A topic's field or message whose value is a vector.

    Its elements are those of the first message. Where messages name them, as joints, later ones may
    have them in another order, and only some of them: the others stay as they are.

    Args:
        text: A topic, or a topic and a field of it.
        topics: The types of the bag's topics, by name.

    Attributes:
        topic: The topic.
        names: What the elements are; empty before the first message.
        newest: The vector now.

    Raises:
        NotFoundError: There is no such topic.
        UsageError: It is not known which field of it is meant, or the field is malformed.
    """

    def __init__(self, text: str, topics: dict[str, str]) -> None:
        self.topic, path = parse_field(text, list(topics))
        path = path or _FIELDS.get(topics[self.topic], "")
        if not path:
            raise UsageError(
                f"{self.topic} has the type {topics[self.topic]}: which field of it is meant?",
                hint=f"Name it, such as {self.topic}/position. Only a topic is enough for "
                f"{', '.join(_FIELDS)}.",
            )
        self.names: tuple[str, ...] = ()
        self.newest: list[float] = []
        self._read = field_reader(path)
        self._places: dict[str, int] = {}

    # Any: a message of any type.
    def take(self, message: Any) -> None:
        """Store the values of a message; one without values changes nothing.

        Raises:
            InvalidMessageError: Its vector is none, or has another length than the first.
        """
        try:
            values = [float(value) for value in self._read(message)]
        except (TypeError, ValueError) as error:
            raise InvalidMessageError(f"{self.topic}: the field is no vector") from error
        if not values:
            return
        names = _names(message, len(values))
        if not self.names:
            self.names = names or tuple(map(str, range(len(values))))
            self._places = {name: place for place, name in enumerate(names)}
            self.newest = values
            return
        if names and self._places:
            for name, value in zip(names, values, strict=True):
                if name in self._places:
                    self.newest[self._places[name]] = value
        elif len(values) == len(self.newest):
            self.newest = values
        else:
            raise InvalidMessageError(
                f"{self.topic} has {len(values)} values in place of {len(self.newest)}"
            )


def _names(message: Any, length: int) -> tuple[str, ...]:
    for field in _NAMES:
        names = getattr(message, field, None)
        if isinstance(names, list) and len(names) == length and len(set(names)) == length:
            return tuple(names)
    return ()


def types_of(decoder: Decoder) -> dict[str, str]:
    """Return the types of the topics that can be decoded."""
    return {name: topic.type_name for name, topic in decoder.topics.items()}
