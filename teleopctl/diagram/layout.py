"""Diagrams of boxes and arrows, and their layout in columns from left to right."""

from __future__ import annotations

import itertools
from bisect import bisect_right, insort
from typing import NamedTuple


class DiagramBox(NamedTuple):
    """Box of a diagram: unique key, text, and kind (``node``, ``topic`` or ``label``).

    Attributes:
        key: Unique key of the box.
        text: Text in the box.
        kind: ``node`` and ``topic`` have different frames; a ``label`` has no frame and is drawn
            in the middle of an arrow.
    """

    key: str
    text: str
    kind: str


class Edge(NamedTuple):
    """Arrow between two boxes of a diagram; ``both`` has a head at each end."""

    source: str
    target: str
    both: bool = False


class Diagram(NamedTuple):
    """Content of a diagram of any kind, not yet laid out: boxes, and the arrows between them."""

    boxes: tuple[DiagramBox, ...]
    edges: tuple[Edge, ...]


def connect(boxes: list[DiagramBox], pairs: list[tuple[str, str]]) -> Diagram:
    """Return a diagram with an arrow for each pair of keys; opposite pairs get one double arrow.

    Duplicate pairs are ignored.
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


_ORDER_SWEEPS = 12

Pair = tuple[int, int]


def assign_columns(count: int, pairs: list[Pair]) -> tuple[list[list[int]], list[list[int]]]:
    """Return boxes in columns, arrows mostly to the right, and the places that each arrow passes.

    Args:
        count: Number of boxes, which are numbered from 0.
        pairs: Source and target box of each arrow.

    Returns:
        The columns; and for each arrow the places that it passes through, from left to right. The
        first and last place are boxes; places between, one in each column, are numbered from
        ``count``.
    """
    position = _sequence(count, pairs)
    rightward = {
        (first, last) if position[first] < position[last] else (last, first)
        for first, last in pairs
        if first != last
    }
    rank = _ranks(count, rightward, position)
    columns: list[list[int]] = [[] for _ in range(max(rank, default=0) + 1)]
    for number in sorted(range(count), key=lambda one: position[one]):
        columns[rank[number]].append(number)
    chains = []
    passed: dict[Pair, list[int]] = {}
    following = count
    for first, last in pairs:
        if first == last:
            chains.append([first])
            continue
        if rank[first] > rank[last]:
            first, last = last, first
        chain = passed.get((first, last))
        if chain is None:
            between = range(rank[first] + 1, rank[last])
            chain = passed[first, last] = [first, *range(following, following + len(between)), last]
            for column, number in zip(between, chain[1:], strict=False):
                columns[column].append(number)
            following += len(between)
        chains.append(chain)
    return columns, chains


def _sequence(count: int, pairs: list[Pair]) -> list[int]:
    """Return the position of each box in a sequence in which few arrows lead back.

    The greedy heuristic of Eades, Lin and Smyth (1993): boxes without incoming arrows are next, and
    boxes without outgoing arrows are last. Otherwise the box with the largest difference between
    outgoing and incoming arrows is next.
    """
    targets: list[set[int]] = [set() for _ in range(count)]
    sources: list[set[int]] = [set() for _ in range(count)]
    for first, last in pairs:
        if first != last:
            targets[first].add(last)
            sources[last].add(first)
    left = set(range(count))
    head: list[int] = []
    tail: list[int] = []
    while left:
        ends = [one for one in sorted(left) if not targets[one] and sources[one]]
        starts = [one for one in sorted(left) if not sources[one]]
        if ends:
            tail += ends
        elif starts:
            head += starts
        else:
            starts = [max(sorted(left), key=lambda one: len(targets[one]) - len(sources[one]))]
            head += starts
        for one in ends or starts:
            left.discard(one)
            for other in targets[one]:
                sources[other].discard(one)
            for other in sources[one]:
                targets[other].discard(one)
    position = [0] * count
    for index, one in enumerate([*head, *reversed(tail)]):
        position[one] = index
    return position


def _ranks(count: int, rightward: set[Pair], position: list[int]) -> list[int]:
    targets: list[list[int]] = [[] for _ in range(count)]
    sources: list[list[int]] = [[] for _ in range(count)]
    for first, last in rightward:
        targets[first].append(last)
        sources[last].append(first)
    rank = [0] * count
    row = sorted(range(count), key=lambda one: position[one])
    for one in row:
        rank[one] = max((rank[source] + 1 for source in sources[one]), default=0)
    # A box with more outgoing than incoming arrows is placed beside its targets.
    for one in reversed(row):
        if len(targets[one]) > len(sources[one]):
            rank[one] = min(rank[target] for target in targets[one]) - 1
    return rank


def order_columns(columns: list[list[int]], chains: list[list[int]]) -> list[list[int]]:
    """Return the columns with boxes reordered so that few arrows cross (barycentre heuristic)."""
    before: dict[int, set[int]] = {}
    after: dict[int, set[int]] = {}
    for chain in chains:
        for first, last in itertools.pairwise(chain):
            after.setdefault(first, set()).add(last)
            before.setdefault(last, set()).add(first)
    best = [list(column) for column in columns]
    fewest = _crossings(best, after)
    present = [list(column) for column in best]
    for sweep in range(_ORDER_SWEEPS):
        if fewest == 0:
            break
        rightward = sweep % 2 == 0
        others = before if rightward else after
        row = range(1, len(present)) if rightward else range(len(present) - 2, -1, -1)
        for index in row:
            beside = present[index - 1 if rightward else index + 1]
            place = {number: at for at, number in enumerate(beside)}
            present[index] = _by_barycentre(present[index], others, place)
        crossings = _crossings(present, after)
        if crossings < fewest:
            fewest, best = crossings, [list(column) for column in present]
    return best


def _by_barycentre(
    column: list[int], others: dict[int, set[int]], place: dict[int, int]
) -> list[int]:
    """Return a column sorted by the mean position of each box's neighbours in another one."""
    means = {}
    for number in column:
        joined = [place[other] for other in others.get(number, ()) if other in place]
        if joined:
            means[number] = sum(joined) / len(joined)
    moved = iter(sorted(means, key=lambda number: means[number]))
    return [next(moved) if number in means else number for number in column]


