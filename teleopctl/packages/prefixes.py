"""Packages below install prefixes, as colcon and the Debian packages of ROS install them.

An installed package has a marker ``share/ament_index/resource_index/packages/NAME`` below its
prefix, files in ``share/NAME``, programs in ``lib/NAME`` and Python modules in
``lib/pythonX.Y/site-packages``. ``AMENT_PREFIX_PATH`` lists the prefixes, ``COLCON_PREFIX_PATH``
the ``install/`` folders of workspaces, in which each package has its own prefix unless the
workspace was built with ``--merge-install``.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from functools import lru_cache, partial
from pathlib import Path

from teleopctl.base.typed import Final
from teleopctl.packages.installed_layout import INDEX
from teleopctl.packages.own_packages import is_own_prefix, own_prefix
from teleopctl.packages.records import INSTALLED, Package, PackageProgram

AMENT_VARIABLE: Final = "AMENT_PREFIX_PATH"
COLCON_VARIABLE: Final = "COLCON_PREFIX_PATH"

# File that colcon writes into an install folder.
_LAYOUT: Final = ".colcon_install_layout"
_PYTHON_FOLDERS: Final = (
    "lib/python3*/site-packages",
    "local/lib/python3*/dist-packages",  # Debian's Python 3.10 with its patched setuptools
    "lib/python3/dist-packages",
    "Lib/site-packages",  # Windows
)


def search_paths() -> list[str]:
    """Return the existing folders of ``AMENT_PREFIX_PATH``; without any, those of this Python.

    These are the prefix of teleopctl's packages, and Python's own if it has ROS packages.

    Raises:
        SystemFailureError: The prefix of teleopctl's packages cannot be written.
    """
    if os.environ.get(AMENT_VARIABLE):
        return _folders(AMENT_VARIABLE)
    return [*_of_python(), str(own_prefix())]


def prefixes() -> dict[str, str]:
    """Return the existing install prefixes, each with the environment variable that lists it.

    The last one may be that of this Python, below which pip installs the files of ROS packages. The
    prefix of teleopctl's own packages is left out.
    """
    listed = (folder for folder in _folders(AMENT_VARIABLE) if not is_own_prefix(folder))
    found = dict.fromkeys(listed, AMENT_VARIABLE)
    for base in _folders(COLCON_VARIABLE):
        for prefix in _prefixes_of_workspace(base):
            found.setdefault(prefix, COLCON_VARIABLE)
    for prefix in _of_python():
        found.setdefault(prefix, "installed beside Python")
    return found


def include_prefix_of(file: Path) -> None:
    """Add the install prefix around a file to ``AMENT_PREFIX_PATH`` or ``COLCON_PREFIX_PATH``.

    In a colcon workspace in which each package has its own prefix, all prefixes are added. Their
    environment hooks are applied.
    """
    around = Path(os.path.abspath(file)).parents  # noqa: PTH100 -- links stay as they are
    prefix = next((folder for folder in around if (folder / INDEX).is_dir()), None)
    if prefix is None or str(prefix) in prefixes():
        return
    variable, folder = AMENT_VARIABLE, prefix
    if (prefix.parent / _LAYOUT).is_file():
        variable, folder = COLCON_VARIABLE, prefix.parent
    named = filter(None, (os.environ.get(variable), str(folder)))
    os.environ[variable] = os.pathsep.join(named)
    from teleopctl.packages.environment_hooks import apply_installed_hooks

    for each in [str(prefix)] if folder == prefix else _prefixes_of_workspace(str(folder)):
        apply_installed_hooks(Path(each))


def installed_packages(name: str) -> Iterator[Package]:
    """Yield the installed packages of a name, one per prefix, in the order of the prefixes."""
    for prefix, variable in prefixes().items():
        if os.path.isfile(os.path.join(prefix, INDEX, "packages", name)):  # noqa: PTH113, PTH118
            yield _package(name, prefix, variable)


def installed_names() -> set[str]:
    """Return the names of all installed packages."""
    return {name for prefix in prefixes() for name in _names(prefix)}


def python_folders(prefix: Path) -> tuple[Path, ...]:
    """Return the Python module folders of an install prefix, with those that ``.egg-link`` names.

    With ``--symlink-install``, a package's modules stay in a source folder; the folder's path is
    read from an ``.egg-link`` file.
    """
    folders = [folder for pattern in _PYTHON_FOLDERS for folder in sorted(prefix.glob(pattern))]
    linked: list[Path] = []
    for folder in folders:
        for link in sorted(folder.glob("*.egg-link")):
            lines = link.read_text(encoding="utf-8", errors="replace").splitlines()
            linked += [Path(line) for line in lines[:1] if Path(line).is_dir()]
    return (*folders, *linked)


# Cached, since a process looks for many packages in the same prefixes.
@lru_cache(maxsize=1024)
def is_ros(prefix: Path) -> bool:
    """Return whether an install prefix is that of a ROS distribution, not of a workspace."""
    marker = Path(INDEX, "packages", "ros_environment")
    return (prefix / marker).is_file() or (prefix.parent / "ros_environment" / marker).is_file()


def _of_python() -> list[str]:
    return [sys.prefix] if os.path.isdir(os.path.join(sys.prefix, INDEX)) else []  # noqa: PTH112, PTH118


def _folders(variable: str) -> list[str]:
    named = os.environ.get(variable, "").split(os.pathsep)
    return [folder for folder in dict.fromkeys(named) if folder and os.path.isdir(folder)]  # noqa: PTH112


def _prefixes_of_workspace(base: str) -> Iterator[str]:
    if os.path.isdir(os.path.join(base, INDEX)):  # noqa: PTH112, PTH118
        yield base
        return
    with os.scandir(base) as entries:
        for entry in sorted(entries, key=lambda entry: entry.name):
            if os.path.isdir(os.path.join(entry.path, INDEX)):  # noqa: PTH112, PTH118
                yield entry.path


def _names(prefix: str) -> list[str]:
    try:
        with os.scandir(os.path.join(prefix, INDEX, "packages")) as entries:  # noqa: PTH118
            return [e.name for e in entries if not e.name.startswith(".") and not e.is_dir()]
    except OSError:
        return []


def _package(name: str, prefix: str, variable: str) -> Package:
    return Package(
        name,
        Path(os.path.abspath(prefix), "share", name),  # noqa: PTH100 -- links stay as they are
        kind=INSTALLED,
        found_by=variable,
        read_executables=partial(_executables, name, Path(prefix)),
    )


def _executables(name: str, prefix: Path) -> dict[str, PackageProgram]:
    """Return the executable files below ``lib/NAME``, at any depth; the first of each name."""
    found: dict[str, PackageProgram] = {}
    roots = python_folders(prefix)
    for top, folders, files in os.walk(prefix / "lib" / name):
        folders[:] = sorted(folder for folder in folders if not folder.startswith("."))
        for file in sorted(files):
            path = Path(top, file)
            if os.access(path, os.X_OK):
                program = PackageProgram(file, name, "", path, (path.parent, *roots))
                found.setdefault(file, program)
    return found
