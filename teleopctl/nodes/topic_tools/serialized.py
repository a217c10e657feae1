"""Executables ``relay``, ``throttle``, ``drop``, ``delay``, ``mux`` and ``demux``.

They pass on serialized messages of any type, also of types without a definition here.
"""

from __future__ import annotations

import contextlib
import sys
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from teleopctl.errors import UsageError
from teleopctl.interfaces import get_service
from teleopctl.node import (
    Clock,
    ClockType,
    ExternalShutdownException,
    Node,
    Parameter,
    init,
    parse_ros_arguments,
    qos_for_publishers,
    raw_message_class,
    spin,
)

_DEPTH = 10
_LOOK_PERIOD_S = 0.1
_NS = 1e9
NONE_TOPIC = "__none"
"""Name that selects no topic in ``mux`` and ``demux``."""

# Any, here and below: publishers and subscriptions of any type, messages generated at run time.


class _Source(NamedTuple):
    """Type and QoS of the publishers of a topic."""

    type_name: str
    version: str
    is_reliable: bool
    is_latched: bool


class TopicTool(Node):
    """Node that receives a topic of any type and publishes on another topic of the same type.

    The type and the QoS are those of the input's publishers; both endpoints exist while there are
    publishers, and with the parameter ``lazy`` the subscription only while the output has one.

    Args:
        name: Name of the node.
        parameters: Parameters from the command line's words, by name.
        suffix: End of the default output topic; None if the subclass declares the topics.
    """

    def __init__(self, name: str, parameters: dict[str, Any], suffix: str | None = None) -> None:
        overrides = [Parameter(key, value=value) for key, value in parameters.items()]
        super().__init__(name, parameter_overrides=overrides)
        self.input_topic = self.output_topic = ""
        self.is_lazy = False
        if suffix is not None:
            self.input_topic = self.required("input_topic", Parameter.Type.STRING)
            default = f"{self.input_topic}{suffix}"
            self.output_topic = str(self.declare_parameter("output_topic", default).value)
        self._source: _Source | None = None
        self._publisher: Any = None
        self._subscription: Any = None

    def begin(self) -> None:
        """Search for the input's publishers now and ten times a second; call it at the end."""
        self.create_timer(_LOOK_PERIOD_S, self.look, clock=_steady())
        self.look()

    def required(self, name: str, kind: Any) -> Any:
        """Declare a parameter of a kind of `Parameter.Type` without a default; return its value.

        Raises:
            UsageError: The parameter is not set.
        """
        value = self.declare_parameter(name, kind).value
        if value is None:
            raise UsageError(
                f"{self.get_name()} needs the parameter '{name}'",
                hint=f"Give its arguments (`teleopctl run topic_tools {self.get_name()} --help`), "
                f"or --ros-args -p {name}:=VALUE.",
            )
        return value

    def declare_lazy(self) -> None:
        """Declare the parameter ``lazy``."""
        self.is_lazy = bool(self.declare_parameter("lazy", False).value)

    def process(self, message: bytes) -> None:
        """Publish a received message; subclasses publish some, or later."""
        self.publish(message)

    def publish(self, message: bytes) -> None:
        """Publish a message, unless the publisher is gone."""
        if self._publisher is not None:
            self._publisher.publish(message)

    def look(self) -> None:
        """Create and destroy the publisher and the subscription by what the graph has."""
        source = self._find_source()
        if source != self._source or not self._is_at(self._publisher, self.output_topic):
            self._drop_publisher()
        if source is None or not self._is_at(self._subscription, self.input_topic):
            self._drop_subscription()
        if source is None:
            return
        kind = raw_message_class(source.type_name, source.version)
        if self._publisher is None:
            self._drop_subscription()
            self._source = source
            self._publisher = self.create_publisher(kind, self.output_topic, self._qos)
        if self.is_lazy and not self._publisher.get_subscription_count():
            self._drop_subscription()
        elif self._subscription is None:
            self._subscription = self.create_subscription(
                kind, self.input_topic, self.process, self._qos, raw=True
            )

    def _find_source(self) -> _Source | None:
        if self.input_topic == NONE_TOPIC or self.output_topic == NONE_TOPIC:
            return None
        topic = self.resolve_topic_name(self.input_topic)
        tokens = self.graph().publishers(topic)
        if not tokens:
            return None
        tokens = [token for token in tokens if token.type_name == tokens[0].type_name]
        reliable = [token.qos.is_reliable for token in tokens]
        latched = [token.qos.is_transient_local for token in tokens]
        for values, word, other in (
            (reliable, "'reliable' reliability", "'best effort' reliability"),
            (latched, "'transient local' durability", "'volatile' durability"),
        ):
            if any(values) and not all(values):
                self.get_logger().warning(
                    f"Some, but not all, publishers on topic {self.input_topic} offer {word}. "
                    f"Falling back to {other} in order to connect to all publishers.",
                    once=True,
                )
        self._qos = qos_for_publishers([token.qos for token in tokens], _DEPTH)
        return _Source(tokens[0].type_name, tokens[0].type_hash, all(reliable), all(latched))

    def _is_at(self, endpoint: Any, topic: str) -> bool:
        return endpoint is None or endpoint.topic_name == self.resolve_topic_name(topic)

    def _drop_publisher(self) -> None:
        if self._publisher is not None:
            self.destroy_publisher(self._publisher)
            self._publisher = self._source = None

    def _drop_subscription(self) -> None:
        if self._subscription is not None:
            self.destroy_subscription(self._subscription)
            self._subscription = None


