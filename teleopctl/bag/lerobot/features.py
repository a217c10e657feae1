"""Features of an episode: which fields of a bag's topics they are, and their newest values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt
from lxml import etree

from teleopctl.bag.base import Bag
from teleopctl.bag.export.decoding import PICTURES, Decoder
from teleopctl.bag.export.plots import parse_field
from teleopctl.bag.verify.session import DESCRIPTION_TOPIC, read_parameters
from teleopctl.errors import InvalidMessageError, NotFoundError, UsageError
from teleopctl.interfaces import deserialize, field_reader, get_message
from teleopctl.pictures import (
    DEPTH_ENCODINGS,
    GreyScaling,
    PictureError,
    camera_topics,
    depths_of,
    image_of,
)

Pixels: TypeAlias = npt.NDArray[np.uint8] | npt.NDArray[np.float32]
"""Image of a camera: RGB, shape (height, width, 3), or depths in metres, (height, width)."""

STATE_FEATURE, ACTION, HAND, STAMPS = "observation.state", "action", "hand", "stamps"
"""Names of the features that are no pictures; STATE_FEATURE and ACTION are LeRobot's."""

CAMERA_PREFIX = "observation.images."
"""LeRobot's prefix of the features that are pictures."""

# Default field of a topic by its type, used if only a topic is given.
_FIELDS = {
    "sensor_msgs/msg/JointState": "position",
    "trajectory_msgs/msg/JointTrajectory": "points[-1].positions",
    "control_msgs/msg/JointTrajectoryControllerState": "reference.positions",
    "std_msgs/msg/Float64MultiArray": "data",
    "std_msgs/msg/Float32MultiArray": "data",
}
_NAMES = ("name", "joint_names")
# LeRobot's suffix of a joint's name, by the last part of the field.
_SUFFIXES = {
    "position": ".pos",
    "positions": ".pos",
    "velocity": ".vel",
    "velocities": ".vel",
    "effort": ".effort",
}
_UNITS = {".pos": ("rad", "m"), ".vel": ("rad/s", "m/s"), ".effort": ("N m", "N")}

_ARRAY = "std_msgs/msg/Float64MultiArray"
_STATE_OF_CONTROLLER = "control_msgs/msg/JointTrajectoryControllerState"
_TWIST = "geometry_msgs/msg/TwistStamped"
# Time in ns after which servo takes no further motion from a twist: its incoming_command_timeout.
_TWIST_VALID_NS = 100_000_000


class Vector(Protocol):
    """Interface of a feature that is a vector of numbers."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the elements; empty before the first message."""

    @property
    def topics(self) -> tuple[str, ...]:
        """Names of the topics that the values come from."""

    @property
    def time_ns(self) -> int:
        """Time of the oldest of the newest messages, in nanoseconds."""

    # Any: a message of any type.
    def update(self, topic: str, message: Any, time_ns: int) -> None:
        """Take the values of a message of one of the topics.

        Raises:
            InvalidMessageError: The message does not have such values.
        """

    def values_at(self, time_ns: int) -> list[float]:
        """Return the values at a time, which is not before the newest message."""

    def missing(self) -> list[str]:
        """Return the topics without which there are no values yet."""


class VectorField:
    """Array field of a topic, such as joint positions, with its newest values.

    The first message defines the elements. If messages name their elements, such as joints, later
    messages may have other orders or fewer elements: missing elements keep their values.

    Args:
        text: Name of a topic, or topic and field.
        topics: Types of the bag's topics, by topic name.
        joints: Names of the elements, for messages without names.

    Attributes:
        names: Names of the elements with LeRobot's suffix, such as ``joint_1.pos``.
        topics: Name of the topic.
        time_ns: Time of the newest message.

    Raises:
        NotFoundError: The topic does not exist.
        UsageError: The type has no default field, or the field path is malformed.
    """

    def __init__(self, text: str, topics: Mapping[str, str], joints: Sequence[str] = ()) -> None:
        topic, path = parse_field(text, list(topics))
        path = path or _FIELDS.get(topics[topic], "")
        if not path:
            raise UsageError(
                f"{topic} has the type {topics[topic]}: name one of its fields",
                hint=f"Name it, such as {topic}/position. Only a topic is enough for "
                f"{', '.join(_FIELDS)}.",
            )
        self.topics: tuple[str, ...] = (topic,)
        self.names: tuple[str, ...] = ()
        self.time_ns = 0
        self._newest: list[float] = []
        self._read = field_reader(path)
        self._suffix = _SUFFIXES.get(path.rpartition(".")[2], "")
        self._joints = tuple(joints)
        self._places: dict[str, int] = {}

    # Any: a message of any type.
    def update(self, topic: str, message: Any, time_ns: int) -> None:
        """Take a message's values, by element name if named; ignore empty arrays.

        Raises:
            InvalidMessageError: The field is no vector, or its length differs from the first one.
        """
        try:
            values = [float(value) for value in self._read(message)]
        except (TypeError, ValueError) as error:
            raise InvalidMessageError(f"{topic}: the field is not a vector") from error
        if not values:
            return
        names = _names(message, len(values))
        if not self.names:
            known = self._joints if len(self._joints) == len(values) else ()
            suffix = self._suffix or (".pos" if known else "")
            self.names = tuple(f"{name}{suffix}" for name in names or known) or tuple(
                map(str, range(len(values)))
            )
            self._places = {name: place for place, name in enumerate(names)}
            self._newest = values
        elif names and self._places:
            for name, value in zip(names, values, strict=True):
                if name in self._places:
                    self._newest[self._places[name]] = value
        elif len(values) == len(self._newest):
            self._newest = values
        else:
            raise InvalidMessageError(
                f"{topic} has {len(values)} values in place of {len(self._newest)}"
            )
        self.time_ns = time_ns

    def values_at(self, time_ns: int) -> list[float]:
        """Return the newest values."""
        del time_ns
        return list(self._newest)

    def missing(self) -> list[str]:
        """Return the topic before its first values, else nothing."""
        return [] if self.names else list(self.topics)


