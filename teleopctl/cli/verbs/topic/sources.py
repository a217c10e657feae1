"""Topics named on a command line, with their types and the QoS that suits their publishers."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING, Any, Sequence
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import (
    absolute_name,
    is_pattern,
    learn_type,
    live_graph,
    matching_names,
)
from teleopctl.cli.messages import message_class_named
from teleopctl.errors import (
    NotFoundError,
    RefusedError,
    TeleopctlError,
    UnavailableError,
    UsageError,
    did_you_mean,
)
from teleopctl.wire import Graph, RouterNotRunning

if TYPE_CHECKING:
    from collections.abc import Sequence

    from teleopctl.node import QoSProfile
    from teleopctl.wire import EndpointToken, Graph


class TopicSource:
    """A topic to subscribe to: message class, and its publishers when the verb started."""

    __slots__ = ("message_class", "publishers", "topic")

    # Any: the class depends on the topic.
    def __init__(
        self, topic: str, message_class: type[Any], publishers: Sequence[EndpointToken]
    ) -> None:
        self.topic = topic
        self.message_class = message_class
        self.publishers = publishers

    def compatible_qos(self, depth: int) -> QoSProfile:
        """Return a QoS profile that is compatible with all publishers, as reliable as possible.

        If the publishers' policies differ, a line on stderr names the policy that is used.
        """
        from teleopctl.node import qos_for_publishers

        self.note_fallbacks()
        return qos_for_publishers([publisher.qos for publisher in self.publishers], depth)

    def note_fallbacks(self) -> None:
        """Print which policy is used, on stderr, where those of the publishers differ."""
        offers = [publisher.qos for publisher in self.publishers]
        _note_fallback([each.is_reliable for each in offers], "Reliability", "BEST_EFFORT")
        _note_fallback([each.is_transient_local for each in offers], "Durability", "VOLATILE")


_BETTER = {"Reliability": "RELIABLE", "Durability": "TRANSIENT_LOCAL"}


def _note_fallback(have_it: Sequence[bool], policy: str, lesser: str) -> None:
    if any(have_it) and not all(have_it):
        kind = f"QoS{policy}Policy"
        console.note(
            f"Some, but not all, publishers are offering {kind}.{_BETTER[policy]}. Falling back to "
            f"{kind}.{lesser} as it will connect to all publishers"
        )


def graph_or_start_router() -> Graph:
    """Return the ROS graph; where no router runs, start one and return an empty graph."""
    try:
        return live_graph()
    except RouterNotRunning:
        from teleopctl.wire import ensure_router

        ensure_router()
        return Graph()


def find_source(
    topic: str,
    type_name: str | None = None,
    *,
    graph: Graph | None = None,
    takes_type: bool = False,
    raw: bool = False,
) -> TopicSource:
    """Return the TopicSource of a topic (class, publishers); warn of other types and versions.

    Args:
        topic: Full name of the topic.
        type_name: Type given by the user, with which the topic need not exist; None for the type in
            the graph.
        graph: ROS graph; None to query it.
        takes_type: Whether the verb has an argument for the type, which error messages mention.
        raw: Whether the verb uses messages as bytes, so that their type may be unknown.

    Raises:
        TeleopctlError: The type is unknown, or is neither given nor in the graph.
        RouterNotRunning: The type is not given, and no router runs.
    """
    from teleopctl.interfaces import get_message

    if graph is None:
        graph = live_graph() if type_name is None else graph_or_start_router()
    message_type = (
        message_class_named(type_name, graph).TYPE_NAME
        if type_name
        else _only_type(graph, topic, takes_type)
    )
    _warn_of_other_types(topic, message_type, graph)
    publishers = graph.publishers(topic, message_type)
    if raw and publishers:
        from teleopctl.node import raw_message_class

        message_class = raw_message_class(message_type, publishers[0].type_hash)
    else:
        learn_type(message_type, graph)
        message_class = get_message(message_type)
    _warn_of_other_versions(topic, message_class, publishers)
    return TopicSource(topic, message_class, publishers)


def find_sources(
    topics: Sequence[tuple[str, str | None]], graph: Graph, *, raw: bool = False
) -> list[TopicSource]:
    """Return the TopicSource of each topic; omit, with a warning, those without known type.

    Args:
        topics: Full names of the topics, each with the type given by the user or None.
        graph: ROS graph.
        raw: Whether the verb uses messages as bytes, so that their types may be unknown.

    Raises:
        UnavailableError: No topic can be subscribed to.
    """
    found = []
    for topic, type_name in topics:
        try:
            found.append(find_source(topic, type_name, graph=graph, takes_type=True, raw=raw))
        except TeleopctlError as failure:
            if len(topics) == 1:
                raise
            console.warn(f"{topic}: {failure.message}")
    if not found:
        raise UnavailableError("None of these topics can be subscribed to")
    return found


def warn_unpublished(topic: str) -> None:
    """Warn that a topic has no publisher, in ROS 2's words."""
    console.warn(f"topic [{topic}] does not appear to be published yet")


