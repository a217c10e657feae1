"""What a new package is to be."""

from __future__ import annotations

import keyword
import re
from typing import Final, NamedTuple

from teleopctl.errors import UsageError

AMENT_PYTHON: Final = "ament_python"
AMENT_CMAKE: Final = "ament_cmake"
AMENT_CARGO: Final = "ament_cargo"
CMAKE: Final = "cmake"
BUILD_TYPES: Final = (CMAKE, AMENT_CMAKE, AMENT_CARGO, AMENT_PYTHON)

_PACKAGE_NAME: Final = re.compile("[A-Za-z][A-Za-z0-9_-]+")
_PROGRAM_NAME: Final = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")


class NewPackage(NamedTuple):
    """Options of a new package, with the names of ``ros2 pkg create``.

    Attributes:
        name: Its name.
        build_type: One of `BUILD_TYPES`.
        package_format: 2 or 3, of its ``package.xml``.
        description: For people.
        license: Its license's identifier, or any text.
        maintainer_name: Who maintains it.
        maintainer_email: Where to write to.
        dependencies: Names of packages that it needs.
        node_name: A program that it is to have, or None.
        library_name: A library that it is to have, or None.
    """

    name: str
    build_type: str
    package_format: int
    description: str
    license: str
    maintainer_name: str
    maintainer_email: str
    dependencies: tuple[str, ...] = ()
    node_name: str | None = None
    library_name: str | None = None


def check(package: NewPackage) -> None:
    """Raise for invalid names.

    Raises:
        UsageError: A name is none, or not one in the package's language.
    """
    is_python = package.build_type == AMENT_PYTHON
    if _PACKAGE_NAME.fullmatch(package.name) is None:
        raise UsageError(
            f"'{package.name}' is no name of a package",
            hint="Two characters or more: a letter, then letters, digits and underscores, in lower "
            "case, as in arm_driver.",
        )
    if is_python and package.name == "test":
        raise UsageError(
            "Aborted since 'ament_python' packages can't be named 'test'. Please choose a "
            "different package name.",
            hint="Its code and its tests would lie in the same folder.",
        )
    if is_python:
        _check_module(package.name, "package name")
    for name in (*package.dependencies, package.node_name, package.library_name):
        if name is not None and _PROGRAM_NAME.fullmatch(name) is None:
            raise UsageError(f"'{name}' is no name of a package, a node or a library")
    for name, kind in ((package.node_name, "node"), (package.library_name, "library")):
        if is_python and name is not None:
            _check_module(name, kind)


def _check_module(name: str, kind: str) -> None:
    if not name.isidentifier() or keyword.iskeyword(name):
        usable = re.sub(r"\W", "_", name)
        raise UsageError(
            f"'{name}' cannot be imported in Python, where the {kind} becomes a module",
            hint=f"--build-type ament_python takes names like {usable}_node.",
        )
