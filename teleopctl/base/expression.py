"""Evaluation of expressions with Python's arithmetic, comparisons and logic only.

Expressions in a launch file (``$(eval …)``) or in an untrusted robot description are data, not
code. They are parsed with Python's own grammar, but only literals, operators and a few functions
are evaluated, on numbers and texts of limited size.
"""

import ast
import math
import operator

from teleopctl.base.budget import LONGEST_TEXT
from teleopctl.base.printable import shortened
from teleopctl.base.typed import Any, Callable, Mapping

_MAX_POWER = 64
_MAX_BASE = 10**9
# In characters. Python's parser is recursive.
_LONGEST_TEXT = 10_000
# Range of a float; larger integers only serve to keep the machine busy.
_LARGEST_INTEGER_BITS = 1024
_MOST_DIGITS = 308
_METHODS: dict[str, Callable[..., Any]] = {
    "get": dict.get,
    "lower": str.lower,
    "split": str.split,
    "strip": str.strip,
    "upper": str.upper,
}
_NAMED = (ast.Name, ast.Attribute)
# Allowed types of a name's value; a mapping is a namespace.
_PLAIN = (bool, int, float, str, list, tuple, Mapping, type(None))

_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
}
_UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Not: operator.not_,
}
_COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda left, right: left in right,
    ast.NotIn: lambda left, right: left not in right,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
}
_NAMES: dict[str, object] = {
    "true": True,
    "false": False,
    "tau": math.tau,
    "pi": math.pi,
    "e": math.e,
    "inf": math.inf,
    "nan": math.nan,
}


def _round(value: float, digits: int | None = None) -> float:
    if digits is not None and abs(digits) > _MOST_DIGITS:
        raise ValueError(f"round takes at most {_MOST_DIGITS} digits")
    return round(value, digits)


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": abs,
    "acos": math.acos,
    "asin": math.asin,
    "atan": math.atan,
    "atan2": math.atan2,
    "bool": bool,
    "ceil": math.ceil,
    "cos": math.cos,
    "float": float,
    "floor": math.floor,
    "hypot": math.hypot,
    "int": int,
    "len": len,
    "max": max,
    "min": min,
    "radians": math.radians,
    "degrees": math.degrees,
    "round": _round,
    "sin": math.sin,
    "sqrt": math.sqrt,
    "str": str,
    "tan": math.tan,
}


class ExpressionError(ValueError):
    """An expression cannot be evaluated; the message names the part and the reason."""


def evaluate(text: str) -> str:
    """Evaluate a restricted Python expression of numbers and texts, and return the result as text.

    Raises:
        ExpressionError: As `compute` raises it.
    """
    return str(compute(text))


def compute(text: str, names: Mapping[str, Any] | None = None) -> Any:  # Any: the result
    """Return the value of a restricted Python expression: number, text, bool, None, list or dict.

    Args:
        text: The expression.
        names: Further names and their values. Functions are not allowed as values.

    Raises:
        ExpressionError: The text is not an expression, uses something other than literals,
            operators and the known functions and names, or its evaluation fails.
    """
    if len(text) > _LONGEST_TEXT:
        raise ExpressionError(f"'{shortened(text)}' has more than {_LONGEST_TEXT} characters")
    try:
        return _Evaluation(names or {}).value(ast.parse(text.strip(), mode="eval").body)
    except ExpressionError:
        raise
    except SyntaxError as error:
        raise ExpressionError(f"'{shortened(text)}' is not an expression: {error.msg}") from error
    except (RecursionError, MemoryError) as error:
        # Python's parser raises MemoryError for too many nested brackets or signs.
        raise ExpressionError("the expression is nested too deeply") from error
    except (ArithmeticError, TypeError, ValueError, LookupError) as error:
        raise ExpressionError(f"'{shortened(text)}' cannot be computed: {error}") from error


