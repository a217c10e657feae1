"""Expand xacro files into URDF.

The ``xacro`` package is written as a program: it keeps its state in module variables, prints
errors and exits. This module wraps it as a function that returns the text or raises one error with
the file, the line if known, and the reason.

A xacro file is a program: its expressions are Python's, and they can escape xacro's restrictions.
Untrusted files are read in safe mode, which has properties, arguments, macros, conditions,
``$(find …)`` and the arithmetic of `teleopctl.base.expression` only.
"""

import contextlib
import io
import logging
import os
import re
import threading
from collections.abc import Iterator, Mapping
from html import unescape
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any, NamedTuple
from xml.parsers.expat import ExpatError, errors

from teleopctl.base import budget
from teleopctl.base.budget import BudgetError, Tally
from teleopctl.base.expression import ExpressionError, compute
from teleopctl.base.printable import shortened
from teleopctl.errors import InvalidDescriptionError, NotFoundError, TeleopctlError
from teleopctl.packages import include_package_of, package_share
from teleopctl.robot.any_robot import arguments_text, xacro_arguments
from teleopctl.robot.xacro.python_values import BoundedPython
from teleopctl.robot.xacro.source_lines import Places, recorded_lines, source_places

SAFE = "TELEOPCTL_SAFE"
"""Environment variable that makes every process read descriptions in safe mode."""

# Forms of `$(…)` allowed in safe mode; the others read the environment or evaluate Python.
_SAFE_EXTENSION = re.compile(r"\$\((?:cwd|dirname|arg\s[^()$]*|find\s[^()$]*)\)")

# Maximum number of nested macros that an error message names.
_MOST_MACROS_NAMED = 8

_log = logging.getLogger(__name__)
_lock = threading.Lock()

_MISSING_ARGUMENT = "Undefined substitution argument"
_UNBOUND_PREFIX = errors.codes[errors.XML_ERROR_UNBOUND_PREFIX]
# xacro's message has the innermost expression first, each on a line of its own.
_EXPRESSION = re.compile(r"when evaluating expression '(?P<expression>.*?)' *(?:\n|$)", re.DOTALL)

# Errors that the Python expressions in a xacro file may raise.
_EXPRESSION_ERRORS = (
    ArithmeticError,
    AttributeError,
    LookupError,
    NameError,
    RuntimeError,
    SyntaxError,
    TypeError,
    ValueError,
)


class ExpandedXacro(NamedTuple):
    """Expanded xacro text, with the files and lines it came from.

    Attributes:
        text: URDF text.
        files: Files that were read, the file itself first.
        places: Source file and line of each line of the text, if requested.
    """

    text: str
    files: tuple[Path, ...]
    places: Places = MappingProxyType({})


def expand_xacro(
    path: Path | str, mappings: Mapping[str, str] | None = None, *, safe: bool | None = None
) -> str:
    """Expand a xacro file and return the URDF text; a plain URDF keeps its content.

    Args:
        path: Path of the file.
        mappings: Values of the file's ``<xacro:arg>`` by name.
        safe: Whether to use safe mode; by default if ``TELEOPCTL_SAFE`` is neither empty nor 0.

    Returns:
        URDF as text.

    Raises:
        InvalidDescriptionError: When the file is missing, is not XML, cannot be expanded, or has
            an expression that safe mode does not allow.
    """
    return read_xacro(path, mappings, safe=safe).text


def read_xacro(
    path: Path | str,
    mappings: Mapping[str, str] | None = None,
    *,
    safe: bool | None = None,
    places: bool = False,
) -> ExpandedXacro:
    """Expand a xacro file; return URDF text, files read and optional source lines.

    Args:
        path: As for `expand_xacro`.
        mappings: As for `expand_xacro`.
        safe: As for `expand_xacro`.
        places: Whether to record the source file and line of each line.

    Raises:
        InvalidDescriptionError: As for `expand_xacro`.
    """
    include_package_of(Path(path))
    arguments = {name: str(value) for name, value in (mappings or {}).items()}
    printed = io.StringIO()
    with (
        _lock,
        contextlib.redirect_stderr(printed),
        contextlib.redirect_stdout(printed),
        bounded_xacro(safe=safe) as xacro,
        recorded_lines(xacro) if places else contextlib.nullcontext() as notes,
    ):
        # xacro appends included files to this list and never clears it.
        xacro.all_includes.clear()
        try:
            document = xacro.process_file(str(path), mappings=arguments, verbosity=0)
            written = None if notes is None else notes.remove(document)
            text: str = document.toprettyxml(indent="  ")
            included = dict.fromkeys(Path(name).absolute() for name in xacro.all_includes)
        except ExpatError as error:
            raise _syntax_error(xacro, error) from error
        except OSError as error:
            raise InvalidDescriptionError(
                f"Cannot read {error.filename or path}: {error.strerror}"
            ) from error
        except xacro.XacroException as error:
            raise _expansion_error(xacro, Path(path), error) from error
        except _EXPRESSION_ERRORS as error:
            raise _expansion_error(xacro, Path(path), error) from error
    for line in printed.getvalue().splitlines():
        _log.warning("%s: %s", path, line)
    files = (Path(path).absolute(), *included)
    return ExpandedXacro(text, files, source_places(text, written) if written else {})


