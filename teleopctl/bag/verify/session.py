"""Content of a bag with a simulated run: robot, commands, parameters and published topics."""

from __future__ import annotations

import struct
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.bag.base import Bag
from teleopctl.bag.verify.comparison import RecordedMessage
from teleopctl.errors import InvalidFileError, InvalidMessageError
from teleopctl.interfaces import (
    NANOSECONDS_PER_SECOND,
    deserialize,
    get_message,
    parameter_value_to_python,
    to_seconds,
)
from teleopctl.node import flatten_parameters

if TYPE_CHECKING:
    from sensor_msgs.msg import JointState

DESCRIPTION_TOPIC = "/robot_description"
EVENTS_TOPIC = "/parameter_events"

STATE_ATTACHMENT = "simulation_state.json"
"""Name of the attachment with the state of the simulation at the start of an episode."""

RECORD_NAME = "teleopctl"
"""Name of the metadata record with the versions of programs and libraries."""

_CLOCK = "rosgraph_msgs/msg/Clock"
_JOINT_STATE = "sensor_msgs/msg/JointState"
_PARAMETER_EVENT = "rcl_interfaces/msg/ParameterEvent"
_STRING = "std_msgs/msg/String"
_TF = "tf2_msgs/msg/TFMessage"

# A run ends at a gap of this much simulated time: the next stamp may be damaged, and simulating up
# to that time could take years.
_LONGEST_GAP_NS = 60 * NANOSECONDS_PER_SECOND
# Number of consecutive messages with earlier times that shows a restart, not a single bad stamp.
_RESTARTED = 3


class RecordedTopic(NamedTuple):
    """Recorded topic with its messages and their simulated times.

    Attributes:
        type_name: Name of the message type, such as ``sensor_msgs/msg/JointState``.
        messages: Messages in the order of recording; their times are 0 if `is_stamped` is False.
        is_stamped: Whether the messages have a stamp.
        numbers: Sequence numbers of the messages; empty if the recorder did not number them.
    """

    type_name: str
    messages: Sequence[RecordedMessage]
    is_stamped: bool = True
    numbers: Sequence[int] = ()

    def missing_numbers(self) -> list[int]:
        """Return the recorder's sequence numbers that are missing in the topic."""
        return sorted({*range(1, max(self.numbers, default=0))} - {*self.numbers})


@dataclass(frozen=True)
class RecordedCommands:
    """Recorded joint commands, by the simulated time of the joint states that they answer.

    Attributes:
        by_time: Command that the simulator used, by the time of the joint state in nanoseconds.
        late_ns: Times of commands that arrived after the simulator had continued without them.
        unstamped: Number of commands without the time of a joint state, whose effect is unknown.
    """

    by_time: Mapping[int, JointState]
    late_ns: Sequence[int] = ()
    unstamped: int = 0


@dataclass(frozen=True)
class RecordedSession:
    """Recorded simulated run: robot description, topics, parameters and versions.

    Attributes:
        robot_description: URDF of the simulated robot.
        types: Types of all topics in the bag, by name.
        counts: Number of messages of each topic, by name.
        parameters: Recorded parameters, by full node name and dotted parameter name.
        versions: Recorded versions of programs and libraries, by name.
        start: State of the simulation at the start, as the simulator saves it; empty for a
            recording that begins with the simulation.
    """

    robot_description: str
    types: Mapping[str, str] = field(default_factory=dict)
    counts: Mapping[str, int] = field(default_factory=dict)
    parameters: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    start: str = ""


def read_session(bag: Bag) -> RecordedSession:
    """Return the `RecordedSession` (robot, topics, parameters, versions) of a bag's simulated run.

    Raises:
        InvalidFileError: The bag has no robot description.
    """
    counts = {topic.name: count for topic, count in bag.metadata.topics}
    # A robot in a namespace has its description topic in the namespace.
    described = [name for name in counts if name.endswith(DESCRIPTION_TOPIC)]
    string = get_message(_STRING)
    # The simulator uses the first description.
    texts = (deserialize(each.data, string).data for each in bag.messages(described))
    description = next(filter(None, texts), "") if described else ""
    if not description:
        raise InvalidFileError(
            f"{bag.path} has no robot description, so that nothing can be simulated",
            hint=f"Record {DESCRIPTION_TOPIC} too, as launch … record:=true does.",
        )
    return RecordedSession(
        description,
        {topic.name: topic.type_name for topic, _ in bag.metadata.topics},
        counts,
        read_parameters(bag),
        dict(bag.records()).get(RECORD_NAME, {}),
        next((a.data.decode() for a in bag.attachments() if a.name == STATE_ATTACHMENT), ""),
    )


def read_topics(bag: Bag, names: Collection[str]) -> dict[str, RecordedTopic]:
    """Return topics of a bag by name, with undecoded messages and their header stamps.

    Raises:
        InvalidFileError: A message is too short to have a stamp.
    """
    messages: dict[str, list[RecordedMessage]] = defaultdict(list)
    topics = {topic.name: topic for topic, _ in bag.metadata.topics if topic.name in names}
    places = {name: _stamp_place(topic.type_name) for name, topic in topics.items()}
    for message in bag.messages([*topics]) if topics else ():
        place = places[message.topic]
        try:
            time_ns = 0 if place is None else _time_ns(message.data, place)
        except struct.error as error:
            raise InvalidFileError(
                f"{bag.path}, {message.topic}: a message of {len(message.data)} bytes has no time"
            ) from error
        messages[message.topic].append(
            RecordedMessage(
                time_ns,
                message.data,
                message.sequence,
                message.log_time_ns,
                message.publish_time_ns,
            )
        )
    return {
        name: RecordedTopic(
            topic.type_name,
            messages[name],
            places[name] is not None,
            tuple(each.sequence for each in messages[name]) if topic.is_counted else (),
        )
        for name, topic in topics.items()
    }