def _steady() -> Clock:
    return Clock(clock_type=ClockType.STEADY_TIME)


class Relay(TopicTool):
    """Node that publishes each message of a topic on another one."""

    def __init__(self, parameters: dict[str, Any] | None = None) -> None:
        super().__init__("relay", parameters or {}, "_relay")
        self.declare_lazy()
        self.begin()


class Throttle(TopicTool):
    """Node that limits a topic to a number of messages, or of bytes, per second."""

    def __init__(self, parameters: dict[str, Any] | None = None) -> None:
        super().__init__("throttle", parameters or {}, "_throttle")
        self.declare_lazy()
        kind = self.required("throttle_type", Parameter.Type.STRING)
        self._period_ns = 0.0
        self._bytes_per_s = self._window_ns = 0
        self._is_by_bytes = kind == "bytes"
        if kind == "messages":
            rate = float(self.required("msgs_per_sec", Parameter.Type.DOUBLE))
            if not rate > 0.0:
                raise UsageError(f"msgs_per_sec must be greater than zero, got {rate:g}")
            self._period_ns = _NS / rate
        elif kind == "bytes":
            self._bytes_per_s = int(self.required("bytes_per_sec", Parameter.Type.INTEGER))
            self._window_ns = round(self.required("window", Parameter.Type.DOUBLE) * _NS)
        else:
            raise UsageError(f"Unknown throttle type '{kind}': it is messages or bytes")
        use_wall_clock = bool(self.declare_parameter("use_wall_clock", False).value)
        self._clock: Any = Clock() if use_wall_clock else self.get_clock()
        self._last_ns = self._clock.now().nanoseconds
        # Time of each message in the window, ns, and its size, bytes.
        self._sent: deque[tuple[int, int]] = deque()
        self.begin()

    def process(self, message: bytes) -> None:
        """Publish a message if the limit allows it."""
        now_ns = self._clock.now().nanoseconds
        if self._is_by_bytes:
            while self._sent and self._sent[0][0] < now_ns - self._window_ns:
                self._sent.popleft()
            if sum(size for _, size in self._sent) < self._bytes_per_s:
                self.publish(message)
                self._sent.append((now_ns, len(message)))
            return
        if now_ns < self._last_ns:
            self.get_logger().warning(
                "Detected jump back in time, resetting throttle period to now."
            )
            self._last_ns = now_ns
        if now_ns - self._last_ns >= self._period_ns:
            self.publish(message)
            self._last_ns = now_ns


class Drop(TopicTool):
    """Node that leaves out the first X of every Y messages."""

    def __init__(self, parameters: dict[str, Any] | None = None) -> None:
        super().__init__("drop", parameters or {}, "_drop")
        self.declare_lazy()
        self._x = int(self.required("X", Parameter.Type.INTEGER))
        self._y = int(self.required("Y", Parameter.Type.INTEGER))
        self._count = 0
        self.begin()

    def process(self, message: bytes) -> None:
        """Publish a message unless it is among the first X of Y."""
        if self._count >= self._x:
            self.publish(message)
        self._count += 1
        if self._count >= self._y:
            self._count = 0