def over_budget(path: Path, error: Exception) -> TeleopctlError | None:
    """Return an error to raise for an expansion beyond the limits; None for other errors.

    Args:
        path: Path of the file that was expanded.
        error: Error of the expansion; for any other fault None is returned.
    """
    import xacro

    if isinstance(_root_cause(error), BudgetError | RecursionError):
        return _expansion_error(xacro, path, error)
    return None


def is_safe(env: Mapping[str, str] = os.environ) -> bool:
    """Return whether safe mode is on: ``TELEOPCTL_SAFE`` is set, and neither empty nor 0."""
    return env.get(SAFE, "") not in ("", "0")


@contextlib.contextmanager
def bounded_xacro(*, safe: bool | None = None) -> Iterator[ModuleType]:
    """Yield the ``xacro`` package with ``$(find …)`` and limits of teleopctl, for one file.

    Args:
        safe: As for `expand_xacro`.
    """
    import xacro
    from xacro import substitution_args

    # xacro resolves `$(find …)` only with ament_index_python installed, and has no hook for it.
    substitution_args._eval_find = _find_package  # noqa: SLF001
    if safe is None:
        safe = is_safe()
    with _only_arithmetic(xacro) if safe else _bounded_python(xacro), _bounded(xacro):
        yield xacro


@contextlib.contextmanager
def _bounded(xacro: ModuleType) -> Iterator[None]:
    """Limit macros, blocks and texts, which can grow without bound even without recursion."""
    own = {name: vars(xacro)[name] for name in ("eval_text", "parse", "replace_node")}
    own["resolve_macro"] = vars(xacro)["resolve_macro"]
    calls = Tally("calls of macros", budget.MOST_MACRO_CALLS)
    files = Tally("files that include one another", budget.MOST_INCLUDED_FILES)
    elements = Tally("elements made by macros and blocks", budget.MOST_ELEMENTS)
    characters = Tally("characters", budget.LONGEST_DOCUMENT)

    # Any, here and below: xacro's own elements, macros, symbols and values.
    def resolve_macro(*args: Any) -> Any:
        found = own["resolve_macro"](*args)
        calls.add()
        # xacro copies the whole body, including parts that a condition leaves out.
        elements.add(_size(found[-1].body))
        return found

    def parse(*args: Any) -> Any:
        document = own["parse"](*args)
        if files.count:
            elements.add(_size(document))
        files.add()
        return document

    def replace_node(node: Any, by: Any, content_only: bool = False) -> None:
        if getattr(node, "tagName", "") == "xacro:insert_block":
            elements.add(1 + _size(by))
        _replace(node, by, content_only=content_only)

    def eval_text(*args: Any) -> Any:
        value = own["eval_text"](*args)
        if isinstance(value, str):
            if len(value) > budget.LONGEST_TEXT:
                raise BudgetError(f"a text has more than {budget.LONGEST_TEXT:,} characters")
            characters.add(len(value))
        return value

    bounded = (eval_text, parse, replace_node, resolve_macro)
    vars(xacro).update({function.__name__: function for function in bounded})
    try:
        yield
    finally:
        vars(xacro).update(own)


def _size(node: Any) -> int:
    """Return the number of elements in a node of a document."""
    return len(node.getElementsByTagName("*"))


def _replace(node: Any, by: Any, *, content_only: bool) -> None:
    """Replace a node by other nodes or their content, as xacro's ``replace_node`` does.

    xacro's function searches the place of each node among all nodes: 4 s for 25,000 of them.
    """
    given = [] if by is None else by if isinstance(by, list) else [by]
    new = [child for one in given for child in one.childNodes] if content_only else given
    parent = node.parentNode
    place = parent.childNodes.index(node)
    before, behind = node.previousSibling, node.nextSibling
    if content_only:
        for one in given:
            one.childNodes[:] = []
    parent.childNodes[place : place + 1] = new
    node.parentNode = node.previousSibling = node.nextSibling = None
    for one in new:
        one.parentNode, one.previousSibling = parent, before
        if before is not None:
            before.nextSibling = one
        before = one
    if before is not None:
        before.nextSibling = behind
    if behind is not None:
        behind.previousSibling = before


@contextlib.contextmanager
def _only_arithmetic(xacro: ModuleType) -> Iterator[None]:
    """Make xacro evaluate ``${…}`` by `compute`, not by Python, and allow few kinds of ``$(…)``."""
    # xacro has no hook for this.
    python, extension = vars(xacro)["safe_eval"], vars(xacro)["eval_extension"]

    # Any: xacro's own symbols and values.
    def arithmetic(text: str, symbols: Any, _: object = None) -> Any:
        try:
            return compute(text, symbols)
        except ExpressionError as error:
            raise ExpressionError(f"refused in safe mode: {error}") from error

    def few_extensions(text: str) -> Any:
        if _SAFE_EXTENSION.fullmatch(text):
            return extension(text)
        raise ExpressionError(f"refused in safe mode: {shortened(text)}")

    vars(xacro).update(safe_eval=arithmetic, eval_extension=few_extensions)
    try:
        yield
    finally:
        vars(xacro).update(safe_eval=python, eval_extension=extension)


