"""Environment variables that packages set when their workspace is sourced.

A ``CMakeLists.txt`` names hooks in ``ament_environment_hooks``, and a ``setup.py`` installs them to
``share/NAME/hook``. A ``.dsv`` file has one operation per line, such as
``prepend-non-duplicate;GZ_SIM_RESOURCE_PATH;share/NAME/models`` with a path below the install
prefix. Of shell scripts, lines with ``ament_prepend_unique_value``, ``ament_append_unique_value``
and ``export NAME=value`` are read; scripts are not executed.

The shell that sourced a workspace has applied its hooks. Here the hooks of packages that are used
from their sources are applied, and those of an install prefix that was found by a path.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, MutableMapping
from pathlib import Path

from teleopctl.base.typed import Final, NamedTuple
from teleopctl.packages.source_folders import text_of

_FUNCTIONS: Final = {
    "ament_prepend_unique_value": "prepend-non-duplicate",
    "ament_append_unique_value": "append-non-duplicate",
    "colcon_prepend_unique_value": "prepend-non-duplicate",
    "export": "export",
}
_SHELLS: Final = (".sh", ".bash", ".zsh")
_TEMPLATE: Final = re.compile(r"@(\w+)@")
_VARIABLE: Final = re.compile(r"\$\{?(\w+)\}?")
_PREFIXES: Final = ("AMENT_CURRENT_PREFIX", "COLCON_CURRENT_PREFIX", "CMAKE_INSTALL_PREFIX")
# Modules and packages below a prefix are found without these variables, and modules that were made
# for another Python would hide teleopctl's.
_SEARCHED: Final = ("AMENT_PREFIX_PATH", "PYTHONPATH")
_MOST_FILES: Final = 10_000  # that the files of a prefix name; a large ROS has 3,000


class Operation(NamedTuple):
    """Change of an environment variable.

    Attributes:
        kind: Kind of the change, as in a ``.dsv`` file: ``prepend-non-duplicate`` and so on; or
            ``export`` for a value that is no path.
        variable: Name of the variable.
        value: New value, or a path relative to the install prefix.
    """

    kind: str
    variable: str
    value: str

    def apply(self, prefix: Path, environment: MutableMapping[str, str]) -> None:
        """Change the variable in an environment.

        Args:
            prefix: Install prefix of the package.
            environment: Environment variables.
        """
        old = environment.get(self.variable, "")
        if self.kind == "export":
            environment[self.variable] = self.value
            return
        if self.kind in ("set", "set-if-unset"):
            place = prefix / self.value
            value = str(place) if self.value and place.exists() else self.value
            if self.kind == "set" or self.variable not in environment:
                environment[self.variable] = value
            return
        folder = str(prefix / self.value) if self.value else str(prefix)
        known = old.split(os.pathsep)
        if folder in known or (self.kind.endswith("if-exists") and not Path(folder).exists()):
            return
        parts = [old, folder] if self.kind.startswith("append") else [folder, old]
        environment[self.variable] = os.pathsep.join(filter(None, parts))


def apply_installed_hooks(prefix: Path, environment: MutableMapping[str, str] = os.environ) -> None:
    """Apply the hooks of the packages below an install prefix, as its ``setup.bash`` would."""
    pending = sorted(prefix.glob("share/*/package.dsv"))  # colcon's
    pending = pending or sorted(prefix.glob("share/*/local_setup.dsv"))
    read: set[Path] = set()
    while pending and len(read) < _MOST_FILES:
        file = pending.pop(0)
        if file in read:
            continue
        read.add(file)
        for line in (text_of(file) or "").splitlines():
            kind, _, rest = line.partition(";")
            if kind == "source":
                if rest.endswith(".dsv"):
                    pending.append(prefix / rest)
                continue
            for operation in _of_dsv(line):
                if operation.variable not in _SEARCHED:
                    operation.apply(prefix, environment)


def source_hooks(name: str, folder: Path) -> list[Operation]:
    """Return the operations of the hooks of a source package.

    Args:
        name: Name of the package.
        folder: Source folder of the package.
    """
    files = [file for file in _hook_files(name, folder) if file.is_file()]
    described = {_stem(file) for file in files if _kind(file) == ".dsv"}
    operations: list[Operation] = []
    for file in files:
        text = _filled_in(text_of(file) or "", name)
        if _kind(file) == ".dsv":
            operations += [found for line in text.splitlines() for found in _of_dsv(line)]
        elif _kind(file) in _SHELLS and _stem(file) not in described:
            operations += [found for line in text.splitlines() for found in _of_shell(line)]
    return operations


def _hook_files(name: str, folder: Path) -> Iterator[Path]:
    text = text_of(folder / "CMakeLists.txt")
    if text is not None and "ament_environment_hooks" in text:
        from teleopctl.packages.cmake_script import installation

        for path in installation(text, folder).hooks:
            yield folder / path
    text = text_of(folder / "setup.py")
    if text is not None and "hook" in text and "data_files" in text:
        from teleopctl.packages.setup_script import setup_arguments

        match setup_arguments(text, folder).get("data_files"):
            case list(entries) | tuple(entries):
                for entry in entries:
                    match entry:
                        case (str(target), list(files) | tuple(files)):
                            if target.rstrip("/") == f"share/{name}/hook":
                                yield from (folder / file for file in files if _is_text(file))


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _kind(file: Path) -> str:
    """Return the suffix of a hook's file, without the ``.in`` of a template."""
    return Path(file.name.removesuffix(".in")).suffix


