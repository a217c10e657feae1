"""Expressions of ``$(eval …)``: Python's arithmetic, comparisons and logic, and nothing else.

The text of a launch file is data. It is parsed with Python's own grammar, but only literals,
operators and a handful of functions are evaluated.
"""

import ast
import math
import operator
from collections.abc import Callable
from typing import Any

_MAX_POWER = 64
_MAX_BASE = 10**9

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
    "pi": math.pi,
    "e": math.e,
    "inf": math.inf,
    "nan": math.nan,
}
_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": abs,
    "bool": bool,
    "ceil": math.ceil,
    "cos": math.cos,
    "float": float,
    "floor": math.floor,
    "int": int,
    "len": len,
    "max": max,
    "min": min,
    "radians": math.radians,
    "degrees": math.degrees,
    "round": round,
    "sin": math.sin,
    "sqrt": math.sqrt,
    "str": str,
    "tan": math.tan,
}


class ExpressionError(ValueError):
    """An expression that cannot be evaluated; the message says which part and why."""


def evaluate(text: str) -> str:
    """Evaluate an expression and return its result as text, as ``str`` prints it.

    Raises:
        ExpressionError: When the text is not an expression, uses something other than literals,
            operators and the known functions, or fails while it is computed.
    """
    try:
        tree = ast.parse(text.strip(), mode="eval")
        return str(_value(tree.body))
    except ExpressionError:
        raise
    except SyntaxError as error:
        raise ExpressionError(f"'{text}' is not an expression: {error.msg}") from error
    except RecursionError as error:
        raise ExpressionError("the expression is nested too deeply") from error
    except (ArithmeticError, TypeError, ValueError, LookupError) as error:
        raise ExpressionError(f"'{text}' cannot be computed: {error}") from error


def _value(node: ast.expr) -> Any:
    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.Name):
        if node.id in _NAMES:
            return _NAMES[node.id]
        raise ExpressionError(f"'{node.id}' is not known; text has to be quoted")
    if isinstance(node, ast.List | ast.Tuple):
        return [_value(item) for item in node.elts]
    if isinstance(node, ast.UnaryOp) and type(node.op) in _UNARY:
        return _UNARY[type(node.op)](_value(node.operand))
    if isinstance(node, ast.BinOp):
        return _binary(node)
    if isinstance(node, ast.BoolOp):
        return _logic(node)
    if isinstance(node, ast.Compare):
        return _compare(node)
    if isinstance(node, ast.IfExp):
        return _value(node.body if _value(node.test) else node.orelse)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        function = _FUNCTIONS.get(node.func.id)
        if function is None:
            raise ExpressionError(f"'{node.func.id}' is not one of {', '.join(sorted(_FUNCTIONS))}")
        return function(*[_value(argument) for argument in node.args])
    raise ExpressionError(f"'{ast.unparse(node)}' is not allowed in an expression")


def _binary(node: ast.BinOp) -> Any:
    left, right = _value(node.left), _value(node.right)
    if isinstance(node.op, ast.Pow):
        # Bounded, so that no launch file keeps the machine busy with one number.
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


def _logic(node: ast.BoolOp) -> Any:
    result: Any = None
    for operand in node.values:
        result = _value(operand)
        if bool(result) == isinstance(node.op, ast.Or):
            return result
    return result


def _compare(node: ast.Compare) -> bool:
    left = _value(node.left)
    for operation, operand in zip(node.ops, node.comparators, strict=True):
        right = _value(operand)
        if not _COMPARE[type(operation)](left, right):
            return False
        left = right
    return True
