"""A rule of the house: whoever writes `Any` in a public signature says in a comment why."""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "teleopctl"

Function = ast.FunctionDef | ast.AsyncFunctionDef


def public_functions(body: list[ast.stmt], begin: int = 0) -> Iterator[tuple[Function, int]]:
    """Public functions, and methods and constructors of public classes, with their class's line."""
    for statement in body:
        match statement:
            case ast.ClassDef(name=name) if not name.startswith("_"):
                yield from public_functions(statement.body, statement.lineno)
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                if not name.startswith("_") or name.endswith("__"):
                    yield statement, begin
            case ast.If(body=body, orelse=orelse) | ast.Try(body=body, orelse=orelse):
                yield from public_functions([*body, *orelse], begin)


def names_any(annotation: ast.expr | None) -> bool:
    for node in ast.walk(annotation) if annotation else ():
        match node:
            case ast.Name(id="Any") | ast.Attribute(attr="Any"):
                return True
            case ast.Constant(value=str(text)) if re.search(r"\bAny\b", text):
                return True
    return False


def has_any(function: Function) -> bool:
    arguments = function.args
    every = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
    every += [star for star in (arguments.vararg, arguments.kwarg) if star]
    return names_any(function.returns) or any(names_any(each.annotation) for each in every)


def reasons(source: str) -> list[tuple[int, int]]:
    """Line and column of each comment that speaks of Any."""
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    return [
        token.start
        for token in tokens
        if token.type == tokenize.COMMENT and re.search(r"\bAny\b", token.string)
    ]


def unexplained(source: str) -> list[str]:
    """Public functions with an Any that no comment explains.

    A comment holds for the signature in which it stands, or for all that follows it in its block:
    the module, or the class.
    """
    if not re.search(r"\bAny\b", source):
        return []
    functions = [
        (function, class_line)
        for function, class_line in public_functions(ast.parse(source).body)
        if has_any(function)
    ]
    # Comments are found slowly, so only where one is needed.
    known = reasons(source) if functions else []
    found = []
    for function, class_line in functions:
        first = min([function.lineno, *(each.lineno for each in function.decorator_list)])
        last = max(function.lineno, function.body[0].lineno - 1)
        said = any(
            (line < first and column == 0)
            or (class_line < line < first and column == function.col_offset)
            or first <= line <= last
            for line, column in known
        )
        if not said:
            found.append(f"{function.lineno}: {function.name}")
    return found


def test_any_in_a_public_signature_is_explained():
    found = {
        str(file.relative_to(PACKAGE)): unexplained(file.read_text(encoding="utf-8"))
        for file in PACKAGE.rglob("*.py")
    }
    assert {file: lines for file, lines in found.items() if lines} == {}


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("def f(a: Any): pass", ["1: f"]),
        ("def f() -> dict[str, typing.Any]: pass", ["1: f"]),
        ("def f(*a: 'list[Any]'): pass", ["1: f"]),
        ("class C:\n    def __init__(self, **a: Any): pass", ["2: __init__"]),
        ("def _f(a: Any): pass\nclass _C:\n    def f(self, a: Any): pass", []),
        ("def f(a: AnyStr): pass", []),
        ("# Any: it\n# depends\n\ndef f(a: Any): pass\nclass C:\n    def g(self) -> Any: pass", []),
        ("def f(a: Any): pass  # Any: it depends", []),
        ("class C:\n    # Any: so\n    def f() -> Any: pass\n    def g() -> Any: pass", []),
        ("class C:\n    # Any: so\n    x = 1\nclass D:\n    def f() -> Any: pass", ["5: f"]),
        ("def f(a: Any): pass\n# Any: too late", ["1: f"]),
    ],
)
def test_what_counts_as_explained(source, found):
    assert unexplained(source) == found
