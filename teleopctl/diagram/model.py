"""What a picture of boxes and arrows shows, before anybody knows where it stands."""

from __future__ import annotations

from typing import NamedTuple


class DiagramBox(NamedTuple):
    """A box of a diagram.

    Attributes:
        key: What tells it from all others.
        text: What stands in it.
        kind: How it is drawn: ``node`` and ``topic`` have a frame of their own; a ``label`` has
            none and stands on an arrow, of which it is the middle.
    """

    key: str
    text: str
    kind: str


class Edge(NamedTuple):
    """An arrow between two boxes; ``both`` has a head at each end."""

    source: str
    target: str
    both: bool = False


class Diagram(NamedTuple):
    """Boxes, and the arrows between them."""

    boxes: tuple[DiagramBox, ...]
    edges: tuple[Edge, ...]


def joined(boxes: list[DiagramBox], pairs: list[tuple[str, str]]) -> Diagram:
    """Return a diagram of boxes and pairs of keys; opposite pairs share an arrow.

    A pair that stands more than once counts once.
    """
    known = dict.fromkeys(pairs)
    edges = []
    for source, target in known:
        back = (target, source) in known and source != target
        if not back:
            edges.append(Edge(source, target))
        elif source < target:
            edges.append(Edge(source, target, both=True))
    return Diagram(tuple(boxes), tuple(edges))