@contextlib.contextmanager
def _bounded_python(xacro: ModuleType) -> Iterator[None]:
    """Limit the Python expressions of a file; see `teleopctl.robot.xacro.python_values`."""
    python, within = vars(xacro)["safe_eval"], BoundedPython()
    inner = vars(vars(xacro)["substitution_args"])
    vars(xacro).update(safe_eval=within.safe_eval)
    # The module calls the builtin `eval`, which a name in the module hides.
    inner["eval"] = within.eval
    try:
        yield
    finally:
        vars(xacro).update(safe_eval=python)
        del inner["eval"]


def _find_package(name: str) -> str:
    """Return the folder of a package's files, for ``$(find PACKAGE)``.

    Raises:
        NotFoundError: The package is unknown.
    """
    return str(package_share(name))


def _syntax_error(xacro: ModuleType, error: ExpatError) -> TeleopctlError:
    hint = None
    if error.code == _UNBOUND_PREFIX:
        hint = 'Declare xmlns:xacro="http://www.ros.org/wiki/xacro" in the root element.'
    reason = errors.messages[error.code]
    return InvalidDescriptionError(
        f"{xacro.filestack[-1]}:{error.lineno}:{error.offset + 1}: invalid XML: {reason}", hint=hint
    )


def _expansion_error(xacro: ModuleType, path: Path, error: Exception) -> TeleopctlError:
    """Describe a failed expansion: where it happened, in which macro, and why."""
    cause = _root_cause(error)
    if isinstance(cause, BudgetError):
        expression = _EXPRESSION.search(str(cause)) or _EXPRESSION.search(str(error))
        place = _place(xacro, path, expression.group("expression") if expression else None)
        return InvalidDescriptionError(f"{place}: {str(cause).splitlines()[0]}{_inside(xacro)}")
    if isinstance(cause, OSError):
        missing = cause.filename or path
        message = f"Cannot read {missing}: {cause.strerror}"
        if Path(str(missing)) == path:
            return InvalidDescriptionError(f"Cannot read {path}: {cause.strerror}")
        return InvalidDescriptionError(f"{_place(xacro, path, None)}: {message}")
    if isinstance(cause, RecursionError):
        return InvalidDescriptionError(
            f"{_place(xacro, path, None)}: files or macros include each other without end"
        )
    reason, hint = str(error), None
    if isinstance(cause, NotFoundError):
        reason, hint = cause.message, cause.hint
    elif isinstance(cause, Exception) and reason.startswith("<class "):
        reason = f"{type(cause).__name__}: {cause}"
    elif _MISSING_ARGUMENT in reason and (known := xacro_arguments(_files_so_far(xacro, path))):
        hint = f"It takes {arguments_text(known)}; give them as name:=value"
    expression = _EXPRESSION.search(reason)
    place = _place(xacro, path, expression.group("expression") if expression else None)
    reason = " ".join(reason.split()) or type(error).__name__
    return InvalidDescriptionError(f"{place}: {reason}{_inside(xacro)}", hint=hint)


def _inside(xacro: ModuleType) -> str:
    """Return the end of a sentence that names the macros being expanded; empty for none."""
    macros = [macro.body.getAttribute("name") for macro in xacro.macrostack or []]
    if len(macros) > _MOST_MACROS_NAMED:
        macros = ["…", *macros[-_MOST_MACROS_NAMED:]]
    return f" (in macro {' > '.join(macros)})" if macros else ""


def _files_so_far(xacro: ModuleType, path: Path) -> list[Path]:
    return list(dict.fromkeys((path, *map(Path, xacro.all_includes))))


def _root_cause(error: BaseException) -> BaseException:
    inner = getattr(error, "exc", None)
    return _root_cause(inner) if isinstance(inner, BaseException) else error


def _place(xacro: ModuleType, path: Path, expression: str | None) -> str:
    """Name the file that was being expanded and, if only one line can be meant, the line."""
    file = path
    if xacro.macrostack:
        # while a macro is expanded, its text comes from the file that defines it
        file = Path(xacro.macrostack[-1].history[-1][-1] or path)
    elif xacro.filestack:
        file = Path(xacro.filestack[-1] or path)
    if expression:
        with contextlib.suppress(OSError, UnicodeDecodeError):
            lines = file.read_text(encoding="utf-8").splitlines()
            meant = f"${{{expression}}}", f"$(eval {expression})"
            numbers = [
                n for n, line in enumerate(lines, 1) if any(m in unescape(line) for m in meant)
            ]
            if len(numbers) == 1:
                return f"{file}:{numbers[0]}"
    return str(file)
