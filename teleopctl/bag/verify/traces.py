"""Messages as they were and as they are, for a picture of a field that differs."""

from __future__ import annotations

import math
from collections import defaultdict

from teleopctl.bag.look.curves import Curve
from teleopctl.bag.verify.comparison import Difference, leaves
from teleopctl.interfaces import deserialize, get_message, to_seconds


class ComparedTraces:
    """Stores the compared messages, for plots."""

    def __init__(self) -> None:
        self._types: dict[str, str] = {}
        self._pairs: dict[str, list[tuple[int, bytes, bytes]]] = defaultdict(list)

    def note(self, topic: str, type_name: str, time_ns: int, recorded: bytes, now: bytes) -> None:
        """Store the CDR of a recorded and a replayed message of a time in nanoseconds."""
        self._types[topic] = type_name
        self._pairs[topic].append((time_ns, recorded, now))

    def curves(self, difference: Difference) -> list[Curve]:
        """Return the recorded and the replayed curve of a field, over simulated seconds.

        Where it is no number, a curve has gaps.
        """
        name = f"{difference.topic} {difference.field}"
        message_class = get_message(self._types[difference.topic])
        curves = []
        pairs = self._pairs[difference.topic]
        for title, messages in (
            (f"{name}, recorded", [recorded for _, recorded, _ in pairs]),
            (f"{name}, now", [now for _, _, now in pairs]),
        ):
            values = [
                dict(leaves(deserialize(data, message_class))).get(difference.field)
                for data in messages
            ]
            curves.append(
                Curve(
                    title,
                    [to_seconds(pair[0]) for pair in pairs],
                    [float(v) if isinstance(v, int | float) else math.nan for v in values],
                )
            )
        return curves