class _Evaluation:
    """Evaluates one expression with the names that the expression may use."""

    def __init__(self, names: Mapping[str, Any]) -> None:
        self._names = names

    def value(self, node: ast.expr) -> Any:
        """Evaluate a node of the expression's syntax tree, and return its value."""
        result = self._value(node)
        if isinstance(result, int) and result.bit_length() > _LARGEST_INTEGER_BITS:
            raise ExpressionError(f"integers beyond {_LARGEST_INTEGER_BITS} bits are not computed")
        if isinstance(result, str | list) and len(result) > LONGEST_TEXT:
            raise ExpressionError(f"texts and lists are limited to {LONGEST_TEXT} elements")
        return result

    def _value(self, node: ast.expr) -> Any:
        if isinstance(node, ast.Constant):
            return node.value
        if isinstance(node, ast.Name | ast.Attribute):
            return self._named(node)
        if isinstance(node, ast.List | ast.Tuple):
            return [self.value(item) for item in node.elts]
        if isinstance(node, ast.Dict):
            pairs = zip(node.keys, node.values, strict=True)
            return {self.value(key): self.value(value) for key, value in pairs if key is not None}
        if isinstance(node, ast.UnaryOp) and type(node.op) in _UNARY:
            return _UNARY[type(node.op)](self.value(node.operand))
        if isinstance(node, ast.BinOp):
            return self._binary(node)
        if isinstance(node, ast.BoolOp):
            return self._logic(node)
        if isinstance(node, ast.Compare):
            return self._compare(node)
        if isinstance(node, ast.IfExp):
            return self.value(node.body if self.value(node.test) else node.orelse)
        if isinstance(node, ast.Subscript):
            return self._element(node)
        if isinstance(node, ast.Call) and _function_name(node.func) == "dict" and not node.args:
            # xacro files write dict(…), since a curly bracket ends an expression of xacro.
            return {word.arg: self.value(word.value) for word in node.keywords if word.arg}
        if isinstance(node, ast.Call) and not node.keywords:
            arguments = [self.value(argument) for argument in node.args]
            function = _FUNCTIONS.get(_function_name(node.func))
            if function is not None:
                return function(*arguments)
            if isinstance(node.func, ast.Attribute) and node.func.attr in _METHODS:
                return _METHODS[node.func.attr](self.value(node.func.value), *arguments)
        raise ExpressionError(
            f"'{shortened(ast.unparse(node))}' is not allowed in an expression; the functions are "
            f"{', '.join(sorted(_FUNCTIONS))}"
        )

    def _named(self, node: ast.Name | ast.Attribute) -> Any:
        """The value of a name, or of ``math.NAME``, or of a name in a namespace."""
        if isinstance(node, ast.Name):
            if node.id not in self._names:
                if node.id in _NAMES:
                    return _NAMES[node.id]
                raise ExpressionError(f"'{node.id}' is not known; text has to be quoted")
            result = self._names[node.id]
        elif isinstance(node.value, ast.Name) and node.value.id == "math" and node.attr in _NAMES:
            return _NAMES[node.attr]
        else:
            inside = self._named(node.value) if isinstance(node.value, _NAMED) else None
            if not isinstance(inside, Mapping) or node.attr not in inside:
                raise ExpressionError(f"'{shortened(ast.unparse(node))}' is not known")
            result = inside[node.attr]
        if not isinstance(result, _PLAIN):
            raise ExpressionError(f"'{ast.unparse(node)}' is neither a number nor a text")
        return result

    def _element(self, node: ast.Subscript) -> Any:
        whole, index = self.value(node.value), self.value(node.slice)
        if isinstance(whole, str | list | dict):
            return whole[index]
        raise ExpressionError(f"'{shortened(ast.unparse(node.value))}' has no elements")

    def _binary(self, node: ast.BinOp) -> Any:
        left, right = self.value(node.left), self.value(node.right)
        if isinstance(node.op, ast.Pow):
            # Limited, so that no file keeps the machine busy with one number.
            if abs(right) > _MAX_POWER:
                raise ExpressionError(f"exponents beyond {_MAX_POWER} are not computed")
            return left**right if abs(left) < _MAX_BASE else float(left) ** right
        function = _BINARY.get(type(node.op))
        if function is None:
            raise ExpressionError(f"'{ast.unparse(node)}' is not allowed in an expression")
        formats = isinstance(node.op, ast.Mod) and isinstance(left, str)
        repeats = isinstance(node.op, ast.Mult) and any(
            isinstance(side, str | list) for side in (left, right)
        )
        if formats or repeats:
            raise ExpressionError("text and lists cannot be repeated or formatted")
        return function(left, right)

    def _logic(self, node: ast.BoolOp) -> Any:
        result: Any = None
        for operand in node.values:
            result = self.value(operand)
            if bool(result) == isinstance(node.op, ast.Or):
                return result
        return result

    def _compare(self, node: ast.Compare) -> bool:
        left = self.value(node.left)
        for operation, operand in zip(node.ops, node.comparators, strict=True):
            right = self.value(operand)
            if not _COMPARE[type(operation)](left, right):
                return False
            left = right
        return True


def _function_name(node: ast.expr) -> str:
    """The name of a function, also as ``math.NAME``; empty for anything else."""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        return node.attr if node.value.id == "math" else ""
    return node.id if isinstance(node, ast.Name) else ""
