"""Arguments that a ``setup.py`` passes to ``setup``, found without running it.

A ``setup.py`` is a program, and the search finds packages in any cloned folder: it must not execute
their code. So the script's syntax tree is evaluated: assignments, lists, ``+``, f-strings, loops,
conditions, environment variables, functions of the script, and of other functions only those in
``_FUNCTIONS``, ``_FUNCTIONS_ON_FILES`` and ``_METHODS``, such as ``os.path.join`` and ``glob``.
This covers the ``setup.py`` files of ROS 2's packages, also those that ask for ``ROS_VERSION``. All
other expressions, and those that depend on them, have no value and are left out.
"""

import ast
import glob
import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, Final

# Any: values of the script.

_MOST_STEPS: Final = 100_000  # os.walk over a description with 2,000 meshes takes 40,000
_MOST_CALLS: Final = 20  # nested function calls
_LONGEST: Final = 10_000  # characters of a computed text, elements of a list, files found
_PADDED: Final = re.compile(r"%[^sd%]|\{[^}]*[:.!\[]")  # formats whose result can have any length


def setup_arguments(text: str, folder: Path | None = None) -> dict[str, Any]:
    """Return the arguments of ``setup`` in a ``setup.py`` that can be found without running it.

    Args:
        text: Text of the script.
        folder: Folder for relative paths; None to not search for files, so that expressions which
            depend on files have no value.
    """
    try:
        tree = ast.parse(text)
        script = _Script(folder)
        with suppress(_Return):
            script.run(tree.body)
        if script.arguments is None:  # for example, below a condition that has no value
            calls = [n for n in ast.walk(tree) if isinstance(n, ast.Call) and _is_setup(n)]
            # A script for ROS 1 and 2 has a call without these arguments too.
            calls.sort(key=lambda call: not any(k.arg in _OF_ROS_2 for k in call.keywords))
            for call in calls[:1]:
                script.evaluate(call)
    # a null byte is no syntax error before Python 3.12; nesting of a million brackets
    except (SyntaxError, ValueError, RecursionError, MemoryError, _UnknownError, _TooLargeError):
        return {}
    return script.arguments or {}


class _UnknownError(Exception):
    """An expression has no value here."""


class _TooLargeError(Exception):
    """The script needs more time or memory than the limits for a package's script."""


class _Return(Exception):
    """A ``return`` statement ends the body of a function of the script."""

    def __init__(self, value: Any) -> None:
        self.value = value