def _crossings(columns: list[list[int]], after: dict[int, set[int]]) -> int:
    found = 0
    for left, right in itertools.pairwise(columns):
        place = {number: at for at, number in enumerate(right)}
        seen: list[int] = []
        for number in left:
            ends = sorted(place[other] for other in after.get(number, ()))
            found += sum(len(seen) - bisect_right(seen, end) for end in ends)
            for end in ends:
                insort(seen, end)
    return found


_STRAIGHTEN_SWEEPS = 16
# Bends of long arrows are the most visible.
_WEIGHT_OF_A_LONG_ARROW = 8.0


def straighten(
    columns: list[list[int]],
    chains: list[list[int]],
    heights: list[float],
    gap: float,
    boxes: int,
) -> list[float]:
    """Return the vertical centres of boxes and arrow places that make arrows nearly straight.

    Each place repeatedly moves towards the mean of the places that it is connected with; within a
    column this is a least squares problem with the constraint that places do not overlap.

    Args:
        columns: Places of each column, from top to bottom.
        chains: Places that each arrow passes through.
        heights: Height of each place.
        gap: Smallest distance between two places of a column.
        boxes: Number of boxes; places from this number on are those of arrows.
    """
    joined: list[dict[int, float]] = [{} for _ in heights]
    for chain in chains:
        for first, last in itertools.pairwise(chain):
            is_long = first >= boxes and last >= boxes
            weight = _WEIGHT_OF_A_LONG_ARROW if is_long else 1.0
            joined[first][last] = joined[last][first] = weight
    centers = [0.0] * len(heights)
    offsets = []
    for column in columns:
        offset, own = 0.0, []
        for above, number in zip([None, *column], column, strict=False):
            if above is not None:
                offset += (heights[above] + heights[number]) / 2 + gap
            own.append(offset)
            centers[number] = offset
        offsets.append(own)
        middle = offset / 2
        for number in column:
            centers[number] -= middle
    for sweep in range(_STRAIGHTEN_SWEEPS):
        row = range(len(columns)) if sweep % 2 == 0 else range(len(columns) - 1, -1, -1)
        for index in row:
            column = columns[index]
            wanted, weights = [], []
            for number in column:
                total = sum(joined[number].values())
                mean = sum(weight * centers[other] for other, weight in joined[number].items())
                wanted.append(mean / total if total else centers[number])
                weights.append(total or 0.1)
            found = _apart(wanted, weights, offsets[index])
            for number, center in zip(column, found, strict=True):
                centers[number] = center
    return centers