class TopicDelay(TopicTool):
    """Node that publishes each message a fixed time later."""

    def __init__(self, parameters: dict[str, Any] | None = None) -> None:
        super().__init__("delay", parameters or {}, "_delay")
        self._delay_s = float(self.declare_parameter("delay", 0.0).value)
        if self._delay_s < 0.0:
            raise UsageError(f"delay must not be negative, got {self._delay_s:g}")
        use_wall_clock = bool(self.declare_parameter("use_wall_clock", False).value)
        self._clock: Any = Clock() if use_wall_clock else self.get_clock()
        self.begin()

    def process(self, message: bytes) -> None:
        """Publish a message after the delay, by a timer of its own."""

        def publish() -> None:
            self.destroy_timer(timer)
            self.publish(message)

        timer = self.create_timer(self._delay_s, publish, clock=self._clock)


class Selector(TopicTool):
    """Node with one topic on one side and one selected topic of several on the other one.

    Args:
        name: ``mux`` or ``demux``.
        parameters: See `TopicTool`.
        topics: Name of the parameter with the several topics.
    """

    def __init__(self, name: str, parameters: dict[str, Any], topics: str) -> None:
        super().__init__(name, parameters)
        self._what = name
        initial = str(self.declare_parameter("initial_topic", "").value)
        self._declare_other_side()
        self._topics = list(self.required(topics, Parameter.Type.STRING_ARRAY))
        self.select(initial or next(iter(self._topics), NONE_TOPIC))
        for verb, serve in (
            ("Add", self._on_add),
            ("Delete", self._on_delete),
            ("List", self._on_list),
            ("Select", self._on_select),
        ):
            kind = get_service(f"topic_tools_interfaces/srv/{name.capitalize()}{verb}")
            self.create_service(kind, f"~/{verb.lower()}", serve)
        self.begin()

    def _declare_other_side(self) -> None:
        raise NotImplementedError

    @property
    def selected(self) -> str:
        """The selected topic, as it was named."""
        raise NotImplementedError

    def select(self, topic: str) -> None:
        """Select a topic."""
        raise NotImplementedError

    def _find(self, topic: str) -> str | None:
        """Return the name of a topic among the several; None if it is not there."""
        if topic == NONE_TOPIC:
            return None
        full = self.resolve_topic_name(topic)
        return next((each for each in self._topics if self.resolve_topic_name(each) == full), None)

    def _on_add(self, request: Any, response: Any) -> Any:
        log, topic = self.get_logger(), request.topic
        log.info(f"trying to add {topic} to {self._what}")
        if topic == NONE_TOPIC:
            log.warning(
                f"failed to add topic {topic} to {self._what}, because it's reserved for special "
                "use"
            )
        elif self._find(topic) is not None:
            log.warning(
                f"tried to add a topic that {self._what} was already listening to: [{topic}]"
            )
        else:
            self._topics.append(topic)
            log.info(f"added {topic} to {self._what}")
            response.success = True
        return response

    def _on_delete(self, request: Any, response: Any) -> Any:
        log, topic = self.get_logger(), request.topic
        log.info(f"trying to delete {topic} to {self._what}")
        found = self._find(topic)
        if found is None:
            log.warning(f"tried to delete non-subscribed topic {topic} from {self._what}")
        elif found == self._find(self.selected):
            log.warning(f"tried to delete currently selected topic {topic} from {self._what}")
        else:
            self._topics.remove(found)
            log.info(f"deleted topic {topic} from {self._what}")
            response.success = True
        return response

    def _on_list(self, _: Any, response: Any) -> Any:
        response.topics = self._topics
        return response

    def _on_select(self, request: Any, response: Any) -> Any:
        log, topic = self.get_logger(), request.topic
        response.prev_topic = self.selected if self._find(self.selected) is not None else ""
        if topic == NONE_TOPIC:
            log.info(f"{self._what} selected to no input.")
        else:
            log.info(f"trying to switch {self._what} to {topic}")
            if self._find(topic) is None:
                return response
        self.select(topic)
        self.look()
        if topic != NONE_TOPIC:
            log.info(f"{self._what} selected input: [{topic}]")
        response.success = True
        return response


class Mux(Selector):
    """Node that publishes one selected topic of several."""

    def __init__(self, parameters: dict[str, Any] | None = None) -> None:
        super().__init__("mux", parameters or {}, "input_topics")

    def _declare_other_side(self) -> None:
        self.output_topic = str(self.declare_parameter("output_topic", "~/selected").value)
        self.declare_lazy()

    @property
    def selected(self) -> str:
        """The input topic."""
        return self.input_topic

    def select(self, topic: str) -> None:
        """Select the input topic to publish."""
        self.input_topic = topic


