"""Compares states, number by number."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from teleopctl.interfaces import to_seconds

if TYPE_CHECKING:
    from sensor_msgs.msg import JointState

_FIELDS = ("position", "velocity", "effort")


class Difference(NamedTuple):
    """One number that is another one than was recorded.

    Attributes:
        time_ns: Simulated time of the state, in nanoseconds.
        joint: Name of the joint.
        field: ``position`` (rad or m), ``velocity`` (rad/s or m/s) or ``effort`` (N m or N).
        recorded: As the bag has it; NaN where it has none.
        replayed: As it is now; NaN where there is none.
    """

    time_ns: int
    joint: str
    field: str
    recorded: float
    replayed: float

    @property
    def size(self) -> float:
        """How far apart they are; infinite where only one of them is a number."""
        distance = abs(self.recorded - self.replayed)
        return math.inf if math.isnan(distance) else distance

    def __str__(self) -> str:
        """Say it in a line."""
        return (
            f"{to_seconds(self.time_ns):.3f} s: {self.joint} {self.field} was {self.recorded!r} "
            f"and is {self.replayed!r} ({self.size:.3g} apart)"
        )


@dataclass
class Verdict:
    """How a replayed session compares with the recording.

    Attributes:
        tolerance: What two numbers may be apart; 0 asks for the same bits.
        states: How many states were compared.
        end_ns: Simulated time of the last one, in nanoseconds.
        first: What differed at the first time at which anything did, each joint and field.
        largest: The largest difference of each joint and field that differed.
    """

    tolerance: float = 0.0
    states: int = 0
    end_ns: int = 0
    first: list[Difference] = field(default_factory=list)
    largest: dict[tuple[str, str], Difference] = field(default_factory=dict)

    @property
    def is_same(self) -> bool:
        """Whether nothing differed."""
        return not self.first

    def compare(self, time_ns: int, recorded: JointState, replayed: JointState) -> None:
        """Compare the state of a time.

        Args:
            time_ns: Its simulated time, in nanoseconds.
            recorded: As the bag has it.
            replayed: As it is now; the order of its joints may be another one.
        """
        self.states += 1
        self.end_ns = max(self.end_ns, time_ns)
        found = [
            difference
            for difference in differences(time_ns, recorded, replayed)
            if not _same(difference.recorded, difference.replayed)
            and not difference.size <= self.tolerance
        ]
        if found and not self.first:
            self.first = found
        for difference in found:
            key = (difference.joint, difference.field)
            if key not in self.largest or difference.size > self.largest[key].size:
                self.largest[key] = difference


def differences(time_ns: int, recorded: JointState, replayed: JointState) -> Iterator[Difference]:
    """Yield every pair of numbers of two states, equal ones too."""
    names = dict.fromkeys([*recorded.name, *replayed.name])
    for field_ in _FIELDS:
        before, now = _by_name(recorded, field_), _by_name(replayed, field_)
        for name in names:
            if name in before or name in now:
                yield Difference(
                    time_ns, name, field_, before.get(name, math.nan), now.get(name, math.nan)
                )


def _by_name(state: JointState, field_: str) -> dict[str, float]:
    values: Sequence[float] = getattr(state, field_)
    return dict(zip(state.name, map(float, values), strict=False))


def _same(one: float, other: float) -> bool:
    """Whether two numbers have the same bits, as also the two zeros have not."""
    return struct.pack("<d", one) == struct.pack("<d", other)
