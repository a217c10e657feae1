"""Hostile inputs: random bytes, and valid data with a few bytes changed."""

from __future__ import annotations

import random

LONGEST = 400
_EDGES = (0, 1, 0x7F, 0x80, 0xFF)


def bytes_of(chance: random.Random, good: bytes) -> bytes:
    """Return random bytes, or valid ones that are truncated, extended or changed in places."""
    kind = chance.randrange(4)
    if kind == 0:
        return chance.randbytes(chance.randrange(LONGEST))
    if kind == 1:
        return good[: chance.randrange(len(good) + 1)]
    if kind == 2:
        return good + chance.randbytes(chance.randrange(64))
    data = bytearray(good)
    for _ in range(chance.randrange(1, 9)):
        if data:
            value = chance.choice((chance.choice(_EDGES), chance.randrange(256)))
            data[chance.randrange(len(data))] = value
    return bytes(data)


def text_of(chance: random.Random, good: str) -> str:
    """Return a valid text with characters replaced, inserted or removed in a few places."""
    characters = list(good)
    for _ in range(chance.randrange(1, 6)):
        place = chance.randrange(len(characters) or 1)
        new = chance.choice(("", "/", "%", ",", ":", "-1", "9" * 30, chr(chance.randrange(0x3000))))
        characters[place : place + chance.randrange(3)] = [new]
    return "".join(characters)
