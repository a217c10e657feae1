"""Where launch files are: given by path, in a package, or among those that teleopctl brings."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from teleopctl.errors import NotFoundError, did_you_mean
from teleopctl.packages import builtin_package, find_package, include_package_of

SUFFIXES = (".yaml", ".yml")
"""The endings of launch files."""


def is_launch_file(name: str) -> bool:
    """Whether a name has the ending of a launch file."""
    return name.endswith(SUFFIXES)


def builtin_files() -> list[str]:
    """Return the names of the launch files that teleopctl brings."""
    return sorted(path.name for path in _builtin_folder().glob("*.yaml"))


def builtin_file(name: str) -> Path | None:
    """Return the launch file of that name that teleopctl brings, or None."""
    path = _builtin_folder() / name
    return path if path.is_file() else None


def is_builtin(file: Path) -> bool:
    """Whether a launch file is one that teleopctl brings."""
    return file.parent == _builtin_folder()


def _builtin_folder() -> Path:
    own = builtin_package("teleopctl")
    assert own is not None
    return own.share / "launch"


def find_launch_file(package: str | None, name: str) -> Path:
    """Find a launch file.

    Args:
        package: Package to look in, or None for a path or a built-in file.
        name: A path, or the name of a file in the package's ``launch`` folder, or of a built-in
            one; the ending ``.yaml`` may be left out.

    Raises:
        NotFoundError: When there is no such package or file, or it is not a YAML file.
    """
    candidates = [*_in_package(package, name)] if package is not None else [Path(name).expanduser()]
    candidates += [_builtin_folder() / name, _builtin_folder() / f"{name}.yaml"]
    for path in candidates:
        if path.is_file():
            if path.suffix not in SUFFIXES:
                raise NotFoundError(
                    f"{path} is not a YAML launch file",
                    hint="teleopctl reads ROS 2's YAML launch files; built in are "
                    f"{', '.join(builtin_files())}.",
                )
            include_package_of(path)
            return path.absolute()
    where = f" in package '{package}'" if package is not None else ""
    known = {*builtin_files(), *(files_in_package(package) if package is not None else ())}
    stem = Path(name).name.split(".", maxsplit=1)[0]
    guess = did_you_mean(name, known) or did_you_mean(stem, {file.split(".")[0] for file in known})
    listed = f"There are {', '.join(sorted(known))}, and any YAML file by its path."
    raise NotFoundError(
        f"Launch file '{name}' not found{where}",
        hint=f"{guess} {listed}" if guess else listed,
    )


def files_in_package(package: str) -> list[str]:
    """Return the names of the launch files of a package.

    Raises:
        TeleopctlError: There is no such package.
    """
    folder = find_package(package).share / "launch"
    return sorted(path.name for suffix in SUFFIXES for path in folder.glob(f"*{suffix}"))


def _in_package(package: str, name: str) -> Iterator[Path]:
    share = find_package(package).share
    for folder in (share / "launch", share):
        yield folder / name
        yield folder / f"{name}.yaml"
    # Some packages sort their launch files into folders.
    if Path(name).name == name:
        yield from sorted((share / "launch").rglob(name))
