"""Detection of held keys on terminals, most of which report no release."""

from __future__ import annotations

from teleopctl.base.keyboard import Key

# A key that is held repeats after 0.25 s to 0.66 s on usual systems, then each 30 ms to 50 ms. The
# first press lasts until the first repeat, so that the motion does not stutter; a repeat lasts for
# three of them, so that the motion ends with the release.
FIRST_HOLD_S = 0.6
REPEAT_HOLD_S = 0.15


class HeldKeys:
    """Keys of a terminal that are held, as far as key repetition shows.

    Where the terminal reports releases, a key is held until then. Elsewhere it is held for a while
    after each press, and a new key ends the one before, since a terminal repeats only the last.
    """

    def __init__(self) -> None:
        self._until: dict[str, float] = {}

    def on_key(self, key: Key, now_s: float) -> None:
        """Process a key event at a time on the monotonic clock, s."""
        if key.is_released:
            self._until.pop(key.name, None)
        elif key.reports_release:
            self._until[key.name] = float("inf")
        else:
            is_repeat = self._until.get(key.name, -1.0) > now_s
            self._until = {key.name: now_s + (REPEAT_HOLD_S if is_repeat else FIRST_HOLD_S)}

    def release_all(self) -> None:
        """Release all keys."""
        self._until.clear()

    def held(self, now_s: float) -> frozenset[str]:
        """Return the names of the keys that are held at a time, s."""
        return frozenset(name for name, until in self._until.items() if until > now_s)
