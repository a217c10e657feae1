"""Measures of a run: one number computed from a field in the run's bag."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from numbers import Real
from pathlib import Path
from typing import NamedTuple

from teleopctl.bag import Decoder, open_bag, parse_field
from teleopctl.errors import InvalidMessageError, UsageError
from teleopctl.interfaces import field_reader

_FORM = re.compile(r"(?P<field>/[^:]+?)(?::(?P<how>[a-z]+))?")

_HOW: dict[str, Callable[[list[float]], float]] = {
    "last": lambda values: values[-1],
    "first": lambda values: values[0],
    "min": min,
    "max": max,
    "absmax": lambda values: max(map(abs, values)),
    "mean": lambda values: math.fsum(values) / len(values),
    "rms": lambda values: math.sqrt(math.fsum(v * v for v in values) / len(values)),
    "range": lambda values: max(values) - min(values),
    "count": lambda values: float(len(values)),
}


class Measure(NamedTuple):
    """Number to compute for a run: a field of a topic, and a statistic of the field's values.

    Attributes:
        field: Topic and field, ``/joint_states/position[0]``.
        statistic: Statistic of the values, such as ``max``.
    """

    field: str
    statistic: str

    @property
    def name(self) -> str:
        """Name of the measure in tables: ``FIELD:STATISTIC``."""
        return f"{self.field}:{self.statistic}"


def parse_measure(text: str) -> Measure:
    """Return the `Measure` for a text such as ``/joint_states/position[0]:max``; default ``:last``.

    Raises:
        UsageError: The text does not have that form, or the statistic is unknown.
    """
    match = _FORM.fullmatch(text)
    how = (match["how"] or "last") if match else ""
    if match is None or how not in _HOW:
        raise UsageError(
            f"'{text}' is no measure",
            hint=f"Such as /joint_states/position[0]:max; there are {', '.join(_HOW)}.",
        )
    return Measure(match["field"], how)


def measure_bag(bag: Path, measure: Measure) -> float:
    """Return a measure's number: its statistic over all values of its field in a run's bag.

    Raises:
        NotFoundError: The bag, or the topic in the bag, does not exist.
        InvalidMessageError: The topic has no messages, or the number is not finite.
    """
    with open_bag(bag) as opened:
        field = parse_field(measure.field, [topic.name for topic, _ in opened.metadata.topics])
        decoder = Decoder(opened, [field.topic])
        read = field_reader(field.path)
        values = [_number(field.full_name, read(each.message)) for each in decoder.messages()]
    if not values:
        raise InvalidMessageError(f"The bag has no message of {field.topic}")
    number = _HOW[measure.statistic](values)
    if not math.isfinite(number):
        raise InvalidMessageError(f"{measure.name} is {number}")
    return number


def _number(name: str, value: object) -> float:
    # Real includes numpy's numbers.
    if isinstance(value, Real):
        return float(value)
    raise InvalidMessageError(f"{name} is not a number but {type(value).__name__}")
