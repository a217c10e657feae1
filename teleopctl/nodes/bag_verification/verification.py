"""Verification of a bag: run the recorded simulation again, and compare its messages."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

from teleopctl.bag import (
    STATE_ATTACHMENT,
    Bag,
    ComparedStream,
    Difference,
    DifferenceKind,
    RecordedMessage,
    RecordedSession,
    RecordedTopic,
    ReplayComparison,
    end_of_run_ns,
    open_bag,
    read_commands,
    read_session,
    read_topics,
)
from teleopctl.errors import InvalidFileError, NotFoundError
from teleopctl.interfaces import deserialize, get_message, serialize, to_seconds
from teleopctl.nodes.bag_verification.broadcaster_replay import BroadcasterReplay
from teleopctl.nodes.bag_verification.frame_replay import TF_TYPE, FrameReplay, split_by_frames
from teleopctl.robot import COMMANDS_TOPIC, STATES_TOPIC
from teleopctl.sim import CHANGES_TOPIC, SavedState, SimulationReplay

# Libraries whose versions affect the bits of the messages.
_LIBRARIES = ("mujoco", "numpy", "teleopctl")

_SIMULATOR = "/mujoco_sim"
_TF, _TF_STATIC = "/tf", "/tf_static"

_BY_WALL_TIME = "depends on wall time"
# By message type, or by the type's package.
_REASONS = {
    "rcl_interfaces": _BY_WALL_TIME,
    "diagnostic_msgs": _BY_WALL_TIME,
    "pal_statistics_msgs": _BY_WALL_TIME,
    "gazebo_msgs/msg/PerformanceMetrics": _BY_WALL_TIME,
    "controller_manager_msgs": "depends on when controllers were started, in wall time",
    "action_msgs": "depends on wall time",
    "rosbag2_interfaces": "describes the recording itself",
    "sensor_msgs/msg/Image": "is rendered, which differs in bits between machines",
    "sensor_msgs/msg/CompressedImage": "is rendered, which differs in bits between machines",
    "sensor_msgs/msg/CameraInfo": "is published with images, at times that depend on rendering",
    "sensor_msgs/msg/PointCloud2": "is rendered, which differs in bits between machines",
}
_OTHERWISE = "its publisher is not run again"

OnMessage = Callable[[str, str, int, bytes, bytes], object]


class Verification(NamedTuple):
    """Result of `verify_bag`: comparison of messages, other library versions, remarks.

    Attributes:
        verdict: Comparison of the messages.
        other_versions: Libraries whose version has changed since the recording, with both versions.
        remarks: Other possible reasons for differences, one sentence each.
    """

    verdict: ReplayComparison
    other_versions: dict[str, tuple[str, str]]
    remarks: list[str]


def verify_bag(
    path: Path,
    *,
    tolerance: float = 0.0,
    world: str | None = None,
    timestep_s: float | None = None,
    on_message: OnMessage = lambda *_: None,
) -> Verification:
    """Simulate a recorded bag again without a ROS graph; return how its messages compare.

    The simulator runs with its recorded parameters, and applies the recorded commands at their
    recorded simulated times. Controllers without command interfaces and robot_state_publisher
    receive its states. Everything runs in this process, as fast as the machine allows.

    Args:
        path: Path of the bag.
        tolerance: Largest allowed difference of two numbers; 0 for equal bits.
        world: World that replaces the recorded one; empty for no world.
        timestep_s: Physics timestep that replaces the recorded one, in seconds.
        on_message: Called with the topic, its type, the simulated time in nanoseconds, the CDR of
            the recorded message and the CDR of the replayed message.

    Raises:
        InvalidFileError: The bag does not hold a complete run.
        InvalidDescriptionError: The robot or the world cannot be simulated.
        NotFoundError: The bag or the world does not exist.
    """
    with open_bag(path) as bag:
        session = read_session(bag)
        remarks = list(bag.remarks)
        parameters = _parameters(bag, session)
        for name, wanted in (("world", world), ("timestep", timestep_s)):
            if wanted is not None:
                parameters[name] = wanted
            elif name not in parameters:
                remarks.append(f"The bag does not record its {name}; the default is used")
        run = _Run(session, parameters, tolerance, on_message)
        run.read(read_topics(bag, run.wanted))
    run.run()
    remarks += run.remarks
    return Verification(run.verdict, _other_versions(session.versions), remarks)


def state_since(path: Path, from_ns: int) -> bytes:
    """Return the state of a recorded simulation from which its messages since a time follow.

    The run is simulated again up to that time, and compared: a state that other commands led to
    would be of no use.

    Args:
        path: Path of the bag.
        from_ns: Time of recording of the first message, in nanoseconds.

    Returns:
        The state, as `STATE_ATTACHMENT` of a bag; ``b""`` for a bag without a simulation, or one
        that does not run again with the same bits.
    """
    try:
        with open_bag(path) as bag:
            session = read_session(bag)
            if COMMANDS_TOPIC not in session.types:
                return b""
            run = _Run(session, _parameters(bag, session), 0.0, lambda *_: None)
            run.read(read_topics(bag, run.wanted))
    except (InvalidFileError, NotFoundError):
        return b""
    return run.state_since(from_ns)


def _parameters(bag: Bag, session: RecordedSession) -> dict[str, object]:
    """Return the parameters of the simulator."""
    parameters: dict[str, object] = dict(session.parameters.get(_SIMULATOR, {}))
    if "update_rate" not in parameters:
        parameters["update_rate"] = _rate_hz(read_topics(bag, {STATES_TOPIC}))
    return parameters


class _Run:
    """Replay of a recorded run, with the comparison of its messages.

    Args:
        session: Recorded run, as read from the bag.
        parameters: Parameters of the simulator.
        tolerance: Largest allowed difference of two numbers.
        on_message: See `verify_bag`.
    """

    def __init__(
        self,
        session: RecordedSession,
        parameters: Mapping[str, object],
        tolerance: float,
        on_message: OnMessage,
    ) -> None:
        self.verdict = ReplayComparison(tolerance)
        self.remarks: list[str] = []
        self._session = session
        self._on_message = on_message
        self._states_topic = str(parameters.get("joint_states_topic", STATES_TOPIC))
        self._commands_topic = str(parameters.get("joint_commands_topic", COMMANDS_TOPIC))
        self._latched: dict[str, bytes] = {}
        self._streams: dict[str, ComparedStream] = {}
        self._frames_stream: ComparedStream | None = None
        self._bodies_stream: ComparedStream | None = None
        start = SavedState.parse(session.start, STATE_ATTACHMENT) if session.start else None
        self._start_ns = 0 if start is None else start.time_ns
        self._rerun = SimulationReplay(session.robot_description, parameters, self._publish, start)
        self._period_ns = self._rerun.control_period_ns
        self._broadcasters = BroadcasterReplay(
            session.robot_description,
            session.parameters,
            self._states_topic,
            self._period_ns,
            self._publish_of_controller,
        )
        self._frames = FrameReplay(session.robot_description, session.parameters)

    @property
    def wanted(self) -> set[str]:
        """Topics of the bag whose messages are compared or played back."""
        also = {self._commands_topic, self._frames.states_topic, _TF, _TF_STATIC, CHANGES_TOPIC}
        published = {*self._rerun.topics, *self._broadcasters.topics}
        return (published | also) & set(self._session.types)

    def read(self, topics: Mapping[str, RecordedTopic]) -> None:
        """Store recorded topics and prepare the comparison; InvalidFileError without commands.

        Raises:
            InvalidFileError: A controller commands joints, and no commands were recorded.
        """
        if self._start_ns:
            end_of_run_ns(topics.values(), self._start_ns)  # raises if the start is missing
            # Messages of the state's own time came before it; commands and changes may follow it.
            since_ns = {self._commands_topic: self._start_ns, CHANGES_TOPIC: self._start_ns}
            # The fixed frames have the time of their publisher's start.
            since_ns[_TF_STATIC] = 0
            topics = {
                name: _from(topic, since_ns.get(name, self._start_ns + 1))
                for name, topic in topics.items()
            }
        self._recorded = topics
        commands = topics.get(self._commands_topic)
        cycles = any(topics[name].messages for name in self._broadcasters.topics & set(topics))
        # Each cycle of the controllers sends commands; before the first cycle there are none.
        lacks = commands is None or (cycles and not commands.messages)
        if lacks and self._broadcasters.commanding:
            raise InvalidFileError(
                f"The bag has no messages on {self._commands_topic}: the commands of the "
                "joints were not recorded",
                hint=f"Record {self._commands_topic} too, as launch … record:=true does.",
            )
        for name in sorted(self._rerun.inputs):
            if self._session.counts.get(name):
                self.remarks.append(
                    f"{name} moves a robot in the simulator itself: the times of its effect are "
                    "not in the bag, so they show as differences"
                )
        # A state is saved between two messages.
        latest_ns = self._start_ns + self._period_ns if self._start_ns else 0
        self._end_ns = end_of_run_ns(topics.values(), latest_ns)
        for name, topic in topics.items():
            played_back = (self._commands_topic, CHANGES_TOPIC)
            if name not in (_TF, _TF_STATIC, *played_back) and topic.is_stamped:
                controllers = name in self._broadcasters.topics
                if controllers or name in self._rerun.topics:
                    self._streams[name] = self._stream(name, topic, may_skip=controllers)
        if _TF in topics:
            self._split_frames(topics[_TF])
        states = topics.get(self._states_topic)
        self._commands = read_commands(
            commands or RecordedTopic("", ()), self._period_ns, states.messages if states else ()
        )
        self._command_stream: ComparedStream | None = None
        if commands is not None:
            self._command_stream = self._stream(self._commands_topic, commands, may_skip=True)

    def _stream(
        self, name: str, topic: RecordedTopic, publisher: str = "", *, may_skip: bool = False
    ) -> ComparedStream:
        stream = ComparedStream(
            name,
            topic.type_name,
            topic.messages,
            publisher,
            self.verdict.tolerance,
            may_skip,
            frozenset(topic.numbers),
            may_repeat=name in self._rerun.topics and publisher != self._frames.name,
        )
        self.verdict.streams.append(stream)
        return stream

    def _split_frames(self, topic: RecordedTopic) -> None:
        groups = {_SIMULATOR: self._rerun.moving_frames, self._frames.name: self._frames.children}
        found = split_by_frames(topic, {name: each for name, each in groups.items() if each})
        if _TF in self._rerun.topics:
            self._bodies_stream = self._stream(_TF, found[_SIMULATOR], _SIMULATOR)
        if (joints := found.get(self._frames.name)) and joints.messages:
            self._frames_stream = self._stream(_TF, joints, self._frames.name, may_skip=True)
        elif joints:
            self.verdict.not_compared[f"{_TF} of {self._frames.name}"] = "no message was recorded"
        if others := found[""].messages:
            self.verdict.not_compared[f"{_TF} of others, {len(others)} messages"] = _OTHERWISE

    # --- the run --------------------------------------------------------------------------

    def run(self) -> None:
        """Run the simulation again with the recorded commands, and compare all messages."""
        self._rerun.run(self._commands.by_time, self._end_ns, self._take_tick, self._changes())
        if self._frames.states_topic not in self._broadcasters.topics:
            # No replayed publisher has these joint states, so the recorded ones are used.
            states = self._recorded.get(self._frames.states_topic)
            for state in states.messages if states else ():
                self._take_frames(state.time_ns, state.data)
        self._compare_fixed_frames()
        for name, topic in self._recorded.items():
            if not topic.is_stamped and name in self._latched:
                stream = self._stream(name, topic._replace(messages=()))
                for each in topic.messages:
                    stream.compared += 1
                    stream.compare(0, each.data, self._latched[name])
                if not topic.messages:
                    stream.add(Difference(name, 0, kind=DifferenceKind.MISSING))
        self._close()

    def state_since(self, from_ns: int) -> bytes:
        """Run up to a time between the first two states since a time of recording; see there."""
        states = self._recorded.get(self._states_topic)
        messages = states.messages if states else ()
        time_ns = next((each.time_ns for each in messages if each.log_time_ns >= from_ns), None)
        if time_ns is None:
            return b""
        found: list[SavedState] = []
        # At no time at which a view is published.
        self._rerun.save_at(time_ns + 3 * self._period_ns // 10, found.append)
        end_ns = time_ns + self._period_ns
        self._rerun.run(self._commands.by_time, end_ns, changes=self._changes())
        is_same = all(stream.is_same for stream in self._streams.values())
        return found[0].text().encode() if found and is_same else b""

    # Any: messages, whose classes are made at run time.
    def _changes(self) -> list[tuple[int, Any]]:
        """Return the recorded changes by services, with their simulated times."""
        if (topic := self._recorded.get(CHANGES_TOPIC)) is None:
            return []
        if topic.messages:
            self.verdict.played_back[CHANGES_TOPIC] = len(topic.messages)
        kind = get_message(topic.type_name)
        return [(each.time_ns, deserialize(each.data, kind)) for each in topic.messages]

    def _publish(self, topic: str, time_ns: int, data: bytes) -> None:
        """Compare a message of the simulator, or store it if it is latched."""
        if topic == self._states_topic:
            self._broadcasters.update(time_ns, data)
        if topic == _TF:
            self._compare(self._bodies_stream, time_ns, data)
        elif (stream := self._streams.get(topic)) is not None:
            self._compare(stream, time_ns, data)
        else:
            self._latched[topic] = data

    def _publish_of_controller(self, topic: str, time_ns: int, data: bytes) -> None:
        self._compare(self._streams.get(topic), time_ns, data)
        if topic == self._frames.states_topic:
            self._take_frames(time_ns, data)

    def _take_frames(self, time_ns: int, state: bytes) -> None:
        if (stream := self._frames_stream) is not None:
            recorded = stream.at(time_ns)
            now = self._frames.compare(time_ns, state, stream)
            if now is not None and recorded is not None:
                self._on_message(_TF, TF_TYPE, time_ns, recorded.data, now)

    def _take_tick(self, time_ns: int) -> None:
        """Check that a control tick has exactly one recorded command."""
        if (stream := self._command_stream) is not None and (recorded := stream.at(time_ns)):
            stream.take(time_ns, recorded.data)
        elif stream is not None:
            stream.take(time_ns, b"")

    def _compare(self, stream: ComparedStream | None, time_ns: int, data: bytes) -> None:
        if stream is None or (self._rerun.is_repeating and stream.at(time_ns) is None):
            return
        if (recorded := stream.take(time_ns, data)) is not None:
            self._on_message(stream.topic, stream.type_name, time_ns, recorded.data, data)

    def _compare_fixed_frames(self) -> None:
        """Compare the fixed frames except for their stamps, which are times of the start."""
        topic = self._recorded.get(_TF_STATIC)
        if topic is None:
            return
        stream = self._stream(_TF_STATIC, RecordedTopic(TF_TYPE, ()), self._frames.name)
        # Any: the types of messages are made at run time.
        message_class: Any = get_message(TF_TYPE)
        others: set[str] = set()
        for recorded in topic.messages:
            message: Any = deserialize(recorded.data, message_class)
            own = [each for each in message.transforms if each.child_frame_id in self._frames.fixed]
            others |= {each.child_frame_id for each in message.transforms} - set(self._frames.fixed)
            if not own:
                continue
            for each in own:
                each.header.stamp.sec = each.header.stamp.nanosec = 0
            stream.compared += 1
            stream.compare(
                0,
                bytes(serialize(message_class(transforms=own))),
                bytes(serialize(message_class(transforms=[*self._frames.fixed.values()]))),
            )
        if self._frames_stream is not None and self._frames.fixed and not stream.compared:
            # The publisher of the moving frames publishes the fixed frames too.
            stream.add(Difference(_TF_STATIC, 0, kind=DifferenceKind.MISSING))
        if others:
            self.verdict.not_compared[f"{_TF_STATIC}: {', '.join(sorted(others))}"] = _OTHERWISE

    # --- the end --------------------------------------------------------------------------

    def _close(self) -> None:
        stamped = [*self._streams.values(), *filter(None, [self._bodies_stream])]
        of_simulator = [s for s in stamped if s.topic not in self._broadcasters.topics]
        longest = max(of_simulator, key=lambda stream: len(stream.recorded), default=None)
        commands = self._command_stream
        for stream in self.verdict.streams:
            if stream is commands:
                # One controller cycle publishes both the commands and the joint states.
                stream.close(self._streams.get(self._frames.states_topic))
            elif stream.topic in self._broadcasters.topics:
                stream.close(commands)
            elif stream is self._frames_stream:
                stream.close(self._streams.get(self._frames.states_topic))
            else:
                stream.close(longest)
            if stream.skipped_ns:
                self._report_skipped(stream)
        self._count()
        self._report_commands()
        self._report_not_compared()

    def _count(self) -> None:
        """Find missing and repeated messages by the recorder's sequence numbers.

        Their times do not show them all: a latched message is sent again to late subscribers, so
        its topic has no times to compare, and messages may be missing before the first recorded
        one.
        """
        for name, topic in self._recorded.items():
            streams = [stream for stream in self.verdict.streams if stream.topic == name]
            if not streams or not all(stream.is_same for stream in streams):
                continue
            for number in topic.missing_numbers()[:1]:
                after = zip(topic.numbers, topic.messages, strict=True)
                time_ns = next((m.time_ns for other, m in after if other > number), 0)
                streams[0].add(Difference(name, time_ns, kind=DifferenceKind.MISSING))
            counted = [number for number in topic.numbers if number]
            if len(counted) > len(set(counted)):
                streams[0].add(Difference(name, 0, kind=DifferenceKind.EXTRA))

    def _report_skipped(self, stream: ComparedStream) -> None:
        count, first_s = len(stream.skipped_ns), to_seconds(stream.skipped_ns[0])
        self.remarks.append(
            f"{stream.name} has no message for {count} states, from {first_s:.3f} s on: none "
            "was published, by the recorder's count"
        )

    def _report_commands(self) -> None:
        if self._command_stream is not None:
            self.verdict.streams.remove(self._command_stream)
            if not self._command_stream.is_same:
                self.verdict.streams.insert(0, self._command_stream)
            self.verdict.played_back[self._commands_topic] = len(self._commands.by_time)
        last_ns = max(self._commands.by_time, default=0)
        if self._commands.by_time and self.verdict.end_ns <= last_ns:
            last = f"{self._commands_topic} of {to_seconds(last_ns):.3f} s"
            self.verdict.not_compared[last] = "the recording ends before it commands anything"
        if late := self._commands.late_ns:
            self.remarks.append(
                f"{len(late)} commands, the first that of {to_seconds(late[0]):.3f} s, arrived "
                "after the simulator had continued without them, as in the replay"
            )
        if self._commands.unstamped:
            self.remarks.append(
                f"{self._commands.unstamped} commands match no state: the time of their "
                "effect is unknown"
            )

    def _report_not_compared(self) -> None:
        verdict, types = self.verdict, self._session.types
        done = {stream.topic for stream in verdict.streams} | set(verdict.played_back)
        done.add(CHANGES_TOPIC)
        for topic in sorted({_TF, _TF_STATIC} - set(types)):
            verdict.not_compared[topic] = "was not recorded"
        for topic in sorted({*self._rerun.topics, *self._broadcasters.topics} - set(types)):
            verdict.not_compared[topic] = "was not recorded"
        for topic, type_name in sorted(types.items()):
            if topic in done or topic in verdict.not_compared:
                continue
            if not self._session.counts[topic]:
                verdict.not_compared[topic] = "no message was recorded"
            elif topic.endswith("/robot_description"):
                verdict.played_back[topic] = 1
            else:
                verdict.not_compared[topic] = self._why_not(topic, type_name)

    def _why_not(self, topic: str, type_name: str) -> str:
        if known := _REASONS.get(type_name) or _REASONS.get(type_name.split("/", 1)[0]):
            return known
        for node, why in self._broadcasters.not_run.items():
            if _is_below(topic, node):
                return f"{node} {why}"
        return _OTHERWISE


def _is_below(topic: str, node: str) -> bool:
    return topic.startswith(f"{node}/")


def _rate_hz(topics: Mapping[str, RecordedTopic]) -> int:
    """Return the rate of the control ticks by their shortest interval; 10 without an interval."""
    found: Sequence[RecordedMessage] = topics[STATES_TOPIC].messages if topics else ()
    times_ns = sorted({each.time_ns for each in found})
    period_ns = min((b - a for a, b in itertools.pairwise(times_ns)), default=0)
    return round(1e9 / period_ns) if period_ns else 10


def _other_versions(recorded: Mapping[str, str]) -> dict[str, tuple[str, str]]:
    here = {name: metadata.version(name) for name in _LIBRARIES}
    return {
        name: (recorded[name], here[name])
        for name in _LIBRARIES
        if name in recorded and recorded[name] != here[name]
    }


def _from(topic: RecordedTopic, start_ns: int) -> RecordedTopic:
    """Return a topic without the messages before a simulated time."""
    if not topic.is_stamped:
        return topic
    return topic._replace(messages=[each for each in topic.messages if each.time_ns >= start_ns])
