"""In which column each box stands, and in which order the boxes of a column."""

from __future__ import annotations

import itertools
from bisect import bisect_right, insort

_SWEEPS = 12

Pair = tuple[int, int]


def in_columns(count: int, pairs: list[Pair]) -> tuple[list[list[int]], list[list[int]]]:
    """Assign boxes to columns such that arrows lead to the right where possible.

    Args:
        count: How many boxes there are; they are numbered from 0.
        pairs: From which box to which one each arrow leads.

    Returns:
        The columns; and for each arrow the places that it passes through, from left to right, from
        box to box. Those between are no boxes', one in each column, numbered from ``count``.
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
    """The position of each box in a row in which few arrows lead back.

    The greedy heuristic of Eades, Lin and Smyth (1993): what has no arrow to it comes next, what
    has none from it comes last, and of the others next who sends more than it gets.
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
    # Who sends more than it gets stands beside those to whom it sends.
    for one in reversed(row):
        if len(targets[one]) > len(sources[one]):
            rank[one] = min(rank[target] for target in targets[one]) - 1
    return rank


def in_order(columns: list[list[int]], chains: list[list[int]]) -> list[list[int]]:
    """Return columns ordered so that few arrows cross (barycentre heuristic)."""
    before: dict[int, set[int]] = {}
    after: dict[int, set[int]] = {}
    for chain in chains:
        for first, last in itertools.pairwise(chain):
            after.setdefault(first, set()).add(last)
            before.setdefault(last, set()).add(first)
    best = [list(column) for column in columns]
    fewest = _crossings(best, after)
    present = [list(column) for column in best]
    for sweep in range(_SWEEPS):
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
    """Order a column by the mean place of what each is joined with; the rest keeps its place."""
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
