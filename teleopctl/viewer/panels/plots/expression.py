"""Expressions of plotted fields, such as ``/a/position[0] - /b/position[0]`` or ``d(/a/data)``.

Expressions are typed by users, perhaps on another machine: they are parsed with Python's grammar,
and only arithmetic and the functions of `FUNCTIONS` are evaluated, on arrays.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl.base.printable import shortened
from teleopctl.errors import TeleopctlError, similar_names

if TYPE_CHECKING:
    from teleopctl.viewer.panels.plots.series import Floats, Samples

_LONGEST_TEXT = 1000
_FIELD = re.compile(r"/[A-Za-z_]\w*(?:\[\d+\])?(?:/[A-Za-z_]\w*(?:\[\d+\])?)*")
_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: np.divide,
    ast.Mod: np.mod,
    ast.Pow: np.float_power,
}


def _derivative(times: Floats, values: Floats) -> Floats:
    """Return the derivative over time in 1/s, by central differences; NaN for a single sample."""
    if len(times) < 2:
        return np.full(len(times), np.nan)
    return np.gradient(values, times)


def _integral(times: Floats, values: Floats) -> Floats:
    """Return the integral over time since the first sample, by trapezoids."""
    steps = np.diff(times) * (values[1:] + values[:-1]) / 2
    return np.concatenate([np.zeros(min(len(times), 1)), np.cumsum(np.nan_to_num(steps))])


FUNCTIONS: dict[str, tuple[int, Callable[..., Any]]] = {
    "abs": (1, np.abs),
    "atan2": (2, np.arctan2),
    "cos": (1, np.cos),
    "d": (1, _derivative),
    "deg": (1, np.degrees),
    "exp": (1, np.exp),
    "hypot": (2, np.hypot),
    "integral": (1, _integral),
    "log": (1, np.log),
    "max": (2, np.maximum),
    "min": (2, np.minimum),
    "rad": (1, np.radians),
    "sin": (1, np.sin),
    "sqrt": (1, np.sqrt),
    "tan": (1, np.tan),
    "unwrap": (1, np.unwrap),
}
"""Functions of expressions: number of arguments, and the function on arrays."""

_OF_TIME = {"d", "integral"}
_CONSTANTS = {"pi": np.pi}


class PlotExpressionError(TeleopctlError):
    """Error: a plotted expression cannot be read; the text has the expression."""


class PlotExpression:
    """Expression of fields, evaluated on arrays of samples at common times.

    Args:
        text: The expression, with fields in rqt_plot's spelling: ``/topic/field/sub[3]``. A field
            extends as far as it can: a division needs a space behind its slash.

    Attributes:
        text: See the argument.
        fields: The fields of the expression, in order of their first use.

    Raises:
        PlotExpressionError: The text is no expression, or has no field.
    """

    def __init__(self, text: str) -> None:
        self.text = text.strip()
        if len(self.text) > _LONGEST_TEXT:
            raise PlotExpressionError(f"The expression is longer than {_LONGEST_TEXT} characters")
        found: dict[str, None] = {}
        words: list[str] = []
        place = 0
        # A slash divides behind an operand, and begins a field anywhere else.
        while place < len(self.text):
            field = _FIELD.match(self.text, place)
            before = "".join(words).rstrip()[-1:]
            if field and not (before.isalnum() or before in (")", "_", ".")):
                found.setdefault(field[0])
                words.append(f"_{list(found).index(field[0])}")
                place = field.end()
            else:
                words.append(self.text[place])
                place += 1
        self.fields = tuple(found)
        try:
            self._tree = ast.parse("".join(words), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise self._fault("is no expression") from None
        if not self.fields:
            raise self._fault("has no field such as /joint_states/position[0]")
        self.evaluate(np.zeros(2), {name: np.zeros(2) for name in self.fields})

    def _fault(self, what: str) -> PlotExpressionError:
        return PlotExpressionError(f"{shortened(self.text)} {what}")

    @property
    def is_field(self) -> bool:
        """Whether the expression is one field alone."""
        return self.fields == (self.text,)

    def evaluate(self, times: Floats, values: Mapping[str, Floats]) -> Floats:
        """Return the values of the expression.

        Args:
            times: Times in seconds, shape (n,).
            values: Values of each field at these times, each of shape (n,).

        Returns:
            Values, shape (n,); NaN where they are not defined.

        Raises:
            PlotExpressionError: A name, operator or function is unknown.
        """
        fields = [values[name] for name in self.fields]

        def value_of(node: ast.expr) -> Any:
            if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
                return float(node.value)
            if isinstance(node, ast.Name):
                if re.fullmatch(r"_\d+", node.id):
                    return fields[int(node.id[1:])]
                if node.id in _CONSTANTS:
                    return _CONSTANTS[node.id]
                raise self._fault(f"has the unknown name {node.id}{_guess(node.id)}")
            if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
                return _BINARY[type(node.op)](value_of(node.left), value_of(node.right))
            if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
                value = value_of(node.operand)
                return -value if isinstance(node.op, ast.USub) else value
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                return call(node.func.id, node)
            raise self._fault("has more than numbers, fields, + - * / % ** and functions")

        def call(name: str, node: ast.Call) -> Any:
            if name not in FUNCTIONS:
                raise self._fault(f"has the unknown function {name}{_guess(name)}")
            count, function = FUNCTIONS[name]
            if len(node.args) != count or node.keywords:
                raise self._fault(f"gives {name} not {count} argument{'s' * (count > 1)}")
            arguments = [np.broadcast_to(value_of(one), times.shape) for one in node.args]
            return function(times, *arguments) if name in _OF_TIME else function(*arguments)

        try:
            with np.errstate(all="ignore"):
                result = np.broadcast_to(value_of(self._tree), times.shape)
                return np.asarray(result, dtype=np.float64)
        except (OverflowError, RecursionError) as error:
            raise self._fault(f"cannot be evaluated: {error}") from error


def _guess(name: str) -> str:
    near = similar_names(name, [*FUNCTIONS, *_CONSTANTS], 1)
    return f"; did you mean {near[0]}?" if near else f"; functions are {', '.join(FUNCTIONS)}"


def topic_and_path(field: str, topics: Iterable[str]) -> tuple[str, str] | None:
    """Return topic and field path of a field in rqt_plot's spelling; None for an unknown topic.

    Args:
        field: The field, such as ``/joint_states/position[0]``.
        topics: Names of the topics that there are; the longest that fits is taken.
    """
    fitting = [topic for topic in topics if field.startswith(f"{topic}/")]
    if not fitting:
        return None
    topic = max(fitting, key=len)
    return topic, field[len(topic) + 1 :].replace("/", ".")


class DerivedSamples:
    """Samples of an expression, evaluated when they are drawn, at all times of its fields.

    Args:
        expression: The expression.
        inputs: Samples of each of its fields, in their order.
    """

    def __init__(self, expression: PlotExpression, inputs: Sequence[Samples]) -> None:
        self._expression, self._inputs = expression, inputs

    @property
    def added(self) -> int:
        """Counter that rises with each change."""
        return sum(one.added for one in self._inputs)

    @property
    def last_s(self) -> float | None:
        """Time in seconds up to which all fields have samples; None if one has none."""
        ends = [one.last_s for one in self._inputs]
        return None if None in ends else min(end for end in ends if end is not None)

    @property
    def first_s(self) -> float | None:
        """Time in seconds from which all fields have samples; None if one has none."""
        starts = [one.first_s for one in self._inputs]
        return None if None in starts else max(start for start in starts if start is not None)

    def between(self, start_s: float, end_s: float) -> tuple[Floats, Floats]:
        """Return times and values in a time window, with the last sample before its start."""
        # With the samples behind the end, between which values are interpolated up to it.
        windows = [one.between(start_s, np.inf) for one in self._inputs]
        first = max((times[0] for times, _ in windows if len(times)), default=np.inf)
        last = min((times[-1] for times, _ in windows if len(times)), default=-np.inf)
        if any(len(times) == 0 for times, _ in windows) or first > last:
            return np.empty(0), np.empty(0)
        times = np.unique(np.concatenate([times for times, _ in windows]))
        times = times[(times >= first) & (times <= min(last, end_s))]
        fields = zip(self._expression.fields, windows, strict=True)
        values = {name: np.interp(times, *window) for name, window in fields}
        return times, self._expression.evaluate(times, values)
