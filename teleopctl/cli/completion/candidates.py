"""Completion candidates from the live graph and from the files and packages of this machine.

Completion prints no errors: without a router or a response, there are no candidates.
"""

from __future__ import annotations

import os

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.errors import TeleopctlError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    from teleopctl.cli.completion.completing import TypedWords
    from teleopctl.wire import Graph


def topics(incomplete: str) -> list[str]:
    """Return the names of live, not hidden topics that begin with a text; none without router."""
    return _matching(incomplete, lambda graph: dict(graph.topic_names_and_types()))


def services(incomplete: str) -> list[str]:
    """Return the names of live, not hidden services that begin with a text; none without router."""
    return _matching(incomplete, lambda graph: dict(graph.service_names_and_types()))


def nodes(incomplete: str) -> list[str]:
    """Return the full names of live, not hidden nodes that begin with a text."""
    return _matching(incomplete, lambda graph: graph.node_names())


def files(incomplete: str) -> list[str]:
    """Return the paths of files, and of folders with a ``/`` at the end, that begin with a text."""
    folder, _, beginning = incomplete.rpartition("/")
    above = f"{folder}/" if "/" in incomplete else ""
    try:
        with os.scandir(os.path.expanduser(above) or ".") as found:  # noqa: PTH111
            entries = sorted((each.name, each.is_dir()) for each in found)
    except OSError:
        return []
    return [
        f"{above}{name}{'/' if is_folder else ''}"
        for name, is_folder in entries
        if name.startswith(beginning) and (beginning or not name.startswith("."))
    ]


def _files_and_folders(incomplete: str, is_wanted: Callable[[str], bool]) -> list[str]:
    """Return the files of a kind, and folders if the text is a path rather than a package."""
    folders = "/" if incomplete.startswith((".", "~")) or "/" in incomplete else "\0"
    return [name for name in files(incomplete) if is_wanted(name) or name.endswith(folders)]


def programs(ctx: TypedWords, incomplete: str) -> list[str]:
    """Return candidates for the next word of ``run``: package or .py file, program, then files."""
    from teleopctl import packages

    words = ctx.params.get("words") or []
    names: set[str] = set()
    if not words:
        # A package's programs are found in its build scripts, so only matching packages are read.
        for name in package_names(incomplete):
            try:
                if packages.find_package(name).executables:
                    names.add(name)
            except TeleopctlError:
                continue
        names.update(_files_and_folders(incomplete, lambda name: name.endswith(".py")))
    elif len(words) == 1 and not packages.is_path(words[0]):
        package = packages.lookup_package(words[0])
        names.update(package.executables if package else ())
    else:
        names.update(files(incomplete))
    return sorted(name for name in names if name.startswith(incomplete))


def package_names(incomplete: str) -> list[str]:
    """Return the names of ROS packages that begin with a text."""
    from teleopctl import packages

    return [name for name in packages.package_names() if name.startswith(incomplete)]


def launch_words(ctx: TypedWords, incomplete: str) -> list[str]:
    """Return candidates for the next word of ``launch``: file or package, then file or argument."""
    from teleopctl.launch import files_in_package, is_launch_file

    try:
        match ctx.params.get("words") or []:
            case []:
                names = _launch_files_and_packages(incomplete)
            case [file, *_] if is_launch_file(file):
                names = _launch_arguments(None, file)
            case [package]:
                names = files_in_package(package)
            case [package, file, *_]:
                names = _launch_arguments(package, file)
    except TeleopctlError:
        return []
    return [name for name in names if name.startswith(incomplete)]


def running_processes(incomplete: str) -> list[str]:
    """Return the names of running background processes that begin with a text."""
    from teleopctl.launch import running

    return sorted({e.record.name for e in running() if e.record.name.startswith(incomplete)})


def logged_processes(incomplete: str) -> list[str]:
    """Return the process names that `logs` can show: running ones, and ended ones of launches."""
    from teleopctl.launch import running

    names = {entry.record.name for entry in running(include_ended=True)}
    return sorted(name for name in names if name.startswith(incomplete))


def _launch_files_and_packages(incomplete: str) -> list[str]:
    from teleopctl.launch import builtin_files, is_launch_file

    return [
        *builtin_files(),
        *_files_and_folders(incomplete, is_launch_file),
        *(package for package in package_names(incomplete) if _has_launch_files(package)),
    ]


def _has_launch_files(package: str) -> bool:
    from teleopctl import packages
    from teleopctl.launch import files_in_package, is_launch_file

    folder = packages.find_package(package).folder
    try:  # most packages have a folder launch; reading the build scripts takes longer
        if any(is_launch_file(file.name) for file in (folder / "launch").iterdir()):
            return True
    except OSError:
        # Without this folder, launch files exist only if a build script installs them.
        scripts = " ".join(_text_of(folder / name) for name in ("CMakeLists.txt", "setup.py"))
        if "launch" not in scripts and "add_subdirectory" not in scripts:
            return False
    return bool(files_in_package(package))


def _text_of(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


# Variables that determine which files a launch file includes.
_PLACES = ("AMENT_PREFIX_PATH", "ROS_DISTRO", "TELEOPCTL_PACKAGE_PATH")


def _launch_arguments(package: str | None, file: str) -> list[str]:
    def read() -> tuple[list[str], Iterable[str]]:
        from teleopctl.launch import argument_names, find_launch_file

        files: set[Path] = set()
        return argument_names(find_launch_file(package, file), files), map(str, files)

    from teleopctl.cli.declared import cached_names

    where = (os.getcwd(), *(os.environ.get(name, "") for name in _PLACES))  # noqa: PTH109
    return [f"{name}:=" for name in cached_names(("launch", package or "", file, *where), read)]


def _matching(incomplete: str, names: Callable[[Graph], Iterable[str]]) -> list[str]:
    from teleopctl.cli.graph_lookup import live_graph

    try:
        return [name for name in names(live_graph()) if name.startswith(incomplete)]
    except TeleopctlError:
        return []
