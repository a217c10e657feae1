"""Search for programs by package and name, by name alone, or by the path of a file."""

from __future__ import annotations

import os
from pathlib import Path

from teleopctl.errors import AmbiguousNameError, NotFoundError, did_you_mean
from teleopctl.packages.distributions import builtin_package
from teleopctl.packages.finding import (
    find_package,
    include_package_of,
    list_packages,
    package_layers,
)
from teleopctl.packages.records import DISTRIBUTION, SOURCES, Package, PackageProgram

# Package with the functions of teleopctl's own executables.
_OURS = "teleopctl.nodes."


def find_executable(package: str | None, name: str, *, builtin: bool = False) -> PackageProgram:
    """Return a program by package and name, by name alone, or by path; raise if there is none.

    Args:
        package: Name of the package; None if ``name`` is a path or unique among all packages.
        name: Name of the program, or path of a file.
        builtin: Whether to search only teleopctl's own packages.

    Raises:
        TeleopctlError: The package or the program is not found, or several packages have different
            programs of that name.
    """
    if builtin:
        own = builtin_package(package or "")
        if own is None or name not in own.executables:
            raise NotFoundError(f"teleopctl has no program '{name}' in a package '{package}'")
        return own.executables[name]
    if package is not None:
        return _executable_of(package, name)
    if is_path(name):
        return _executable_file(name)
    return _only_executable(name)


def _executable_of(package: str, name: str) -> PackageProgram:
    offered = find_package(package).executables
    if name in offered:
        return offered[name]
    # A package that was found without the entry points may have more programs among them.
    layers = package_layers(package)
    for layer in layers:
        if layer.kind == DISTRIBUTION and name in layer.executables:
            return layer.executables[name]
    compiled = next((p for p in layers if p.kind == SOURCES and name in _compiled(p)), None)
    if compiled is not None:
        raise NotFoundError(
            f"No executable found: '{name}' of package '{package}' is compiled",
            hint=f"{compiled.folder / 'CMakeLists.txt'} builds it. After colcon build, source "
            "install/setup.bash, so that AMENT_PREFIX_PATH contains it.",
        )
    names = ", ".join(sorted(offered))
    # A launch file names many: `ros2 run` alone need not repeat the one that was typed.
    missing = f"Package '{package}' has no executable '{name}'"
    raise NotFoundError(
        "No executable found",
        hint=f"{missing}. {did_you_mean(name, offered) or (names and f'It has {names}.')}".rstrip(),
    )


def _compiled(package: Package) -> set[str]:
    from teleopctl.packages.source_programs import compiled_programs

    return compiled_programs(package.folder)


def _executable_file(path: str) -> PackageProgram:
    file = Path(path).expanduser().absolute()
    if not file.is_file():
        raise NotFoundError("No executable found", hint=f"There is no file {file}.")
    include_package_of(file)
    return PackageProgram(name=file.name, file=file, import_roots=(file.parent,))


def _only_executable(name: str) -> PackageProgram:
    """Return the program of that name, which several packages may share.

    The user's programs have precedence: many packages have a `talker`, and so do teleopctl's demos.
    """
    packages = list_packages()
    found = [entry.executables[name] for entry in packages if name in entry.executables]
    found = [entry for entry in found if not entry.target.startswith(_OURS)] or found
    if not found:
        every = {executable for entry in packages for executable in entry.executables}
        raise NotFoundError("No executable found", hint=did_you_mean(name, every))
    if len({(entry.target, entry.file, entry.import_roots) for entry in found}) > 1:
        owners = ", ".join(entry.package for entry in found)
        raise AmbiguousNameError(
            f"Several packages have an executable '{name}': {owners}",
            hint=f"Name one: teleopctl run {found[0].package} {name}",
        )
    return found[0]


def is_path(text: str) -> bool:
    """Return whether a program's name is a file path: it has a slash or ends in ``.py``."""
    return "/" in text or os.sep in text or text.endswith(".py")