def _stem(file: Path) -> str:
    return Path(file.name.removesuffix(".in")).stem


def _filled_in(text: str, name: str) -> str:
    """Return a template with CMake's variables replaced; the install prefix becomes relative."""
    known = {"PROJECT_NAME": name, "CMAKE_INSTALL_PREFIX": "${CMAKE_INSTALL_PREFIX}"}
    return _TEMPLATE.sub(lambda one: known.get(one[1], one[0]), text)


def _of_dsv(line: str) -> Iterator[Operation]:
    """Yield the operations in a line of a ``.dsv`` file, one per value."""
    kind, *rest = (part.strip() for part in line.split(";"))
    if not rest or not re.fullmatch(
        r"set(-if-unset)?|(prepend|append)-non-duplicate(-if-exists)?", kind
    ):
        return
    variable, *values = rest
    if not _is_name(variable):
        return
    for value in values or [""]:
        yield Operation(kind, variable, _relative(value))


def _of_shell(line: str) -> Iterator[Operation]:
    """Yield the operation in a line of a shell script, if it is one of the known forms."""
    import shlex

    try:
        words = shlex.split(line, comments=True)
    except ValueError:  # a quotation over several lines
        return
    if not words or words[0] not in _FUNCTIONS:
        return
    kind = _FUNCTIONS[words[0]]
    match words[1:]:
        case [assignment] if kind == "export" and "=" in assignment:
            variable, _, value = assignment.partition("=")
        case [variable, value] if kind != "export":
            pass
        case _:
            return
    for own in (f"${variable}", f"${{{variable}}}") if kind == "export" else ():
        # A=$A:new and A=new:$A extend a path.
        if value.startswith(f"{own}:"):
            kind, value = "append-non-duplicate", value.removeprefix(f"{own}:")
        elif value.endswith(f":{own}"):
            kind, value = "prepend-non-duplicate", value.removesuffix(f":{own}")
    relative = _relative(value)
    if relative != value and kind == "export":
        kind = "set"
    if _is_name(variable) and "$" not in relative:  # the shell would know the variable's value
        yield Operation(kind, variable, relative)


def _is_name(variable: str) -> bool:
    return variable.isascii() and variable.isidentifier()


def _relative(value: str) -> str:
    """Return a value with a path below the install prefix made relative to the prefix."""
    found = _VARIABLE.match(value)
    if found is not None and found[1] in _PREFIXES:
        value = value[found.end() :].lstrip("/")
    return value.replace("\0", "")