class Demux(Selector):
    """Node that publishes a topic on one selected topic of several."""

    def __init__(self, parameters: dict[str, Any] | None = None) -> None:
        super().__init__("demux", parameters or {}, "output_topics")

    def _declare_other_side(self) -> None:
        self.input_topic = str(self.declare_parameter("input_topic", "~/input").value)

    @property
    def selected(self) -> str:
        """The output topic."""
        return self.output_topic

    def select(self, topic: str) -> None:
        """Publish on another topic."""
        self.output_topic = topic


# --- command lines --------------------------------------------------------------------------------

_Words = Sequence[tuple[str, Callable[[str], object]]]


def _topic(word: str) -> str:
    return word


_RELAY: _Words = (("input_topic", _topic), ("output_topic", _topic))
_DROP: _Words = (("input_topic", _topic), ("X", int), ("Y", int), ("output_topic", _topic))
_DELAY: _Words = (("input_topic", _topic), ("delay", float), ("output_topic", _topic))
_MESSAGES: _Words = (("input_topic", _topic), ("msgs_per_sec", float), ("output_topic", _topic))
_BYTES: _Words = (
    ("input_topic", _topic),
    ("bytes_per_sec", int),
    ("window", float),
    ("output_topic", _topic),
)
_USAGE = {
    "relay": "<intopic> [outtopic]",
    "throttle": "messages <intopic> <msgs_per_sec> [outtopic]\n"
    "       throttle bytes <intopic> <bytes_per_sec> <window> [outtopic]",
    "drop": "<intopic> <X> <Y> [outtopic]",
    "delay": "<intopic> <delay> [outtopic]",
    "mux": "<outtopic> <intopic1> [intopic2...]",
    "demux": "<intopic> <outtopic1> [outtopic2...]",
}


def parse_words(program: str, words: Sequence[str]) -> dict[str, Any]:
    """Return the parameters for the command-line arguments; empty without arguments.

    Raises:
        UsageError: There are too few or too many words, or one is not a number.
    """
    usage = UsageError(
        f"Incorrect number of arguments: {' '.join(words) or 'none'}",
        hint=f"usage: {program} {_USAGE[program]}",
    )
    if program in ("mux", "demux"):
        if not words:
            return {}
        if len(words) < 2:
            raise usage
        one, several = (
            ("output_topic", "input_topics")
            if program == "mux"
            else ("input_topic", "output_topics")
        )
        return {one: words[0], several: [*words[1:]]}
    found: dict[str, Any] = {}
    declared = {"relay": _RELAY, "drop": _DROP, "delay": _DELAY}.get(program, ())
    if program == "throttle" and words:
        kind, words = words[0], words[1:]
        if kind not in ("messages", "bytes"):
            raise UsageError(f"Unknown throttle type '{kind}'", hint=usage.hint)
        found["throttle_type"] = kind
        declared = _MESSAGES if kind == "messages" else _BYTES
    if len(words) > len(declared):
        raise usage
    # All but the last word, the output topic, belong together.
    least = 1 if program in ("relay", "delay") else len(declared) - 1
    if words and len(words) < least:
        raise usage
    for (name, convert), word in zip(declared, words, strict=False):
        try:
            found[name] = convert(word)
        except ValueError:
            raise UsageError(f"{name} is '{word}', expected a number", hint=usage.hint) from None
    return found


def _run(make: Callable[[dict[str, Any]], Node], program: str) -> None:
    words = parse_ros_arguments(sys.argv).program[1:]
    if "-h" in words or "--help" in words:
        sys.stdout.write(f"usage: {program} {_USAGE[program]}\n")
        return
    parameters = parse_words(program, words)
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=sys.argv),
        make(parameters) as node,
    ):
        spin(node)


def relay() -> None:
    """Publish each message of a topic on another one until Ctrl-C."""
    _run(Relay, "relay")


def throttle() -> None:
    """Publish a topic with a limited rate or bandwidth until Ctrl-C."""
    _run(Throttle, "throttle")


def drop() -> None:
    """Publish a topic without X of every Y messages until Ctrl-C."""
    _run(Drop, "drop")


def delay() -> None:
    """Publish a topic later, until Ctrl-C."""
    _run(TopicDelay, "delay")


def mux() -> None:
    """Publish one of several topics until Ctrl-C."""
    _run(Mux, "mux")


def demux() -> None:
    """Publish a topic on one of several topics until Ctrl-C."""
    _run(Demux, "demux")
