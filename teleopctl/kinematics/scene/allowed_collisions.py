"""Allowed collision matrix: which pairs of links and objects may touch."""

from __future__ import annotations

from collections.abc import Iterable, Mapping


class AllowedCollisions:
    """Pairs of links and objects that may touch, as MoveIt's allowed collision matrix.

    An entry of a pair counts first. Without one the defaults of its two names count: if both have
    one, both must allow; if none has one, the pair must not touch.

    Args:
        pairs: Pairs that may touch.
    """

    def __init__(self, pairs: Iterable[tuple[str, str]] = ()) -> None:
        self._entries: dict[tuple[str, str], bool] = {}
        self._defaults: dict[str, bool] = {}
        for first, second in pairs:
            self.set(first, second, is_allowed=True)

    def set(self, first: str, second: str, *, is_allowed: bool) -> None:
        """Set whether two links or objects may touch."""
        self._entries[_pair(first, second)] = is_allowed

    def set_default(self, name: str, *, is_allowed: bool) -> None:
        """Set whether a link or object may touch those for which there is no entry."""
        self._defaults[name] = is_allowed

    def is_allowed(self, first: str, second: str) -> bool:
        """Return whether two links or objects may touch."""
        entry = self._entries.get(_pair(first, second))
        if entry is not None:
            return entry
        defaults = [self._defaults[name] for name in (first, second) if name in self._defaults]
        return bool(defaults) and all(defaults)

    def forget(self, name: str) -> None:
        """Remove all entries of a link or object, and its default."""
        self._defaults.pop(name, None)
        for pair in [pair for pair in self._entries if name in pair]:
            del self._entries[pair]

    def copy(self) -> AllowedCollisions:
        """Return a copy."""
        other = AllowedCollisions()
        other._entries, other._defaults = dict(self._entries), dict(self._defaults)
        return other

    @property
    def entries(self) -> Mapping[tuple[str, str], bool]:
        """Whether each pair that has an entry, in alphabetical order, may touch."""
        return self._entries

    @property
    def defaults(self) -> Mapping[str, bool]:
        """Whether each link or object that has a default may touch others."""
        return self._defaults

    @property
    def names(self) -> list[str]:
        """All names that have entries, in alphabetical order."""
        return sorted({name for pair in self._entries for name in pair})


def _pair(first: str, second: str) -> tuple[str, str]:
    return (first, second) if first <= second else (second, first)
