"""Programs of source packages, from their setup and CMake scripts.

Nothing is built and nothing is executed: ``setup.py``, ``setup.cfg``, ``pyproject.toml`` and
``CMakeLists.txt`` are read as text.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

from teleopctl.base.typed import Final
from teleopctl.packages.cmake_script import installation
from teleopctl.packages.records import PackageProgram
from teleopctl.packages.setup_script import setup_arguments
from teleopctl.packages.source_folders import text_of

_BUILT: Final = re.compile(r"^[^#\n]*\badd_(?:executable|library)\s*\(", re.MULTILINE)
_SCRIPTS = "console_scripts"


def executables(package: str, folder: Path) -> dict[str, PackageProgram]:
    """Return the programs, by name, that a source package's setup and CMake scripts install."""
    programs = {
        name: PackageProgram(name, package, target, None, (import_root(folder, target),))
        for name, target in console_scripts(folder).items()
    }
    text = text_of(folder / "CMakeLists.txt")
    if text is None or "install" not in text:
        return programs
    installed = installation(text, folder)
    for path, source in installed.files:
        place, _, name = path.rpartition("/")
        file = folder / source
        if (
            (place == f"lib/{package}" or place.startswith(f"lib/{package}/"))
            and file.is_file()
            and (path in installed.programs or os.access(file, os.X_OK))
        ):
            file = Path(os.path.normpath(file))
            programs.setdefault(name, PackageProgram(name, package, "", file, (file.parent,)))
    return programs


def compiled_programs(folder: Path) -> set[str]:
    """Return the names of programs that a package's ``CMakeLists.txt`` compiles and installs."""
    text = text_of(folder / "CMakeLists.txt")
    return set() if text is None else installation(text, folder).targets


def compiles(folder: Path) -> bool:
    """Return whether a package's ``CMakeLists.txt`` compiles anything."""
    text = text_of(folder / "CMakeLists.txt")
    return text is not None and _BUILT.search(text) is not None


def depends_on(folder: Path, name: str) -> bool:
    """Return whether a package's ``package.xml`` has a tag whose text is another package's name."""
    text = text_of(folder / "package.xml")
    return text is not None and re.search(rf">\s*{re.escape(name)}\s*<", text) is not None


def console_scripts(folder: Path) -> dict[str, str]:
    """Return the console scripts of a Python package by name, as ``module:function``."""
    return entry_points(folder, _SCRIPTS)


def entry_points(folder: Path, group: str) -> dict[str, str]:
    """Return the entry points of a group that a Python package declares, by name.

    ``setup.py`` has precedence over ``setup.cfg``, which has precedence over ``pyproject.toml``.
    """
    found: dict[str, str] = {}
    for name, reader in (
        ("pyproject.toml", _of_pyproject),
        ("setup.cfg", _of_setup_cfg),
        ("setup.py", _of_setup_py),
    ):
        file = folder / name
        text = text_of(file)
        if text is not None:
            found.update(reader(text, group))
    return found


def import_root(folder: Path, target: str) -> Path:
    """Return the folder from which ``module:function`` can be imported."""
    top = target.partition(":")[0].partition(".")[0]
    source = folder / "src"
    if (source / top).is_dir() or (source / f"{top}.py").is_file():
        return source
    return folder


def _parse_entry_points(lines: list[str]) -> dict[str, str]:
    scripts = {}
    for line in lines:
        name, equals, target = line.partition("=")
        target = target.partition("[")[0].strip()
        if equals and ":" in target:
            scripts[name.strip()] = target.replace(" ", "")
    return scripts


def _of_setup_cfg(text: str, group: str) -> dict[str, str]:
    import configparser

    parser = configparser.ConfigParser(interpolation=None)
    try:
        parser.read_string(text)
    except configparser.Error:
        return {}
    lines = parser.get("options.entry_points", group, fallback="")
    return _parse_entry_points(lines.splitlines())


def _of_pyproject(text: str, group: str) -> dict[str, str]:
    import tomllib

    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return {}
    project = document.get("project")
    if not isinstance(project, dict):
        return {}
    groups = {_SCRIPTS: project.get("scripts")}
    if isinstance(others := project.get("entry-points"), dict):
        groups |= others
    entries = groups.get(group)
    if not isinstance(entries, dict):
        return {}
    return _parse_entry_points([f"{name} = {target}" for name, target in entries.items()])


def _of_setup_py(text: str, group: str) -> dict[str, str]:
    groups = setup_arguments(text).get("entry_points")
    lines = groups.get(group) if isinstance(groups, dict) else None
    if isinstance(lines, str):
        lines = lines.splitlines()
    if not isinstance(lines, list | tuple):
        return {}
    return _parse_entry_points([line for line in lines if isinstance(line, str)])