class _Script:
    def __init__(self, folder: Path | None) -> None:
        self.arguments: dict[str, Any] | None = None
        self._folder = folder
        self._names: dict[str, Any] = {"__name__": "__main__", "__file__": "setup.py"}
        self._functions: dict[str, ast.FunctionDef] = {}
        self._steps = 0
        self._calls = 0

    def run(self, body: list[ast.stmt]) -> None:
        for statement in body:
            try:
                self._execute(statement)
            except _UnknownError:
                # A name whose new value is unknown must not keep its old value.
                for node in ast.walk(statement):
                    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                        self._names.pop(node.id, None)

    def _execute(self, statement: ast.stmt) -> None:
        match statement:
            case ast.FunctionDef():
                self._functions[statement.name] = statement
            case ast.Assign(targets=targets):
                value = self.evaluate(statement.value)
                for target in targets:
                    self._assign(target, value)
            case ast.AnnAssign(target=target, value=ast.expr() as node):
                self._assign(target, self.evaluate(node))
            case ast.AugAssign(target=ast.Name(id=name), op=ast.Add()):
                added = self._plus(self._value_of(name), self.evaluate(statement.value))
                self._names[name] = added
            case ast.For():
                for item in self._items(statement.iter):
                    self._assign(statement.target, item)
                    self.run(statement.body)
            case ast.If():
                self.run(statement.body if self.evaluate(statement.test) else statement.orelse)
            case ast.With() | ast.Try():
                self.run(statement.body)
            case ast.Return(value=ast.expr() as node):
                raise _Return(self.evaluate(node))
            case ast.Expr(value=ast.Call() as call):
                self.evaluate(call)

    def _step(self) -> None:
        self._steps += 1
        if self._steps > _MOST_STEPS:
            raise _TooLargeError

    def _assign(self, target: ast.expr, value: Any) -> None:
        self._step()
        match target:
            case ast.Name(id=name):
                self._names[name] = value
            case ast.Tuple(elts=parts) | ast.List(elts=parts):
                if not isinstance(value, list | tuple) or len(value) != len(parts):
                    raise _UnknownError
                for part, each in zip(parts, value, strict=True):
                    self._assign(part, each)
            case _:
                raise _UnknownError

    def evaluate(self, node: ast.expr) -> Any:
        self._step()
        match node:
            case ast.Constant(value=value):
                return value
            case ast.Attribute() if _dotted(node) in _CONSTANTS:
                return _CONSTANTS[_dotted(node)]
            case ast.Attribute() | ast.Name() if _dotted(node) in ("os.environ", "environ"):
                return _environment()
            case ast.Name(id=name):
                return self._value_of(name)
            case ast.List(elts=parts):
                return list(self._known(parts))
            case ast.Tuple(elts=parts):
                return tuple(self.evaluate(part) for part in parts)
            case ast.Dict():
                return self._mapping(node)
            case ast.BinOp(left=left, op=ast.Add(), right=right):
                return self._plus(self.evaluate(left), self.evaluate(right))
            case ast.BinOp(left=left, op=ast.Mod(), right=right):
                template = _template(self.evaluate(left))
                return self._try(lambda: template % self.evaluate(right))
            case ast.JoinedStr(values=parts):
                return self._try(lambda: "".join(str(self.evaluate(part)) for part in parts))
            case ast.FormattedValue(value=value, format_spec=None):
                return self.evaluate(value)
            case ast.Subscript(value=value, slice=index):
                return self._try(lambda: self.evaluate(value)[self.evaluate(index)])
            case ast.ListComp(elt=element, generators=[ast.comprehension() as loop]):
                return list(self._comprehension(element, loop))
            case ast.GeneratorExp(elt=element, generators=[ast.comprehension() as loop]):
                return list(self._comprehension(element, loop))
            case ast.IfExp(test=test, body=body, orelse=otherwise):
                return self.evaluate(body if self.evaluate(test) else otherwise)
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return not self.evaluate(operand)
            case ast.BoolOp(op=ast.And(), values=parts):
                return all(self.evaluate(part) for part in parts)
            case ast.BoolOp(op=ast.Or(), values=parts):
                return any(self.evaluate(part) for part in parts)
            case ast.Compare(left=left, ops=[operator], comparators=[right]):
                compare = _COMPARISONS.get(type(operator))
                if compare is not None:
                    return self._try(lambda: compare(self.evaluate(left), self.evaluate(right)))
            case ast.Call():
                return self._call(node)
        raise _UnknownError

    def _value_of(self, name: str) -> Any:
        if name not in self._names:
            raise _UnknownError
        return self._names[name]

    def _known(self, nodes: list[ast.expr]) -> Iterator[Any]:
        """Yield the values of a list's elements, without elements that have no value."""
        for node in nodes:
            with suppress(_UnknownError):
                if isinstance(node, ast.Starred):
                    yield from self._items(node.value)
                else:
                    yield self.evaluate(node)

    def _items(self, node: ast.expr) -> list[Any]:
        value = self.evaluate(node)
        if not isinstance(value, list | tuple):
            raise _UnknownError
        return list(value)

    def _mapping(self, node: ast.Dict) -> dict[Any, Any]:
        mapping = {}
        for key, value in zip(node.keys, node.values, strict=True):
            with suppress(_UnknownError):
                if key is None:
                    mapping.update(self._try(partial(dict, self.evaluate(value))))
                else:
                    mapping[_text(self.evaluate(key))] = self.evaluate(value)
        return mapping

    def _comprehension(self, element: ast.expr, loop: ast.comprehension) -> Iterator[Any]:
        for item in self._items(loop.iter):
            self._assign(loop.target, item)
            with suppress(_UnknownError):
                if all(self.evaluate(condition) for condition in loop.ifs):
                    yield self.evaluate(element)

    def _call(self, node: ast.Call) -> Any:
        name = _dotted(node.func)
        if _is_setup(node):
            keys = [ast.Constant(each.arg) if each.arg else None for each in node.keywords]
            values = [each.value for each in node.keywords]
            self.arguments = self._mapping(ast.Dict(keys=[*keys], values=values))
            return None
        if isinstance(node.func, ast.Name) and name in self._functions:
            return self._own_function(self._functions[name], node)
        arguments = [self.evaluate(argument) for argument in node.args]
        options = {each.arg: self.evaluate(each.value) for each in node.keywords if each.arg}
        if name in _FUNCTIONS:
            return self._try(lambda: _FUNCTIONS[name](*arguments, **options))
        if name in _FUNCTIONS_ON_FILES:
            if self._folder is None:
                raise _UnknownError
            return self._try(lambda: _FUNCTIONS_ON_FILES[name](self._folder, *arguments, **options))
        if isinstance(node.func, ast.Attribute):
            owner, method = self.evaluate(node.func.value), node.func.attr
            if method in _METHODS.get(type(owner), ()):
                if method == "format":
                    _template(owner)
                value = self._try(lambda: getattr(owner, method)(*arguments, **options))
                _bounded(owner)
                return value
        raise _UnknownError

    def _own_function(self, function: ast.FunctionDef, call: ast.Call) -> Any:
        """Call a function of the script, with its own local names; outer names are readable."""
        names = [argument.arg for argument in function.args.args]
        first = len(names) - len(function.args.defaults)
        given = dict(zip(names[first:], function.args.defaults, strict=True))
        given |= dict(zip(names, call.args, strict=False))
        given |= {each.arg: each.value for each in call.keywords if each.arg}
        if self._calls == _MOST_CALLS:
            raise _TooLargeError
        outside = self._names
        self._names = outside | {name: self.evaluate(node) for name, node in given.items()}
        self._calls += 1
        try:
            self.run(function.body)
        except _Return as ended:
            return ended.value
        finally:
            self._names = outside
            self._calls -= 1
        return None

    def _plus(self, left: Any, right: Any) -> Any:
        return self._try(lambda: left + right)

    def _try(self, compute: Callable[[], Any]) -> Any:
        try:
            value = compute()
        except (TypeError, ValueError, LookupError, AttributeError, OSError) as error:
            raise _UnknownError from error
        return _bounded(value)