def _only_type(graph: Graph, topic: str, takes_type: bool) -> str:
    topics = dict(graph.topic_names_and_types(include_hidden=True))
    types = topics.get(topic, [])
    if not types:
        from teleopctl.node import validate_absolute_name

        validate_absolute_name(topic)
        warn_unpublished(topic)
        way_out = (
            "Give the type to wait for the first publisher."
            if takes_type
            else "Start its publisher first."
        )
        raise NotFoundError(
            "Could not determine the type for the passed topic",
            hint=did_you_mean(topic, topics) or way_out,
        )
    if len(types) > 1:
        raise RefusedError(
            f"Cannot echo topic '{topic}', as it contains more than one type: [{', '.join(types)}]",
            hint="Give the type explicitly." if takes_type else None,
        )
    return types[0]


def _warn_of_other_types(topic: str, message_type: str, graph: Graph) -> None:
    types = dict(graph.topic_names_and_types(include_hidden=True)).get(topic, [])
    if types and message_type not in types:
        console.warn(
            f"topic [{topic}] has the type {', '.join(types)}: only messages of the type "
            f"{message_type} are received"
        )


def _warn_of_other_versions(
    topic: str, message_class: type[Any], publishers: Sequence[EndpointToken]
) -> None:
    from teleopctl.interfaces import type_hash

    type_name = message_class.TYPE_NAME
    ours = getattr(message_class, "TYPE_HASH", None) or type_hash(type_name)
    others = sorted({p.full_name for p in publishers if p.type_hash != ours})
    if others:
        console.warn(
            f"{', '.join(others)} on {topic} uses another version of {type_name} than this "
            "program (type hashes differ), so its messages do not arrive; is ROS_DISTRO set to "
            "its distribution?"
        )


class NamedTopics:
    """Topics and patterns given on a command line, some with their types.

    Args:
        words: Names of topics, each optionally followed by its type.

    Attributes:
        are_several: Whether there may be more than one topic.
        have_types: Whether the type of each topic is given, so that no topic has to exist yet.
    """

    def __init__(self, words: Sequence[str]) -> None:
        self._wanted: list[tuple[str, str | None]] = []
        for position, word in enumerate(words):
            # A second and last word without a leading slash is a type, valid or not, so that errors
            # report it as a type.
            is_second = position == 1 == len(words) - 1
            is_type = _looks_like_type(word) or (is_second and word[:1] != "/")
            if position and is_type and self._wanted[-1][1] is None:
                self._wanted[-1] = (self._wanted[-1][0], word)
            else:
                self._wanted.append((word, None))
        self.have_types = all(type_name for _, type_name in self._wanted)
        self.are_several = len(self._wanted) > 1 or is_pattern(self._wanted[0][0])

    def require_single(self) -> str:
        """Return the name of the only topic; raise a UsageError if there are several.

        Raises:
            UsageError: Several topics are given.
        """
        if self.are_several:
            raise UsageError("Only fields of a single topic can be drawn")
        return self._wanted[0][0]

    def are_all_published(self, graph: Graph) -> bool:
        """Return whether the only topic has publishers in a graph, none of them latched."""
        name, type_name = self._wanted[0]
        publishers = graph.publishers(absolute_name(name), type_name)
        return bool(publishers) and not any(each.qos.is_transient_local for each in publishers)

    def sources(self, *, raw: bool, graph: Graph | None = None) -> list[TopicSource]:
        """Return the TopicSource of each named topic, with patterns expanded.

        Args:
            raw: Whether the verb uses messages as bytes, so that their types may be unknown.
            graph: ROS graph; None to query it.

        Raises:
            TeleopctlError: The only topic, or each of them, cannot be subscribed to.
        """
        if graph is None:
            graph = graph_or_start_router() if self.have_types else live_graph()
        if not self.are_several:
            name, type_name = self._wanted[0]
            topic = absolute_name(name)
            return [find_source(topic, type_name, graph=graph, takes_type=True, raw=raw)]
        live = [name for name, _ in graph.topic_names_and_types(include_hidden=True)]
        found = {
            topic: type_name
            for name, type_name in self._wanted
            for topic in (matching_names(name, live, kind="topic") if is_pattern(name) else [name])
        }
        topics = [(absolute_name(topic), type_name) for topic, type_name in found.items()]
        return find_sources(topics, graph, raw=raw)


def _looks_like_type(word: str) -> bool:
    """Return whether a word is a package and a name that begins with a capital letter."""
    package, slash, name = word.replace("/msg/", "/", 1).partition("/")
    return (
        bool(slash)
        and package.isidentifier()
        and package[0].islower()
        and name.isidentifier()
        and name[0].isupper()
    )
