"""What the measuring verbs have in common: they listen, and print once a second."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.verbs.topic.source import (
    TopicSource,
    find_source,
    graph_or_router,
    warn_unpublished,
)
from teleopctl.cli.words.patterns import expanded
from teleopctl.errors import UsageError, did_you_mean

if TYPE_CHECKING:
    from teleopctl.cli.verbs.topic.qos.options import QosWishes
    from teleopctl.node import Node
    from teleopctl.wire import Graph

PRINT_PERIOD_S = 1.0
_DEPTH = 10

# Any: bytes, or a message of any type.
Arrival = Callable[[TopicSource, Any, int], None]


class TopicListener:
    """Subscribes to topics until Ctrl-C, also to those that appear later.

    Args:
        names: The topics; they may be patterns.
        every: All topics that there are, in their place.
        raw: Hand over bytes instead of messages, which spares the decoding.
        wishes: The quality of service that was asked for.
        use_sim_time: Measure the time of ``/clock``.
        of_day: Tell arrivals by the time of day instead of that of a steady clock.
        check: Raises what is wrong with a topic that there is, at once or when it comes.

    Attributes:
        topics: Full names of the topics.

    Raises:
        UsageError: No topic was named.
        TeleopctlError: A topic that there is cannot be measured.
    """

    def __init__(
        self,
        names: Sequence[str],
        *,
        every: bool,
        raw: bool,
        wishes: QosWishes,
        use_sim_time: bool,
        of_day: bool = False,
        check: Callable[[TopicSource], None] = lambda _: None,
    ) -> None:
        if not names and not every:
            raise UsageError("Name a topic, or measure all of them with --all")
        if names and every:
            raise UsageError("Cannot specify both --all/-a and topic names")
        graph = graph_or_router()
        live = [name for name, _ in graph.topic_names_and_types(include_hidden=not every)]
        self.topics = live if every else expanded(names, live, kind="topic")
        self._raw = raw
        self._wishes = wishes
        self._use_sim_time = use_sim_time
        self._of_node = use_sim_time or of_day
        self._check = check
        self._sources = [found for topic in self.topics if (found := self._source(topic, graph))]
        self._missing = sorted(set(self.topics) - {source.topic for source in self._sources})
        for topic in self._missing:
            warn_unpublished(topic)
            if hint := did_you_mean(topic, live):
                console.note(f"  {hint}")

    def announce_all(self, *, as_json: bool) -> bool:
        """Print that all topics are subscribed to; return False if there is none."""
        if not self.topics:
            say = console.note if as_json else console.out
            say("No topics available")
        elif not as_json:
            console.out(f"Subscribing to all {len(self.topics)} available topics...")
        return bool(self.topics)

    def run(
        self,
        arrive: Arrival,
        report: Callable[[int], None],
        subscribed: Callable[[str], None] = lambda _: None,
    ) -> None:
        """Subscribe, and report once a second.

        Args:
            arrive: Called on the transport's thread for each message, with the topic, the message
                and the time of its arrival in nanoseconds, so that neither decoding of other
                messages nor printing falsifies the times.
            report: Called with the present time of that clock.
            subscribed: Called with the name of each topic that is listened to from now on.
        """
        with command_node(use_sim_time=self._use_sim_time) as node:
            now_ns = node.get_clock().nanoseconds if self._of_node else time.monotonic_ns
            for source in self._sources:
                self._subscribe(node, source, arrive, now_ns)
                subscribed(source.topic)
            console.flush()
            graph_has_changed = threading.Event()
            if self._missing:
                node.context.on_graph_change(graph_has_changed.set)
                graph_has_changed.set()
            due_s = time.monotonic()
            while node.context.ok():
                due_s += PRINT_PERIOD_S
                while (left_s := due_s - time.monotonic()) > 0:
                    if graph_has_changed.wait(left_s):
                        graph_has_changed.clear()
                        for source in self._found(node):
                            self._subscribe(node, source, arrive, now_ns)
                            subscribed(source.topic)
                report(now_ns())
                console.flush()

    def _found(self, node: Node) -> list[TopicSource]:
        """The topics that were missing and have come."""
        graph = node.graph()
        sources = [found for topic in self._missing if (found := self._source(topic, graph))]
        for source in sources:
            self._missing.remove(source.topic)
        return sources

    def _source(self, topic: str, graph: Graph) -> TopicSource | None:
        """A topic as it stands in the graph; None where nobody has it."""
        if not (graph.publishers(topic) or graph.subscriptions(topic)):
            return None
        source = find_source(topic, graph=graph, raw=self._raw)
        self._check(source)
        return source

    def _subscribe(
        self, node: Node, source: TopicSource, arrive: Arrival, now_ns: Callable[[], int]
    ) -> None:
        from teleopctl.node import DurabilityPolicy

        qos = source.suited_qos(_DEPTH)
        # What was sent before comes all at once, which says nothing of a rate.
        qos.durability = DurabilityPolicy.VOLATILE

        def receive(message: Any) -> None:
            arrive(source, message, now_ns())

        node.create_subscription(
            source.message_class,
            source.topic,
            receive,
            self._wishes.suited(qos),
            raw=self._raw,
            immediate=True,
        )