class JoinedFields:
    """Fields of several topics as one vector, such as the references of two controllers.

    Args:
        fields: Fields in their order.

    Attributes:
        topics: Names of the topics.
    """

    def __init__(self, fields: Sequence[VectorField]) -> None:
        self._fields = fields
        self.topics = tuple(topic for field in fields for topic in field.topics)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the elements; empty before each topic has had a message."""
        return () if self.missing() else tuple(name for one in self._fields for name in one.names)

    @property
    def time_ns(self) -> int:
        """Time of the oldest of the newest messages."""
        return min(one.time_ns for one in self._fields)

    # Any: a message of any type.
    def update(self, topic: str, message: Any, time_ns: int) -> None:
        """Take a message's values.

        Raises:
            InvalidMessageError: A field is no vector, or its length differs from the first one.
        """
        for one in self._fields:
            if topic in one.topics:
                one.update(topic, message, time_ns)

    def values_at(self, time_ns: int) -> list[float]:
        """Return the newest values of all fields."""
        return [value for one in self._fields for value in one.values_at(time_ns)]

    def missing(self) -> list[str]:
        """Return the topics without values."""
        return [topic for one in self._fields for topic in one.missing()]


class HandTwist:
    """Twist commanded by an operator: zeros before the first message and after the last one.

    Args:
        topic: Topic of type ``geometry_msgs/msg/TwistStamped``.

    Attributes:
        names: ``linear.x`` to ``angular.z``.
        topics: Name of the topic.
        time_ns: Time of the newest message.
    """

    names = tuple(f"{part}.{axis}" for part in ("linear", "angular") for axis in "xyz")

    def __init__(self, topic: str) -> None:
        self.topics: tuple[str, ...] = (topic,)
        self.time_ns = 0
        self._newest = [0.0] * 6

    # Any: a message of any type.
    def update(self, topic: str, message: Any, time_ns: int) -> None:
        """Take the six numbers of a twist.

        Raises:
            InvalidMessageError: The message is no TwistStamped.
        """
        try:
            twist = message.twist
            self._newest = [
                float(getattr(part, axis))
                for part in (twist.linear, twist.angular)
                for axis in "xyz"
            ]
        except AttributeError as error:
            raise InvalidMessageError(f"{topic} has no twists") from error
        self.time_ns = time_ns

    def values_at(self, time_ns: int) -> list[float]:
        """Return the newest twist, or zeros if it is too old to move a robot."""
        is_valid = time_ns - self.time_ns <= _TWIST_VALID_NS
        return list(self._newest) if is_valid else [0.0] * 6

    def missing(self) -> list[str]:
        """Return nothing: without messages the twist is zero."""
        return []


class Camera:
    """Image topic with its newest image.

    Args:
        key: Name of the feature.
        topic: Name of the topic.
        is_depth: Whether the images are depths.

    Attributes:
        newest: Newest image, RGB of shape (height, width, 3), or depths in metres of shape (height,
            width); None before the first one.
        time_ns: Time of the newest image.
    """

    def __init__(self, key: str, topic: str, *, is_depth: bool = False) -> None:
        self.key = key
        self.topic = topic
        self.is_depth = is_depth
        self.newest: Pixels | None = None
        self.time_ns = 0
        self._scaling = GreyScaling()

    # Any: an image message.
    def update(self, message: Any, time_ns: int) -> None:
        """Set the newest image from an image message.

        Raises:
            PictureError: The message has no image, or one of another size than the first.
        """
        pixels: Pixels
        if self.is_depth:
            pixels = depths_of(message)
            if pixels.shape[0] < getattr(message, "height", 0):
                raise PictureError(f"Only {len(pixels)} of {message.height} rows have arrived")
        else:
            pixels = np.asarray(image_of(message, self._scaling).convert("RGB"))
        if self.newest is not None and pixels.shape != self.newest.shape:
            raise PictureError(f"{pixels.shape[:2]} is not {self.newest.shape[:2]}")
        self.newest, self.time_ns = pixels, time_ns


def decodable_types(decoder: Decoder) -> dict[str, str]:
    """Return the message type of each topic that a decoder can decode, by topic name."""
    return {name: topic.type_name for name, topic in decoder.topics.items()}


def find_actions(bag: Bag) -> list[str]:
    """Return the topics of a bag with the commands or references of the robot's controllers.

    These are the references of trajectory controllers, and the commands of other controllers.
    """
    counts = {topic.name: (topic.type_name, count) for topic, count in bag.metadata.topics}
    states = [
        name for name, (kind, count) in counts.items() if kind == _STATE_OF_CONTROLLER and count
    ]
    controllers = {name.rpartition("/")[0] for name in states}
    commands = [
        name
        for name, (kind, count) in counts.items()
        if kind == _ARRAY
        and count
        and name.endswith("/commands")
        and name.rpartition("/")[0] not in controllers
    ]
    return sorted(states) + sorted(commands)


def find_cameras(bag: Bag) -> dict[str, str]:
    """Return one image topic of each camera in a bag, by the cameras' names, raw if there is one.

    The name of a camera is that of its namespace, ``camera`` for a topic without one.
    """
    decoder = Decoder(bag)
    topics = {
        topic.name: [topic.type_name]
        for topic, count in bag.metadata.topics
        if count and topic.name in decoder.topics
    }
    return camera_topics(topics, prefers_raw=True)


def find_hand(bag: Bag) -> str | None:
    """Return the topic of an operator's twists for servo in a bag, or None."""
    found = [
        topic.name
        for topic, _ in bag.metadata.topics
        if topic.type_name == _TWIST and topic.name.endswith("/delta_twist_cmds")
    ]
    return min(found, default=None)


