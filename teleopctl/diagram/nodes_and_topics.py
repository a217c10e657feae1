"""Diagram of the nodes and topics of a ROS graph, by the rules of rqt_graph.

Topics of every node and tools that only monitor are hidden by default (``/rosout``,
``/parameter_events``, ``/clock``, ``/statistics``, RViz, rqt, names with a part that starts with
``_``). The topics of an action are drawn as one box, as are topics that transport one camera's
images, and ``/tf`` with ``/tf_static``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from teleopctl.diagram.layout import Diagram, DiagramBox, connect

if TYPE_CHECKING:
    from teleopctl.wire import Graph

SHOWN = ("active", "nodes", "all")
"""Kinds of diagrams: nodes with the topics that connect them; nodes alone, with arrows named after
the topics; nodes with all of their topics."""

_DEBUG_TOPICS = {"/rosout", "/parameter_events", "/clock", "/statistics"}
_DEBUG_NODES = ("rqt", "rviz")
_ACTION = "/_action/"
_TRANSPORTS = ("/compressed", "/compressedDepth", "/theora", "/ffmpeg", "/zstd", "/camera_info")
# Largest number of topic names on an arrow; an arrow of more topics has only their number.
_MOST_NAMED = 4

Pairs = set[tuple[str, str]]


def ros_graph(
    graph: Graph,
    shown: str = "active",
    *,
    include_hidden: bool = False,
    note: Callable[[str], str] | None = None,
) -> Diagram:
    """Return a ROS graph's diagram: nodes and topics, or nodes alone, as ``shown`` selects.

    Args:
        graph: Nodes, publishers and subscriptions.
        shown: One of `SHOWN`.
        include_hidden: Whether to include nodes and topics that are hidden by default.
        note: Function that returns what to write beside a topic's name, such as its type; None for
            names alone. Topics under one name have the note of the first.
    """
    from teleopctl.wire import EntityKind

    published: Pairs = set()
    subscribed: Pairs = set()
    for endpoint in graph.endpoints:
        if endpoint.kind in (EntityKind.MP, EntityKind.MS):
            pairs = published if endpoint.kind is EntityKind.MP else subscribed
            if include_hidden or not _is_hidden(endpoint.full_name, endpoint.name):
                pairs.add((endpoint.full_name, endpoint.name))
    nodes = {
        node.full_name for node in graph.nodes if include_hidden or not _is_debug(node.full_name)
    }
    published, subscribed, first_of = _grouped(published, subscribed)
    texts = {name: note(first) if note else "" for name, first in first_of.items()}
    if shown == "nodes":
        return _nodes_only(nodes, published, subscribed, texts)
    if shown == "active":
        both_ends = {topic for _, topic in published} & {topic for _, topic in subscribed}
        published = {pair for pair in published if pair[1] in both_ends}
        subscribed = {pair for pair in subscribed if pair[1] in both_ends}
        nodes = {node for node, _ in published | subscribed}
    topics = {topic for _, topic in published | subscribed}
    boxes = [DiagramBox(_node(name), name, "node") for name in sorted(nodes)]
    boxes += [
        DiagramBox(_topic(name), f"{name}\n{texts[name]}".rstrip(), "topic")
        for name in sorted(topics)
    ]
    pairs_of_keys = [(_node(node), _topic(topic)) for node, topic in sorted(published)]
    pairs_of_keys += [(_topic(topic), _node(node)) for node, topic in sorted(subscribed)]
    return connect(boxes, pairs_of_keys)


def with_neighbours(diagram: Diagram, is_wanted: Callable[[DiagramBox], bool]) -> Diagram:
    """Return the selected boxes of a diagram, those connected to them, and the arrows between.

    Topics and labels that are kept also keep the nodes at their other ends.

    Args:
        diagram: The diagram.
        is_wanted: Function that chooses boxes.
    """
    joined: dict[str, set[str]] = {box.key: set() for box in diagram.boxes}
    for edge in diagram.edges:
        joined[edge.source].add(edge.target)
        joined[edge.target].add(edge.source)
    kinds = {box.key: box.kind for box in diagram.boxes}
    wanted = {box.key for box in diagram.boxes if is_wanted(box)}
    beside = wanted.union(*(joined[key] for key in wanted))
    kept = beside.union(*(joined[key] for key in beside if kinds[key] != "node"))
    return Diagram(
        tuple(box for box in diagram.boxes if box.key in kept),
        tuple(
            edge
            for edge in diagram.edges
            if edge.source in kept
            and edge.target in kept
            and (edge.source in beside or edge.target in beside)
        ),
    )


def _nodes_only(
    nodes: set[str], published: Pairs, subscribed: Pairs, texts: dict[str, str]
) -> Diagram:
    topics: dict[tuple[str, str], list[str]] = {}
    readers: dict[str, list[str]] = {}
    for node, topic in sorted(subscribed):
        readers.setdefault(topic, []).append(node)
    for node, topic in sorted(published):
        for reader in readers.get(topic, ()):
            topics.setdefault((node, reader), []).append(topic)
    boxes = [DiagramBox(_node(name), name, "node") for name in sorted(nodes)]
    pairs = []
    for (node, reader), names in topics.items():
        key = f"label {node} {reader}"
        text = [f"{name}  {texts[name]}".rstrip() for name in names]
        if len(names) > _MOST_NAMED:
            text = [f"{len(names)} topics"]
        boxes.append(DiagramBox(key, "\n".join(text), "label"))
        pairs += [(_node(node), key), (key, _node(reader))]
    return connect(boxes, pairs)


# Different keys for a node and a topic with the same name.
def _node(name: str) -> str:
    return f"node {name}"


def _topic(name: str) -> str:
    return f"topic {name}"


def _is_hidden(node: str, topic: str) -> bool:
    is_hidden_topic = "/_" in topic and _ACTION not in topic
    return topic in _DEBUG_TOPICS or is_hidden_topic or _is_debug(node)


def _is_debug(node: str) -> bool:
    name = node.rpartition("/")[2]
    return name.startswith("_") or name.lower().startswith(_DEBUG_NODES)


def _grouped(published: Pairs, subscribed: Pairs) -> tuple[Pairs, Pairs, dict[str, str]]:
    """Put topics that belong together under one name; also return the first topic of each name."""
    topics = {topic for _, topic in published | subscribed}
    names = {topic: _group_of(topic, topics) for topic in topics}
    first_of: dict[str, str] = {}
    for topic in sorted(topics):
        first_of.setdefault(names[topic], topic)
    return (
        {(node, names[topic]) for node, topic in published},
        {(node, names[topic]) for node, topic in subscribed},
        first_of,
    )


def _group_of(topic: str, topics: set[str]) -> str:
    if topic == "/tf_static":
        return "/tf"
    if _ACTION in topic:
        return f"{topic.partition(_ACTION)[0]}/action_topics"
    for ending in _TRANSPORTS:
        # The names of these topics start with the name of the image topic.
        if topic.endswith(ending) and topic.removesuffix(ending) in topics:
            return f"{topic.removesuffix(ending)}/image_topics"
    if any(topic + ending in topics for ending in _TRANSPORTS):
        return f"{topic}/image_topics"
    return topic
