"""Type stubs of interface packages: ``.pyi`` files for classes that are made at run time.

The stub of a class has the types of its fields when they are read, the types that may be assigned,
its constants and its keyword arguments. Single numbers are strict, as in rclpy: teleopctl's classes
convert numpy scalars, but those of rclpy reject them, so that a program that passes the type
checker runs with both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import isfinite
from pathlib import Path

from teleopctl.interfaces.definition import (
    FLOATS,
    INTEGER_RANGES,
    STRINGS,
    Constant,
    Definition,
    Field,
    FieldType,
    Shape,
)
from teleopctl.interfaces.message import constant_value
from teleopctl.interfaces.services import ACTION_PARTS, ACTION_SERVICES, SERVICE_PARTS
from teleopctl.interfaces.typenames import split

Lookup = Callable[[str], Definition | None]

_HEAD = "# Written by teleopctl from the definitions of the package.\n"
# Names that no field, constant or type of a package can have. A stub imports only the used names.
_IMPORTS = {
    "_builtins": "import builtins as _builtins",
    "_numpy": "import numpy as _numpy",
    "_array": "from array import array as _array",
    "_Iterable": "from collections.abc import Iterable as _Iterable",
    "_Final": "from typing import Final as _Final",
    "_NDArray": "from numpy.typing import NDArray as _NDArray",
    "_Message": "from teleopctl.interfaces.message import Message as _Message",
    "_Strings": "from teleopctl.interfaces.protocols import Strings as _Strings",
    "_Action": "from teleopctl.interfaces.store import ActionBase as _Action",
    "_Service": "from teleopctl.interfaces.store import ServiceBase as _Service",
}
_INDENT = "    "


def write_stubs(
    folder: Path, type_names: Iterable[str], lookup: Lookup, *, suffix: str = ""
) -> list[str]:
    """Write ``.pyi`` stubs for the classes of interface types; return the packages' names.

    Args:
        folder: Folder in which each package gets a folder; created if needed.
        type_names: Full names of messages, services and actions, without derived types.
        lookup: Function that returns the definition of a type or derived type by its full name.
        suffix: End of the folders' names; with ``-stubs`` type checkers find the stubs in
            ``site-packages``.

    Returns:
        Sorted names of the packages.

    Raises:
        TeleopctlError: A definition cannot be parsed.
        OSError: The files cannot be written.
    """
    modules: dict[tuple[str, str], list[str]] = {}
    for name in sorted(type_names):
        package, kind, _ = split(name)
        modules.setdefault((package, kind), []).append(name)
    for (package, kind), names in modules.items():
        home = folder / f"{package}{suffix}"
        home.mkdir(parents=True, exist_ok=True)
        home.joinpath("__init__.pyi").write_text(_HEAD, encoding="utf-8")
        home.joinpath(f"{kind}.pyi").write_text(module_stub(names, lookup), encoding="utf-8")
    return sorted({package for package, _ in modules})


def module_stub(type_names: Iterable[str], lookup: Lookup) -> str:
    """Return the text of the ``.pyi`` stub of a module such as ``std_msgs.msg``.

    Args:
        type_names: Full names of the module's types, without derived types.
        lookup: Function that returns the definition of a type or derived type by its full name.
    """
    writer = _Writer(lookup)
    body = "".join(writer.module(type_names))
    imports = [f"{line}\n" for name, line in _IMPORTS.items() if name in body]
    imports += [f"import {module} as {_alias(module)}\n" for module in sorted(writer.modules)]
    return "".join((_HEAD, *imports, body))


def _alias(module: str) -> str:
    return f"_{module.replace('.', '_')}"


class _Writer:
    """Writes the classes of one module.

    Attributes:
        modules: Other modules whose classes the stub uses.
    """

    def __init__(self, lookup: Lookup) -> None:
        self._lookup = lookup
        self._module = ""
        self.modules: set[str] = set()

    def module(self, type_names: Iterable[str]) -> Iterator[str]:
        """Yield the stub lines of a module's classes."""
        for type_name in type_names:
            package, kind, name = split(type_name)
            self._module = f"{package}.{kind}"
            yield "\n"
            write = {"srv": self._service, "action": self._action}.get(kind, self._message)
            yield from write(name, type_name, "")

    def _service(self, name: str, type_name: str, margin: str) -> Iterator[str]:
        yield f"{margin}class {name}(_Service):\n"
        for part in SERVICE_PARTS:
            yield from self._message(part, f"{type_name}_{part}", margin + _INDENT)

    def _action(self, name: str, type_name: str, margin: str) -> Iterator[str]:
        yield f"{margin}class {name}(_Action):\n"
        *parts, feedback_message = ACTION_PARTS
        for part in parts:
            yield from self._message(part, f"{type_name}_{part}", margin + _INDENT)
        yield f"{margin}{_INDENT}class Impl:\n"
        inner = margin + 2 * _INDENT
        for service in ACTION_SERVICES:
            yield from self._service(f"{service}Service", f"{type_name}_{service}", inner)
        yield from self._message(feedback_message, f"{type_name}_{feedback_message}", inner)
        for attribute, shared in (
            ("CancelGoalService", "action_msgs/srv/CancelGoal"),
            ("GoalStatusMessage", "action_msgs/msg/GoalStatusArray"),
        ):
            yield f"{inner}{attribute} = {self._class(shared)}\n"

    def _message(self, name: str, type_name: str, margin: str) -> Iterator[str]:
        definition = self._lookup(type_name)
        assert definition is not None, type_name
        yield f"{margin}class {name}(_Message):\n"
        inner = margin + _INDENT
        for constant in definition.constants:
            yield f"{inner}{constant.name}: {_constant(constant)}\n"
        # A field hides the builtin of the same name in the annotations of the class.
        hidden = {field.attribute for field in definition.fields}
        arguments = []
        for field in definition.fields:
            read, assigned = self._types(field.type, hidden)
            arguments.append(f", {field.attribute}: {assigned} = ...")
            yield from _attribute(field, read, assigned, hidden, inner)
        star = ", *" if arguments else ""
        yield f"{inner}def __init__(self{star}{''.join(arguments)}) -> None: ...\n"

    def _types(self, kind: FieldType, hidden: set[str]) -> tuple[str, str]:
        """Return the type that a field has when it is read, and the one that may be assigned."""
        element = self._element(kind, hidden)
        if kind.shape is Shape.SINGLE:
            return element, element
        if kind.is_numeric:
            name = "uint8" if kind.base == "char" else kind.base
            block = (
                f"_NDArray[_numpy.{name}]" if kind.shape is Shape.ARRAY else f"_array[{element}]"
            )
            return block, f"_Iterable[{element}]"
        read = f"{_builtin('list', hidden)}[{element}]"
        if kind.base in STRINGS:
            return read, "_Strings"
        also = f" | {element}" if kind.base == "byte" else ""
        return read, f"_Iterable[{element}]{also}"

    def _element(self, kind: FieldType, hidden: set[str]) -> str:
        if kind.is_nested:
            return self._class(kind.base)
        if kind.base in INTEGER_RANGES:
            return _builtin("int", hidden)
        if kind.base in FLOATS:
            return _builtin("float", hidden)
        return _builtin({"byte": "bytes", "bool": "bool"}.get(kind.base, "str"), hidden)

    def _class(self, type_name: str) -> str:
        package, kind, name = split(type_name)
        path = name
        if kind != "msg":  # a part of a service or an action is a class inside it
            for service in ACTION_SERVICES:
                path = path.replace(f"_{service}", f".Impl.{service}Service")
            path = path.replace("_FeedbackMessage", ".Impl.FeedbackMessage").replace("_", ".")
        module = f"{package}.{kind}"
        if module == self._module:
            return path
        self.modules.add(module)
        return f"{_alias(module)}.{path}"


def _builtin(name: str, hidden: set[str]) -> str:
    return f"_builtins.{name}" if name in hidden else name


def _attribute(
    field: Field, read: str, assigned: str, hidden: set[str], margin: str
) -> Iterator[str]:
    name = field.attribute
    if read == assigned:
        yield f"{margin}{name}: {read}\n"
        return
    yield f"{margin}@{_builtin('property', hidden)}\n"
    yield f"{margin}def {name}(self) -> {read}: ...\n"
    yield f"{margin}@{name}.setter\n"
    yield f"{margin}def {name}(self, value: {assigned}) -> None: ...\n"


def _constant(constant: Constant) -> str:
    value = constant_value(constant)
    if isinstance(value, float) and not isfinite(value):
        return "_Final[float]"
    return f"_Final = {value!r}"
