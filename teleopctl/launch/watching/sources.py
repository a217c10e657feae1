"""What a process of a launch is made from: the files whose change asks for a new start."""

from __future__ import annotations

import importlib.util
import os
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

from teleopctl.errors import TeleopctlError
from teleopctl.launch.model.plan import ProcessPlan
from teleopctl.launch.watching.files_read import is_of_user
from teleopctl.packages import (
    PackageProgram,
    find_executable,
    installed_module_roots,
    is_path,
    lookup_package,
    source_module_root,
)

_NODES = "teleopctl.nodes"
_PARAMETERS = "--params-file"
# What a program is given to read, and does not write: a bag or a table may be an argument, too.
_READ = frozenset({".py", ".rviz", ".sdf", ".srdf", ".urdf", ".xacro", ".xml", ".yaml", ".yml"})
_NO_SOURCES = frozenset({"build", "install", "launch", "log", "test", "tests", "__pycache__"})
_DEPENDENCY = re.compile(r"<(?:depend|exec_depend|run_depend)[^>]*>\s*([\w-]+)\s*<")


def sources_of(plan: ProcessPlan, log_directory: Path) -> frozenset[Path]:
    """Return the user's files that a process is made from.

    That are its program, the Python modules of the program's package and of the packages that this
    one depends on, its parameter files, and the scripts and descriptions that its command line
    names.

    Args:
        plan: The process.
        log_directory: The launch's folder, whose files are the launch's own.
    """
    words = plan.command
    if plan.shell:
        try:
            words = shlex.split(words[0])
        except ValueError:
            return frozenset()
    found = {*_named(words, plan.working_directory), *_of_program(words)}
    return frozenset(
        path for path in found if is_of_user(path) and not path.is_relative_to(log_directory)
    )


def _named(words: list[str], folder: str | None) -> Iterator[Path]:
    before = ""
    for word in words:
        path = Path(os.path.normpath(os.path.join(folder or "", word))).absolute()  # noqa: PTH118
        if (before == _PARAMETERS or path.suffix in _READ) and path.is_file():
            yield path
        before = word


def _of_program(words: list[str]) -> Iterator[Path]:
    if _NODES not in words:
        return
    rest = words[words.index(_NODES) + 1 :]
    try:
        if rest and is_path(rest[0]):
            yield from _of_executable(find_executable(None, rest[0]))
        elif len(rest) > 1 and rest[0] != "--builtin":
            yield from _of_executable(find_executable(rest[0], rest[1]))
    except TeleopctlError:
        # It was there when the launch file was evaluated; when it is back, so are its files.
        return


def _of_executable(executable: PackageProgram) -> Iterator[Path]:
    if executable.file is not None:
        yield executable.file
    if executable.target and not executable.import_roots:
        yield from _of_module(executable.target)
    package = lookup_package(executable.package) if executable.package else None
    if package is None:
        return
    roots = [] if executable.target and not executable.import_roots else [package.folder]
    roots += [root / package.name for root in installed_module_roots(package.name)]
    try:
        manifest = (package.folder / "package.xml").read_text(encoding="utf-8", errors="replace")
    except OSError:
        manifest = ""
    for name in _DEPENDENCY.findall(manifest):
        root = source_module_root(name)
        roots += [] if root is None else [root / name]
    for root in roots:
        yield from _modules_below(root)


def _of_module(target: str) -> Iterator[Path]:
    """Of an installed distribution: where it was installed to be worked on (``pip install -e``)."""
    try:
        spec = importlib.util.find_spec(re.split("[.:]", target)[0])
    except (ImportError, ValueError):
        return
    if spec is None or spec.origin is None or not is_of_user(Path(spec.origin)):
        return
    if spec.submodule_search_locations is None:
        yield Path(spec.origin)
    for folder in spec.submodule_search_locations or ():
        yield from _modules_below(Path(folder))


def _modules_below(root: Path) -> Iterator[Path]:
    for folder, below, files in os.walk(root):
        below[:] = [name for name in below if name[0] != "." and name not in _NO_SOURCES]
        yield from (Path(folder, name) for name in files if name.endswith(".py"))
