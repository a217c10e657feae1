"""Evaluation of the Python expressions in xacro files, with limits on size and time.

The content of ``${…}`` and ``$(eval …)`` is evaluated by Python itself, where one operation can
keep the machine busy for ever: ``9**9**9**9`` cannot even be interrupted. So operations whose
result would be too large are refused beforehand, all others work on small values, and the time is
checked between them. This protects against mistakes and simple traps: untrusted files need safe
mode, which has no Python.
"""

from __future__ import annotations

import ast
import builtins
import math
import re
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache, reduce
from types import CodeType
from typing import Any

from teleopctl.base import budget
from teleopctl.base.budget import BudgetError
from teleopctl.base.expression import ExpressionError

_LOOKS_EVERY = 64

# Functions whose result is as large as a number among their arguments.
_SIZED = frozenset(
    (
        *("bytearray", "bytes", "to_bytes", "comb", "factorial", "perm"),
        *("center", "expandtabs", "ljust", "rjust", "zfill"),
    )
)
_LARGEST_SIZE = 10_000
# A width in a format with six digits, or one that is taken from an argument.
_WIDE = re.compile(r"\d{6}|%[^A-Za-z%]*\*|[:.][^{}]*\{")
# Names, attributes, sums and quotients are only as large as the text; most expressions have nothing
# else, and compiling one with guards takes three times as long.
_PLAIN = re.compile(r"(?!.*\b(?:for|lambda)\b)[\w\s.,'\"\[\]+/-]*", re.DOTALL)
# Python's functions that evaluate code or wait for input.
_NEVER = ("breakpoint", "compile", "eval", "exec", "input")

_OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "add",
    ast.LShift: "shift",
    ast.Mod: "remainder",
    ast.Mult: "multiply",
    ast.Pow: "power",
}


# Any, here and below: values of expressions have any type.
class BoundedPython:
    """Evaluator of the Python expressions in xacro files, with limits on size and time."""

    def __init__(self) -> None:
        self._operations = 0
        self._made = 0
        self._ends_s = time.thread_time() + budget.LONGEST_EXPRESSIONS_S
        guards: dict[str, Callable[..., Any]] = {
            "add": self._add,
            "shift": self._shift,
            "remainder": self._remainder,
            "multiply": self._multiply,
            "power": self._power,
            "call": self._call,
            "each": self._each,
            "format": self._format,
            "made": self._noted,
        }
        self._guards = {_hidden(name): guard for name, guard in guards.items()}
        known = {name: value for name, value in vars(builtins).items() if name not in _NEVER}
        self._builtins = {**known, "pow": self._pow, **self._guards}

    def safe_eval(self, text: str, names: dict[str, Any], local: Any = None) -> Any:
        """Return the value of the expression in a ``${…}``; replaces xacro's ``safe_eval``.

        Raises:
            BudgetError: The evaluation takes too long, or a value is too large.
        """
        names.update(__builtins__=self._guards)
        return self._evaluate(_compiled(text.strip(), inner=False), names, local)

    def eval(self, text: str, names: dict[str, Any], local: Any = None) -> Any:
        """Return the value of the expression in a ``$(eval …)``; replaces Python's ``eval``.

        Raises:
            BudgetError: The evaluation takes too long, or a value is too large.
        """
        names.update(__builtins__=self._builtins)
        try:
            return self._evaluate(_compiled(text.strip(), inner=True), names, local)
        except (BudgetError, ExpressionError) as error:
            # xacro adds this text only for ${…}.
            raise type(error)(f"{error}\nwhen evaluating expression '{text}'") from error

    def _evaluate(self, code: CodeType, names: dict[str, Any], local: Any) -> Any:
        try:
            value = eval(code, names, local)  # noqa: S307 - that is what xacro files are
        except RecursionError as error:
            if any(isinstance(part, CodeType) for part in code.co_consts):
                raise BudgetError("a function of it recurses without end") from error
            raise  # the recursion is in files or macros
        _size(value)
        return value

    # -- guarded operations ------------------------------------------------------------------------

    def _note(self) -> None:
        """Count an operation, and check the time after every `_LOOKS_EVERY` operations."""
        self._operations += 1
        if self._operations > budget.MOST_OPERATIONS:
            raise BudgetError(f"it takes more than {budget.MOST_OPERATIONS:,} operations")
        if self._operations % _LOOKS_EVERY == 0 and time.thread_time() > self._ends_s:
            raise BudgetError(
                f"the file's expressions take more than {budget.LONGEST_EXPRESSIONS_S:g} s"
            )

    def _noted(self, value: Any) -> Any:
        """Count an operation and the size of its result; return the result."""
        self._note()
        self._made += _size(value)
        if self._made > budget.MOST_MADE:
            raise BudgetError(f"the file's expressions make more than {budget.MOST_MADE:,} parts")
        return value

    def _add(self, left: Any, right: Any) -> Any:
        return self._noted(left + right)

    def _multiply(self, left: Any, right: Any) -> Any:
        for many, few in ((left, right), (right, left)):
            if isinstance(few, int) and not isinstance(many, int | float | complex):
                _limit(_size(many) * max(0, few))
        return self._noted(left * right)

    def _power(self, left: Any, right: Any) -> Any:
        if isinstance(left, int) and isinstance(right, int) and abs(left) > 1:
            _limit_bits(left.bit_length() * right)
        return self._noted(left**right)

    def _pow(self, left: Any, right: Any, modulus: Any = None) -> Any:
        return self._power(left, right) if modulus is None else pow(left, right, modulus)

    def _shift(self, left: Any, right: Any) -> Any:
        if isinstance(left, int) and isinstance(right, int):
            _limit_bits(left.bit_length() + right)
        return self._noted(left << right)

    def _remainder(self, left: Any, right: Any) -> Any:
        if isinstance(left, str | bytes):
            _check_format(left)
        return self._noted(left % right)

    def _format(self, value: Any, spec: str) -> str:
        _check_format(spec)
        return str(self._noted(format(value, spec)))

    def _each(self, values: Iterable[Any]) -> Iterator[Any]:
        for value in values:
            self._note()
            yield value

    def _call(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Any:
        self._note()
        name = getattr(function, "__name__", "")
        if name in _SIZED and any(isinstance(a, int) and a > _LARGEST_SIZE for a in args):
            raise BudgetError(f"{name} takes no number beyond {_LARGEST_SIZE}")
        of = getattr(function, "__self__", None)
        if isinstance(of, str | bytes):
            if name in ("format", "format_map"):
                _check_format(of)
            if name == "join" and args:
                args = (list(args[0]), *args[1:])
                _limit(len(of) * len(args[0]) + sum(map(_size, args[0])))
            if name in ("replace", "translate"):
                _limit((len(of) + 1) * max(map(_size, args), default=0))
        elif function is format and len(args) > 1:
            return self._format(*args)
        elif function in (sum, math.prod, math.lcm):
            return self._fold(function, args, kwargs)
        return self._noted(function(*args, **kwargs))

    def _fold(
        self, function: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]
    ) -> Any:
        """Sum, multiply or take the least common multiple of values, one after another.

        Python's own functions copy the intermediate result for each list or large number, so that
        their time grows with the square of the size of the arguments.
        """
        if function is math.lcm:
            return reduce(lambda left, right: self._noted(math.lcm(left, right)), args, 1)
        is_sum = function is sum
        start = kwargs.get("start", args[1] if is_sum and len(args) > 1 else 0 if is_sum else 1)
        if not args or (is_sum and isinstance(start, int | float | str)):
            return self._noted(function(*args, **kwargs))
        return reduce(self._add if is_sum else self._multiply, args[0], start)


