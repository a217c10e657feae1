"""Parameters of the runs of a sweep: grids, and samples of distributions."""

from __future__ import annotations

import itertools
import math
import random
import re
from collections.abc import Callable, Sequence
from typing import NamedTuple

from teleopctl.errors import UsageError

_CALL = re.compile(r"(?P<name>[a-z_]+)\((?P<values>.*)\)")
# More runs than this are taken to be a typing error.
_MOST_RUNS = 1_000_000


class GridParameter(NamedTuple):
    """Launch argument or node parameter of a sweep that takes each of a list of values.

    Attributes:
        name: Launch argument, or ``node:parameter``.
        values: Values as texts.
    """

    name: str
    values: tuple[str, ...]


class RandomParameter(NamedTuple):
    """Launch argument or node parameter of a sweep, drawn from a distribution for each run.

    Attributes:
        name: Launch argument, or ``node:parameter``.
        distribution: Distribution as on the command line, such as ``uniform(0.2,1)``.
        draw: Called with the random number generator; returns a value as text.
    """

    name: str
    distribution: str
    draw: Callable[[random.Random], str]


def parse_grid(text: str) -> GridParameter:
    """Return the `GridParameter` for a text: ``mass:=0.5,1,2`` or ``mass:=linspace(0,1,5)``.

    Raises:
        UsageError: The text does not have one of these forms.
    """
    name, value = _split(text, "--grid mass:=0.5,1,2")
    call = _CALL.fullmatch(value)
    if call is None or call["name"] != "linspace":
        return GridParameter(name, tuple(_elements(value)))
    first, last, count = _numbers(text, call["values"], 3)
    if not (count.is_integer() and 2 <= count <= _MOST_RUNS):
        raise UsageError(f"'{text}': linspace takes the first and the last value and how many")
    steps = int(count) - 1
    return GridParameter(
        name,
        tuple(_text(first + (last - first) * step / steps, 12) for step in range(steps + 1)),
    )


def parse_sample(text: str) -> RandomParameter:
    """Return the `RandomParameter` for a text such as ``friction:=uniform(0.2,1)``.

    Raises:
        UsageError: The text does not have that form, or names an unknown distribution.
    """
    name, value = _split(text, "--sample friction:=uniform(0.2,1)")
    call = _CALL.fullmatch(value)
    if call is not None and call["name"] == "choice":
        values = _elements(call["values"])
        return RandomParameter(name, value, lambda source: source.choice(values))
    if call is None or call["name"] not in _DISTRIBUTIONS:
        known = ", ".join((*_DISTRIBUTIONS, "choice"))
        raise UsageError(f"'{text}': '{value}' is no distribution", hint=f"There are {known}.")
    first, second = _numbers(text, call["values"], 2)
    is_valid, draw = _DISTRIBUTIONS[call["name"]]
    if not is_valid(first, second):
        raise UsageError(f"'{text}': {call['name']} cannot have these values")
    return RandomParameter(name, value, lambda source: draw(source, first, second))


def combinations(
    grids: Sequence[GridParameter], samples: Sequence[RandomParameter], runs: int, seed: int
) -> list[dict[str, str]]:
    """Return the parameters of all runs: each grid combination with the same random draws.

    All combinations use the same draws, so that they can be compared. Each sampled parameter has
    its own random number generator: adding another parameter does not change its values.

    Raises:
        UsageError: A parameter is varied twice, or there are too many runs.
    """
    names = [*(grid.name for grid in grids), *(sample.name for sample in samples)]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise UsageError(f"'{twice}' is varied twice")
    if math.prod(len(grid.values) for grid in grids) * runs > _MOST_RUNS:
        raise UsageError(f"More than {_MOST_RUNS} runs")
    sources = {
        sample.name: random.Random(f"{seed}/{sample.name}")  # noqa: S311 -- no secret
        for sample in samples
    }
    draws = [
        {sample.name: sample.draw(sources[sample.name]) for sample in samples} for _ in range(runs)
    ]
    cells = itertools.product(*(grid.values for grid in grids))
    return [
        dict(zip((grid.name for grid in grids), cell, strict=True)) | draw
        for cell in cells
        for draw in draws
    ]


_DISTRIBUTIONS: dict[
    str,
    tuple[Callable[[float, float], bool], Callable[[random.Random, float, float], str]],
] = {
    "uniform": (
        lambda low, high: low <= high,
        lambda source, low, high: _text(source.uniform(low, high)),
    ),
    "loguniform": (
        lambda low, high: 0.0 < low <= high,
        lambda source, low, high: _text(math.exp(source.uniform(math.log(low), math.log(high)))),
    ),
    "normal": (
        lambda _, deviation: deviation >= 0.0,
        lambda source, mean, deviation: _text(source.gauss(mean, deviation)),
    ),
    "integers": (
        lambda low, high: low.is_integer() and high.is_integer() and low <= high,
        lambda source, low, high: str(source.randint(int(low), int(high))),
    ),
}


def _split(text: str, example: str) -> tuple[str, str]:
    name, separator, value = text.partition(":=")
    if not (name and separator and value):
        raise UsageError(
            f"'{text}' does not have the form name:=values", hint=f"Such as {example}."
        )
    return name, value


def _elements(text: str) -> list[str]:
    """Split at commas outside of brackets."""
    elements, depth = [""], 0
    for character in text:
        if character == "," and depth == 0:
            elements.append("")
            continue
        depth += (character in "[{(") - (character in "]})")
        elements[-1] += character
    return [element.strip() for element in elements]


def _numbers(text: str, values: str, count: int) -> list[float]:
    try:
        numbers = [float(value) for value in values.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise UsageError(f"'{text}': expected {count} numbers in the brackets")
    return numbers


def _text(number: float, digits: int = 6) -> str:
    """Return a number as text with six significant digits, or ``digits`` if six are imprecise.

    Six digits distinguish random values, but not 1000000 from 1000000.5.

    The text contains a decimal point, so that YAML does not read an integer.
    """
    text = f"{number:.6g}"
    if not math.isclose(float(text), number, rel_tol=10.0**-digits):
        text = f"{number:.{digits}g}"
    if "e" in text:
        mantissa, _, exponent = text.partition("e")
        return f"{mantissa if '.' in mantissa else mantissa + '.0'}e{exponent}"
    return text if "." in text else f"{text}.0"
