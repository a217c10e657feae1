"""What a bag has of a session in lockstep: each state, and the command that answered it."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from teleopctl.bag.storage.bag import Bag
from teleopctl.errors import InvalidFileError, InvalidMessageError
from teleopctl.interfaces import deserialize, get_message, to_nanoseconds, to_seconds
from teleopctl.node import parameter_value_to_python

if TYPE_CHECKING:
    from sensor_msgs.msg import JointState

STATES_TOPIC = "/robot_joint_states"
COMMANDS_TOPIC = "/robot_joint_commands"
DESCRIPTION_TOPIC = "/robot_description"
EVENTS_TOPIC = "/parameter_events"
SIMULATOR = "/mujoco_sim"

RECORD_NAME = "teleopctl"
"""The record of metadata that has the versions of programs and libraries."""

_JOINT_STATE = "sensor_msgs/msg/JointState"
_PARAMETER_EVENT = "rcl_interfaces/msg/ParameterEvent"
_STRING = "std_msgs/msg/String"


@dataclass(frozen=True)
class Session:
    """A session in lockstep, as a bag has it.

    Attributes:
        robot_description: URDF of the robot that was simulated.
        states: The state of each control tick, by its simulated time in nanoseconds, ascending.
        commands: The command that answered the state of a time; where there is none, nobody did.
        period_ns: Simulated time between two states, in nanoseconds.
        other_commands: Commands that answer no state, so that nobody knows when they took effect.
        parameters: Of the simulator's node, by name, as far as the bag has them.
        versions: Of the programs and libraries, by name, as far as the bag has them.
    """

    robot_description: str
    states: Mapping[int, JointState]
    commands: Mapping[int, JointState]
    period_ns: int
    other_commands: int = 0
    parameters: Mapping[str, object] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)


@dataclass
class _Found:
    robot_description: str = ""
    states: dict[int, JointState] = field(default_factory=dict)
    commands: dict[int, JointState] = field(default_factory=dict)
    other_commands: int = 0


def read_session(
    bag: Bag,
    states_topic: str = STATES_TOPIC,
    commands_topic: str = COMMANDS_TOPIC,
    simulator: str = SIMULATOR,
) -> Session:
    """Read the session that a bag has recorded.

    Args:
        bag: The bag.
        states_topic: Where the simulator published the state of each control tick.
        commands_topic: Where the controllers answered it.
        simulator: Full name of the simulator's node.

    Raises:
        InvalidFileError: The bag lacks a part of it; the message says which.
    """
    found = _read(bag, states_topic, commands_topic)
    if not found.robot_description:
        raise InvalidFileError(
            f"{bag.path} has no robot description, so that nothing can be simulated",
            hint=f"Record {DESCRIPTION_TOPIC} too, as launch … record:=true does.",
        )
    times_ns = sorted(found.states)
    if len(times_ns) < 2:
        raise InvalidFileError(
            f"{bag.path} has {len(times_ns)} messages on {states_topic}: no session in lockstep",
            hint="Record the launch from its first message: launch sim.yaml record:=true",
        )
    period_ns = min(later - earlier for earlier, later in itertools.pairwise(times_ns))
    _refuse_gaps(bag, states_topic, times_ns, period_ns)
    answers = {time_ns: c for time_ns, c in found.commands.items() if time_ns in found.states}
    return Session(
        found.robot_description,
        {time_ns: found.states[time_ns] for time_ns in times_ns},
        answers,
        period_ns,
        found.other_commands + len(found.commands) - len(answers),
        read_parameters(bag, simulator),
        dict(bag.records()).get(RECORD_NAME, {}),
    )


def read_parameters(bag: Bag, node: str) -> dict[str, object]:
    """Return the parameters of a node, as far as a bag has them.

    A node publishes each parameter when it declares it. Where the recorder came too late for that,
    it has asked the node.

    Args:
        bag: The bag.
        node: The node's full name.
    """
    import yaml

    found: dict[str, object] = {}
    for attachment in bag.attachments():
        if attachment.name.startswith("parameters") and attachment.name.endswith(".yaml"):
            document = yaml.safe_load(attachment.data)
            listed = document.get(node) if isinstance(document, dict) else None
            if isinstance(listed, dict):
                found |= listed.get("ros__parameters") or {}
    event_class = get_message(_PARAMETER_EVENT)
    for message in bag.messages((EVENTS_TOPIC,)):
        event: Any = deserialize(message.data, event_class)
        if event.node == node:
            for parameter in event.new_parameters:
                found.setdefault(parameter.name, parameter_value_to_python(parameter.value))
    return found


def _read(bag: Bag, states_topic: str, commands_topic: str) -> _Found:
    joint_state, string = get_message(_JOINT_STATE), get_message(_STRING)
    found = _Found()
    # A robot in a namespace is described there.
    described = [
        topic.name for topic, _ in bag.metadata.topics if topic.name.endswith(DESCRIPTION_TOPIC)
    ]
    for message in bag.messages((states_topic, commands_topic, *described)):
        try:
            if message.topic in described:
                # The simulator keeps the first one.
                found.robot_description = (
                    found.robot_description or deserialize(message.data, string).data
                )
                continue
            read: Any = deserialize(message.data, joint_state)
        except InvalidMessageError as error:
            raise InvalidFileError(f"{bag.path}, {message.topic}: {error.message}") from error
        time_ns = to_nanoseconds(read.header.stamp)
        if message.topic == states_topic:
            if time_ns in found.states:
                raise InvalidFileError(
                    f"{bag.path} has the time {to_seconds(time_ns):.3f} s twice on {states_topic}",
                    hint="A simulation that was started again, or two of them: cut one out.",
                )
            found.states[time_ns] = read
        elif time_ns == 0 and found.commands:
            found.other_commands += 1
        else:
            # The simulator takes the first answer.
            found.commands.setdefault(time_ns, read)
    return found


def _refuse_gaps(bag: Bag, states_topic: str, times_ns: list[int], period_ns: int) -> None:
    """Refuse a recording that does not have every state from the first one on.

    Raises:
        InvalidFileError: It has not.
    """
    if times_ns[0] != 0:
        raise InvalidFileError(
            f"{bag.path} begins at {to_seconds(times_ns[0]):.3f} s of simulated time: what had "
            "happened before is not in it",
            hint="Record the launch from its first message: launch sim.yaml record:=true",
        )
    for number, time_ns in enumerate(times_ns):
        if time_ns != number * period_ns:
            missing_s = to_seconds(number * period_ns)
            raise InvalidFileError(
                f"{bag.path} lacks the state of {missing_s:.3f} s on {states_topic}",
                hint="What a recorder drops it reports: record less, or with a larger cache.",
            )
