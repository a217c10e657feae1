"""The vertical axis of a plot: its range, and ticks whose labels differ.

A plot that always enlarges its data to its full height draws the rounding of a computation as
chatter. Data that does not change by more than a floor is flat, and drawn as a flat line. The floor
depends on the data's magnitude, as matplotlib's (so rqt_plot's) ``nonsingular`` has it:

    floor = max(1e-9, 1e-10 max|v|)

1e-9 is a nanometre or a nanoradian, which no sensor of a robot tells from the next; a joint that a
simulation holds moves by 1e-13. 1e-10 is half a millimetre of a UTM coordinate; rounding of
doubles is a hundred thousand times smaller.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal

_ABSOLUTE_FLOOR = 1e-9
_RELATIVE_FLOOR = 1e-10
# Above and below flat data, of its magnitude. Zero has none, and is drawn between -1 and 1.
_FLAT_ROOM = 0.1
_LEAST_FLAT_ROOM = 1e3 * _ABSOLUTE_FLOOR
# An axis is kept while its data takes at least this share of it, so that it does not jump about.
_KEPT_SHARE = 0.2
# Longer labels than this do not fit beside a plot of the page.
_LONGEST_LABEL = 7
# Differences of larger numbers are infinite.
_LARGEST = 4e307


@dataclass(frozen=True)
class VerticalAxis:
    """Range and ticks of a vertical axis.

    A tick stands at ``base + factor * label``; the title names base and factor, as matplotlib's
    offset text does.

    Attributes:
        low: The lower end of the range.
        high: The upper end.
        ticks: Where ticks stand, ascending.
        labels: What is written beside each of them; all differ.
        title: Factor and base of the labels, such as ``x1e-6 + 1.2``; empty for 1 and 0.
        is_flat: Whether the data changes by less than the floor.
        step: The distance of two ticks.
    """

    low: float
    high: float
    ticks: tuple[float, ...]
    labels: tuple[str, ...]
    title: str
    is_flat: bool
    step: float

    def suits(self, low: float, high: float) -> bool:
        """Return whether data between two values may be drawn on this axis as well."""
        inside = self.low <= low and high <= self.high
        large = high - low >= _KEPT_SHARE * (self.high - self.low)
        return inside and self.is_flat == _is_flat(low, high) and (self.is_flat or large)


def vertical_axis(low: float, high: float, most_steps: int = 4) -> VerticalAxis:
    """Return an axis for data between two values.

    Args:
        low: The least value.
        high: The greatest value, not below ``low``.
        most_steps: How many steps of the ticks the data spans at most.
    """
    low, high = max(low, -_LARGEST), min(high, _LARGEST)
    is_flat = _is_flat(low, high)
    if is_flat:
        magnitude = max(abs(low), abs(high))
        room = max(_FLAT_ROOM * magnitude, _LEAST_FLAT_ROOM)
        low, high = (low - room, high + room) if magnitude > _ABSOLUTE_FLOOR else (-1.0, 1.0)
    step, factor, exponent = _step((high - low) / most_steps)
    # A quotient may be rounded to the wrong side: the range has to contain the data.
    first, last = math.floor(low / step), math.ceil(high / step)
    numbers = range(first - (first * step > low), last + (last * step < high) + 1)
    values = [Decimal(number * factor).scaleb(exponent) for number in numbers]
    labels, title = _labels(values, exponent)
    ticks = tuple(map(float, values))
    return VerticalAxis(ticks[0], ticks[-1], ticks, labels, title, is_flat, step)


def _is_flat(low: float, high: float) -> bool:
    floor = max(_ABSOLUTE_FLOOR, _RELATIVE_FLOOR * max(abs(low), abs(high)))
    return high - low <= floor


def _step(rough: float) -> tuple[float, int, int]:
    """Return a round number not below another one: itself, and the a and b of a * 10^b."""
    exponent = math.floor(math.log10(rough))
    power = float(f"1e{exponent}")
    for factor in (1, 2, 5):
        if factor * power >= rough * (1.0 - 1e-9):
            return factor * power, factor, exponent
    return float(f"1e{exponent + 1}"), 1, exponent + 1


def _labels(values: list[Decimal], exponent: int) -> tuple[tuple[str, ...], str]:
    """Return what is written beside ticks, and the title that says how to read it."""
    plain = tuple(f"{value:.{max(0, -exponent)}f}" for value in values)
    if max(map(len, plain)) <= _LONGEST_LABEL:
        return plain, ""
    base = Decimal(0)
    scaled = _in_units(values, base, exponent)
    if max(map(len, scaled)) > _LONGEST_LABEL:
        base = values[len(values) // 2]
        scaled = _in_units(values, base, exponent)
    terms = [f"x1e{exponent}"] * (exponent != 0) + [f"+ {_text(base)}"] * bool(base)
    return scaled, " ".join(terms)


def _in_units(values: list[Decimal], base: Decimal, exponent: int) -> tuple[str, ...]:
    return tuple(f"{(value - base).scaleb(-exponent):.0f}" for value in values)


def _text(value: Decimal) -> str:
    """Return a number without zeros at its end, with all its digits."""
    short = f"{value.normalize():f}"
    return short if len(short) <= 20 else f"{value.normalize():e}"
