"""Source folders of ROS 2 packages: what they are called and which programs they offer.

Nothing is built and nothing is executed: ``package.xml``, ``setup.py``, ``setup.cfg`` and
``pyproject.toml`` are read as text.
"""

import os
import re
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path

from teleopctl.packages.setup_script import setup_arguments

# They take 12 ms where the file system is warm, 150 ms where it is not.
_MAX_FOLDERS = 500
_SKIPPED_FOLDERS = frozenset(
    {"__pycache__", "build", "dist", "install", "log", "node_modules", "site-packages", "venv"}
)
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_NAME = re.compile(r"<name>\s*([A-Za-z0-9_\-]+)\s*</name>")


def package_name(manifest: Path) -> str | None:
    """Read the name that a ``package.xml`` declares.

    Returns:
        The name, or None when the file cannot be read or declares none.
    """
    text = _text_of(manifest)
    match = None if text is None else _NAME.search(_COMMENT.sub("", text))
    return match.group(1) if match else None


def enclosing_package(folder: Path) -> Path | None:
    """Return the nearest folder with a ``package.xml``: the given one, or one that it lies in."""
    return next((f for f in (folder, *folder.parents) if (f / "package.xml").is_file()), None)


def find_package_folders(
    root: Path, on_cut: Callable[[int], object] = lambda _: None
) -> Iterator[tuple[str | None, Path]]:
    """Yield (package name, folder) of the packages at and below a folder, nearest first.

    The name is None where `package_name` finds none.

    The search goes breadth first and is bounded in the number of folders, so that a command given
    in a home folder stays quick. Hidden folders, virtual environments, colcon's
    outputs and folders marked ``COLCON_IGNORE`` are skipped, and so is what lies inside a package.

    Args:
        root: The folder.
        on_cut: Called with the bound when it ends the search.
    """
    pending = deque([str(root)])
    seen = 0
    while pending and seen < _MAX_FOLDERS:
        folder = pending.popleft()
        seen += 1
        try:
            with os.scandir(folder) as found:
                entries = list(found)
        except OSError:
            continue
        names = {entry.name for entry in entries}
        if "COLCON_IGNORE" in names or "pyvenv.cfg" in names:
            continue
        if "package.xml" in names:
            yield package_name(Path(folder, "package.xml")), Path(folder)
            continue
        pending.extend(
            entry.path
            for entry in sorted(entries, key=lambda entry: entry.name)
            if not entry.name.startswith(".")
            and entry.name not in _SKIPPED_FOLDERS
            and entry.is_dir(follow_symlinks=False)
        )
    if pending:
        on_cut(_MAX_FOLDERS)


def console_scripts(folder: Path) -> dict[str, str]:
    """Read the programs that a Python package declares, as program name → ``module:function``.

    ``setup.py`` wins over ``setup.cfg``, which wins over ``pyproject.toml``.
    """
    scripts: dict[str, str] = {}
    for name, reader in (
        ("pyproject.toml", _scripts_of_pyproject),
        ("setup.cfg", _scripts_of_setup_cfg),
        ("setup.py", _scripts_of_setup_py),
    ):
        file = folder / name
        text = _text_of(file)
        if text is not None:
            scripts.update(reader(text))
    return scripts


def import_root(folder: Path, target: str) -> Path:
    """Return the folder to import ``module:function`` from: the package's own, or its ``src``."""
    top = target.partition(":")[0].partition(".")[0]
    source = folder / "src"
    if (source / top).is_dir() or (source / f"{top}.py").is_file():
        return source
    return folder


def _text_of(file: Path) -> str | None:
    """Read a file; None when there is none or it is not ours to read."""
    try:
        return file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None


def _parse_entry_points(lines: list[str]) -> dict[str, str]:
    scripts = {}
    for line in lines:
        name, equals, target = line.partition("=")
        target = target.partition("[")[0].strip()
        if equals and ":" in target:
            scripts[name.strip()] = target.replace(" ", "")
    return scripts


def _scripts_of_setup_cfg(text: str) -> dict[str, str]:
    import configparser

    parser = configparser.ConfigParser(interpolation=None)
    try:
        parser.read_string(text)
    except configparser.Error:
        return {}
    lines = parser.get("options.entry_points", "console_scripts", fallback="")
    return _parse_entry_points(lines.splitlines())


def _scripts_of_pyproject(text: str) -> dict[str, str]:
    import tomllib

    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return {}
    project = document.get("project")
    scripts = project.get("scripts") if isinstance(project, dict) else None
    if not isinstance(scripts, dict):
        return {}
    return _parse_entry_points([f"{name} = {target}" for name, target in scripts.items()])


def _scripts_of_setup_py(text: str) -> dict[str, str]:
    entry_points = setup_arguments(text).get("entry_points")
    lines = entry_points.get("console_scripts") if isinstance(entry_points, dict) else None
    if isinstance(lines, str):
        lines = lines.splitlines()
    if not isinstance(lines, list | tuple):
        return {}
    return _parse_entry_points([line for line in lines if isinstance(line, str)])
