"""Search for launch files: by path, in a package, or among teleopctl's own."""

from __future__ import annotations

import os
from itertools import chain
from pathlib import Path

from teleopctl import plugins
from teleopctl.base.typed import Iterator
from teleopctl.errors import NotFoundError, did_you_mean
from teleopctl.packages import builtin_package, find_package, include_package_of

SUFFIXES = (".yaml", ".yml", ".xml", ".launch", ".py")
"""Suffixes of launch files in all languages; the last one is also that of many other files."""

# Endings that are tried for a name without an ending, in this order.
_ADDED = (".yaml", ".launch.yaml", ".launch.xml", ".launch.py", ".xml", ".py")
# Endings of names of launch files; of Python files, only those that end in ``launch.py``.
_LOOKS = (*SUFFIXES[:-1], "launch.py")


def is_launch_file(name: str) -> bool:
    """Return whether a file name ends in yaml, yml, xml, launch or launch.py; no package.xml."""
    return name.endswith(_LOOKS) and not name.endswith("package.xml")


def builtin_files() -> list[str]:
    """Return the names of teleopctl's own launch files."""
    return sorted(path.name for path in _builtin_folder().glob("*.yaml"))


def builtin_file(name: str) -> Path | None:
    """Return the path of teleopctl's own launch file of this name; None if there is none."""
    path = _builtin_folder() / name
    return path if path.is_file() else None


def is_builtin(file: Path) -> bool:
    """Return whether a launch file is one of teleopctl's own."""
    return file.parent == _builtin_folder()


def _builtin_folder() -> Path:
    own = builtin_package("teleopctl")
    assert own is not None
    return own.share / "launch"


def find_launch_file(package: str | None, name: str) -> Path:
    """Return a launch file's absolute path: by path, in a package, or built in; or raise.

    Args:
        package: Name of the package that has the file, or None for a path or a built-in file.
        name: Path, or name of a file of the package or of a built-in file. The ending of a name may
            be left out.

    Raises:
        NotFoundError: The package or file does not exist, the file is no launch file, or the
            package has several files of that name.
    """
    given = _in_package(package, name) if package is not None else [Path(name).expanduser()]
    for path in chain(given, (_builtin_folder() / name, _builtin_folder() / f"{name}.yaml")):
        if path.is_file():
            if plugins.find(plugins.LAUNCH_LANGUAGES, path.suffix) is None:
                endings = sorted(plugins.available(plugins.LAUNCH_LANGUAGES))
                raise NotFoundError(
                    f"{path} is not a launch file",
                    hint=f"Launch files end in {', '.join(endings)}; built in are "
                    f"{', '.join(builtin_files())}.",
                )
            include_package_of(path)
            return path.absolute()
    raise _not_found(package, name)


def _not_found(package: str | None, name: str) -> NotFoundError:
    known = {*builtin_files(), *(files_in_package(package) if package is not None else ())}
    stem = Path(name).name.split(".", maxsplit=1)[0]
    guess = did_you_mean(name, known) or did_you_mean(stem, {file.split(".")[0] for file in known})
    listed = f"There are {', '.join(sorted(known))}, and any launch file by its path."
    message = f"Launch file '{name}' not found"
    if package is not None:
        message = (
            f"file '{name}' was not found in the share directory of package '{package}' "
            f"which is at '{find_package(package).share}'"
        )
    return NotFoundError(message, hint=f"{guess} {listed}" if guess else listed)


def files_in_package(package: str) -> list[str]:
    """Return the sorted names of the launch files below the ``launch`` folder of a package.

    Raises:
        TeleopctlError: The package does not exist.
    """
    folder = find_package(package).share / "launch"
    return sorted({path.name for path in _files_below(folder) if is_launch_file(path.name)})


def _in_package(package: str, name: str) -> Iterator[Path]:
    share = find_package(package).share
    for folder in (share / "launch", share):
        yield folder / name
        yield from (folder / f"{name}{ending}" for ending in _ADDED)
    # Some packages sort their launch files into folders.
    if Path(name).name == name:
        found = sorted(path for path in _files_below(share) if path.name == name)
        if len(found) > 1:
            places = ", ".join(f"'{path}'" for path in found)
            raise NotFoundError(
                f"file '{name}' was found more than once in the share directory of package "
                f"'{package}': [{places}]",
                hint="Name it by its folder, as in FOLDER/FILE.",
            )
        yield from found


def _files_below(folder: Path) -> Iterator[Path]:
    """Yield all files below a folder, without hidden folders such as ``.git``."""
    for place, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if name[:1] != "." and name != "__pycache__"]
        yield from (Path(place, name) for name in files)
