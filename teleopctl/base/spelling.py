"""Similarity of names, for the suggestions of error messages.

Unlike difflib, whose import takes as long as Python's own start, this reads letters alone.
"""

from __future__ import annotations

from teleopctl.base.typed import Iterable

_SIMILAR = 0.65


def similarity(one: str, other: str) -> float:
    """Return twice the length of the longest common subsequence over both lengths, from 0 to 1.

    0 means that no letter is common, 1 that the texts are equal.
    """
    # A bit per letter of `one`: Hyyrö's algorithm, which computes a row of lengths at once.
    places: dict[str, int] = {}
    for at, letter in enumerate(one):
        places[letter] = places.get(letter, 0) | 1 << at
    all_bits = row = (1 << len(one)) - 1
    for letter in other:
        common = row & places.get(letter, 0)
        row = (row + common | row - common) & all_bits
    return 2 * (len(one) - row.bit_count()) / (len(one) + len(other) or 1)


def similar_names(
    name: str, known: Iterable[str], most: int = 3, least: float = _SIMILAR
) -> list[str]:
    """Return the names that are spelled like one, the most similar first.

    Args:
        name: Name to compare with.
        known: Names to choose from.
        most: Largest number of names to return.
        least: Least `similarity` of a returned name.
    """
    ranked = sorted((-similarity(name, each), each) for each in known)
    return [each for rank, each in ranked[:most] if -rank >= least]