def read_commands(
    topic: RecordedTopic, period_ns: int, states: Sequence[RecordedMessage] = ()
) -> RecordedCommands:
    """Return recorded commands by the time of the joint state that each one answers.

    Args:
        topic: Recorded topic of the commands from the controllers.
        period_ns: Time between two simulation ticks, in nanoseconds.
        states: Recorded joint states; empty if they were not recorded. A command published after
            the next state is late: the simulator had stopped waiting for the command.

    Raises:
        InvalidFileError: A command cannot be decoded.
    """
    sent_ns = {state.time_ns: state.publish_time_ns for state in states}
    joint_state = get_message(_JOINT_STATE)
    found: dict[int, JointState] = {}
    late: list[int] = []
    unstamped = 0
    for message in topic.messages:
        time_ns = message.time_ns
        if time_ns == 0 and found:
            unstamped += 1
        elif sent_ns.get(time_ns + period_ns, message.publish_time_ns) < message.publish_time_ns:
            late.append(time_ns)
        elif time_ns not in found:
            # The simulator uses the first command for a state.
            try:
                found[time_ns] = deserialize(message.data, joint_state)
            except InvalidMessageError as error:
                raise InvalidFileError(
                    f"A command of {to_seconds(time_ns):.3f} s: {error.message}"
                ) from error
    return RecordedCommands(found, late, unstamped)


def end_of_run_ns(topics: Collection[RecordedTopic], start_ns: int = 0) -> int:
    """Return the simulated time in ns when the recorded run ends; raise if its start is missing.

    Args:
        topics: Recorded topics.
        start_ns: Simulated time at which the run begins.

    Raises:
        InvalidFileError: The run was not recorded from its start, or was restarted.
    """
    times_ns = sorted({m.time_ns for topic in topics if topic.is_stamped for m in topic.messages})
    if len(times_ns) < 2:
        raise InvalidFileError(
            "The bag has no simulated run",
            hint="Record the launch from its first message: launch sim.yaml record:=true",
        )
    if times_ns[0] > start_ns:
        raise InvalidFileError(
            f"The bag begins at {to_seconds(times_ns[0]):.3f} s of simulated time: earlier "
            "events were not recorded",
            hint="Record the launch from its first message: launch sim.yaml record:=true",
        )
    for topic in topics:
        if topic.is_stamped and topic.type_name in (_CLOCK, _JOINT_STATE):
            _refuse_restart(topic)
    end_ns = start_ns
    for time_ns in times_ns:
        if time_ns > end_ns + _LONGEST_GAP_NS:
            break
        end_ns = time_ns
    return end_ns


def _refuse_restart(topic: RecordedTopic) -> None:
    latest_ns = again = 0
    for message in topic.messages:
        again = again + 1 if message.time_ns < latest_ns else 0
        latest_ns = max(latest_ns, message.time_ns)
        if again == _RESTARTED:
            raise InvalidFileError(
                f"Simulated time jumps back from {to_seconds(latest_ns):.3f} s in the bag, and on "
                "from there",
                hint="The simulation was reset or started again, or there were two of them: "
                "record each run for itself.",
            )


def read_parameters(bag: Bag) -> dict[str, dict[str, object]]:
    """Return recorded parameter values, by node name and then dotted parameter name.

    Nodes publish each parameter on ``/parameter_events`` when they declare it. Parameters declared
    before the recording are in attachments, since the recorder requested them from the nodes.

    Raises:
        InvalidFileError: A file of parameters in the bag cannot be read.
    """
    import yaml

    from teleopctl.base import ros_yaml

    found: dict[str, dict[str, object]] = defaultdict(dict)
    for attachment in bag.attachments():
        if attachment.name.startswith("parameters") and attachment.name.endswith(".yaml"):
            try:
                document = ros_yaml.load(attachment.data.decode(errors="replace"))
            except yaml.YAMLError as error:
                reason = str(error).replace("\n", " ")
                raise InvalidFileError(f"{bag.path}, {attachment.name}: {reason}") from error
            for node, listed in document.items() if isinstance(document, dict) else ():
                values = listed.get("ros__parameters") if isinstance(listed, dict) else None
                if isinstance(values, dict):
                    found[node] |= dict(flatten_parameters(values))
    event_class = get_message(_PARAMETER_EVENT)
    for message in bag.messages((EVENTS_TOPIC,)):
        event: Any = deserialize(message.data, event_class)
        for parameter in event.new_parameters:
            found[event.node].setdefault(parameter.name, parameter_value_to_python(parameter.value))
    return dict(found)


def _stamp_place(type_name: str) -> int | None:
    """Return the offset of the stamp in the CDR of a type, in bytes; None without a stamp."""
    if type_name == _CLOCK:
        return 4
    if type_name == _TF:
        # After the number of transforms.
        return 8
    fields = get_message(type_name).get_fields_and_field_types()
    return 4 if next(iter(fields.values()), "") == "std_msgs/Header" else None


def _time_ns(data: bytes, place: int) -> int:
    if place == 8 and data[4:8] == b"\0\0\0\0":
        return 0
    order = "<" if len(data) > 1 and data[1] & 1 else ">"
    seconds, nanoseconds = struct.unpack_from(f"{order}iI", data, place)
    return int(seconds) * NANOSECONDS_PER_SECOND + int(nanoseconds)
