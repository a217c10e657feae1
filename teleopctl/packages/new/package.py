"""A package to create: its description, manifest and license, and the steps of its creation."""

from __future__ import annotations

import os
import re
from pathlib import Path
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
    """Options of a package to create, with the names of ``ros2 pkg create``.

    Attributes:
        name: Name of the package.
        build_type: One of `BUILD_TYPES`.
        package_format: Format of ``package.xml``, 2 or 3.
        description: Description of the package.
        license: Identifier of the license, or any text.
        maintainer_name: Name of the maintainer.
        maintainer_email: E-mail address of the maintainer.
        dependencies: Names of the packages that the package depends on.
        node_name: Name of a program to create, or None.
        library_name: Name of a library to create, or None.
        controller: Name of a controller to create, or None.
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
    controller: str | None = None


def check_names(package: NewPackage) -> None:
    """Raise a UsageError if the package's, node's or library's name is invalid.

    Raises:
        UsageError: A name is invalid, or is no module name in a Python package.
    """
    is_python = package.build_type == AMENT_PYTHON
    if _PACKAGE_NAME.fullmatch(package.name) is None:
        raise UsageError(
            f"'{package.name}' is not a valid package name",
            hint="Two characters or more: a letter, then letters, digits and underscores, in lower "
            "case, as in arm_driver.",
        )
    if is_python and package.name == "test":
        raise UsageError(
            "Aborted since 'ament_python' packages can't be named 'test'. Please choose a "
            "different package name.",
            hint="Its code and its tests would be in the same folder.",
        )
    if is_python:
        _check_module(package.name, "package name")
    for name in (*package.dependencies, package.node_name, package.library_name):
        if name is not None and _PROGRAM_NAME.fullmatch(name) is None:
            raise UsageError(f"'{name}' is not a valid name of a package, a node or a library")
    if package.controller is not None and not is_python:
        raise UsageError(
            f"A controller is written in Python, and the build type is {package.build_type}",
            hint="--controller goes with --build-type ament_python.",
        )
    for name, kind in (
        (package.node_name, "node"),
        (package.library_name, "library"),
        (package.controller, "controller"),
    ):
        if is_python and name is not None:
            _check_module(name, kind)


def _check_module(name: str, kind: str) -> None:
    import keyword

    if not name.isidentifier() or keyword.iskeyword(name):
        usable = re.sub(r"\W", "_", name)
        raise UsageError(
            f"'{name}' cannot be imported in Python, where the {kind} becomes a module",
            hint=f"--build-type ament_python takes names like {usable}_node.",
        )


class Note(NamedTuple):
    """Step of creating a package: report a line of text."""

    text: str


class Folder(NamedTuple):
    """Step of creating a package: create a folder."""

    path: str


class File(NamedTuple):
    """Step of creating a package: write a file.

    Attributes:
        path: Path of the file.
        text: Content of the file.
        is_reported: Whether to print the path.
    """

    path: str
    text: str
    is_reported: bool = True


Step = Note | Folder | File


def join_path(*parts: str) -> str:
    """Join the parts of a path, keeping a leading ``./``."""
    return os.path.join(*parts)  # noqa: PTH118 -- a Path would drop the ./


_FOLDER: Final = Path(__file__).parent / "licenses"

# BSD-2.0 is another name for the three-clause license in ament's tools.
_FILES: Final = {
    "Apache-2.0": "Apache-2.0",
    "BSL-1.0": "BSL-1.0",
    "BSD-2.0": "BSD-3-Clause",
    "BSD-2-Clause": "BSD-2-Clause",
    "BSD-3-Clause": "BSD-3-Clause",
    "GPL-3.0-only": "GPL-3.0-only",
    "LGPL-3.0-only": "LGPL-3.0-only",
    "MIT": "MIT",
    "MIT-0": "MIT-0",
}


def license_names() -> list[str]:
    """Return the SPDX identifiers of the licenses whose text is available."""
    return list(_FILES)


def license_text(name: str, holder: str, year: int) -> str | None:
    """Return a license's text with holder and year; None for an unknown license.

    Args:
        name: SPDX identifier of the license.
        holder: Copyright holder.
        year: Year of the copyright.
    """
    if name not in _FILES:
        return None
    text = _FOLDER.joinpath(f"{_FILES[name]}.txt").read_text(encoding="utf-8")
    return text.replace("{year}", str(year)).replace("{holder}", holder)


_TEST_DEPENDENCIES: Final = {
    AMENT_CMAKE: ("ament_lint_auto", "ament_lint_common"),
    AMENT_PYTHON: ("ament_copyright", "ament_flake8", "ament_pep257", "python3-pytest"),
}


def _test_dependencies(package: NewPackage) -> tuple[str, ...]:
    if package.controller is not None:
        return ("python3-pytest",)
    return _TEST_DEPENDENCIES.get(package.build_type, ())


def package_xml(package: NewPackage) -> str:
    """Return the text of a new package's ``package.xml``."""
    from xml.sax.saxutils import escape, quoteattr

    schema = f"http://download.ros.org/schema/package_format{package.package_format}.xsd"
    lines = [
        '<?xml version="1.0"?>',
        f'<?xml-model href="{schema}" schematypens="http://www.w3.org/2001/XMLSchema"?>',
        f'<package format="{package.package_format}">',
        f"  <name>{package.name}</name>",
        "  <version>0.0.0</version>",
        f"  <description>{escape(package.description)}</description>",
        f"  <maintainer email={quoteattr(package.maintainer_email)}>"
        f"{escape(package.maintainer_name)}</maintainer>",
        f"  <license>{escape(package.license)}</license>",
        "",
    ]
    tools: tuple[str, ...] = ()
    if package.build_type == AMENT_CMAKE:
        tools = ("ament_cmake_ros" if package.library_name else "ament_cmake",)
    for tag, names in (
        ("buildtool_depend", tools),
        ("depend", package.dependencies),
        ("test_depend", _test_dependencies(package)),
    ):
        lines += [f"  <{tag}>{name}</{tag}>" for name in names]
        lines += [""] if names else []
    build_type = f"    <build_type>{package.build_type}</build_type>"
    return "\n".join([*lines, "  <export>", build_type, "  </export>", "</package>", ""])
