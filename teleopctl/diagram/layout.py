"""Where the boxes and arrows of a diagram stand: in columns from left to right.

The method of Sugiyama, Tagawa and Toda (1981) in its usual four steps: arrows of circles are
turned round, boxes get columns, boxes of a column are ordered so that few arrows cross, and then
moved up and down so that arrows are straight. It is our own, since the libraries that have it are
under the GPL (grandalf, igraph) or need Graphviz' programs.
"""

from __future__ import annotations

from typing import NamedTuple

from teleopctl.diagram.columns import in_columns, in_order
from teleopctl.diagram.model import Diagram, DiagramBox, Edge
from teleopctl.diagram.straight import straight

Point = tuple[float, float]

# Pixels, at a font of 12.
LINE_HEIGHT = 15.0
_LETTER_WIDTH = 6.8
_MARGIN = 12.0
_SAME = 0.5
_BOX_HEIGHT = 26.0
_GAP_BETWEEN_BOXES = 14.0
_GAP_BETWEEN_COLUMNS = 46.0
_GAP_BETWEEN_PARTS = 26.0


class BoxPlacement(NamedTuple):
    """Position and size of a box."""

    x: float
    y: float
    width: float
    height: float


class DiagramLayout(NamedTuple):
    """Positions of all boxes and arrows, in pixels.

    Attributes:
        width: Of the whole picture.
        height: Of the whole picture.
        places: Where each box stands, by its key.
        routes: The points of each arrow, in the order of the diagram's edges: where it leaves its
            source, the ends of the columns that it passes through, where it meets its target.
    """

    width: float
    height: float
    places: dict[str, BoxPlacement]
    routes: list[list[Point]]


def lay_out(diagram: Diagram) -> DiagramLayout:
    """Return the positions of a diagram's boxes and arrows.

    The same diagram has the same layout each time.

    What is not joined by arrows stands below each other, the largest part first.
    """
    routes: dict[Edge, list[Point]] = {}
    places: dict[str, BoxPlacement] = {}
    width = y = _MARGIN
    for boxes, edges in _parts(diagram):
        part_width, part_height = _lay_out_part(boxes, edges, y, places, routes)
        width = max(width, part_width)
        y += part_height + _GAP_BETWEEN_PARTS
    height = y - _GAP_BETWEEN_PARTS + _MARGIN if places else y
    return DiagramLayout(width + _MARGIN, height, places, [routes[edge] for edge in diagram.edges])


def size_of(box: DiagramBox) -> tuple[float, float]:
    """Return the size of a box for its text."""
    lines = box.text.split("\n")
    width = 20 + _LETTER_WIDTH * max(map(len, lines))
    return width, _BOX_HEIGHT + LINE_HEIGHT * (len(lines) - 1)


def _parts(diagram: Diagram) -> list[tuple[list[DiagramBox], list[Edge]]]:
    """The parts that no arrow joins."""
    group = {box.key: box.key for box in diagram.boxes}

    def top(key: str) -> str:
        while group[key] != key:
            group[key] = group[group[key]]
            key = group[key]
        return key

    for edge in diagram.edges:
        group[top(edge.source)] = top(edge.target)
    parts: dict[str, tuple[list[DiagramBox], list[Edge]]] = {}
    for box in diagram.boxes:
        parts.setdefault(top(box.key), ([], []))[0].append(box)
    for edge in diagram.edges:
        parts[top(edge.source)][1].append(edge)
    return sorted(parts.values(), key=lambda part: -len(part[0]))


def _lay_out_part(
    boxes: list[DiagramBox],
    edges: list[Edge],
    top: float,
    places: dict[str, BoxPlacement],
    routes: dict[Edge, list[Point]],
) -> tuple[float, float]:
    """Lay one part out below ``top``; return its right end and its height."""
    numbers = {box.key: number for number, box in enumerate(boxes)}
    sizes = [size_of(box) for box in boxes]
    pairs = [(numbers[edge.source], numbers[edge.target]) for edge in edges]
    columns, chains = in_columns(len(boxes), pairs)
    columns = in_order(columns, chains)
    # What an arrow passes through is a place without size.
    count = sum(map(len, columns))
    heights = [height for _, height in sizes] + [0.0] * (count - len(boxes))
    centers = straight(columns, chains, heights, _GAP_BETWEEN_BOXES, len(boxes))
    lowest = min(center - heights[number] / 2 for number, center in enumerate(centers))
    centers = [center - lowest + top for center in centers]

    lefts: list[float] = []
    rights: list[float] = []
    x = _MARGIN
    for column in columns:
        inside = [sizes[number][0] for number in column if number < len(boxes)]
        lefts.append(x)
        rights.append(x + max(inside, default=0.0))
        x = rights[-1] + _GAP_BETWEEN_COLUMNS
    column_of = {number: index for index, column in enumerate(columns) for number in column}
    for number, box in enumerate(boxes):
        width, height = sizes[number]
        index = column_of[number]
        middle = (lefts[index] + rights[index]) / 2
        places[box.key] = BoxPlacement(
            middle - width / 2, centers[number] - height / 2, width, height
        )
    for edge, chain in zip(edges, chains, strict=True):
        routes[edge] = _route(edge, chain, places, centers, column_of, (lefts, rights))
    height = max(center + heights[number] / 2 for number, center in enumerate(centers)) - top
    return rights[-1], height


def _route(
    edge: Edge,
    chain: list[int],
    places: dict[str, BoxPlacement],
    centers: list[float],
    column_of: dict[int, int],
    ends: tuple[list[float], list[float]],
) -> list[Point]:
    """The points of an arrow; ``chain`` are the places that it passes, from left to right."""
    source, target = places[edge.source], places[edge.target]
    if edge.source == edge.target:
        right = source.x + source.width
        upper, lower = source.y + source.height * 0.25, source.y + source.height * 0.75
        out = right + _GAP_BETWEEN_COLUMNS / 2
        return [(right, upper), (out, upper), (out, lower), (right, lower)]
    lefts, rights = ends
    first, last = (source, target) if source.x < target.x else (target, source)
    points = [(first.x + first.width, centers[chain[0]])]
    for number in chain:
        column = column_of[number]
        if number != chain[0]:
            points.append((lefts[column], centers[number]))
        if number != chain[-1]:
            points.append((rights[column], centers[number]))
    points.append((last.x, centers[chain[-1]]))
    # The widest box of a column reaches its ends, but for the rounding of floats.
    if points[1][0] - points[0][0] < _SAME:
        del points[1]
    if points[-1][0] - points[-2][0] < _SAME:
        del points[-2]
    return points if first is source else points[::-1]