def action_vector(texts: Sequence[str], types: Mapping[str, str], bag: Bag) -> JoinedFields:
    """Return the vector of the robot's commands.

    Args:
        texts: Topics, or topics and fields.
        types: Types of the topics, by name.
        bag: Bag, whose recorded parameters name the joints of controllers.
    """
    joints: dict[str, Sequence[str]] = {}
    if any(types.get(text) == _ARRAY for text in texts):
        for node, values in read_parameters(bag).items():
            listed = values.get("joints")
            if isinstance(listed, list):
                joints[node] = [str(name) for name in listed]
    fields = [VectorField(one, types, joints.get(one.rpartition("/")[0], ())) for one in texts]
    return JoinedFields(fields)


def units(names: Sequence[str], prismatic: set[str]) -> list[str]:
    """Return the unit of each element by its suffix, empty for an unknown one.

    Args:
        names: Names of elements, such as ``joint_1.pos``.
        prismatic: Names of the prismatic joints; all others turn.
    """
    found = []
    for name in names:
        joint, dot, suffix = name.rpartition(".")
        pair = _UNITS.get(f"{dot}{suffix}", ("", ""))
        found.append(pair[joint in prismatic])
    return found


def prismatic_joints(bag: Bag) -> set[str]:
    """Return the names of the prismatic joints of the robot that a bag describes."""
    described = [
        topic.name for topic, _ in bag.metadata.topics if topic.name.endswith(DESCRIPTION_TOPIC)
    ]
    found: set[str] = set()
    for message in bag.messages(described) if described else ():
        parser = etree.XMLParser(resolve_entities=False, no_network=True)
        try:
            text = deserialize(message.data, get_message("std_msgs/msg/String")).data
            robot = etree.fromstring(text.encode(), parser)
        except (etree.XMLSyntaxError, InvalidMessageError):
            continue
        joints = robot.iterfind(".//joint[@type='prismatic']")
        found |= {str(joint.get("name")) for joint in joints}
    return found


def require_pictures(topic: str, types: Mapping[str, str], bag: Bag) -> None:
    """Raise if a topic has no pictures.

    Raises:
        NotFoundError: The topic does not exist, or cannot be decoded.
        UsageError: The topic has no pictures.
    """
    if topic not in types:
        raise NotFoundError(f"{bag.path} has no topic '{topic}' that can be decoded")
    if types[topic] not in PICTURES:
        raise UsageError(f"{topic} has no pictures, but {types[topic]}")


def has_depths(decoder: Decoder, topic: str) -> bool:
    """Return whether the images of a topic are depths, by the first one."""
    first = next(iter(decoder.messages([topic])), None)
    if first is None:
        return False
    form = getattr(first.message, "encoding", "") or getattr(first.message, "format", "")
    return form in DEPTH_ENCODINGS or "compressedDepth" in form


# Any: a message of any type.
def _names(message: Any, length: int) -> tuple[str, ...]:
    for field in _NAMES:
        names = getattr(message, field, None)
        if isinstance(names, list) and len(names) == length and len(set(names)) == length:
            return tuple(names)
    return ()