def _dotted(node: ast.expr) -> str:
    """Return the dotted name of an expression, such as ``os.path.join``; empty if it has none."""
    if isinstance(node, ast.Attribute):
        above = _dotted(node.value)
        return f"{above}.{node.attr}" if above else ""
    return node.id if isinstance(node, ast.Name) else ""


def _is_setup(call: ast.Call) -> bool:
    return _dotted(call.func).rpartition(".")[2] == "setup"


def _bounded(value: Any) -> Any:
    if isinstance(value, str | list | tuple | dict) and len(value) > _LONGEST:
        raise _TooLargeError
    return value


def _template(value: Any) -> str:
    if _PADDED.search(_text(value)):
        raise _UnknownError
    return _text(value)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise _UnknownError
    return value


def _glob(folder: Path, pattern: str, recursive: bool = False) -> list[str]:
    # pathlib's glob has other rules for hidden files and **
    found = glob.iglob(pattern, root_dir=folder, recursive=recursive)  # noqa: PTH207
    return sorted(islice(found, _LONGEST))


def _walk(folder: Path, top: str) -> list[tuple[str, list[str], list[str]]]:
    # as os.walk does, a relative folder stays as it was written
    start = str(folder / top)
    found = islice(os.walk(start), _LONGEST)
    return [(top + root[len(start) :], folders, files) for root, folders, files in found]


def _listdir(folder: Path, top: str = ".") -> list[str]:
    return sorted(path.name for path in folder.joinpath(top).iterdir())


def _tests_of_files() -> Iterator[tuple[str, Callable[[Path, str], bool]]]:
    for name, test in (("exists", Path.exists), ("isdir", Path.is_dir), ("isfile", Path.is_file)):
        for prefix in ("os.path.", "path.", ""):
            yield f"{prefix}{name}", partial(_test, test)


def _test(test: Callable[[Path], bool], folder: Path, path: str) -> bool:
    return test(folder / path)


def _environment() -> dict[str, str]:
    """Return the environment variables, with those that a sourced ROS 2 always has."""
    return {"ROS_VERSION": "2", "ROS_PYTHON_VERSION": "3", "ROS_DISTRO": "jazzy", **os.environ}


def _getenv(name: str, default: Any = None) -> Any:
    return _environment().get(name, default)


_OF_ROS_2: Final = ("entry_points", "data_files")
_CONSTANTS: dict[str, Any] = {
    "os.name": os.name,
    "os.sep": "/",
    "sys.platform": sys.platform,
    "sys.version_info": tuple(sys.version_info[:3]),
}

# Functions by the names that ``setup.py`` files of ROS packages use, depending on their imports.
_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "str": str,
    "int": int,
    "bool": bool,
    "os.getenv": _getenv,
    "getenv": _getenv,
    "list": list,
    "tuple": tuple,
    "dict": dict,
    "sorted": sorted,
    "len": len,
    **{
        f"{prefix}{name}": getattr(os.path, name)
        for prefix in ("os.path.", "path.", "")
        for name in ("basename", "dirname", "join", "normpath", "relpath", "split", "splitext")
    },
}
_FUNCTIONS_ON_FILES: dict[str, Callable[..., Any]] = {
    **dict.fromkeys(("glob", "glob.glob", "iglob", "glob.iglob"), _glob),
    **dict.fromkeys(("os.walk", "walk"), _walk),
    **dict.fromkeys(("os.listdir", "listdir"), _listdir),
    **dict(_tests_of_files()),
}
_METHODS: dict[type, tuple[str, ...]] = {
    str: (
        *("endswith", "format", "join", "lower", "lstrip", "removeprefix", "removesuffix"),
        *("replace", "rstrip", "split", "splitlines", "startswith", "strip", "upper"),
    ),
    list: ("append", "copy", "extend", "insert", "sort"),
    dict: ("get", "items", "update"),
}
_COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], bool]] = {
    ast.Eq: lambda left, right: bool(left == right),
    ast.NotEq: lambda left, right: bool(left != right),
    ast.Lt: lambda left, right: bool(left < right),
    ast.LtE: lambda left, right: bool(left <= right),
    ast.Gt: lambda left, right: bool(left > right),
    ast.GtE: lambda left, right: bool(left >= right),
    ast.Is: lambda left, right: left is right,
    ast.IsNot: lambda left, right: left is not right,
    ast.In: lambda left, right: left in right,
    ast.NotIn: lambda left, right: left not in right,
}
