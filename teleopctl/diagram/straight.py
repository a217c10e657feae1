"""How high each box of a column stands: so that arrows are as straight as they can be."""

from __future__ import annotations

import itertools

_SWEEPS = 16
# Bends of a long arrow are the ugliest.
_WEIGHT_OF_A_LONG_ARROW = 8.0


def straight(
    columns: list[list[int]],
    chains: list[list[int]],
    heights: list[float],
    gap: float,
    boxes: int,
) -> list[float]:
    """Return the vertical positions of boxes that make arrows as straight as possible.

    Each place moves towards the mean of those that it is joined with, again and again; in a column
    that is least squares under the condition that nothing overlaps.

    Args:
        columns: The places of each column, from top to bottom.
        chains: The places that each arrow passes through.
        heights: How high each place is.
        gap: What lies at least between two places of a column.
        boxes: Places from this number on are those of arrows.
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
    for sweep in range(_SWEEPS):
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
    """The least squares solution in which neighbours are as far apart as their offsets.

    Without the offsets that is the question for a sequence that does not fall, which pooling
    neighbours that violate it answers.
    """
    pools: list[tuple[float, float, int]] = []  # mean, weight, how many
    for want, weight, offset in zip(wanted, weights, offsets, strict=True):
        mean, total, count = want - offset, weight, 1
        while pools and pools[-1][0] > mean:
            other_mean, other_total, other_count = pools.pop()
            mean = (mean * total + other_mean * other_total) / (total + other_total)
            total, count = total + other_total, count + other_count
        pools.append((mean, total, count))
    means = [mean for mean, _, count in pools for _ in range(count)]
    return [mean + offset for mean, offset in zip(means, offsets, strict=True)]