class _Guarding(ast.NodeTransformer):
    """AST transformer that replaces operations of an expression by calls of the guards above."""

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        self.generic_visit(node)
        name = _OPERATORS.get(type(node.op))
        return node if name is None else _call_of(name, node.left, node.right)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        self.generic_visit(node)
        return _call_of("call", node.func, *node.args, keywords=node.keywords)

    def visit_comprehension(self, node: ast.comprehension) -> ast.comprehension:
        self.generic_visit(node)
        node.iter = _call_of("each", node.iter)
        return node

    def visit_Lambda(self, node: ast.Lambda) -> ast.Lambda:
        self.generic_visit(node)
        node.body = _call_of("made", node.body)
        return node

    def visit_FormattedValue(self, node: ast.FormattedValue) -> ast.FormattedValue:
        self.generic_visit(node)
        if node.format_spec is not None and node.conversion == -1:
            return ast.FormattedValue(_call_of("format", node.value, node.format_spec), -1, None)
        return node


def _hidden(name: str) -> str:
    """Return a name that no expression can contain."""
    return f" {name}"


def _call_of(name: str, *args: ast.expr, keywords: list[ast.keyword] | None = None) -> ast.Call:
    return ast.Call(ast.Name(_hidden(name), ast.Load()), list(args), keywords or [])


@lru_cache(maxsize=8192)
def _compiled(text: str, *, inner: bool) -> CodeType:
    """Return the guarded code of an expression; unless ``inner``, names must not start with __."""
    code = compile(text, "<expression>", "eval")
    if not inner and (names := [name for name in code.co_names if name.startswith("__")]):
        # The message is xacro's.
        raise ExpressionError(f"Use of invalid name(s): {', '.join(names)}")
    if _PLAIN.fullmatch(text):
        return code
    tree = ast.fix_missing_locations(_Guarding().visit(ast.parse(text, mode="eval")))
    return compile(tree, "<expression>", "eval")


def _size(value: Any) -> int:
    """Return the number of characters or parts of a value; raise if the limit is exceeded.

    Raises:
        BudgetError: The value is too large.
    """
    if isinstance(value, int):
        _limit_bits(value.bit_length())
        return _size_of_integer(value)
    if not isinstance(value, str | bytes | list | tuple | set | frozenset | range | Mapping):
        return 1
    count, left = 0, [value]
    while left:
        one = left.pop()
        count += 1
        if isinstance(one, range):
            count += max(0, (one.stop - one.start) // one.step)
        elif isinstance(one, str | bytes):
            count += len(one)
        elif isinstance(one, int):
            count += _size_of_integer(one) - 1
        elif isinstance(one, list | tuple | set | frozenset | Mapping):
            left.extend(one.values() if isinstance(one, Mapping) else one)
        _limit(count + len(left))
    return count


def _size_of_integer(value: int) -> int:
    """Return the number of parts that an integer counts as: one, plus one for each 64 bits."""
    return 1 + value.bit_length() // 64


def _limit(size: int) -> None:
    if size > budget.LONGEST_TEXT:
        raise BudgetError(f"a text or list would have more than {budget.LONGEST_TEXT:,} parts")


def _limit_bits(bits: int) -> None:
    if bits > budget.LARGEST_INTEGER_BITS:
        raise BudgetError(
            f"a number would have more than {budget.LARGEST_INTEGER_BITS * 3 // 10} digits"
        )


def _check_format(text: str | bytes) -> None:
    if _WIDE.search(text if isinstance(text, str) else text.decode("latin-1")):
        raise BudgetError("a width that is too large or computed is refused")