def _apart(wanted: list[float], weights: list[float], offsets: list[float]) -> list[float]:
    """Return the positions closest to given ones (least squares) without overlaps.

    After subtraction of the offsets this is isotonic regression, solved by pooling adjacent
    violators.
    """
    pools: list[tuple[float, float, int]] = []  # mean, weight, count
    for want, weight, offset in zip(wanted, weights, offsets, strict=True):
        mean, total, count = want - offset, weight, 1
        while pools and pools[-1][0] > mean:
            other_mean, other_total, other_count = pools.pop()
            mean = (mean * total + other_mean * other_total) / (total + other_total)
            total, count = total + other_total, count + other_count
        pools.append((mean, total, count))
    means = [mean for mean, _, count in pools for _ in range(count)]
    return [mean + offset for mean, offset in zip(means, offsets, strict=True)]


Point = tuple[float, float]

# Sizes in pixels, for a font of 12 pixels.
LINE_HEIGHT = 15.0
_LETTER_WIDTH = 6.8
_MARGIN = 12.0
_SAME = 0.5
_BOX_HEIGHT = 26.0
_GAP_BETWEEN_BOXES = 14.0
_GAP_BETWEEN_COLUMNS = 46.0
_GAP_BETWEEN_PARTS = 26.0


class BoxRectangle(NamedTuple):
    """Rectangle of a box in a laid-out diagram: top left corner and size, in pixels."""

    x: float
    y: float
    width: float
    height: float


class DiagramLayout(NamedTuple):
    """Layout of a diagram in pixels: size, rectangles of the boxes and points of the arrows.

    Attributes:
        width: Width of the whole picture.
        height: Height of the whole picture.
        places: Rectangle of each box, by key.
        routes: Points of each arrow, in the order of the diagram's edges: start at the source, ends
            of the columns that the arrow passes through, end at the target.
    """

    width: float
    height: float
    places: dict[str, BoxRectangle]
    routes: list[list[Point]]


def lay_out(diagram: Diagram) -> DiagramLayout:
    """Return the layout of a diagram, in columns from left to right.

    The same diagram has the same layout each time.

    Parts that are not connected by arrows are placed below each other, the largest part first.
    """
    routes: dict[Edge, list[Point]] = {}
    places: dict[str, BoxRectangle] = {}
    width = y = _MARGIN
    for boxes, edges in _parts(diagram):
        part_width, part_height = _lay_out_part(boxes, edges, y, places, routes)
        width = max(width, part_width)
        y += part_height + _GAP_BETWEEN_PARTS
    height = y - _GAP_BETWEEN_PARTS + _MARGIN if places else y
    return DiagramLayout(width + _MARGIN, height, places, [routes[edge] for edge in diagram.edges])


def size_of(box: DiagramBox) -> tuple[float, float]:
    """Return the width and height of a box in pixels, estimated from the box's text."""
    lines = box.text.split("\n")
    width = 20 + _LETTER_WIDTH * max(map(len, lines))
    return width, _BOX_HEIGHT + LINE_HEIGHT * (len(lines) - 1)


def _parts(diagram: Diagram) -> list[tuple[list[DiagramBox], list[Edge]]]:
    """Return the connected parts of a diagram: boxes and arrows of each."""
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
    places: dict[str, BoxRectangle],
    routes: dict[Edge, list[Point]],
) -> tuple[float, float]:
    """Lay one part out below ``top``; return its right end and its height."""
    numbers = {box.key: number for number, box in enumerate(boxes)}
    sizes = [size_of(box) for box in boxes]
    pairs = [(numbers[edge.source], numbers[edge.target]) for edge in edges]
    columns, chains = assign_columns(len(boxes), pairs)
    columns = order_columns(columns, chains)
    # A place that an arrow passes through has no height.
    count = sum(map(len, columns))
    heights = [height for _, height in sizes] + [0.0] * (count - len(boxes))
    centers = straighten(columns, chains, heights, _GAP_BETWEEN_BOXES, len(boxes))
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
        places[box.key] = BoxRectangle(
            middle - width / 2, centers[number] - height / 2, width, height
        )
    for edge, chain in zip(edges, chains, strict=True):
        routes[edge] = _route(edge, chain, places, centers, column_of, (lefts, rights))
    height = max(center + heights[number] / 2 for number, center in enumerate(centers)) - top
    return rights[-1], height


def _route(
    edge: Edge,
    chain: list[int],
    places: dict[str, BoxRectangle],
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
    # The widest box of a column spans it, but for rounding: drop segments without length.
    if points[1][0] - points[0][0] < _SAME:
        del points[1]
    if points[-1][0] - points[-2][0] < _SAME:
        del points[-2]
    return points if first is source else points[::-1]
